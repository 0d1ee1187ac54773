"""A plan as a folder, and back."""

import hashlib
from operator import index
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from cases.basis import Artefact, plan_basis
from cases.errors import FileProblem, HexciteError
from cases.files import DAMAGED, json_text, read_json
from cases.schema import Case
from identification.criteria import reference_scaling, singular_values
from identification.limit import LimitReport
from identification.model import identification_model
from planner.families.saved import motion_of_entries
from planner.noise import standing_model
from planner.plans import SCHEMA_VERSION, Plan, Saved
from planner.poses.pose_criteria import pose_regressors, total_information
from planner.request import LONGEST, PoseRequest, Request
from planner.worth import PoseWorth, Worth, figures_of, predicted_std_at_poses

LONGEST_OF_POSES = 4 * 3600.0  # [s] of a measurement at poses: the paper's took 21 min
RATE_OF_0_1 = 1000.0  # [1/s], which plans of the first version assumed without saying so
DIGITS = 16  # of a fingerprint


def fingerprint(plan: Plan) -> str:
    """The first 16 digits of the SHA-256 of its plan.json, wherever the folder is."""
    return fingerprint_of(json_text(plan.to_json()).encode()) if plan.saved is None else plan.saved.fingerprint


def fingerprint_of(content: bytes) -> str:
    """Of a plan.json."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def load_plan(folder: Path, case: Case | None = None, stale: bool = False) -> Plan:
    """Reads a plan folder; its figures are computed anew from its motion and compared.

    Args:
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
    saved = Saved(folder, fingerprint_of(file.read_bytes()), remarks)
    try:
        parameters = len(identification_model(own, index(data["model"])).parameters)
        request = PoseRequest.of_json(data) if of_poses else Request.of_json(data)
        worth = PoseWorth.of_json(data) if of_poses else Worth.of_json(data, parameters)
        limits = LimitReport.of_json(data["limits"])
        predicted = {str(name): float(std) for name, std in data["predicted_std"].items()}
        noise, rate = float(data["assumed_noise_N"]), float(data.get("assumed_rate_Hz", RATE_OF_0_1))
        plan = Plan(own, request, motion, limits, predicted, noise, rate, worth, saved)
        if not artefact.changes(now, own.hash):
            _require_own_figures(file, data, plan)
    except FileProblem:
        raise
    except HexciteError as error:
        raise FileProblem(file, error.typed, "plan again") from error
    except ValidationError as error:
        place = ".".join(map(str, error.errors()[0]["loc"])).removeprefix("search.")
        raise FileProblem(file, f"entry {place} is missing or damaged", "plan again") from error
    except DAMAGED as error:
        raise FileProblem(file, f"entry {error} is missing or damaged", "plan again") from error
    return plan


ALIKE = 1e-3  # of figures that are computed anew: another computer rounds otherwise, nobody reads further


def _require_own_figures(file: Path, data: dict[str, Any], plan: Plan) -> None:
    """Raises FileProblem where an entry of plan.json is not what it is by the motion beside it."""
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
        figures, _, worst = figures_of(case, model, plan.motion, plan.payloads, plan.request.criterion)
        figures |= {"d_efficiency": plan.worth.bound.efficiency(figures["logdet"])}
        predicted = {name: std for name, (std, _) in worst.items()}
    if list(predicted) != list(plan.predicted_std):
        raise ValueError("predicted_std")
    figures |= {"duration_s": plan.duration} | {f"predicted_std.{name}": std for name, std in predicted.items()}
    stated = data | {f"predicted_std.{name}": std for name, std in data["predicted_std"].items()}
    for key, value in figures.items():
        entry = stated[key]
        of_logdet = key == "logdet" or (key == "criterion_value" and plan.request.criterion == "D")
        within = ALIKE * (size if of_logdet else abs(value))
        if isinstance(entry, bool) or not isinstance(entry, int | float) or not abs(entry - value) <= within:
            words = f"{entry:.6g}" if isinstance(entry, int | float) else repr(entry)
            problem = f"{key} is {words}, but {value:.6g} by its motion: changed by hand or by another version"
            raise FileProblem(file, problem, "plan again")
