"""Solves an excitation problem from one start and rates what comes out in NumPy.

The solver's own word is not taken: criterion and limits of every result are computed anew from the motion, and a motion
that exceeds a limit between the instants at which it was constrained is drawn back until it does not.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError, IdentificationError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limits import TOLERANCE, LimitReport, prove
from identification.model import Model, identification_model
from identification.reference import reference_scaling
from planner.families.family import Family
from planner.families.ptp import PointToPointFamily
from planner.infeasible import remedy, require_rest
from planner.noise import expected_noise, seen_through
from planner.search.annealing import annealed_start
from planner.search.ipopt import Reached, Watch, solve
from planner.search.problem import Problem, build_problem, mean_information

Array = NDArray[np.float64]

MARGIN = 1e-3  # of every limit, left for the rounding of program words and for the encoders' view of the motion
CLOSE_ENOUGH = 3e-4  # gap of the bisection that draws a motion back
SMALLEST = 1e-6  # share of all ways below which nothing moves
QUICK_RATE = 1000.0  # [1/s] for comparing starts; the chosen plan is proven at the full rate
PROPOSALS = 60  # of the annealing that finds starts of point-to-point motions, for each pair of moves
SLIPPED = 5e-4  # share of each limit that rows leave free besides: for what slips between constrained instants
FINER = 1e-4  # of that, for what slips between the instants of the quick look
TIGHTER = 2  # times at most that limits are constrained at more instants, and tightened by what is left
NEAR = 0.8  # share of a limit from which its instants are then constrained
DRAWN_BACK = 0.98  # a motion that had to shrink to less than this is searched for once more, from inside
QUICK = 5  # the same for a look at what such motions carry
EXPLORE = {"fourier": 30, "spline": 50, "ptp": 60}  # iterations at most
REFINE, GLANCE = 30, 25  # the same of refinements, and of a glance at another family
SHARPER = (2, 5, 8)  # halvings of the p-norms of K and N, one round after the other: p = 8, 64, 512


@dataclass(frozen=True, slots=True)
class Start:
    """What became of one start.

    Args:
        seed: of the random start.
        start_logdet: log det F at its start, reference scaling, W as identification will have it.
        logdet: log det F of the motion within the limits, the same.
        score: the criterion of the motion within the limits; the larger the better.
        status: the solver's last words.
        converged: whether the solver says that its last stage is done.
        iterations: of the solver, all stages.
        seconds: time spent.
        unknowns: the motion.
        family: what the unknowns mean.
        shrunk: share to which the motion was drawn towards the middle of the box at last.
        begin: where a refinement goes on: the motion before that.
        promise: the criterion there, by which it is chosen for a refinement.
        refined: whether limits were constrained wherever they come close; else at first instants only.
    """

    seed: int
    start_logdet: float
    logdet: float
    score: float
    status: str
    converged: bool
    iterations: int
    seconds: float
    unknowns: Array
    family: Family
    shrunk: float
    begin: Array
    promise: float
    refined: bool


@dataclass(frozen=True, slots=True)
class Failed:
    """A start that led nowhere.

    Args:
        seed: of the random start.
        reason: why, in one line.
    """

    seed: int
    reason: str


@dataclass(frozen=True, slots=True)
class Task:
    """What a worker process needs to run one start.

    Args:
        case: machine and limits.
        model: number of the identification model.
        family: the motions to choose from.
        criterion: letter of Table 4.
        seed: of the random start.
        payload: number of the case's payloads that are mounted, for the noise.
        begin: the result of an exploration that is to be refined.
        rival: whether this is a quick look at another family, to compare with.
    """

    case: Case
    model: int
    family: Family
    criterion: str
    seed: int
    payload: int = 0
    begin: Array | None = None
    rival: bool = False

    @property
    def moves(self) -> bool:
        """Whether the start is an annealed walk, which is refined at once."""
        return isinstance(self.family, PointToPointFamily)


class Rating(NamedTuple):
    """What a motion is worth in reference scaling: log det F, and the criterion to be maximised."""

    logdet: float
    score: float


def rate(model: Model, scaling: Array, family: Family, unknowns: Array, criterion: str) -> Rating:
    """Rates a motion from its samples at 1 kHz; minus infinity where it does not determine all parameters."""
    information = mean_information(model, scaling, family.motion(unknowns))
    try:
        mu = singular_values(information, model.names)
    except IdentificationError:
        return Rating(-np.inf, -np.inf)
    return Rating(CRITERIA["D"].of(mu), CRITERIA[criterion].of(mu))


class Inside(NamedTuple):
    """A motion that satisfies every limit.

    Args:
        unknowns: of the motion.
        report: of its limits.
        share: of all ways that are left.
    """

    unknowns: Array
    report: LimitReport
    share: float


def keep_limits(case: Case, family: Family, unknowns: Array, rate: float) -> Inside:
    """Draws a motion towards the middle of the box until it satisfies every limit, less a margin, on a grid of `rate`.

    From small steps to large ones: lengths of struts need not fall on the way, so that a smaller motion is not always
    further inside.

    Raises:
        InfeasiblePlan: it exceeds a limit even where all but nothing moves; the message names the limit.
    """

    def attempt(share: float) -> tuple[Inside | None, LimitReport]:
        trial = family.shrunk(unknowns, share)
        report = prove(family.motion(trial), case, rate)
        good = report.worst_ratio <= 1.0 - MARGIN + TOLERANCE
        return Inside(trial, report, share) if good else None, report

    best, report = attempt(1.0)
    share, failed, step = 1.0, 1.0, CLOSE_ENOUGH
    while best is None and share > SMALLEST:
        failed, share = share, share - step if step < share / 2 else share / 2
        best, report = attempt(share)
        step *= 2
    if best is None:
        worst = max(report.checks, key=lambda c: c.ratio)
        raise InfeasiblePlan(f"no feasible motion: {worst.sentence()}; {remedy(worst)} or move home")
    while failed - best.share > CLOSE_ENOUGH:
        between = (failed + best.share) / 2
        better, _ = attempt(between)
        if better is None:
            failed = between
        else:
            best = better
    return best


class _Stage(NamedTuple):
    """One run of the solver.

    Args:
        letter: of the criterion.
        halvings: see `planner.search.criterion`.
        convex: see `planner.search.program.Program`.
        iterations: at most.
        options: of the solver.
    """

    letter: str
    halvings: int
    convex: bool
    iterations: int
    options: dict[str, object]


OTHERWISE = 60  # iterations by A, K and N, which begin from a D-optimal motion

# Far from an optimum the barrier adapts and second derivatives are convex: that leads to better optima, sooner.
_FAR: dict[str, object] = {"mu_strategy": "adaptive"}
_NEAR: dict[str, object] = {"mu_init": 1e-4, "mu_linear_decrease_factor": 0.3, "mu_superlinear_decrease_power": 1.05}
_AT_HAND: dict[str, object] = {"mu_init": 1e-5}


def _stages(task: Task) -> Iterator[_Stage]:
    """First by D, which is smooth everywhere, then, when refining, by the criterion asked for."""
    afar = _NEAR if task.moves else _FAR
    if task.rival:
        yield _Stage("D", 0, not task.moves, GLANCE, afar)
        return
    if task.begin is None:
        yield _Stage("D", 0, not task.moves, EXPLORE[task.family.name], afar)
    if task.begin is None and not task.moves:
        return
    if task.criterion == "D" and task.begin is not None:
        yield _Stage("D", 0, False, REFINE, _AT_HAND)
    elif task.criterion == "A":
        yield _Stage("A", 0, not task.moves, OTHERWISE, afar)
    elif task.criterion in "KN":
        for halvings in SHARPER:
            yield _Stage(task.criterion, halvings, not task.moves, OTHERWISE, afar)


def run_start(task: Task, watch: Watch = lambda objective: False) -> Start:
    """Optimises one start.

    Raises:
        InfeasiblePlan: no motion satisfies the limits.
    """
    began = time.perf_counter()
    require_rest(task.case)
    model = identification_model(task.case, task.model)
    scaling = reference_scaling(task.case, model)
    model = seen_through(model, expected_noise(task.case, model, task.payload).whitening)
    family, stopped = task.family, False

    def told(objective: float) -> bool:
        nonlocal stopped
        stopped = watch(objective) or stopped
        return stopped

    exploring = task.begin is None and not task.moves
    begin = _start(task, model, scaling, told)
    problem = build_problem(task.case, model, family, scaling, MARGIN + SLIPPED)
    unknowns = family.start(np.random.default_rng(task.seed), problem.worst) if begin is None else begin
    before = rate(model, scaling, family, unknowns, task.criterion)
    if task.begin is not None:
        problem = problem.with_rows_above(unknowns, NEAR)
    best: tuple[Rating, Inside] | None = None
    iterations, reached = 0, None
    for stage in _stages(task):
        if stopped and best is not None:
            break
        reached = _solve(problem, unknowns, stage, told)
        iterations, unknowns = iterations + reached.iterations, reached.unknowns
        family = family.refined(unknowns)
        problem = problem.within(family.layout(task.case, MARGIN + SLIPPED))
        for round_ in range(0 if exploring else TIGHTER):
            slips = problem.slips(family.motion(unknowns))
            if stopped or (max(slips) <= 1.0 - MARGIN - FINER and problem.outside(unknowns) < SLIPPED):
                break
            problem = problem.with_rows_above(unknowns, NEAR)
            if round_ or task.begin is not None:
                problem = problem.tightened(slips, 1.0 - MARGIN - SLIPPED)
            reached = _solve(problem, unknowns, stage._replace(convex=False, iterations=REFINE, options=_AT_HAND), told)
            iterations, unknowns = iterations + reached.iterations, reached.unknowns
        inside = keep_limits(task.case, family, unknowns, QUICK_RATE)
        if inside.share < DRAWN_BACK and not (stopped or exploring):
            problem = problem.with_rows_above(unknowns, 0.0)
            reached = _solve(problem, inside.unknowns, stage._replace(convex=False, options=_NEAR), told)
            iterations += reached.iterations
            other = keep_limits(task.case, family, reached.unknowns, QUICK_RATE)
            scores = [rate(model, scaling, family, m.unknowns, stage.letter).score for m in (inside, other)]
            if scores[1] >= scores[0]:
                inside = other
        after = rate(model, scaling, family, inside.unknowns, task.criterion)
        if best is None or after.score > best[0].score:
            best = after, inside
        if not exploring:
            unknowns = inside.unknowns
    assert best is not None
    assert reached is not None
    after, inside = best
    if not np.isfinite(after.score):
        raise InfeasiblePlan(
            f"start {task.seed} found no motion inside the limits that determines all parameters of model "
            f"{task.model}; widen [limits.motion], allow a longer --duration or choose a smaller --model"
        )
    promise = rate(model, scaling, family, unknowns, task.criterion).score if exploring else after.score
    seconds = time.perf_counter() - began
    return Start(
        task.seed, before.logdet, after.logdet, after.score, reached.status, reached.converged, iterations, seconds,
        inside.unknowns, family, inside.share, unknowns, promise, not exploring,
    )  # fmt: skip


def _start(task: Task, model: Model, scaling: Array, watch: Watch) -> Array | None:
    """Where the solver begins; None for a random start."""
    family = task.family
    if task.begin is not None or not isinstance(family, PointToPointFamily):
        return task.begin
    draw = np.random.default_rng(task.seed)
    proposals = (QUICK if task.rival else PROPOSALS) * family.moves**2
    return annealed_start(task.case, model, scaling, family, draw, proposals, watch)


def _solve(problem: Problem, unknowns: Array, stage: _Stage, watch: Watch) -> Reached:
    program = replace(problem.program, letter=stage.letter, halvings=stage.halvings, convex=stage.convex)
    reached = solve(program, unknowns, stage.iterations, watch, stage.options)
    if not np.isfinite(reached.unknowns).all():
        return replace(reached, unknowns=unknowns, converged=False)
    return replace(reached, unknowns=np.clip(reached.unknowns, program.lower, program.upper))


def run_safely(task: Task, watch: Watch) -> Start | Failed:
    """Runs a start; what keeps it from a feasible motion is an answer, so that others go on."""
    try:
        return run_start(task, watch)
    except HexciteError as error:
        return Failed(task.seed, str(error))


def seeds_of(seed: int, starts: int) -> list[int]:
    """Seeds of the starts, reproducible from one seed; more starts extend the list."""
    return [int(s.generate_state(1)[0]) for s in np.random.SeedSequence(seed).spawn(starts)]
