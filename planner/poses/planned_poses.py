"""A plan of poses: chosen, put in order, timed and proven."""

from collections.abc import Callable
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError, IdentificationError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import (
    POSE_CRITERIA,
    candidate_scaling,
    pose_regressors,
    singular_values,
    total_information,
)
from identification.limit import LimitReport, worst_of
from identification.limit_proof import prove
from identification.model import Model
from identification.motion import Array, Joined, Standstill, Trajectory
from planner.families import Settings
from planner.noise import sensor_noise, standing_model
from planner.plan_figures import PoseWorth, predicted_std_at_poses
from planner.plans import Plan
from planner.poses.candidates import candidate_design, grid_candidates, sampled_candidates
from planner.poses.removal import MOST_EXHAUSTIVE, reduce_best, refine
from planner.poses.space import standing_report, valid_poses
from planner.poses.travel import fastest_move, require_ways, shortest_order, travel_times
from planner.request import METHODS, PoseRequest
from planner.search.feasibility import remedy

PROOF_RATE_OF_MOVES = 1000.0  # [1/s]; moves between poses are smooth and take about half a second


def poses_planned(
    request: PoseRequest, case: Case, done: Callable[[int], None] = lambda _: None, given: Array | None = None
) -> Plan:
    """Chooses poses, orders, times and proves them.

    Args:
        given: poses of the user, for the method `given`, shape (n, k) [m or rad].
        done: called with the number of poses after each step of the choice.

    Raises:
        HexciteError: the request cannot be met; the message says what to change.
        InfeasiblePlan: there is no valid pose, or no way between the chosen ones.
        IdentificationError: poses cannot determine the model.
    """
    start = perf_counter()
    case.need_motion("a plan of poses")
    setting = case.need_poses("a plan of poses")
    model = standing_model(case, request.model)
    candidates = candidates_of(request, case)
    unscaled = pose_regressors(model, candidates)
    scaling = candidate_scaling(unscaled)
    regressors = unscaled * scaling
    if request.method == "given":
        chosen_poses, remark = _require_valid(case, given), METHODS["given"]
        _require_rank(model, pose_regressors(model, chosen_poses) * scaling)
    else:
        chosen_poses, remark = _choose(request, case, model, candidates, regressors, scaling, done)
    selected = perf_counter() - start
    poses = chosen_poses[_order(case, chosen_poses)]
    motion, limits = _motion(case, poses)
    travel = sum(part.duration for part in motion.parts if not isinstance(part, Standstill))
    selection = pose_regressors(model, poses) * scaling
    information = total_information(selection)
    logdet = float(np.linalg.slogdet(information / len(poses))[1])
    bound = candidate_design(regressors).bound(len(scaling))
    criterion = POSE_CRITERIA[request.criterion]
    noise = noise_of_average(case)
    worth = PoseWorth(
        remark=remark,
        candidates=len(candidates),
        travel_s=travel,
        criterion_value=float(criterion.value(information / len(poses))),
        condition=float(np.sqrt(np.linalg.cond(information))),
        efficiency=float(np.exp((logdet - bound) / len(scaling))),
        select_s=selected,
    )
    settings: Settings = {"settle_s": setting.settle_s, "average_s": setting.average_s}
    predicted = predicted_std_at_poses(case, model, scaling, selection, poses, noise)
    seconds = perf_counter() - start
    return Plan(case, request, motion, limits, predicted, noise, case.recording.rate_Hz, worth, settings, seconds)


def candidates_of(request: PoseRequest, case: Case) -> Array:
    """The poses to choose from, shape (n, k) [m or rad]; errors as `grid_candidates` and `sampled_candidates`."""
    if request.candidates is None:
        return grid_candidates(case)
    return sampled_candidates(case, request.candidates, request.seed)


def _require_rank(model: Model, regressors: Array) -> None:
    try:
        singular_values(total_information(regressors), model.names)
    except IdentificationError as error:
        raise IdentificationError(f"model {model.number}", error.typed) from error


def _require_valid(case: Case, given: Array | None) -> Array:
    """The poses of a user; raises HexciteError without any, InfeasiblePlan where the machine cannot stand at one."""
    if given is None:
        raise HexciteError("method given needs poses: name a CSV file of them with --at")
    for number, valid in enumerate(valid_poses(case, given), 1):
        if not valid:
            place = case.words(given[number - 1])
            worst = standing_report(case, given[number - 1 : number]).violations[0].sentence(timed=False)
            raise InfeasiblePlan(f"the machine cannot stand at pose {number} ({place}): {worst}; take another one")
    return given


def _order(case: Case, poses: Array) -> NDArray[np.int64]:
    """Order of visit, from home to home."""
    home = case.need_motion("a plan of poses")[0]
    times = travel_times(case, np.vstack([home, poses]))
    order = shortest_order(times)
    require_ways(times, order)
    return order[1:-1] - 1


def _motion(case: Case, poses: Array) -> tuple[Joined, LimitReport]:
    home = case.need_motion("a plan of poses")[0]
    setting = case.need_poses("a plan of poses")
    parts: list[Trajectory] = []
    reports: list[LimitReport] = []
    clock, last_pose = 0.0, home
    for pose in [*poses, home]:
        if np.max(np.abs(pose - last_pose)) > 0.0:
            move = fastest_move(case, last_pose, pose)
            reports.append(prove(move, case, PROOF_RATE_OF_MOVES, in_box=False).later(clock))
            parts.append(move)
            clock += move.duration
        if pose is not home:
            parts.append(Standstill(np.array(pose), setting.settle_s, setting.average_s))
            clock += parts[-1].duration
        last_pose = pose
    report = worst_of(reports)
    if not report.kept:
        worst = report.violations[0]
        raise InfeasiblePlan(f"a move between poses fails: {worst.sentence()}; {remedy(worst, case)}")
    return Joined(tuple(parts)), report


def noise_of_average(case: Case) -> float:
    """Standard deviation of a force that is averaged, if its noise is white [N]."""
    sample = sensor_noise(case)
    averaged = case.need_poses("predicted standard deviations").average_s * case.recording.rate_Hz
    return float(sample / np.sqrt(max(averaged, 1.0)))


def _choose(
    request: PoseRequest,
    case: Case,
    model: Model,
    poses: Array,
    regressors: Array,
    scaling: Array,
    done: Callable[[int], None],
) -> tuple[Array, str]:
    """Chosen poses, shape (n, 6) [m, rad], and the result of the choice in one phrase."""
    count = request.wanted(len(poses), regressors.shape[2])
    _require_rank(model, regressors)
    criterion = POSE_CRITERIA[request.criterion]
    if request.method == "all":
        return poses, METHODS["all"]
    change = request.method == "backward-change"
    if len(poses) > MOST_EXHAUSTIVE and (change or not criterion.losses_grow):
        raise HexciteError(
            f"every removal is evaluated for method backward-change and criteria A, K and N, of {MOST_EXHAUSTIVE} "
            f"candidates at most, here are {len(poses)}; choose backward for criterion D, or fewer --candidates"
        )
    indices, _ = reduce_best(regressors, criterion, count, done, change)
    if len(indices) > count:
        raise InfeasiblePlan(
            f"{count} poses do not determine model {request.model}: Algorithm 1 ends at {len(indices)}, every further "
            f"removal loses rank; ask for {len(indices)} or more"
        )
    if request.method in ("backward", "backward-change"):
        return poses[indices], "as many as asked for"
    refined, status = refine(case, model, scaling, criterion, poses[indices])
    return refined, f"refined: {status}"
