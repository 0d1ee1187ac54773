"""Options of identify, and a result as text for people and as JSON."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cases.errors import HexciteError
from identification.estimation.estimators import Method
from identification.estimation.fit import Value
from identification.estimation.priors import Prior
from identification.model import Model
from identification.outcome import Result
from identification.parameters import physical_form
from planner.cli.console import print_table
from planner.precision import carries_rods, value_cells
from planner.request import read_value


def method_of(
    model: Model,
    fix: Sequence[str] | None = None,
    drop: Sequence[str] | None = None,
    prior: Sequence[str] | None = None,
    weights: str | None = None,
) -> Method:
    """The method that a user asks for by the options as typed; HexciteError where one of them is not understood."""
    units = {p.name: p.unit for p in (*model.parameters, *physical_form(model).parameters)}
    constants: dict[str, float] = {}
    for text in fix or ():
        typed = read_value(text, units, "--fix", "m=93.1kg", model.number)
        if typed.std is not None:
            raise HexciteError(f"--fix {text}", f"is exact; write an uncertain value as --prior {text}")
        if typed.name in constants:
            raise HexciteError(f"--fix {text}", f"{typed.name} is given twice; give it once")
        constants[typed.name] = typed.value
    priors = []
    for text in prior or ():
        typed = read_value(text, units, "--prior", "m=33+-0.5kg", model.number)
        if typed.std is None:
            raise HexciteError(f"--prior {text}", "has no standard deviation; write it as --prior m=33+-0.5kg")
        priors.append(Prior(typed.name, typed.value, typed.std))
    return Method(constants, tuple(drop or ()), tuple(priors), weights)


PARAMETER_COLUMNS = ("parameter", "value", "+-", "std (28)", "std robust", "unit")


def answer_of_result(result: Result, folder: Path) -> dict[str, Any]:
    """The JSON answer of a result that was written."""
    return {"result": str(folder), "report": str(folder / "report.html"), **result.record.to_json()}


def parameter_rows(parameters: Mapping[str, Value]) -> list[tuple[str, ...]]:
    """Rows of `PARAMETER_COLUMNS`."""
    return [value_cells(name, value, carries_rods(parameters)) for name, value in parameters.items()]


def show_residuals(answer: dict[str, Any]) -> None:
    """Prints s0 and the residuals of the recorded forces; behind a filter s0 contains the smaller part only."""
    equal = answer["weights"] == "equal"
    sentence = f"recorded forces less the model: {answer['s0_N']:.3g} N rms"
    if equal and answer["delay_s"] is not None and answer["s0_N"] > 2.0 * answer["s0"]:
        sentence += ", most of it above the evaluation's filter, where the estimate does not look"
    print(f"s0 = {answer['s0']:.3g}{' N' if equal else ''}, weights {answer['weights']}; {sentence}")


def show_result(answer: dict[str, Any]) -> None:
    """Prints a result for people."""
    rows = parameter_rows({name: Value(**p) for name, p in answer["parameters"].items()})
    title = f"Model {answer['model']}: {answer['samples']} samples"
    print_table(title, PARAMETER_COLUMNS, rows)
    print(
        "+- is the larger of std by (28), right for white noise, and of std robust, which allows for noise that is not"
    )
    print(f"rank {answer['rank']}, condition {answer['condition']:.3g}")
    show_residuals(answer)
    if answer["delay_s"] is not None:
        delay = answer["delay_s"]
        print(
            f"forces lag the motion by {delay['value'] * 1e3:.3f} +- {delay['std'] * 1e3:.3f} ms "
            "(estimated and compensated)"
        )
    for note in answer["notes"]:
        print(note)
    if "standstills" in answer:
        stops = answer["standstills"]
        source = "the poses of the program" if stops["matched_to_poses"] else "found where the machine stands"
        print(f"{stops['count']} averaged standstills, {source}, by the {stops['found_by']}; weighted by their scatter")
    for warning in answer["warnings"]:
        print(f"warning: {warning}")
    print(f"result written: {answer['result']}, with its report {answer['report']}")
    name, value, deviation, *_, unit = rows[0]
    print(f"{name}: {value} +- {deviation} {unit}")
