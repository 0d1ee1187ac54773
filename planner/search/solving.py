"""Solves an excitation problem from many random starts and rates what comes out in NumPy.

No solver's own word is taken: criterion and limits of every result are computed anew from the motion, and a motion that
passes a limit between the samples of the grid is drawn back until it does not.
"""

import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import HexciteError, IdentificationError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limits import TOLERANCE, LimitReport, of_mechanics, prove, prove_at
from identification.model import Model, identification_model
from identification.motion import Trajectory
from identification.overload import load_shares
from identification.reference import reference_scaling
from planner.families.family import Family
from planner.families.ptp import PointToPointFamily
from planner.infeasible import remedy, require_rest
from planner.noise import expected_noise, seen_through
from planner.search.annealing import annealed_start
from planner.search.lifted import lifted
from planner.search.problem import Problem, build_problem, mean_information
from planner.search.solvers import SOLVERS, Program, Reached, Watch

Array = NDArray[np.float64]

LIMIT_ROUNDS = 5  # rounds of adding the non-linear limits that came close
AGAIN = 3  # later rounds have one in so many of the first one's iterations: they begin where it has ended
EXACT = 3  # with exact second derivatives one in so many iterations is enough
AT_HAND = 1e-6  # barrier where a round begins from the result of the one before
OUTSIDE = 1.1, 1e-3  # from this share of a non-linear limit on, a start is outside and the barrier at least so high
NEAR = 0.9  # share of a non-linear limit from which it counts as close
PASSED = 1e-3  # share by which a limit may be passed within a round's result: the final drawing back takes it
MARGIN = 1e-3  # of every limit, left for the rounding of program words and for the encoders' view of the motion
CLOSE_ENOUGH = 3e-4  # gap of the bisection that draws a motion back
BISECTIONS = 25
GUESSES = 3  # of them, before any motion keeps the limits, go where limits would be kept that shrink with the motion
QUICK_RATE = 1000.0  # [1/s] for comparing starts; the chosen plan is proven at the full rate
SHARPNESS = (1, 3, 5)  # halvings of the p-norms of K and N, one round after the other: p = 4, 16, 64
SHARPER = (2, 5, 8)  # the same with exact second derivatives: p = 8, 64, 512, which is within 0.6 % of exact


class Stage(NamedTuple):
    """How thoroughly to optimise.

    Args:
        name: for the report.
        iterations: of the solver, at most, in the first round.
        fine: whether the family is refined and non-linear limits are rows too; else only the final drawing back keeps
            them, and A, K and N begin from the D-optimal motion.
        annealing: proposals of the annealing that finds starts of point-to-point motions, for each pair of moves: what
            there is to choose grows with their number, and so does the cost of a choice. 0: starts are random.
        barrier: with which IPOPT begins, and then has exact second derivatives; high for starts far from an optimum. 0:
            they are approximated.
    """

    name: str
    iterations: int
    fine: bool
    annealing: int = 0
    barrier: float = 0.0


@dataclass(frozen=True, slots=True)
class Start:
    """What became of one start.

    Args:
        seed: of the random start.
        stage: the stage it went through.
        start_logdet: log det F at its start, reference scaling, W as identification will have it.
        logdet: log det F of the motion within the limits, the same.
        score: the criterion of the motion within the limits; the larger the better.
        status: the solver's last words.
        converged: whether the solver says that it is done.
        iterations: of the solver, all rounds.
        seconds: time spent.
        unknowns: the motion.
        family: what the unknowns mean.
        begin: where another stage goes on: the motion, or what it was before it was drawn back for its sensor forces or
            out of boxes, which are no rows of a coarse stage: shrinking takes most of the information away.
        promise: the criterion there, by which it is chosen for another stage.
    """

    seed: int
    stage: str
    start_logdet: float
    logdet: float
    score: float
    status: str
    converged: bool
    iterations: int
    seconds: float
    unknowns: Array
    family: Family
    begin: Array
    promise: float


@dataclass(frozen=True, slots=True)
class Failed:
    """A start that led nowhere.

    Args:
        seed: of the random start.
        stage: the stage it failed in.
        reason: why, in one line.
    """

    seed: int
    stage: str
    reason: str


@dataclass(frozen=True, slots=True)
class Task:
    """What a worker process needs to run one start.

    Args:
        case: machine and limits.
        model: number of the identification model.
        family: the motions to choose from.
        criterion: letter of Table 4.
        solver: its name.
        stage: how thoroughly.
        seed: of the random start.
        unknowns: where to start instead.
        payload: number of the case's payloads that are mounted, for the noise.
    """

    case: Case
    model: int
    family: Family
    criterion: str
    solver: str
    stage: Stage
    seed: int
    unknowns: Array | None = None
    payload: int = 0

    @property
    def exact(self) -> bool:
        """Whether second derivatives are exact."""
        return self.stage.barrier > 0.0 and self.solver == "ipopt"


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


def random_start(seed: int, family: Family, problem: Problem) -> Array:
    """Random unknowns inside the limits."""
    return family.start(np.random.default_rng(seed), problem.worst())


def _start(task: Task, model: Model, scaling: Array, problem: Problem, watch: Watch) -> Array:
    family, per_pair = task.family, task.stage.annealing
    if not (isinstance(family, PointToPointFamily) and per_pair):
        return random_start(task.seed, family, problem)
    draw = np.random.default_rng(task.seed)
    return annealed_start(task.case, model, scaling, family, draw, per_pair * family.moves**2, watch)


def keep_limits(case: Case, family: Family, unknowns: Array, rate: float) -> tuple[Array, LimitReport]:
    """Draws a motion towards the middle of the box until it keeps every limit, less a margin, on a grid of `rate`.

    Raises:
        InfeasiblePlan: it passes a limit even where all but nothing moves; the message names the limit.
    """
    kept, passed = 0.0, np.inf  # shares
    share, best = 1.0, None
    for number in range(BISECTIONS):
        trial = family.shrunk(unknowns, share)
        report = prove(family.motion(trial), case, rate)
        if report.worst_ratio <= 1.0 - MARGIN + TOLERANCE:
            kept, best = share, (trial, report)
        else:
            passed = share
        if best is not None and (passed - kept <= CLOSE_ENOUGH or kept == 1.0):
            return best
        # The guess is right for what shrinks with the motion; a distance from a box does not.
        guess = share * (1.0 - MARGIN) / report.worst_ratio
        guessed = kept < guess < passed and (best is not None or number < GUESSES)
        share = guess if guessed else (kept + passed) / 2
    if best is not None:
        return best
    worst = max((c for c in report.checks), key=lambda c: c.ratio)
    raise InfeasiblePlan(f"no feasible motion: {worst.sentence()}; {remedy(worst)} or move home")


def run_start(task: Task, watch: Watch = lambda objective: False) -> Start:
    """Optimises one start through one stage.

    Raises:
        InfeasiblePlan: no motion keeps the limits.
    """
    began = time.perf_counter()
    require_rest(task.case)
    model = identification_model(task.case, task.model)
    scaling = reference_scaling(task.case, model)
    model = seen_through(model, expected_noise(task.case, model, task.payload).whitening)
    fine = task.stage.fine
    family = task.family.refined(task.unknowns) if fine and task.unknowns is not None else task.family
    problem = build_problem(task.case, model, family, scaling)
    unknowns = _start(task, model, scaling, problem, watch) if task.unknowns is None else task.unknowns
    before = rate(model, scaling, family, unknowns, task.criterion)
    score, found, reached = -np.inf, unknowns, None
    iterations = 0
    rounds = SHARPER if task.exact else SHARPNESS
    for halvings in rounds if fine and task.criterion in "KN" else (0,):
        letter = task.criterion if fine else "D"
        reached = _optimise(problem, family, found, task, letter, halvings, watch)
        iterations += reached.iterations
        inside, _ = keep_limits(task.case, family, reached.unknowns, QUICK_RATE)
        after = rate(model, scaling, family, inside, task.criterion)
        if after.score > score:
            score, found, rating = after.score, inside, after
    assert reached is not None
    if not np.isfinite(score):
        raise InfeasiblePlan(
            f"start {task.seed} found no motion inside the limits that determines all parameters of model "
            f"{task.model}; widen [limits.motion], allow a longer --duration or choose a smaller --model"
        )
    free = family.motion(reached.unknowns)
    undone = not fine and (len(closest_load(task.case, free)) > 0 or enters_a_box(task.case, free))
    begin, promise = found, score
    if undone:
        begin, promise = reached.unknowns, rate(model, scaling, family, reached.unknowns, task.criterion).score
    seconds = time.perf_counter() - began
    return Start(
        task.seed, task.stage.name, before.logdet, rating.logdet, score, reached.status, reached.converged,
        iterations, seconds, found, family, begin, promise,
    )  # fmt: skip


def closest_load(case: Case, motion: Trajectory) -> tuple[int, ...]:
    """The number of payloads with which a motion uses most of what the sensors may carry, where that is close to all.

    One at a time: where the worst load is held, lighter ones rarely come close.
    """
    count = max(2, int(np.ceil(motion.duration * QUICK_RATE)))
    shares = load_shares(motion.at(np.linspace(0.0, motion.duration, count)), case)
    return (int(shares.argmax()),) if len(shares) and shares.max() > NEAR else ()


def enters_a_box(case: Case, motion: Trajectory) -> bool:
    """Whether platform, struts or tools enter a box that they are kept out of."""
    if not case.need_machine("planning")[1].keep_out:
        return False
    instants = np.linspace(0.0, motion.duration, max(2, int(np.ceil(motion.duration * QUICK_RATE))))
    checks = prove_at(motion, case, instants, limited=of_mechanics).checks
    return any(check.name.startswith("distance from") and not check.kept for check in checks)


def _optimise(
    problem: Problem, family: Family, unknowns: Array, task: Task, letter: str, halvings: int, watch: Watch
) -> Reached:
    """Solves, again with more of the non-linear limits as long as one is passed.

    Sensor forces enter with the load that comes closest to their limit, if it comes close.
    """
    if task.stage.fine:
        problem = problem.with_loads(task.case, closest_load(task.case, family.motion(unknowns)))
    active = problem.held_from_the_start()
    if task.stage.fine:
        active |= problem.limit_shares(unknowns) > NEAR
    iterations = 0
    stopped = False

    def told(objective: float) -> bool:
        nonlocal stopped
        stopped = watch(objective)
        return stopped

    for after in range(LIMIT_ROUNDS if task.stage.fine else 1):
        sampling = problem.sampling
        most = task.stage.iterations if after == 0 else max(1, task.stage.iterations // AGAIN)
        if task.exact:
            barrier = task.stage.barrier if after == 0 and halvings <= SHARPER[0] else AT_HAND
            if problem.limit_shares(unknowns).max() > OUTSIDE[0]:
                barrier = max(barrier, OUTSIDE[1])
            raised = lifted(problem, active, letter, halvings, barrier)
            reached = SOLVERS[task.solver](raised.program, raised.start(unknowns), max(1, most // EXACT), told)
        else:
            program = Program(
                problem.unknowns,
                problem.objective(letter, halvings),
                problem.constraints(active),
                sampling.lower,
                sampling.upper,
            )
            reached = SOLVERS[task.solver](program, unknowns, most, told)
        iterations += reached.iterations
        found = reached.unknowns[: len(unknowns)]
        if np.isfinite(found).all():
            unknowns = np.clip(found, sampling.lower, sampling.upper)
        if task.stage.fine:
            problem = problem.with_loads(task.case, closest_load(task.case, family.motion(unknowns)))
        shares = problem.limit_shares(unknowns)
        if shares.max() <= 1.0 + PASSED or stopped:
            break
        more = len(shares) - len(active)  # rows of further loads
        active = np.vstack([active, np.zeros((more, active.shape[1]), dtype=bool)]) | (shares > NEAR)
    return Reached(unknowns, reached.status, reached.converged, iterations)


def run_safely(task: Task, watch: Watch) -> Start | Failed:
    """Runs a start; what keeps it from a feasible motion is an answer, so that others go on."""
    try:
        return run_start(task, watch)
    except HexciteError as error:
        return Failed(task.seed, task.stage.name, str(error))


def seeds_of(seed: int, starts: int) -> list[int]:
    """Seeds of the starts, reproducible from one seed; more starts extend the list."""
    return [int(s.generate_state(1)[0]) for s in np.random.SeedSequence(seed).spawn(starts)]
