"""What the options of identify say: how the equations are conditioned, and values that are known beforehand."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from cases.errors import HexciteError
from cases.schema import Case
from cases.units import MM
from identification.estimation.estimators import Method, method
from identification.estimation.priors import Prior
from identification.estimation.selection import symmetric_platform
from identification.model import Model
from identification.parameters import physical_form
from identification.samples import Conditioning, Periodic
from identification.saved_result import biases_of

AUTO = "auto"


def read_conditioning(period: str | None, harmonics: int | None, flexible: bool = False) -> Conditioning:
    """The conditioning that options ask for.

    Args:
        period: `auto` or seconds, as typed.
        harmonics: harmonics of the series.
        flexible: whether a structural mode is estimated.

    Raises:
        HexciteError: not understood, or options that do not go together.
    """
    if harmonics is not None and period is None:
        raise HexciteError(f"--harmonics {harmonics}: is for periodic runs; add --period auto or --period SECONDS")
    if harmonics is not None and harmonics < 1:
        raise HexciteError(f"--harmonics {harmonics}: is not a number of harmonics; give 1 or more")
    if flexible and period is not None:
        raise HexciteError("--flexible: lowers the low-pass, which --period does without; leave one of them out")
    if period is None:
        return Conditioning(flexible=flexible)
    return Conditioning(Periodic(None if period == AUTO else _seconds(period), harmonics))


def _seconds(text: str) -> float:
    try:
        value = float(text.removesuffix("s"))
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise HexciteError(f"--period {text}: is not a period; give auto or seconds, as --period 3")
    return value


_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_VALUE = re.compile(rf"(?P<name>\w+)=(?P<value>{_NUMBER})(?:(?:\+-|±)(?P<std>{_NUMBER}))?\s*(?P<unit>[^0-9\s][^\s]*)?")

# SI unit of a parameter -> what users may write instead, and its SI value.
_UNITS: Mapping[str, Mapping[str, float]] = {
    "kg": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "m": {"m": 1.0, "mm": MM},
    "kg m": {"kgm": 1.0, "kgmm": MM},
    "kg m^2": {"kgm2": 1.0, "kgmm2": MM**2},
    "N": {"N": 1.0, "kN": 1e3},
    "N m": {"Nm": 1.0, "Nmm": MM},
    "N/m": {"N/m": 1.0, "N/mm": 1.0 / MM},
    "N m/m": {"Nm/m": 1.0, "Nm/mm": 1.0 / MM},
    "N s^2/m": {"Ns2/m": 1.0, "kg": 1.0},
}


def read_values(texts: Sequence[str], units: Mapping[str, str], option: str) -> dict[str, float]:
    """Exact values in SI by name.

    Args:
        texts: typed texts.
        units: SI unit of each parameter that may be named.
        option: option that they were given with, for messages.

    Raises:
        HexciteError: not understood, an unknown name, a missing or unknown unit, or a name given twice.
    """
    values: dict[str, float] = {}
    for text in texts:
        name, value, std = _read(text, units, option, f"{option} m=93.1kg")
        if std is not None:
            raise HexciteError(f"{option} {text}: is exact; write an uncertain value as --prior {text}")
        if name in values:
            raise HexciteError(f"{option} {text}: {name} is given twice; give it once")
        values[name] = value
    return values


def read_uncertain(texts: Sequence[str], units: Mapping[str, str], option: str) -> list[tuple[str, float, float]]:
    """Values with standard deviations in SI, as (name, value, std); errors as `read_values`."""
    values = []
    for text in texts:
        name, value, std = _read(text, units, option, f"{option} m=33+-0.5kg")
        if std is None:
            raise HexciteError(f"{option} {text}: has no standard deviation; write it as {option} m=33+-0.5kg")
        values.append((name, value, std))
    return values


def _read(text: str, units: Mapping[str, str], option: str, example: str) -> tuple[str, float, float | None]:
    match = _VALUE.fullmatch(text.strip())
    if match is None:
        raise HexciteError(f"{option} {text}: is not understood; write {example}")
    name = match["name"]
    if name not in units:
        raise HexciteError(f"{option} {text}: {name} is not a parameter here; choose from {', '.join(units)}")
    factors = _UNITS[units[name]]
    if match["unit"] not in factors:
        problem = "has no unit" if match["unit"] is None else f"unit {match['unit']} does not fit {name}"
        raise HexciteError(f"{option} {text}: {problem}; give {' or '.join(factors)}")
    factor = factors[match["unit"]]
    return name, float(match["value"]) * factor, None if match["std"] is None else float(match["std"]) * factor


class Typed(NamedTuple):
    """What a user asks of an identification, as typed."""

    estimator: str = "gauss-markov"  # its name
    fix: tuple[str, ...] = ()  # known values
    drop: tuple[str, ...] = ()  # names to leave out
    symmetric: bool = False  # whether the platform is symmetric
    prior: tuple[str, ...] = ()  # uncertain values
    weights: str | None = None  # instead of the case's
    biases: Path | None = None  # result whose offsets are taken
    stale: bool = False  # go on although the case has changed since the biases were identified


def method_of(wish: Typed, model: Model, case: Case) -> Method:
    """The method that a user asks for.

    Raises:
        HexciteError: a value that is not understood, a name that the model does not have, an unknown estimator, a
            result that is none or belongs to another case.
    """
    units = {p.name: p.unit for p in (*model.parameters, *physical_form(model).parameters)}
    constants = read_values(wish.fix, units, "--fix")
    if wish.symmetric:
        constants = symmetric_platform(model) | constants
    priors = [Prior(*values) for values in read_uncertain(wish.prior, units, "--prior")]
    biases = None if wish.biases is None else biases_of(wish.biases, case, wish.stale)
    return method(wish.estimator, constants, wish.drop, priors, wish.weights, biases)
