"""Plans, runs and results as entries of a comparison: cost, information and standard deviations of each."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from cases.basis import case_of, recording_basis, require_unchanged
from cases.errors import FileProblem
from cases.files import another_kind, read_json, sha256_of
from cases.schema import Case
from identification.criteria import CRITERIA, reference_scaling, singular_values
from identification.estimation.fit import Value
from identification.formats.reading import files_of
from identification.identify import default_model, standing_of
from identification.model import Model, identification_model
from identification.motion import Array
from identification.outcome import Result
from identification.parameters import physical_form
from identification.recording import Recording, read
from identification.runs.preparation import moving_run, on_one_clock
from identification.runs.sample_checks import scan
from identification.runs.standstills import standstills
from planner.noise import PoseErrors, counted_information, expected_noise, mean_information
from planner.plan_figures import predicted_std
from planner.plans import Plan
from planner.pose_criteria import pose_regressors
from planner.vibration import Vibration, vibration

Level = Literal["planned", "executed", "identified"]
"""Stage of an excitation."""
LEVELS: tuple[Level, ...] = ("planned", "executed", "identified")


class Conditions(NamedTuple):
    """Conditions of a plan, run or result, and its origin; None where they are unknown."""

    case: Case
    noise: float | None = None  # noise of a force sample that predictions assume [N]; None for identified ones
    load: float | None = None  # mass of the weights that are mounted [kg]
    machine: str | None = None  # machine that was measured, in words; None for plans
    recordings: frozenset[str] = frozenset()  # fingerprints of its recordings
    plan: str | None = None  # fingerprint of its plan


@dataclass(frozen=True, slots=True)
class Entry:
    """A plan, run or result in a comparison."""

    name: str  # as the user named it
    level: Level  # plan, run or result
    conditions: Conditions
    model: int  # number in Table 2
    family: str  # family of the plan, or the description in the recording
    duration: float | None  # measuring time [s]; None where that is unknown
    samples: int  # samples of forces that count
    # A, D, K, N and condition of the mean information in the reference scaling; empty where it is unknown
    criteria: Mapping[str, float]
    parameters: Mapping[str, Value]  # parameters by name; before they are identified of value NaN, std predicted
    s0: float | None  # s0 of a result [N]; None otherwise
    notes: Mapping[str, float]  # figures of the execution, by name
    warnings: tuple[str, ...] = ()  # warnings that its evaluation gave
    # vibration of a planned motion on a machine with a structural mode; None where the case states none
    vibration: Vibration | None = None

    def to_json(self) -> dict[str, Any]:
        """One row of the answer."""
        return {
            "name": self.name,
            "level": self.level,
            "model": self.model,
            "family": self.family,
            "duration_s": self.duration,
            "samples": self.samples,
            "criteria": dict(self.criteria),
            "s0_N": self.s0,
            "parameters": {
                n: {"value": v.value if self.level == "identified" else None, "std": v.reported, "unit": v.unit}
                for n, v in self.parameters.items()
            },
            "execution": dict(self.notes),
            "assumed_noise_N": self.conditions.noise,
            "load_kg": self.conditions.load,
            "machine": self.conditions.machine,
            "warnings": list(self.warnings),
            "vibration": None if self.vibration is None else asdict(self.vibration),
        }


def read_entry(path: Path, case: Case | None = None, stale: bool = False) -> Entry:
    """Reads a plan, recording or result folder.

    Args:
        case: replaces the case that the folder names.
        stale: whether to read it although its case has changed since; a warning says so.

    Raises:
        FileProblem: the folder is not one of these.
        HexciteError: it cannot be used; the message says why.
    """
    if (path / "plan.json").is_file():
        return entry_of_plan(Plan.load(path, case, stale), str(path))
    for file, reader in (("recording.json", _run), ("result.json", _result)):
        if (path / file).is_file():
            return reader(path, case, stale)
    words = "does not exist" if not path.exists() else "is a file" if not path.is_dir() else ""
    words = words or another_kind(path, "plan.json") or "holds no plan, run or result"
    raise FileProblem(path, words, "name folders that plan, poses, run or identify wrote")


def entry_of_plan(saved: Plan, name: str) -> Entry:
    """The entry of a plan, under a name."""
    model = identification_model(saved.case, saved.model)
    scaling = reference_scaling(saved.case, model)
    rate, assumed, poses = saved.case.recording.rate_Hz, saved.assumed_rate, saved.poses
    if len(poses):
        matrix = (pose_regressors(model, poses) * scaling).reshape(-1, len(scaling))
        information, samples, vibrating = matrix.T @ matrix / len(poses), len(poses), None
    else:
        vibrating = vibration(saved.case, model.number, saved.motion, saved.payloads[-1], saved.duration)
        information = mean_information(model, scaling, saved.motion)
        samples = round(saved.motion.duration * rate)
    noise, weights = saved.assumed_noise, saved.payloads[-1]
    if len(poses):  # the noise of plans of poses is that of averages
        noise *= float(np.sqrt(max(saved.case.need_poses("a comparison").average_s * assumed, 1.0)))
    payloads = saved.case.payloads
    load = sum(w.mass_kg for w in payloads.weights[:weights]) if payloads is not None else 0.0
    scale = float(np.sqrt(assumed / rate))  # the case may state another rate since
    deviations = _predicted({n: scale * float(s) for n, s in saved.predicted_std.items()}, model)
    return Entry(
        name, "planned", Conditions(saved.case, noise, float(load), plan=saved.fingerprint),
        model.number, saved.family, saved.duration, samples,
        _criteria(information, model), deviations, None, {}, saved.stale, vibrating,
    )  # fmt: skip


def _predicted(deviations: Mapping[str, float], model: Model) -> dict[str, Value]:
    """Parameters of which standard deviations are predicted [SI]."""
    units = {p.name: p.unit for p in physical_form(model).parameters}
    return {name: Value(np.nan, std, std, units[name]) for name, std in deviations.items()}


def _criteria(information: Array, model: Model) -> dict[str, float]:
    mu = singular_values(information, model.names)
    return {letter: criterion(mu) for letter, criterion in CRITERIA.items()} | {"condition": float(mu[0] / mu[-1])}


def _run(path: Path, user_case: Case | None, stale: bool) -> Entry:
    file = path / "recording.json"
    about = read_json(file, "hexcite run")
    case = case_of(file, about, "run the program again") if user_case is None else user_case
    stale_in = require_unchanged(file, about, recording_basis(case), case, stale, "run the program again")
    recorded = on_one_clock(read(path, case), case)
    recording, _ = standing_of(recorded, case)
    model = identification_model(case, default_model(recording, case))
    scaling = reference_scaling(case, model)
    matrices, struts, samples = _matrices(recording, case, model)
    information = _seen(matrices, None, scaling)
    duration = about.get("executed_s")
    noise = expected_noise(case, model)
    seconds = samples / case.recording.rate_Hz
    if recording.t is None and recorded.t is not None and recorded.trigger is not None:
        seconds = float(np.count_nonzero(recorded.trigger) * recorded.step)  # of standing still, averaged
    errors, by_pose = PoseErrors.of(case, noise), None
    if errors is not None and struts is not None:
        rows = matrices if noise.whitening is None else noise.whitening @ matrices
        by_pose = errors.scatter(rows * scaling, struts, seconds)
    weighted = counted_information(lambda root: _seen(matrices, root, scaling), noise, by_pose)
    expected = predicted_std(case, model, scaling, weighted, seconds, noise.sensors)
    recordings, payload = frozenset(map(sha256_of, files_of([path]))), about.get("payload")
    load = float(payload["mass_kg"]) if isinstance(payload, dict) and "mass_kg" in payload else None
    conditions = Conditions(case, noise.sensors, load, _machine(about), recordings, about.get("plan_hash"))
    figures = ("planned_s", "executed_s", "d_efficiency_planned", "d_efficiency", "path_error_mm")
    return Entry(
        str(path), "executed", conditions, model.number, str(about.get("controller", "recorded")).split(" (")[0],
        None if duration is None else float(duration), samples, _criteria(information, model),
        _predicted(expected, model), None,
        {n: float(about[n]) for n in figures if about.get(n) is not None},
        (*([str(about["remark"])] if about.get("remark") else []), *stale_in),
    )  # fmt: skip


def _machine(about: Mapping[str, Any]) -> str:
    if not about.get("simulated"):
        return "a real machine"
    return "a simulated machine, disturbed" if about.get("disturbances") else "a simulated machine, undisturbed"


def _seen(matrices: Array, root: Array | None, scaling: Array) -> Array:
    """Mean of H A^T R^T R A H, shape (u, u)."""
    rows = ((matrices if root is None else root @ matrices) * scaling).reshape(-1, len(scaling))
    return np.asarray(rows.T @ rows / len(matrices))


def _matrices(recording: Recording, case: Case, model: Model) -> tuple[Array, Array | None, int]:
    """Regressors that are evaluated, strut lengths there, and the number of samples that they stand for."""
    _, recording = scan(recording, case)
    if recording.t is None:
        struts = None if recording.struts is None else recording.struts[~recording.bad]
        return standstills(recording, case, model).matrices, struts, int(np.sum(~recording.bad))
    run = moving_run(recording, case, model)
    struts = run.filter.apply(run.recording.struts)[run.rows] if run.recording.struts is not None else None
    return run.regressors(0.0), struts, run.samples


def _result(path: Path, user_case: Case | None, stale: bool) -> Entry:
    saved = Result.load(path, user_case, stale)
    case, model, data = saved.case, saved.model, saved.record
    conditions = Conditions(case, recordings=saved.recordings, plan=data.plan_hash)
    return Entry(
        str(path), "identified", conditions, model.number, data.estimator, data.measuring_s, data.samples, {},
        saved.parameters, data.s0_N, {}, tuple(dict.fromkeys((*saved.warnings, *saved.remarks))),
    )  # fmt: skip
