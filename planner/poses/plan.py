"""A plan of poses: chosen, put in order, timed and proven. Saved as a plan folder."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cases.basis import KEPT, plan_basis
from cases.errors import InfeasiblePlan
from cases.files import PLAN, atomic_folder, json_text
from cases.recording_columns import POSE
from cases.schema import Case
from cases.units import DEG, MM
from identification.identifiability import Identifiability, analyse
from identification.limits import LimitReport, prove, worst_of
from identification.model import Model, identification_model
from identification.motion import Joined, Measurement, Trajectory
from planner.deviations import predicted_std_at_poses
from planner.families.saved import motion_entries
from planner.infeasible import remedy
from planner.noise import sensor_noise
from planner.poses.approximate import approximate_design
from planner.poses.choosing import Choice, choose, criterion_value, smallest_set
from planner.poses.continuous import continuous_bound
from planner.poses.order import duration, shortest_order
from planner.poses.regressors import candidate_scaling, pose_regressors, require_full_rank, total_information
from planner.poses.request import PoseRequest
from planner.poses.space import Candidates, grid_candidates, sampled_candidates
from planner.poses.travel import fastest_move, require_ways, travel_times

Array = NDArray[np.float64]

SCHEMA_VERSION = 1
PROOF_RATE_OF_MOVES = 1000.0  # [1/s]; moves between poses are smooth and take about half a second
SEEDS = 2000  # poses from which the design over the space starts


@dataclass(frozen=True, slots=True)
class PosePlan:
    """A plan of poses.

    Args:
        case: what it was planned for.
        case_file: name or file of the case.
        request: what was asked for.
        candidates: what the poses were chosen from.
        poses: in the order of visit, shape (n, 6) [m, rad].
        remark: how the choice ended.
        motion: from home through all poses and back home.
        travel: time of the moves [s].
        travel_unordered: the same in the order of choice [s].
        value: of the criterion of Table 4, to be maximised: mean information, reference scaling.
        efficiency: lower bound of the D-efficiency against every design over the candidates; certified.
        efficiency_space: D-efficiency against the design over the whole pose space; an estimate.
        condition: mu_1 / mu_u, reference scaling.
        fewest: poses that Algorithm 1 keeps of these before rank is lost.
        predicted_std: of each physical parameter [SI].
        std_of_all: the same from all candidates.
        noise: standard deviation of an averaged force behind it [N].
        limits: of the moves.
        select_seconds: time spent on choosing [s].
        solve_seconds: time spent on everything [s].
    """

    case: Case
    case_file: str
    request: PoseRequest
    candidates: Candidates
    poses: Array
    remark: str
    motion: Trajectory
    travel: float
    travel_unordered: float
    value: float
    efficiency: float
    efficiency_space: float
    condition: float
    fewest: int
    predicted_std: dict[str, float]
    std_of_all: dict[str, float]
    noise: float
    limits: LimitReport
    select_seconds: float
    solve_seconds: float

    def to_json(self) -> dict[str, Any]:
        """What `plan.json` holds."""
        poses = self.case.need_poses("a plan of poses")
        request = self.request
        return {
            "schema_version": SCHEMA_VERSION,
            "case": self.case.name,
            "case_file": self.case_file,
            "case_hash": self.case.hash,
            KEPT: plan_basis(self.case, poses=True),
            "family": "poses",
            "criterion": request.criterion,
            "method": str(request.method),
            "model": request.model,
            "status": "proven",
            "remark": self.remark,
            "count": len(self.poses),
            "candidates": len(self.candidates.poses),
            "settings": {
                "candidates": self.candidates.origin,
                "considered": self.candidates.considered,
                "seed": request.seed,
                "settle_s": poses.settle_s,
                "average_s": poses.average_s,
            },
            "duration_s": self.motion.duration,
            "travel_s": self.travel,
            "travel_in_order_of_choice_s": self.travel_unordered,
            "criterion_value": self.value,
            "condition": self.condition,
            "efficiency": self.efficiency,
            "efficiency_space": self.efficiency_space,
            "efficiency_method": "D; efficiency: lower bound against the approximate design over the candidates; "
            "efficiency_space: estimate against the design over the whole pose space",
            "fewest_poses": self.fewest,
            "predicted_std": self.predicted_std,
            "predicted_std_of_all_candidates": self.std_of_all,
            "assumed_noise_N": self.noise,
            "assumed_rate_Hz": self.case.recording.rate_Hz,
            "limits": self.limits.to_json(),
            "select_s": self.select_seconds,
            "solve_s": self.solve_seconds,
            "poses": [dict(zip(POSE, row, strict=True)) for row in _in_units(self.poses).tolist()],
            **motion_entries(self.motion),
        }


def plan_poses(
    request: PoseRequest, case: Case, case_file: str, done: Callable[[int], None] = lambda _: None
) -> PosePlan:
    """Chooses poses, orders, times and proves them.

    Args:
        request: what to plan.
        case: machine, limits and poses.
        case_file: name or file that finds the case again from any folder.
        done: called with the number of poses after each step of the choice.

    Raises:
        HexciteError: a request that cannot be met; the message says what to change.
        InfeasiblePlan: no valid pose, or no way between the chosen ones.
        IdentificationError: poses cannot determine the model.
        CaseError: the case lacks machine, limits or poses.
    """
    began = perf_counter()
    model = identification_model(case, request.model)
    candidates = (
        grid_candidates(case)
        if request.candidates is None
        else sampled_candidates(case, request.candidates, request.seed)
    )
    unscaled = pose_regressors(model, candidates.poses)
    scaling = candidate_scaling(unscaled)
    regressors = unscaled * scaling
    request.wanted(len(candidates.poses), regressors.shape[2])
    require_full_rank(regressors, model)
    choice = choose(request, case, model, candidates.poses, regressors, scaling, done)
    selected = perf_counter() - began
    order, unordered = _ordered(case, choice)
    poses = choice.poses[order]
    motion, limits = _motion(case, poses)
    travel = sum(part.duration for part in motion.parts if not isinstance(part, Measurement))
    chosen = pose_regressors(model, poses) * scaling
    seeds = np.vstack([candidates.poses[:: max(1, len(candidates.poses) // SEEDS)], poses])
    space = continuous_bound(case, model, scaling, seeds)
    information = total_information(chosen)
    logdet = float(np.linalg.slogdet(information / len(poses))[1])
    noise = request.noise if request.noise is not None else _noise(case)
    return PosePlan(
        case=case,
        case_file=case_file,
        request=request,
        candidates=candidates,
        poses=poses,
        remark=choice.remark,
        motion=motion,
        travel=travel,
        travel_unordered=unordered,
        value=criterion_value(model, scaling, poses, request.criterion),
        efficiency=approximate_design(regressors).efficiency(chosen),
        efficiency_space=float(np.exp((logdet - space.logdet) / len(scaling))),
        condition=float(np.sqrt(np.linalg.cond(information))),
        fewest=smallest_set(model, scaling, poses, request.criterion),
        predicted_std=predicted_std_at_poses(case, model, scaling, chosen, poses, noise),
        std_of_all=predicted_std_at_poses(case, model, scaling, regressors, candidates.poses, noise),
        noise=noise,
        limits=limits,
        select_seconds=selected,
        solve_seconds=perf_counter() - began,
    )


def _ordered(case: Case, choice: Choice) -> tuple[NDArray[np.int64], float]:
    """Order of visit, and travel in the order of choice [s], both from home to home."""
    home = case.need_machine("a plan of poses")[0].home.vector
    stations = np.vstack([home, choice.poses])
    times = travel_times(case, stations)
    order = shortest_order(times)
    require_ways(times, order)
    as_chosen = duration([*range(len(stations)), 0], np.where(np.isfinite(times), times, 0.0))
    return order[1:-1] - 1, as_chosen


def _motion(case: Case, poses: Array) -> tuple[Joined, LimitReport]:
    home = case.need_machine("a plan of poses")[0].home.vector
    setting = case.need_poses("a plan of poses")
    parts: list[Trajectory] = []
    reports: list[LimitReport] = []
    clock, here = 0.0, home
    for pose in [*poses, home]:
        if np.max(np.abs(pose - here)) > 0.0:
            move = fastest_move(case, here, pose)
            reports.append(prove(move, case, PROOF_RATE_OF_MOVES, clock, in_box=False))
            parts.append(move)
            clock += move.duration
        if pose is not home:
            parts.append(Measurement(np.array(pose), setting.settle_s, setting.average_s))
            clock += parts[-1].duration
        here = pose
    report = worst_of(reports)
    if not report.kept:
        worst = report.violations[0]
        raise InfeasiblePlan(f"a move between poses fails: {worst.sentence()}; {remedy(worst)}")
    return Joined(tuple(parts)), report


def _noise(case: Case) -> float:
    """Of a force that is averaged, if its noise is white [N]."""
    sample = sensor_noise(case)
    averaged = case.need_poses("predicted standard deviations").average_s * case.recording.rate_Hz
    return float(sample / np.sqrt(max(averaged, 1.0)))


def _in_units(poses: Array) -> Array:
    return np.asarray(np.round(poses / np.r_[np.full(3, MM), np.full(3, DEG)], 9))


def save_pose_plan(plan: PosePlan, folder: Path, overwrite: bool = False, plots: bool = False) -> None:
    """Writes a plan folder: plan.json, poses.csv, report.html; where asked for, figures for papers in plots/."""
    from planner.reports.page import render
    from planner.reports.poses import poses_page

    model = identification_model(plan.case, plan.request.model)
    rows = [f"{k}," + ",".join(f"{v:.9g}" for v in row) for k, row in enumerate(_in_units(plan.poses), 1)]
    with atomic_folder(folder, PLAN, overwrite) as part:
        (part / "plan.json").write_text(json_text(plan.to_json()), encoding="utf-8")
        (part / "poses.csv").write_text("\n".join([",".join(("pose", *POSE)), *rows]) + "\n", encoding="utf-8")
        found = analyse(pose_regressors(model, plan.poses), model.names)
        if plots:
            _save_plots(plan, model, found, part / "plots")
        (part / "report.html").write_text(render(poses_page(plan, found)), encoding="utf-8")


def _save_plots(plan: PosePlan, model: Model, found: Identifiability, folder: Path) -> None:
    from planner.poses.plots import density_figure, pose_figure  # Matplotlib takes a second
    from planner.reports.plots import identifiability_figure, save_figure

    save_figure(pose_figure(plan.case, plan.candidates.poses, plan.poses), folder, "poses")
    save_figure(density_figure(plan.case, model, plan.predicted_std, plan.std_of_all), folder, "densities")
    save_figure(identifiability_figure(found), folder, "identifiability")
