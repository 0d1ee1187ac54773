"""Motions of plans as JSON and back: series, moves and polynomial pieces, with SI units in the keys."""

import json
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cases.chain import MOST_JOINTS
from cases.parts import LARGEST
from cases.schema import Case
from identification.machines import machine_of
from identification.motion import Joined, Measurement, Standstill, Trajectory
from identification.trajectories.curves import FourierMotion, Piece, PolynomialMotion
from identification.trajectories.moves import CircularMove, Plane, StraightMove
from identification.trajectories.profile import Profile
from planner.families import Array, Family
from planner.families.ptp import unit_profile

FILE = Path(__file__).with_name("shipped.json")


def motion_entries(motion: Trajectory) -> dict[str, Any]:
    """Entries of `plan.json` that hold a motion.

    Raises:
        TypeError: no motion of a family.
    """
    if isinstance(motion, FourierMotion):
        return {
            "fourier": {
                "period_s": motion.period,
                "repeats": motion.repeats,
                "centre_m_rad": motion.centre.tolist(),
                "a_m_s_rad_s": motion.a.tolist(),
                "b_m_s_rad_s": motion.b.tolist(),
                **({"run_in_s": motion.run_in} if motion.run_in else {}),
            }
        }
    if isinstance(motion, Joined):
        return {"moves": [_part(part) for part in motion.parts]}
    if isinstance(motion, PolynomialMotion):
        pieces = [{"duration_s": p.duration, "coefficients_SI": p.coefficients.tolist()} for p in motion.pieces]
        return {"polynomial": pieces}
    raise TypeError(f"no entry for {type(motion).__name__}")


def _part(part: Trajectory) -> dict[str, Any]:
    if isinstance(part, StraightMove) and isinstance(part.profile, Profile):
        ends = {"start_m_rad": part.start.tolist(), "end_m_rad": part.end.tolist()}
        return {"kind": "straight", **ends, **_times(part.profile)}
    if isinstance(part, CircularMove) and isinstance(part.profile, Profile):
        return {
            "kind": "circle",
            "start_m_rad": part.start.tolist(),
            "end_angles_rad": part.end_angles.tolist(),
            "plane": part.plane.value,
            "centre_m": part.centre.tolist(),
            "angle_rad": part.angle,
            **_times(part.profile),
        }
    if isinstance(part, Standstill):
        return {"kind": "pause", "pose_m_rad": part.pose.tolist(), "duration_s": part.duration}
    if isinstance(part, Measurement):
        times = {"settle_s": part.settle, "average_s": part.average}
        return {"kind": "measure", "pose_m_rad": part.pose.tolist(), **times}
    raise TypeError(f"no entry for {type(part).__name__}")


def _times(profile: Profile) -> dict[str, float]:
    return {
        "jerk_time_s": profile.jerk_time,
        "hold_time_s": profile.hold_time,
        "cruise_time_s": profile.cruise_time,
    }


def motion_of_entries(data: dict[str, Any]) -> Trajectory:
    """The motion of `plan.json`.

    Raises:
        KeyError: no motion there, or an entry is missing.
        TypeError: an entry of the wrong kind.
        ValueError: an entry that describes no motion.
    """
    if "fourier" in data:
        return _fourier(data["fourier"])
    if "moves" in data:
        parts = tuple(_read_part(entry) for entry in data["moves"])
        if not parts:
            raise ValueError("moves")
        ends = [np.asarray(part.at([0.0, part.duration]).pose) for part in parts]
        if len({end.shape for end in ends}) > 1:
            raise ValueError("moves")
        if any(np.abs(before[1] - after[0]).max() > 1e-9 for before, after in pairwise(ends)):
            raise ValueError("moves")
        return Joined(parts)
    if "polynomial" in data:
        pieces = tuple(_read_piece(entry) for entry in data["polynomial"])
        if len({piece.coefficients.shape[1] for piece in pieces}) != 1:
            raise ValueError("polynomial")
        return PolynomialMotion(pieces)
    raise KeyError("fourier, moves or polynomial")


def _coordinates(entry: dict[str, Any], key: str, rows: int | None = None) -> Array:
    """Values of each coordinate, shape (n,) or (rows, n)."""
    value = np.array(entry[key], dtype=float)
    shape = value.shape if rows is None else value.shape[1:]
    if len(shape) != 1 or not 1 <= shape[0] <= MOST_JOINTS or (rows is not None and len(value) != rows):
        raise ValueError(key)
    return _numbers(entry, key, *value.shape)


def _numbers(entry: dict[str, Any], key: str, *shape: int) -> Array:
    value = np.array(entry[key], dtype=float)
    if value.shape != shape or not (np.abs(value) <= LARGEST).all():
        raise ValueError(key)
    return value


def _positive(entry: dict[str, Any], key: str, zero: bool = False) -> float:
    value = float(entry[key])
    if not (value <= LARGEST and (value > 0.0 or (zero and value == 0.0))):
        raise ValueError(key)
    return value


def _fourier(entry: dict[str, Any]) -> FourierMotion:
    order = len(entry["a_m_s_rad_s"])
    repeats = int(entry["repeats"])
    if order < 1 or repeats < 1:
        raise ValueError("a_m_s_rad_s" if order < 1 else "repeats")
    a, b = (_coordinates(entry, key, order) for key in ("a_m_s_rad_s", "b_m_s_rad_s"))
    run_in = _positive(entry, "run_in_s") if "run_in_s" in entry else 0.0
    centre = _coordinates(entry, "centre_m_rad")
    if not len(centre) == a.shape[1] == b.shape[1]:
        raise ValueError("centre_m_rad")
    return FourierMotion(centre, a, b, _positive(entry, "period_s"), repeats, run_in)


def _read_part(entry: dict[str, Any]) -> Trajectory:
    if entry["kind"] == "straight":
        start, end = (_coordinates(entry, key) for key in ("start_m_rad", "end_m_rad"))
        if len(start) != len(end):
            raise ValueError("end_m_rad")
        return StraightMove(start, end, _profile(entry))
    if entry["kind"] == "circle":
        return CircularMove(
            _numbers(entry, "start_m_rad", 6),
            _numbers(entry, "end_angles_rad", 3),
            Plane(entry["plane"]),
            _numbers(entry, "centre_m", 2),
            float(_numbers(entry, "angle_rad")),
            _profile(entry),
        )
    if entry["kind"] == "pause":
        return Standstill(_coordinates(entry, "pose_m_rad"), _positive(entry, "duration_s"))
    if entry["kind"] == "measure":
        settle, average = _positive(entry, "settle_s", zero=True), _positive(entry, "average_s")
        return Measurement(_coordinates(entry, "pose_m_rad"), settle, average)
    raise ValueError("kind")


def _profile(entry: dict[str, Any]) -> Profile:
    jerk, hold, cruise = (_positive(entry, f"{k}_time_s", zero=True) for k in ("jerk", "hold", "cruise"))
    if jerk == hold == 0.0:  # nothing would accelerate
        raise ValueError("hold_time_s")
    return unit_profile(jerk, hold, cruise)


def _read_piece(entry: dict[str, Any]) -> Piece:
    coefficients = np.array(entry["coefficients_SI"], dtype=float)
    if coefficients.ndim != 2 or not 1 <= len(coefficients) <= 6:
        raise ValueError("coefficients_SI")
    return Piece(_coordinates(entry, "coefficients_SI", len(coefficients)), _positive(entry, "duration_s"))


def shipped_start(family: Family, case: Case) -> Array | None:
    """Unknowns of a family from which a search begins, limits of the machine apart; None where nothing fits it.

    Good motions of different machines are alike: in half widths of their boxes (Fourier series, splines), in longest
    steps (point-to-point). A search that begins from one ends higher than from random starts, and sooner; random starts
    follow. `tests/bench/shipped_starts.py` has searched for them on the built-in hexapod.
    """
    if not machine_of(case).of_pose or family.shipped not in _shipped():
        return None
    return family.like(_shipped()[family.shipped])


@cache
def _shipped() -> dict[str, Array]:
    """Names of families -> their tables, shape (n, columns)."""
    tables = json.loads(FILE.read_text(encoding="utf-8"))
    return {name: np.array(tables[name]["table"]) for name in tables}
