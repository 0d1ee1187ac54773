"""Standard deviations that a user wants to be met, as typed."""

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cases.errors import HexciteError
from cases.schema import Case
from identification.model import identification_model
from identification.parameters import physical_form

UNITS = {
    "kg": ("kg", 1.0),
    "g": ("kg", 1e-3),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "kgm2": ("kg m^2", 1.0),
    "N": ("N", 1.0),
    "N/m": ("N/m", 1.0),
    "Nm/m": ("N m/m", 1.0),
    "Nm": ("N m", 1.0),
}
NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"


class Target(NamedTuple):
    """A standard deviation that shall not be exceeded."""

    name: str  # name of the physical parameter
    std: float  # [SI]
    text: str  # as the user wrote it
    unit: str  # unit in which the user wrote it

    def share(self, predicted: Mapping[str, float]) -> float:
        """Share of it that predicted standard deviations [SI] use; it is met up to 1."""
        return predicted[self.name] / self.std

    def compared(self, predicted: Mapping[str, float]) -> str:
        """What is predicted and what is wanted, in the user's unit."""
        scale = UNITS[self.unit][1]
        return f"{self.name} {predicted[self.name] / scale:.3g} of {self.std / scale:.3g} {self.unit}"


def parse_targets(words: tuple[str, ...], case: Case, model: int) -> tuple[Target, ...]:
    """Targets such as m=0.05kg or zC=0.3mm.

    Raises:
        HexciteError: not of this form, an unknown parameter, or a unit that is not the parameter's.
    """
    known = {p.name: p.unit for p in physical_form(identification_model(case, model)).parameters}
    targets = []
    for word in words:
        match = re.fullmatch(rf"(\w+)=({NUMBER}) *([A-Za-z][A-Za-z0-9/^ ]*)", word.strip())
        if match is None:
            raise HexciteError(f"target {word!r} is not of the form m=0.05kg; name, number and unit")
        name, number, unit = match[1], match[2], match[3].replace("^", "").replace(" ", "")
        if name not in known:
            raise HexciteError(f"target {word!r}: model {model} has no {name}; choose {', '.join(known)}")
        if unit not in UNITS or UNITS[unit][0] != known[name]:
            units = ", ".join(u for u, (base, _) in UNITS.items() if base == known[name])
            raise HexciteError(f"target {word!r}: {name} is not measured in {match[3]}; choose {units}")
        std = float(number) * UNITS[unit][1]
        if not (np.isfinite(std) and std > 0.0):
            raise HexciteError(f"target {word!r}: {number} is not a positive number")
        targets.append(Target(name, std, word, unit))
    return tuple(targets)
