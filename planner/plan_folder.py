"""A plan as a folder, and back."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.basis import Artefact, plan_basis
from cases.errors import FileProblem, HexciteError
from cases.files import DAMAGED, PLAN, atomic_folder, check_folder, json_text, read_json
from cases.schema import Case
from identification.criteria import CRITERIA, reference_scaling, singular_values
from identification.limit import LimitReport
from identification.model import Model, identification_model
from identification.motion import Joined, Measurement, Trajectory, sample
from planner.deviations import predicted_std_at_poses, worst_std
from planner.families.saved import motion_of_entries
from planner.families.settings import FAMILIES
from planner.noise import (
    ExpectedNoise,
    PoseErrors,
    expected_noise,
    information_of,
    mean_information,
    seen_through,
    standing_model,
)
from planner.plans import SAMPLE_RATE, SCHEMA_VERSION, Plan, Saved, motion_csv, poses_in_units
from planner.poses.pose_criteria import pose_regressors, total_information
from planner.request import LONGEST, PoseRequest, Request
from planner.worth import PoseWorth, Worth

LONGEST_OF_POSES = 4 * 3600.0  # [s] of a measurement at poses: the paper's took 21 min
RATE_OF_0_1 = 1000.0  # [1/s], which plans of the first version assumed without saying so
DIGITS = 16  # of a fingerprint


def save_plan(plan: Plan, folder: Path, overwrite: bool = False) -> None:
    """Makes a folder with plan.json, and motion.csv or poses.csv.

    Args:
        overwrite: whether a plan that stands there may be replaced.

    Raises:
        FileProblem: the folder is somebody's, or cannot be written.
    """
    check_folder(folder, PLAN, overwrite=overwrite)
    with atomic_folder(folder, PLAN, overwrite) as part:
        write_plan(plan, part)


def write_plan(plan: Plan, folder: Path) -> None:
    """Writes the files of a plan into a folder that is there."""
    if isinstance(plan.worth, PoseWorth):
        rows = [
            f"{k}," + ",".join(f"{v:.9g}" for v in row)
            for k, row in enumerate(poses_in_units(plan.poses, plan.case), 1)
        ]
        name, table = (
            "poses.csv",
            "\n".join([",".join(("pose", *plan.case.need_motion("a plan")[1].columns)), *rows]) + "\n",
        )
    else:
        name, table = "motion.csv", motion_csv(sample(plan.motion, SAMPLE_RATE), plan.case)
    (folder / "plan.json").write_text(plan_text(plan), encoding="utf-8")
    (folder / name).write_text(table, encoding="utf-8")


def plan_text(plan: Plan) -> str:
    """The content of plan.json."""
    return json_text(plan.to_json())


def fingerprint(plan: Plan) -> str:
    """The first 16 digits of the SHA-256 of its plan.json, wherever the folder is."""
    return fingerprint_of(plan_text(plan).encode()) if plan.saved is None else plan.saved.fingerprint


def fingerprint_of(content: bytes) -> str:
    """Of a plan.json."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def load_plan(folder: Path, case: Case | None = None, stale: bool = False) -> Plan:
    """Reads a plan folder; its figures are computed anew from its motion and compared.

    Args:
        folder: its folder.
        case: stands for the case that the plan names, which may have been moved.
        stale: read it although what it was computed from has changed in its case.

    Raises:
        FileProblem: no plan there, damaged, changed by hand, or its case has changed since.
        CaseError: its case is gone or no longer valid.
    """
    file = folder / "plan.json"
    data = read_json(file, "hexcite plan")
    if data.get("schema_version", SCHEMA_VERSION) != SCHEMA_VERSION:
        raise FileProblem(file, f"schema_version {data['schema_version']!r}, expected {SCHEMA_VERSION}", "plan again")
    try:
        for key in ("case_file", "case_hash", "family", "model"):
            if key not in data:
                raise KeyError(key)
        motion = motion_of_entries(data)
    except DAMAGED as error:
        raise FileProblem(file, f"entry {error} is missing or damaged", "plan again") from error
    of_poses = data["family"] == PoseRequest.name
    if not motion.duration <= (LONGEST_OF_POSES if of_poses else LONGEST):
        raise FileProblem(file, f"a motion of {motion.duration:g} s is not an excitation", "plan again")
    artefact = Artefact(file, data, "plan again")
    own = artefact.case() if case is None else case
    count = len(own.need_motion("a plan")[0])
    if motion.at([0.0]).pose.shape[1] != count:
        raise FileProblem(f"{file}: its motion does not have the {count} coordinates of case {own.name}; plan again")
    payload = data.get("payload", 0)
    now = plan_basis(own, payload if isinstance(payload, int) else 0, of_poses)
    remarks = artefact.require_unchanged(now, own, stale)
    if not artefact.changes(now, own.hash) and (problem := problem_of(data, motion, own)):
        raise FileProblem(file, problem, "plan again")
    saved = Saved(folder, fingerprint_of(file.read_bytes()), remarks)
    try:
        parameters = len(identification_model(own, int(data["model"])).parameters)
        request = PoseRequest.of_json(data) if of_poses else Request.of_json(data)
        worth = PoseWorth.of_json(data) if of_poses else Worth.of_json(data, parameters)
        limits = LimitReport.of_json(data["limits"])
        predicted = {str(name): float(std) for name, std in data["predicted_std"].items()}
        noise, rate = float(data["assumed_noise_N"]), float(data.get("assumed_rate_Hz", RATE_OF_0_1))
        return Plan(own, request, motion, limits, predicted, noise, rate, worth, saved)
    except HexciteError as error:
        raise FileProblem(file, error.typed, "plan again") from error
    except DAMAGED as error:
        raise FileProblem(file, f"entry {error} is missing or damaged", "plan again") from error


Array = NDArray[np.float64]

ALIKE = 1e-3  # of figures that are computed anew: another computer rounds otherwise, nobody reads further

CLOCK = 1e-6  # [s] of durations


_Mismatch = tuple[str, object, float]
"""A figure that is not the motion's: the key of plan.json, what it says there and what it should be."""


def mismatches(data: dict[str, Any], motion: Trajectory, case: Case) -> Iterator[_Mismatch]:
    """Figures of plan.json that the motion beside them does not have, one after the other.

    Args:
        motion: motion that its entries describe.

    Raises:
        KeyError: a figure is missing.
        TypeError: a figure of the wrong kind.
        ValueError: a figure that is not a number.
        HexciteError: the motion does not determine the model, or the model is unknown.
    """
    if data["family"] not in (*FAMILIES, "poses"):
        raise ValueError("family")
    yield from _unlike("duration_s", data["duration_s"], motion.duration, CLOCK)
    if data["family"] == "poses":
        yield from _of_poses(data, motion, case)
    else:
        yield from _of_excitation(data, motion, case)


def _of_excitation(data: dict[str, Any], motion: Trajectory, case: Case) -> Iterator[_Mismatch]:
    case = _recorded_as_planned(case, data)
    model = identification_model(case, _whole(data, "model"))
    scaling = reference_scaling(case, model)
    information = mean_information(model, scaling, motion)
    mu = singular_values(information, model.names)
    logdet = CRITERIA["D"].of(mu)
    yield from _unlike("logdet", data["logdet"], logdet, ALIKE * len(mu))
    yield from _unlike("condition", data["condition"], -CRITERIA["K"].of(mu))
    efficiency = float(np.exp((logdet - float(data["bound"]["logdet"])) / len(mu)))
    yield from _unlike("d_efficiency", data["d_efficiency"], efficiency)
    payload = _whole(data, "payload")
    noise = expected_noise(case, model, payload)
    criterion_information = _chosen(case, model, noise, scaling, motion, information)
    yield from _of_criterion(data, singular_values(criterion_information, model.names))
    yield from _unlike("assumed_noise_N", data["assumed_noise_N"], noise.sensors)
    first = _whole(data, "payload_from") if "payload_from" in data else payload
    worst = worst_std(case, model, scaling, motion, range(first, payload + 1))
    yield from _unlike_deviations(data, {name: std for name, (std, _) in worst.items()})


def _chosen(case: Case, model: Model, noise: ExpectedNoise, scaling: Array, motion: Trajectory, plain: Array) -> Array:
    """The information that the search maximised: by the weights of the case, and what errors of the pose leave."""
    errors = PoseErrors.of(case, noise)
    if noise.whitening is None and errors is None:
        return plain
    return information_of(seen_through(model, noise.whitening), scaling, motion, errors)


def _of_criterion(data: dict[str, Any], mu: Array) -> Iterator[_Mismatch]:
    letter = str(data["criterion"])
    if letter not in CRITERIA:
        raise ValueError("criterion")
    score = CRITERIA[letter].of(mu)
    within = ALIKE * (len(mu) if letter == "D" else abs(score))
    yield from _unlike("criterion_value", data["criterion_value"], score, within)


def _of_poses(data: dict[str, Any], motion: Trajectory, case: Case) -> Iterator[_Mismatch]:
    parts = motion.parts if isinstance(motion, Joined) else ()
    poses = np.array([part.pose for part in parts if isinstance(part, Measurement)])
    yield from _unlike("count", data["count"], float(len(poses)), 0.0)
    if len(poses):
        model = standing_model(case, _whole(data, "model"))
        scaling = reference_scaling(case, model)
        regressors = pose_regressors(model, poses) * scaling
        singular_values(total_information(regressors), model.names)
        expected = predicted_std_at_poses(case, model, scaling, regressors, poses, float(data["assumed_noise_N"]))
        yield from _unlike_deviations(data, expected)


def _recorded_as_planned(case: Case, data: dict[str, Any]) -> Case:
    """The case with the rate of recording that the plan assumed."""
    recording = case.recording.model_copy(update={"rate_Hz": float(data.get("assumed_rate_Hz", 1000.0))})
    return case.model_copy(update={"recording": recording})


def _whole(data: dict[str, Any], key: str) -> int:
    if not isinstance(data[key], int) or isinstance(data[key], bool):
        raise ValueError(key)
    return int(data[key])


def _unlike_deviations(data: dict[str, Any], expected: dict[str, float]) -> Iterator[_Mismatch]:
    entries = data["predicted_std"]
    if list(entries) != list(expected):
        raise ValueError("predicted_std")
    for name, std in expected.items():
        yield from _unlike(f"predicted_std.{name}", entries[name], std)


def _unlike(key: str, entry: object, value: float, within: float | None = None) -> Iterator[_Mismatch]:
    within = ALIKE * abs(value) if within is None else within
    if isinstance(entry, bool) or not isinstance(entry, int | float) or not abs(entry - value) <= within:
        yield key, entry, value


def problem_of(data: dict[str, Any], motion: Trajectory, case: Case) -> str | None:
    """What is wrong with the figures of a plan, in words; None where they are those of its motion."""
    try:
        first = next(mismatches(data, motion, case), None)
    except HexciteError as error:
        return f"its motion does not have its figures ({error})"
    except DAMAGED as error:
        return f"entry {error} is missing or damaged"
    if first is None:
        return None
    key, text, found = first
    words = f"{text:.6g}" if isinstance(text, int | float) else repr(text)
    return f"{key} is {words}, but {found:.6g} by its motion: changed by hand or by another version"
