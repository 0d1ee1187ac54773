"""Options of identify, and a result as JSON."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.base.errors import Code, HexciteError
from identification.estimation.estimators import Method, symmetric_platform
from identification.estimation.fit import Value
from identification.estimation.priors import Prior
from identification.model.model import Model
from identification.model.parameters import physical_form
from identification.results.result import Result
from identification.results.verdicts import Check, Verdict, en
from identification.samples.treatment import Treatment
from identification.texts import parameter_words
from planner.request import read_value

ESTIMATORS = ("linear", "nonlinear")


def method_of(
    model: Model,
    *,
    weights: str | None,
    known: Sequence[str] | None,
    dropped: Sequence[str] | None,
    priors: Sequence[str] | None,
    symmetric: bool,
    estimator: str,
) -> Method:
    """The method that a user asks for by the options as typed; HexciteError where one of them is not understood."""
    units = {p.name: p.unit for p in (*model.parameters, *physical_form(model).parameters)}
    constants: dict[str, float] = {}
    for text in known or ():
        typed = read_value(text, units, "--fix", "m=93.1kg", model.number)
        if typed.std is not None:
            raise HexciteError(
                place=f"--fix {text}",
                problem="is exact",
                remedy=f"write an uncertain value as --prior {text}",
                code=Code.CONTRADICTION,
            )
        if typed.name in constants:
            raise HexciteError(
                place=f"--fix {text}",
                problem=f"{typed.name} is given twice",
                remedy="give it once",
                code=Code.CONTRADICTION,
            )
        constants[typed.name] = typed.value
    uncertain = []
    for text in priors or ():
        typed = read_value(text, units, "--prior", "m=33+-0.5kg", model.number)
        if typed.std is None:
            raise HexciteError(
                place=f"--prior {text}",
                problem="has no standard deviation",
                remedy="write it as --prior m=33+-0.5kg",
                code=Code.MISSING,
            )
        uncertain.append(Prior(typed.name, typed.value, typed.std))
    if estimator not in ESTIMATORS:
        raise HexciteError(
            place=f"--estimator {estimator}",
            problem="is unknown",
            remedy=f"choose {' or '.join(ESTIMATORS)}",
            code=Code.UNKNOWN,
        )
    nonlinear = estimator == "nonlinear"
    if symmetric:
        platform = symmetric_platform(model, nonlinear)
        if twice := sorted({*platform} & {*constants, *(dropped or ()), *(p.name for p in uncertain)}):
            raise HexciteError(
                place="--symmetric",
                problem=f"says what {twice[0]} is",
                remedy=f"leave {twice[0]} or --symmetric out",
                code=Code.CONTRADICTION,
            )
        constants |= platform
    return Method(constants, tuple(dropped or ()), tuple(uncertain), weights, nonlinear)


def number_of(text: str) -> int:
    """The number of a model as typed; HexciteError where it is none."""
    try:
        return int(text)
    except ValueError:
        raise HexciteError(
            place=f"--model {text}",
            problem="is neither a number of Table 2 nor all",
            remedy="give 0 to 9, or all",
            code=Code.UNKNOWN,
        ) from None


def treatment_of(
    accelerated: float | None, period: float | None, harmonics: int, cutoff: str | None
) -> Treatment | None:
    """The treatment of the data that is asked for; None for the default."""
    if accelerated is None and period is None and cutoff is None:
        return None
    try:
        frequency = None if cutoff is None else math.inf if cutoff == "none" else float(cutoff)
    except ValueError:
        raise HexciteError(
            place=f"--cutoff {cutoff}",
            problem="is neither a frequency in Hz nor none",
            remedy="give 40, or none",
            code=Code.OUT_OF_RANGE,
        ) from None
    return Treatment(accelerated, period, harmonics, frequency)


def verdict_of_references(texts: Sequence[str], parameters: Mapping[str, Value], model: int) -> Verdict:
    """E_n of parameters beside reference values as typed; HexciteError where one of them is not understood."""
    units, checks = {name: value.unit for name, value in parameters.items()}, []
    for text in texts:
        typed = read_value(text, units, "--reference", "m=19.93+-0.01kg", model)
        if typed.std is None:
            remedy = "write it as --reference m=19.93+-0.01kg"
            raise HexciteError(
                place=f"--reference {text}",
                problem="has no expanded uncertainty (k = 2)",
                remedy=remedy,
                code=Code.MISSING,
            )
        value = parameters[typed.name]
        checks.append(Check(f"E_n of {parameter_words(typed.name)}", en(value, typed.value, typed.std), 1.0, ""))
    return Verdict(tuple(checks), ())


def answer_of_result(result: Result, folder: Path) -> dict[str, Any]:
    """The JSON answer of a result that was written."""
    return {"result": str(folder), "report": str(folder / "report.html"), **result.record.to_json()}
