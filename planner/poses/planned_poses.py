"""A plan of poses: chosen, put in order, timed and proven."""

from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.base.errors import Code, HexciteError, IdentificationError, InfeasiblePlan, option
from cases.base.phrases import phrase, said
from cases.base.units import DEG, MM
from cases.schema import Case
from identification.estimation.criteria import (
    Criterion,
    candidate_scaling,
    pose_regressors,
    singular_values,
    total_information,
)
from identification.limits.limit import TOLERANCE, LimitKind, LimitReport, worst_of
from identification.limits.proof import prove
from identification.model.model import Model
from identification.motion.motion import Array, Joined, Standstill, Trajectory
from planner.bounds.certificate import Maximum
from planner.bounds.design import EXCHANGED, Design, directional, exchanged
from planner.families.plan_settings import AverageSettings
from planner.noise import information_of_known, sensor_noise, standing_model
from planner.plans.figures import PoseWorth, prediction_at_poses
from planner.plans.plan import Plan
from planner.plans.prediction import Gain, Promise
from planner.poses.removal import MOST_EXHAUSTIVE, reduce_best, refine
from planner.poses.space import space_of, standing_report, standing_shares, valid_poses
from planner.poses.travel import fastest_move, require_ways, shortest_order, travel_times
from planner.request import METHODS, PoseRequest
from planner.search.feasibility import remedy

MOST = 200_000  # candidates; 20 000 take seconds and half a GB, and more never had more information
JOINT_CANDIDATES = 2048  # default number for a chain
ROUNDING = 1e-9  # [m] poses on the very edge of the ring are in it
SAME = 2e-3  # [mm, deg] distance of equal poses: what controls can tell apart is more


class LeastPoses(NamedTuple):
    """Where Algorithm 1 ends for a criterion: every further removal would lose rank."""

    criterion: str  # letter of Table 4
    method: str  # reading of Algorithm 1: `backward` or `backward-change`
    poses: int  # how many are left
    condition: float  # mu_1 / mu_u of them, in the scaling of the candidates


def least_poses(request: PoseRequest, case: Case, done: Callable[[int], None] = lambda _: None) -> list[LeastPoses]:
    """The fewest poses that Algorithm 1 leaves for each criterion; both readings of it for K, which differ.

    Args:
        request: model, candidates and their seed count.
        done: called with the number of poses after each removal.

    Raises:
        HexciteError: too many candidates, of which every removal is evaluated.
        InfeasiblePlan: there is no valid pose.
        IdentificationError: all candidates together do not determine the model.
    """
    model, candidates = standing_model(case, request.model), candidates_of(request, case)
    unscaled = pose_regressors(model, candidates)
    regressors = unscaled * candidate_scaling(unscaled)
    _require_rank(model, regressors)
    _require_few(candidates)
    counts = []
    for letter in Criterion:
        for change in (False, True) if letter is Criterion.K else (False,):
            rest, _ = reduce_best(regressors, letter, 1, done, change)
            condition = float(np.sqrt(np.linalg.cond(total_information(regressors[rest]))))
            counts.append(LeastPoses(letter, "backward-change" if change else "backward", len(rest), condition))
    return counts


PROOF_RATE_OF_MOVES = 1000.0  # [1/s]; moves between poses are smooth and take about half a second


def poses_planned(
    request: PoseRequest, case: Case, done: Callable[[int], None] = lambda _: None, given: Array | None = None
) -> Plan:
    """Chooses poses, or takes those given, shape (n, k) [m or rad], orders, times and proves them.

    `done` is called with the number of poses after each step of the choice.

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
    noise, known = noise_of_average(case), request.known
    if request.method == "given":
        chosen_poses, remark = _require_valid(case, given), METHODS["given"]
        _require_rank(model, pose_regressors(model, chosen_poses) * scaling)
    else:
        beforehand = None if known is None else information_of_known(known.by_noise, scaling, noise**2)
        chosen_poses, remark = _choose(request, case, model, candidates, regressors, scaling, beforehand, done)
    selected = perf_counter() - start
    poses = chosen_poses[_order(case, chosen_poses)]
    motion, limits = _motion(case, poses)
    travel = sum(part.duration for part in motion.parts if not isinstance(part, Standstill))
    selection = pose_regressors(model, poses) * scaling
    information = total_information(selection)
    logdet = float(np.linalg.slogdet(information / len(poses))[1])
    bound = candidate_design(regressors).bound(len(scaling))
    criterion = Criterion(request.criterion)  # a letter will do
    worth = PoseWorth(
        remark=remark,
        candidates=len(candidates),
        travel_s=travel,
        criterion_value=float(criterion.of(information / len(poses))),
        condition=float(np.sqrt(np.linalg.cond(information))),
        efficiency=float(np.exp((logdet - bound) / len(scaling))),
        select_s=selected,
    )
    settings = AverageSettings(
        settle_s=setting.settle_s,
        average_s=setting.average_s,
        without=None if request.without is None else LimitKind.JERK,  # nothing else may be left out
    )
    promise, gain = Promise.of([prediction_at_poses(case, model, scaling, selection, poses, noise)]), None
    if known is not None:
        gain = Gain.of(prediction_at_poses(case, model, scaling, selection, poses, noise, known.values), known)
    seconds = perf_counter() - start
    return Plan(
        case, request, motion, limits, promise, noise, case.recording.rate_Hz, worth, settings, seconds, gain=gain
    )


def pose_of_tilt(position: Array, tilt: Array, azimuth: Array, torsion: Array) -> Array:
    """Poses of positions, (n, 3) [m], and angles, (n,) [rad]; R = Rz(azimuth) Ry(tilt) Rz(torsion - azimuth)."""
    turn = Rotation.from_euler("ZYZ", np.column_stack([azimuth, tilt, torsion - azimuth]))
    return np.column_stack([position, turn.as_euler("xyz")])


def grid_candidates(case: Case) -> Array:
    """The case's grid, valid poses only, in the order of Algorithm 1 (x, y, z, tilt, azimuth, torsion).

    Of a chain, which has no grid, quasi-random poses of the motion box.

    Raises:
        HexciteError: the grid is too fine; the message says what to do.
        InfeasiblePlan: no pose is valid; the message names the limits that are exceeded.
        CaseError: the case lacks machine or poses.
    """
    if case.chain is not None:
        return sampled_candidates(case, JOINT_CANDIDATES, 0)
    grid = case.need_poses("pose candidates")
    _require_count(grid.grid_size)
    machine, _, _ = case.need_machine("pose candidates")
    axes = np.meshgrid(*grid.axes, indexing="ij")
    x, y, z, tilt, azimuth, torsion = (a.ravel() for a in axes)
    radius = np.hypot(x, y)
    ring = (radius >= grid.radius[0] - ROUNDING) & (radius <= grid.radius[1] + ROUNDING)
    position = machine.home.vector[:3] + np.column_stack([x, y, z])
    poses = pose_of_tilt(position, tilt, azimuth, torsion)[ring]
    return _valid(case, poses)


def sampled_candidates(case: Case, count: int, seed: int) -> Array:
    """Quasi-random poses (scrambled Sobol points) of the space that refinement searches, valid ones only.

    The grid of a hexapod leaves out the middle of its space, where poses have little information, the space does not.
    `count` is the number of points that are checked; errors as of `grid_candidates`.
    """
    _require_count(count)
    from scipy.stats import qmc  # a second to import, for this alone

    space, home = space_of(case), case.need_motion("pose candidates")[0]
    points = qmc.Sobol(space.size, seed=seed).random_base2(int(np.ceil(np.log2(count))))[:count]
    shares = space.ends[0] + points * np.ptp(space.ends, axis=0)
    for disc in space.discs:
        radius, angle = np.sqrt(points[:, disc.start]), 2 * np.pi * points[:, disc.start + 1]
        shares[:, disc] = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    inside = np.all((shares >= space.ends[0]) & (shares <= space.ends[1]), axis=1)
    return _valid(case, space.poses(shares[inside], home))


def _valid(case: Case, poses: Array) -> Array:
    if not len(poses):
        raise InfeasiblePlan(
            problem=phrase("no_pose_inside", "no pose lies inside poses.radius_mm and the XY range"),
            remedy=phrase("widen_one", "widen one of them"),
            code=Code.INFEASIBLE,
        )
    satisfied = standing_shares(case, poses) <= 1.0 + TOLERANCE
    valid = satisfied.all(axis=1)
    if not valid.any():
        most = int(np.argmin(satisfied.mean(axis=0)))
        worst, share = standing_report(case, poses).checks[most], 100 * (1 - satisfied[:, most].mean())
        raise InfeasiblePlan(
            problem=phrase(
                "no_pose_valid",
                "none of {count} poses is valid: {worst}, exceeded at {share} % of them",
                count=len(poses),
                worst=worst.sentence(timed=False),
                share=f"{share:.0f}",
            ),
            remedy=phrase(
                "or_narrow",
                "{remedy}, or narrow {what}",
                remedy=said(remedy(worst, case)),
                what="[poses]" if case.chain is None else "limits.motion.joints",
            ),
            code=Code.INFEASIBLE,
        )
    return np.asarray(poses[valid])


def _require_count(count: int) -> None:
    if not 1 <= count <= MOST:
        raise HexciteError(
            problem=f"{count} candidates",
            remedy=f"choose 1 to {MOST}: take other steps in [poses], or sample with {option('candidates')} 20000",
            code=Code.OUT_OF_RANGE,
        )


GAP = 5e-4  # dmax <= u (1 + GAP): the bound is then accurate to 0.05 % of efficiency
FIRST = 2000  # candidates that a design begins with, at most


def candidate_design(regressors: Array) -> Design:
    """The D-optimal design over candidates, with its certificate, of regressors of full rank, shape (n, 6, u)."""
    size = regressors.shape[2]

    def largest(inverse: Array, _: Array) -> Maximum:
        derivative = directional(regressors, inverse)
        order = np.argsort(-derivative)[:EXCHANGED]
        fresh = order[derivative[order] > size * (1.0 + GAP / 2)]
        return float(derivative[order[0]]), float(derivative[order[0]]), fresh[:, None]

    first = np.arange(0.0, len(regressors), max(1, len(regressors) // FIRST))[:, None]
    return exchanged(lambda rows: regressors[rows[:, 0].astype(int)], first, largest, GAP)


def candidates_of(request: PoseRequest, case: Case) -> Array:
    """The poses to choose from, shape (n, k) [m or rad]; errors as `grid_candidates` and `sampled_candidates`."""
    if request.candidates is None:
        return grid_candidates(case)
    return sampled_candidates(case, request.candidates, request.seed)


def _require_rank(model: Model, regressors: Array) -> None:
    try:
        singular_values(total_information(regressors), model.names)
    except IdentificationError as error:
        raise IdentificationError(
            place=f"model {model.number}", problem=error.message, code=Code.NO_EXCITATION
        ) from error


def _require_valid(case: Case, given: Array | None) -> Array:
    """The poses of a user; raises HexciteError without any, InfeasiblePlan where the machine cannot stand at one."""
    if given is None:
        raise HexciteError(
            problem="method given needs poses",
            remedy=f"name a CSV file of them with {option('at')}",
            code=Code.MISSING,
        )
    for number, valid in enumerate(valid_poses(case, given), 1):
        if not valid:
            place = case.words(given[number - 1])
            worst = standing_report(case, given[number - 1 : number]).violations[0].sentence(timed=False)
            raise InfeasiblePlan(
                problem=f"the machine cannot stand at pose {number} ({place}): {worst}",
                remedy="take another one",
                code=Code.INFEASIBLE,
            )
    return given


def _order(case: Case, poses: Array) -> NDArray[np.int64]:
    """Order of visit, from home to home."""
    home = case.need_motion("a plan of poses")[0]
    times = travel_times(case, np.vstack([home, poses]))
    order = shortest_order(times)
    require_ways(times, order)
    return order[1:-1] - 1


def _motion(case: Case, poses: Array) -> tuple[Joined, LimitReport]:
    home, limits = case.need_motion("a plan of poses")
    setting = case.need_poses("a plan of poses")
    same = SAME * np.where(limits.turns, DEG, MM)
    parts: list[Trajectory] = []
    reports: list[LimitReport] = []
    clock, last_pose = 0.0, home
    for pose in [*poses, home]:
        if np.any(np.abs(pose - last_pose) > same):
            move = fastest_move(case, last_pose, pose)
            reports.append(prove(move, case, PROOF_RATE_OF_MOVES, in_box=False).later(clock))
            parts.append(move)
            clock += move.duration
            last_pose = pose
        if pose is not home:  # a repeated one is measured once more, without a move
            parts.append(Standstill(np.array(last_pose), setting.settle_s, setting.average_s))
            clock += parts[-1].duration
    report = worst_of(reports)
    if not report.kept:
        worst = report.violations[0]
        raise InfeasiblePlan(
            problem=f"a move between poses fails: {worst.sentence()}",
            remedy=remedy(worst, case),
            code=Code.INFEASIBLE,
        )
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
    known: Array | None,
    done: Callable[[int], None],
) -> tuple[Array, str]:
    """Chosen poses, shape (n, 6) [m, rad], and the result of the choice in one phrase; `known` as of `reduce_best`."""
    count = request.wanted(len(poses), regressors.shape[2])
    _require_rank(model, regressors)
    criterion = Criterion(request.criterion)  # a letter will do
    if request.method == "all":
        return poses, METHODS["all"]
    change = request.method == "backward-change"
    if change or not criterion.losses_grow:
        _require_few(poses)
    indices, _ = reduce_best(regressors, criterion, count, done, change, known)
    if len(indices) > count:
        raise InfeasiblePlan(
            problem=phrase(
                "poses_lose_rank",
                "{count} poses do not determine model {model}: Algorithm 1 ends at {fewest}, every further removal "
                "loses rank",
                count=count,
                model=request.model,
                fewest=len(indices),
            ),
            remedy=phrase("ask_for_more", "ask for {count} or more", count=len(indices)),
            code=Code.NO_EXCITATION,
        )
    if request.method in ("backward", "backward-change"):
        return poses[indices], "as many as asked for"
    refined, status = refine(case, model, scaling, criterion, poses[indices], known)
    return refined, phrase("refined", "refined ({status})", status=said(status))


def _require_few(poses: Array) -> None:
    """Raises HexciteError for more candidates than of which every removal can be evaluated."""
    if len(poses) > MOST_EXHAUSTIVE:
        raise HexciteError(
            problem="every removal is evaluated for method backward-change and criteria A, K and N, of "
            f"{MOST_EXHAUSTIVE} candidates at most, here are {len(poses)}",
            remedy=f"choose backward for criterion D, or fewer {option('candidates')}",
            code=Code.OUT_OF_RANGE,
        )
