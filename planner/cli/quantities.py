"""Values with units as users type them: `m=93.1kg`, `xC=0.5mm`, `m=33+-0.5kg`."""

import re
from collections.abc import Mapping, Sequence

from cases.errors import HexciteError
from cases.units import MM

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
        texts: as typed.
        units: SI unit of each parameter that may be named.
        option: that they were given with, for messages.

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
    found = _VALUE.fullmatch(text.strip())
    if found is None:
        raise HexciteError(f"{option} {text}: is not understood; write {example}")
    name = found["name"]
    if name not in units:
        raise HexciteError(f"{option} {text}: {name} is no parameter here; choose from {', '.join(units)}")
    known = _UNITS[units[name]]
    if found["unit"] not in known:
        problem = "has no unit" if found["unit"] is None else f"unit {found['unit']} does not fit {name}"
        raise HexciteError(f"{option} {text}: {problem}; give {' or '.join(known)}")
    factor = known[found["unit"]]
    return name, float(found["value"]) * factor, None if found["std"] is None else float(found["std"]) * factor
