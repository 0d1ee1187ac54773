"""Plans, runs and results as entries of a comparison: cost, information and standard deviations of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from cases.base.errors import Code, FileProblem
from cases.schema import Case
from identification.estimation.criteria import Criterion, pose_regressors, reference_scaling, singular_values
from identification.estimation.fit import Value
from identification.identify import identify
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from identification.motion.motion import Trajectory
from identification.recording.record import RunOrigin
from identification.recording.recording import Recording, record_of
from identification.results.result import Result
from planner.noise import mean_information
from planner.plans.at_hand import plans_at_hand
from planner.plans.plan import Plan

Level = Literal["planned", "identified"]
"""Origin of the standard deviations: predicted by a plan, or identified from a run."""
EXECUTION = ("planned_s", "executed_s", "d_efficiency_planned", "d_efficiency", "path_error_mm")  # of recording.json


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
    level: Level
    conditions: Conditions
    model: int  # number in Table 2
    family: str  # family of the plan, or controller of the run
    duration: float | None  # measuring time [s]; None where that is unknown
    samples: int  # samples of forces that count
    # A, D, K, N and condition of the mean information of a plan, in the reference scaling
    criteria: Mapping[str, float]
    parameters: Mapping[str, Value]  # parameters by name; before they are identified of value NaN, std predicted
    # s0 of a result by (27) [N; dimensionless where weights are given]; None otherwise
    s0: float | None
    notes: Mapping[str, float]  # figures of the execution, by name
    warnings: tuple[str, ...] = ()  # warnings that its evaluation gave
    white_noise: float | None = None  # of a result, as `s0`
    motion: Trajectory | None = None  # motion of a plan
    measured: Result | None = None  # of a run, with its samples
    residual: float | None = None  # rms of the recorded forces less the model of a result [N]

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
            "s0": self.s0,
            "white_noise": self.white_noise,
            "s0_N": self.residual,
            "parameters": {
                n: {"value": v.value if self.level == "identified" else None, "std": v.reported, "unit": v.unit}
                for n, v in self.parameters.items()
            },
            "execution": dict(self.notes),
            "assumed_noise_N": self.conditions.noise,
            "load_kg": self.conditions.load,
            "machine": self.conditions.machine,
            "warnings": list(self.warnings),
        }


def read_entry(path: Path, case: Case | None = None, stale: bool = False) -> Entry:
    """Reads a plan, recording or result folder; a recording is identified as `hexcite identify` does it by default.

    Args:
        case: replaces the case that the folder names.
        stale: whether to read it although its case has changed since; a warning says so.

    Raises:
        FileProblem: the folder is not one of these.
        HexciteError: it cannot be used; the message says why.
    """
    if (path / "plan.json").is_file():
        return entry_of_plan(Plan.load(path, case, stale), str(path))
    if (path / "recording.json").is_file():
        about = record_of(path)
        entries = {} if about is None else about.to_json()
        notes = {name: float(entries[name]) for name in EXECUTION if entries.get(name) is not None}
        run = Recording.load(path, case, stale)
        return _entry_of_result(identify(run, case, plan=plans_at_hand(run)), str(path), notes)
    if (path / "result.json").is_file():
        return _entry_of_result(Result.load(path, case, stale), str(path), {})
    words = "does not exist" if not path.exists() else "is a file" if not path.is_dir() else ""
    words = words or "holds no plan, run or result"
    raise FileProblem(
        place=path, problem=words, remedy="name folders that plan, poses, run or identify wrote", code=Code.WRONG_KIND
    )


def entry_of_plan(saved: Plan, name: str) -> Entry:
    """The entry of a plan, under a name."""
    model = identification_model(saved.case, saved.model)
    scaling = reference_scaling(saved.case, model)
    rate, assumed, noise, poses = saved.case.recording.rate_Hz, saved.assumed_rate, saved.assumed_noise, saved.poses
    if len(poses):
        matrix = (pose_regressors(model, poses) * scaling).reshape(-1, len(scaling))
        information, samples = matrix.T @ matrix / len(poses), len(poses)
        # The noise of plans of poses is that of averages.
        noise *= float(np.sqrt(max(saved.case.need_poses("a comparison").average_s * assumed, 1.0)))
    else:
        information, samples = mean_information(model, scaling, saved.motion), round(saved.duration * rate)
    mu = singular_values(information, model.names)
    criteria = {letter: letter.of_singular_values(mu) for letter in Criterion} | {"condition": float(mu[0] / mu[-1])}
    payloads = saved.case.payloads
    load = sum(w.mass_kg for w in payloads.weights[: saved.payloads[-1]]) if payloads is not None else 0.0
    scale = float(np.sqrt(assumed / rate))  # the case may state another rate since
    units = {p.name: p.unit for p in physical_form(model).parameters}
    deviations = {n: Value(np.nan, scale * s, scale * s, units[n]) for n, s in saved.predicted_std.items()}
    return Entry(
        name, "planned", Conditions(saved.case, noise, float(load), plan=saved.fingerprint), model.number,
        saved.family, saved.duration, samples, criteria, deviations, None, {}, saved.stale,
        motion=None if len(poses) else saved.motion,
    )  # fmt: skip


def _entry_of_result(result: Result, name: str, notes: Mapping[str, float]) -> Entry:
    record, run = result.record, result.record.run or RunOrigin()
    load = None if run.payload is None else run.mounted
    machine = None if run.simulated is None else "a simulated machine" if run.simulated else "a real machine"
    conditions = Conditions(result.case, None, load, machine, result.recordings, record.plan_hash)
    return Entry(
        name, "identified", conditions, record.model, (run.controller or "recorded").split(" (")[0],
        record.measuring_s, record.samples, {}, result.parameters, record.s0, notes,
        tuple(dict.fromkeys((*result.warnings, *result.remarks))), record.white_noise,
        residual=record.s0_N, measured=result if result.estimate is not None else None,
    )  # fmt: skip
