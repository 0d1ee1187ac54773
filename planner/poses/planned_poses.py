"""A plan of poses: chosen, put in order, timed and proven."""

from collections.abc import Callable
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError, IdentificationError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import singular_values
from identification.limit import LimitReport, worst_of
from identification.limit_proof import prove
from identification.model import Model
from identification.motion import Array, Joined, Standstill, Trajectory
from planner.families import Settings
from planner.noise import sensor_noise, standing_model
from planner.plan_figures import PoseWorth, predicted_std_at_poses
from planner.plans import Plan
from planner.pose_criteria import (
    POSE_CRITERIA,
    candidate_scaling,
    pose_regressors,
    total_information,
)
from planner.poses.candidates import (
    Candidates,
    candidate_design,
    continuous_design,
    grid_candidates,
    sampled_candidates,
)
from planner.poses.removal import MOST_EXHAUSTIVE, reduce_best, reduce_smallest_change, refine
from planner.poses.space import standing_report, valid_poses
from planner.poses.travel import duration, fastest_move, require_ways, shortest_order, travel_times
from planner.request import METHODS, PoseRequest
from planner.search.feasibility import remedy

PROOF_RATE_OF_MOVES = 1000.0  # [1/s]; moves between poses are smooth and take about half a second
SEEDS = 2000  # poses from which the design over the space starts


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
    candidates, considered, origin = candidates_of(request, case, given)
    unscaled = pose_regressors(model, candidates)
    scaling = candidate_scaling(unscaled)
    regressors = unscaled * scaling
    chosen_poses, remark = _choose(request, case, model, candidates, regressors, scaling, done)
    selected = perf_counter() - start
    order, unordered = _ordered(case, chosen_poses)
    poses = chosen_poses[order]
    motion, limits = _motion(case, poses)
    travel = sum(part.duration for part in motion.parts if not isinstance(part, Standstill))
    selection = pose_regressors(model, poses) * scaling
    seeds = np.vstack([candidates[:: max(1, len(candidates) // SEEDS)], poses])
    designs = candidate_design(regressors), continuous_design(case, model, scaling, seeds)
    information = total_information(selection)
    logdet = float(np.linalg.slogdet(information / len(poses))[1])
    efficiency, efficiency_space = (
        float(np.exp((logdet - design.bound(len(scaling))) / len(scaling))) for design in designs
    )
    criterion = POSE_CRITERIA[request.criterion]
    noise = noise_of_average(case)
    worth = PoseWorth(
        remark=remark,
        candidates=len(candidates),
        travel_s=travel,
        travel_in_order_of_choice_s=unordered,
        criterion_value=float(criterion.value(information / len(poses))),
        condition=float(np.sqrt(np.linalg.cond(information))),
        efficiency=efficiency,
        efficiency_space=efficiency_space,
        fewest_poses=len(reduce_best(selection, criterion, 1)[0]),  # Table 5, "Min. poses"
        predicted_std_of_all_candidates=predicted_std_at_poses(case, model, scaling, regressors, candidates, noise),
        select_s=selected,
    )
    settings: Settings = {
        "candidates": origin,
        "considered": considered,
        "settle_s": setting.settle_s,
        "average_s": setting.average_s,
    }
    predicted = predicted_std_at_poses(case, model, scaling, selection, poses, noise)
    seconds = perf_counter() - start
    return Plan(case, request, motion, limits, predicted, noise, case.recording.rate_Hz, worth, settings, seconds)


def candidates_of(request: PoseRequest, case: Case, given: Array | None = None) -> Candidates:
    """The poses to choose from.

    Raises:
        HexciteError: the method `given` without poses.
        InfeasiblePlan: the machine cannot stand at one of them.
    """
    if request.method == "given":
        if given is None:
            raise HexciteError("method given needs poses: name a CSV file of them with --at")
        for number, valid in enumerate(valid_poses(case, given), 1):
            if not valid:
                place = case.words(given[number - 1])
                worst = standing_report(case, given[number - 1 : number]).violations[0].sentence(timed=False)
                raise InfeasiblePlan(f"the machine cannot stand at pose {number} ({place}): {worst}; take another one")
        return given, len(given), "poses of one's own"
    if request.candidates is None:
        return grid_candidates(case)
    return sampled_candidates(case, request.candidates, request.seed)


def _ordered(case: Case, poses: Array) -> tuple[NDArray[np.int64], float]:
    """Order of visit, and travel in the order of choice [s], both from home to home."""
    home = case.need_motion("a plan of poses")[0]
    stations = np.vstack([home, poses])
    times = travel_times(case, stations)
    order = shortest_order(times)
    require_ways(times, order)
    as_chosen = duration([*range(len(stations)), 0], np.where(np.isfinite(times), times, 0.0))
    return order[1:-1] - 1, as_chosen


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
    """Chosen poses, shape (n, 6) [m, rad], and the result of the choice in one phrase.

    Raises:
        HexciteError: too many candidates for the method.
        IdentificationError: all poses together do not determine the model.
        InfeasiblePlan: the poses are too few to determine the model.
    """
    count = request.wanted(len(poses), regressors.shape[2])
    try:
        singular_values(total_information(regressors), model.names)
    except IdentificationError as error:
        raise IdentificationError(f"model {request.model}", error.typed) from error
    criterion = POSE_CRITERIA[request.criterion]
    if request.method in ("all", "given"):
        return poses, METHODS[request.method]
    if request.method == "backward-change":
        if len(poses) > MOST_EXHAUSTIVE:
            raise HexciteError(
                f"method backward-change evaluates every removal and is meant for {MOST_EXHAUSTIVE} candidates at "
                f"most, here are {len(poses)}; choose backward"
            )
        indices, _ = reduce_smallest_change(regressors, criterion, count, done)
    else:
        indices, _ = reduce_best(regressors, criterion, count, done)
    if len(indices) > count:
        raise InfeasiblePlan(
            f"{count} poses do not determine model {request.model}: Algorithm 1 ends at {len(indices)}, every further "
            f"removal loses rank; ask for {len(indices)} or more"
        )
    if request.method in ("backward", "backward-change"):
        return poses[indices], "as many as asked for"
    refined, status = refine(case, model, scaling, criterion, poses[indices])
    return refined, f"refined: {status}"
