"""A plan as a folder, and back: its motion as JSON, with SI units in the keys, and the checks on reading."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import BaseModel, ValidationError

from cases.basis import case_of, changes_since, plan_basis, require_unchanged
from cases.chain import MOST_JOINTS
from cases.errors import FileProblem, HexciteError
from cases.files import DAMAGED, read_json
from cases.schema import Case
from cases.tables import LARGEST
from cases.units import Array
from identification.criteria import Criterion, pose_regressors, reference_scaling, singular_values, total_information
from identification.limit import LimitReport
from identification.model import identification_model
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.curves import FourierMotion, PolynomialMotion
from identification.trajectories.moves import CircularMove, Plane, Profile, StraightMove, unit_profile
from planner.noise import standing_model
from planner.plan_figures import PoseWorth, Worth, figures_of, predicted_std_at_poses
from planner.request import LONGEST, PoseRequest, Request

if TYPE_CHECKING:
    from planner.plans import Plan

SCHEMA_VERSION = 1
LONGEST_OF_POSES = 4 * 3600.0  # [s] of a measurement at poses: the paper's took 21 min
RATE_OF_0_1 = 1000.0  # [1/s] rate that plans of the first version assumed without stating it
DIGITS = 16  # digits of a fingerprint


def fingerprint_of(content: bytes) -> str:
    """Fingerprint of the content of a plan.json: the first 16 digits of its SHA-256."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def load_plan(kind: "type[Plan]", folder: Path, case: Case | None, stale: bool) -> "Plan":
    """Reads a plan folder; its figures are computed anew from its motion and compared.

    Args:
        kind: the type of plans.
        case: replaces the case that the plan names, which may have been moved.
        stale: whether to read it although its case has changed.

    Raises:
        FileProblem: the folder has no plan, it is damaged or changed by hand, or its case has changed since.
        CaseError: its case does not exist any more or is not valid.
    """
    file = folder / "plan.json"
    data = read_json(file, "hexcite plan")
    if data.get("schema_version", SCHEMA_VERSION) != SCHEMA_VERSION:
        raise FileProblem(file, f"schema_version {data['schema_version']!r}, expected {SCHEMA_VERSION}", "plan again")
    with _refusing(file):
        entries = Entries.model_validate(data)
        motion = motion_of_entries(data)
    of_poses = data["family"] == PoseRequest.name
    if not motion.duration <= (LONGEST_OF_POSES if of_poses else LONGEST):
        raise FileProblem(file, f"a motion of {motion.duration:g} s is not an excitation", "plan again")
    own = case_of(file, data, "plan again") if case is None else case
    count = len(own.need_motion("a plan")[0])
    if motion.at([0.0]).pose.shape[1] != count:
        raise FileProblem(file, f"its motion does not have the {count} coordinates of case {own.name}; plan again")
    now = plan_basis(own, entries.payload, of_poses)
    remarks = require_unchanged(file, data, now, own, stale, "plan again")
    with _refusing(file):
        parameters = len(identification_model(own, entries.model).parameters)
        request = PoseRequest.of_json(data) if of_poses else Request.of_json(data)
        worth = PoseWorth.of_json(data) if of_poses else Worth.of_json(data, parameters)
        limits = LimitReport.of_json(data["limits"])
        plan = kind(
            own, request, motion, limits, entries.predicted_std, entries.assumed_noise_N, entries.assumed_rate_Hz,
            worth, entries.settings, entries.solve_s, entries.interrupted,
            folder, fingerprint_of(file.read_bytes()), remarks,
        )  # fmt: skip
        if not changes_since(data, now, own.hash):
            _require_own_figures(file, data, plan)
    return plan


class Entries(BaseModel, strict=True, frozen=True):
    """Entries that every plan.json has, whatever its motion; those with a default may be absent."""

    case_file: str
    case_hash: str
    family: str
    model: int
    criterion: str
    payload: int = 0  # poses have none
    payload_from: int = 0
    predicted_std: dict[str, float]  # [SI]
    assumed_noise_N: float
    assumed_rate_Hz: float = RATE_OF_0_1
    settings: dict[str, Any]
    solve_s: float
    interrupted: bool = False  # poses have none


@contextmanager
def _refusing(file: Path) -> Iterator[None]:
    """Inside, an error about an entry becomes a FileProblem that names it."""
    try:
        yield
    except FileProblem:
        raise
    except HexciteError as error:
        raise FileProblem(file, error.typed, "plan again") from error
    except (ValidationError, *DAMAGED) as error:
        place: object = error
        if isinstance(error, ValidationError):
            place = ".".join(map(str, error.errors()[0]["loc"]))
        raise FileProblem(file, f"entry {place} is missing or damaged", "plan again") from error


ALIKE = 1e-3  # tolerance of figures that are computed anew: another computer rounds otherwise
CLOCK = 1e-6  # [s] tolerance of durations, which add up alike everywhere


def _require_own_figures(file: Path, data: dict[str, Any], plan: "Plan") -> None:
    """Raises FileProblem where an entry of plan.json does not agree with the motion in it."""
    size = 1.0  # an efficiency to a thousandth is a log det to a thousandth of the parameters
    if isinstance(plan.worth, PoseWorth):
        model, poses, noise = standing_model(plan.case, plan.model), plan.poses, plan.assumed_noise
        scaling = reference_scaling(plan.case, model)
        regressors = pose_regressors(model, poses) * scaling
        singular_values(total_information(regressors), model.names)  # raises where they do not determine the model
        figures = {"count": float(len(poses))}
        predicted = predicted_std_at_poses(plan.case, model, scaling, regressors, poses, noise)
    else:
        rate = plan.case.recording.model_copy(update={"rate_Hz": plan.assumed_rate})
        case = plan.case.model_copy(update={"recording": rate})
        model = identification_model(case, plan.model)
        size = float(len(model.names))
        figures, _, predicted = figures_of(case, model, plan.motion, plan.payloads, plan.request.criterion)
        figures |= {"d_efficiency": plan.worth.bound.efficiency(figures["logdet"])}
        if plan.case.sensors.pose_field is not None:  # earlier versions counted such errors in it
            del figures["criterion_value"]
    if list(predicted) != list(plan.predicted_std):
        raise ValueError("predicted_std")
    figures |= {"duration_s": plan.duration} | {f"predicted_std.{name}": std for name, std in predicted.items()}
    stated = data | {f"predicted_std.{name}": std for name, std in data["predicted_std"].items()}
    for key, value in figures.items():
        entry = stated[key]
        of_logdet = key == "logdet" or (key == "criterion_value" and plan.request.criterion == Criterion.D)
        within, digits = ALIKE * (size if of_logdet else abs(value)), 6
        if key == "duration_s":
            within, digits = CLOCK, 9
        if isinstance(entry, bool) or not isinstance(entry, int | float) or not abs(entry - value) <= within:
            words = f"{entry:.{digits}g}" if isinstance(entry, int | float) else repr(entry)
            problem = f"{key} is {words}, but {value:.{digits}g} by its motion: changed by hand or by another version"
            raise FileProblem(file, problem, "plan again")


def motion_entries(motion: Trajectory) -> dict[str, Any]:
    """Entries of `plan.json` that hold a motion.

    Raises:
        TypeError: the motion is not one of a family.
    """
    if isinstance(motion, FourierMotion):
        return {
            "fourier": {
                "period_s": motion.period,
                "repeats": motion.repeats,
                "centre_m_rad": motion.centre.tolist(),
                "a_m_s_rad_s": motion.a.tolist(),
                "b_m_s_rad_s": motion.b.tolist(),
            }
        }
    if isinstance(motion, Joined):
        return {"moves": [_part(part) for part in motion.parts]}
    if isinstance(motion, PolynomialMotion):
        both = zip(motion.durations.tolist(), motion.table.swapaxes(0, 1).tolist(), strict=True)
        pieces = [{"duration_s": duration, "coefficients_SI": coefficients} for duration, coefficients in both]
        return {"polynomial": pieces}
    raise TypeError(f"no entry for {type(motion).__name__}")


def _part(part: Trajectory) -> dict[str, Any]:
    if isinstance(part, StraightMove):
        ends = {"start_m_rad": part.start.tolist(), "end_m_rad": part.end.tolist()}
        return {"kind": "straight", **ends, **_times(part.profile)}
    if isinstance(part, CircularMove):
        return {
            "kind": "circle",
            "start_m_rad": part.start.tolist(),
            "end_angles_rad": part.end_angles.tolist(),
            "plane": part.plane.value,
            "centre_m": part.centre.tolist(),
            "angle_rad": part.angle,
            **_times(part.profile),
        }
    if isinstance(part, Standstill) and not part.average:
        return {"kind": "pause", "pose_m_rad": part.pose.tolist(), "duration_s": part.duration}
    if isinstance(part, Standstill):
        times = {"settle_s": part.settle, "average_s": part.average}
        return {"kind": "measure", "pose_m_rad": part.pose.tolist(), **times}
    raise TypeError(f"no entry for {type(part).__name__}")


def _times(profile: Profile) -> dict[str, float]:
    return {"jerk_time_s": profile.jerk_time, "hold_time_s": profile.hold_time, "cruise_time_s": profile.cruise_time}


def motion_of_entries(data: dict[str, Any]) -> Trajectory:
    """The motion of `plan.json`.

    Raises:
        KeyError: the motion or an entry is missing.
        TypeError: an entry has the wrong type.
        ValueError: an entry does not describe a motion.
    """
    if "fourier" in data:
        return _fourier(data["fourier"])
    if "moves" in data:
        parts = tuple(_read_part(entry) for entry in data["moves"])
        ends = [np.asarray(part.at([0.0, part.duration]).pose) for part in parts]
        one_machine = len({end.shape for end in ends}) == 1
        if not one_machine or any(np.abs(before[1] - after[0]).max() > 1e-9 for before, after in pairwise(ends)):
            raise ValueError("moves")
        return Joined(parts)
    if "polynomial" in data:
        pieces = tuple(_read_piece(entry) for entry in data["polynomial"])
        if len({coefficients.shape[1] for coefficients, _ in pieces}) != 1:
            raise ValueError("polynomial")
        return PolynomialMotion.of_pieces(pieces)
    raise KeyError("fourier, moves or polynomial")


def _coordinates(entry: dict[str, Any], key: str, dimensions: int = 1) -> Array:
    """Values of each coordinate, shape (n,) or (rows, n)."""
    shape = np.shape(entry[key])
    if len(shape) != dimensions or not all(shape) or shape[-1] > MOST_JOINTS:
        raise ValueError(key)
    return _numbers(entry, key, *shape)


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
    repeats, centre = int(entry["repeats"]), _coordinates(entry, "centre_m_rad")
    if repeats < 1:
        raise ValueError("repeats")
    a, b = (_coordinates(entry, key, 2) for key in ("a_m_s_rad_s", "b_m_s_rad_s"))
    if a.shape != b.shape or len(centre) != a.shape[1]:
        raise ValueError("centre_m_rad")
    if "run_in_s" in entry:  # of order 1, which versions before this one planned
        raise ValueError("run_in_s")
    return FourierMotion(centre, a, b, _positive(entry, "period_s"), repeats)


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
        return Standstill(_coordinates(entry, "pose_m_rad"), settle, average)
    raise ValueError("kind")


def _profile(entry: dict[str, Any]) -> Profile:
    jerk, hold, cruise = (_positive(entry, f"{k}_time_s", zero=True) for k in ("jerk", "hold", "cruise"))
    if jerk == hold == 0.0:  # nothing would accelerate
        raise ValueError("hold_time_s")
    return unit_profile(jerk, hold, cruise)


def _read_piece(entry: dict[str, Any]) -> tuple[Array, float]:
    coefficients = _coordinates(entry, "coefficients_SI", 2)
    if len(coefficients) > 6:
        raise ValueError("coefficients_SI")
    return coefficients, _positive(entry, "duration_s")
