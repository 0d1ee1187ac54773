"""A plan as a folder, and back."""

import hashlib
from pathlib import Path
from typing import Any

from cases.basis import Artefact, plan_basis
from cases.errors import FileProblem, HexciteError
from cases.files import PLAN, atomic_folder, check_folder, json_text, read_json
from cases.schema import Case
from identification.limits import LimitReport
from identification.model import identification_model
from identification.motion import sample
from planner.families.saved import motion_of_entries
from planner.plans import SAMPLE_RATE, SCHEMA_VERSION, Plan, Saved, motion_csv, poses_in_units
from planner.poses.pose_request import PoseRequest
from planner.request import LONGEST, Request
from planner.verifying import problem_of
from planner.worth import PoseWorth, Worth

LONGEST_OF_POSES = 4 * 3600.0  # [s] of a measurement at poses: the paper's took 21 min
RATE_OF_0_1 = 1000.0  # [1/s], which plans of the first version assumed without saying so
DIGITS = 16  # of a fingerprint


def save_plan(plan: Plan, folder: Path, overwrite: bool = False) -> None:
    """Makes a folder with plan.json, and motion.csv or poses.csv.

    Args:
        plan: plan to write.
        folder: folder to make.
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
        folder: where it is.
        case: case for which the motion is taken, instead of the plan's own.
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
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FileProblem(file, f"entry {error} is missing or damaged", "plan again") from error
    of_poses = data["family"] == PoseRequest.name
    if not motion.duration <= (LONGEST_OF_POSES if of_poses else LONGEST):
        raise FileProblem(file, f"a motion of {motion.duration:g} s is not an excitation", "plan again")
    named = Artefact(file, data, "plan again")
    own = named.case() if case is None else case
    count = len(own.need_motion("a plan")[0])
    if motion.at([0.0]).pose.shape[1] != count:
        raise FileProblem(f"{file}: its motion does not have the {count} coordinates of case {own.name}; plan again")
    payload = data.get("payload", 0)
    now = plan_basis(own, payload if isinstance(payload, int) else 0, of_poses)
    remarks = named.require_unchanged(now, own, stale) if case is None else ()
    if not named.changes(now, own.hash) and (problem := problem_of(data, motion, own)):
        raise FileProblem(file, problem, "plan again")
    saved = Saved(folder, fingerprint_of(file.read_bytes()), remarks)
    try:
        parameters = len(identification_model(own, int(data["model"])).parameters)
        request, worth = _request(data), PoseWorth.of_json(data) if of_poses else Worth.of_json(data, parameters)
        limits = LimitReport.of_json(data["limits"])
        predicted = {str(name): float(std) for name, std in data["predicted_std"].items()}
        noise, rate = float(data["assumed_noise_N"]), float(data.get("assumed_rate_Hz", RATE_OF_0_1))
        return Plan(own, request, motion, limits, predicted, noise, rate, worth, saved)
    except HexciteError as error:
        raise FileProblem(file, str(error), "plan again") from error
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FileProblem(file, f"entry {error} is missing or damaged", "plan again") from error


def _request(data: dict[str, Any]) -> Request | PoseRequest:
    return PoseRequest.of_json(data) if data["family"] == PoseRequest.name else Request.of_json(data)
