"""A plan as a folder, and back: its motion as JSON, with SI units in the keys, and the checks on reading."""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, TypeAdapter, ValidationError

from cases.base.errors import Code, FileProblem, HexciteError
from cases.base.file_reading import DAMAGED
from cases.tables import LARGEST
from identification.motion.curves import FourierMotion, PolynomialMotion
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import CircularMove, Plane, StraightMove, unit_profile
from planner.families.plan_settings import PlanSettings, settings_of
from planner.plans.prediction import Gain, Promise

SCHEMA_VERSION = 1
LONGEST_OF_POSES = 4 * 3600.0  # [s] of a measurement at poses: the paper's took 21 min
DIGITS = 16  # digits of a fingerprint


def fingerprint_of(content: bytes) -> str:
    """Fingerprint of the content of a plan.json: the first 16 digits of its SHA-256."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


class Entries(BaseModel, strict=True, frozen=True):
    """Entries that every plan.json has, whatever its motion; those with a default are absent of poses."""

    case_file: str
    case_hash: str
    family: str
    model: int
    criterion: str
    payload: int = 0
    payload_from: int = 0
    predicted_std: dict[str, float]  # [SI]
    predicted_budget: dict[str, dict[str, float]] = Field(default_factory=dict)  # [SI]
    predicted_least: dict[str, float] = Field(default_factory=dict)  # [SI]
    assumed_noise_N: float
    assumed_rate_Hz: float
    settings: Annotated[PlanSettings, BeforeValidator(settings_of)]
    solve_s: float
    known: dict[str, Any] | None = None
    interrupted: bool = False
    content: str = ""

    @property
    def gain(self) -> Gain | None:
        """What its run adds to what was known; raises KeyError, TypeError or ValueError where that is damaged."""
        if self.known is None:
            return None
        entry = {key: value for key, value in self.known.items() if key != "loose"}
        return TypeAdapter(Gain).validate_python(entry)

    @property
    def promise(self) -> Promise:
        """What it promises."""
        return Promise(self.predicted_std, self.predicted_budget, self.predicted_least)


@contextmanager
def refusing(file: Path) -> Iterator[None]:
    """Inside, an error about an entry becomes a FileProblem that names it."""
    try:
        yield
    except FileProblem:
        raise
    except HexciteError as error:
        raise FileProblem(place=file, problem=error.message, remedy="plan again", code=Code.DAMAGED) from error
    except (ValidationError, *DAMAGED) as error:
        place = str(error).strip()  # NumPy's own sentences end in a blank
        if isinstance(error, ValidationError):
            place = ".".join(map(str, error.errors()[0]["loc"]))
        raise FileProblem(
            place=file, problem=f"entry {place} is missing or damaged", remedy="plan again", code=Code.DAMAGED
        ) from error


_FOURIER = {
    "period": "period_s",
    "repeats": "repeats",
    "centre": "centre_m_rad",
    "a": "a_m_s_rad_s",
    "b": "b_m_s_rad_s",
}
_RUN_IN = {"run_in": "run_in_s"}  # of order 1 alone
_PROFILE = {"jerk_time": "jerk_time_s", "hold_time": "hold_time_s", "cruise_time": "cruise_time_s"}
_CIRCLE = {"start": "start_m_rad", "end_angles": "end_angles_rad", "centre": "centre_m", "angle": "angle_rad"}
_MOVES: dict[str, tuple[Callable[..., Trajectory], dict[str, str]]] = {
    "straight": (StraightMove, {"start": "start_m_rad", "end": "end_m_rad"}),
    "circle": (CircularMove, _CIRCLE | {"plane": "plane"}),
    "pause": (Standstill, {"coordinates": "pose_m_rad", "settle": "duration_s"}),
    "measure": (Standstill, {"coordinates": "pose_m_rad", "settle": "settle_s", "average": "average_s"}),
}
"""Kinds of moves: what makes them, and the entry of each of its fields; a time law has entries of its own."""


def motion_entries(motion: Trajectory) -> dict[str, Any]:
    """Entries of `plan.json` that hold a motion.

    Raises:
        TypeError: the motion is not one of a family.
    """
    if isinstance(motion, FourierMotion):
        return {"fourier": _written(motion, _FOURIER | (_RUN_IN if motion.run_in else {}))}
    if isinstance(motion, Joined):
        return {"moves": [_move_entries(part) for part in motion.parts]}
    if isinstance(motion, PolynomialMotion):
        both = zip(motion.durations.tolist(), motion.table.swapaxes(0, 1).tolist(), strict=True)
        pieces = [{"duration_s": duration, "coefficients_SI": coefficients} for duration, coefficients in both]
        return {"polynomial": pieces}
    raise TypeError(f"no entry for {type(motion).__name__}")


def _move_entries(move: Trajectory) -> dict[str, Any]:
    if isinstance(move, Standstill):
        kind = "measure" if move.average else "pause"
        return {"kind": kind, **_written(move, _MOVES[kind][1])}
    if isinstance(move, StraightMove | CircularMove):
        kind = "straight" if isinstance(move, StraightMove) else "circle"
        return {"kind": kind, **_written(move, _MOVES[kind][1]), **_written(move.profile, _PROFILE)}
    raise TypeError(f"no entry for {type(move).__name__}")


def _written(value: object, keys: Mapping[str, str]) -> dict[str, Any]:
    fields = {key: getattr(value, name) for name, key in keys.items()}
    arrays = {key: field.tolist() for key, field in fields.items() if isinstance(field, np.ndarray)}
    return fields | arrays | {key: field.value for key, field in fields.items() if isinstance(field, Plane)}


def motion_of_entries(data: Mapping[str, Any]) -> Trajectory:
    """The motion of `plan.json`; whatever it is of, its figures tell whether it was changed.

    Raises:
        KeyError: the motion or an entry is missing.
        TypeError, ValueError, ArithmeticError: an entry does not describe a motion.
    """
    if "fourier" in data:
        entry = {"run_in_s": 0.0} | data["fourier"]
        if entry["repeats"] % 1:  # it would end in motion
            raise ValueError("repeats")
        return FourierMotion(**_read(entry, _FOURIER | _RUN_IN))
    if "moves" in data:
        parts = tuple(_move(number, entry) for number, entry in enumerate(data["moves"]))
        ends = [np.asarray(part.at([0.0, part.duration]).coordinates) for part in parts]
        one_machine = len({end.shape for end in ends}) == 1
        if not one_machine or any(np.abs(before[1] - after[0]).max() > 1e-9 for before, after in pairwise(ends)):
            raise ValueError("moves")
        return Joined(parts)
    if "polynomial" in data:
        pieces = [(_value(entry, "coefficients_SI"), _value(entry, "duration_s")) for entry in data["polynomial"]]
        return PolynomialMotion.of_pieces(pieces)
    raise KeyError("fourier, moves or polynomial")


def _move(number: int, entry: Mapping[str, Any]) -> Trajectory:
    try:
        make, keys = _MOVES[entry["kind"]]
        law = {} if make is Standstill else {"profile": unit_profile(**_read(entry, _PROFILE))}
        return make(**_read(entry, keys), **law)
    except DAMAGED as error:
        raise ValueError(f"moves[{number}] ({error})") from error


def _read(entry: Mapping[str, Any], keys: Mapping[str, str]) -> dict[str, Any]:
    return {name: _value(entry, key) for name, key in keys.items()}


def _value(entry: Mapping[str, Any], key: str) -> Any:
    """A field of a motion: coordinates, a number or a plane; ValueError where it cannot be one."""
    value = entry[key]
    if key == "plane":
        return Plane(value)
    array = np.array(value, dtype=float)
    if not array.size or array.ndim > 2 or not np.all(np.abs(array) <= LARGEST):
        raise ValueError(key)
    if array.ndim:
        return array
    if key.endswith("_s") and value < 0.0:
        raise ValueError(key)
    return value
