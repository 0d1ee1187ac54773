"""Solves an excitation problem from one start.

Criterion and limits of every result are computed anew, whatever the solver reports (`planner.search.feasibility`). A
motion that exceeds a limit between the instants at which it was constrained is optimised again with tighter limits.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cases.base.errors import Code, HexciteError, IdentificationError, InfeasiblePlan, option
from cases.base.phrases import phrase
from cases.base.units import Array
from cases.schema import Case
from identification.estimation.criteria import Criterion, reference_scaling, singular_values
from identification.limits.limit import UNUSED_SHARE
from identification.machines.of_case import machine_of
from identification.model.model import Model, identification_model
from planner.families.family import Family
from planner.families.ptp import PointToPointFamily
from planner.families.states import Kernel
from planner.noise import (
    ExpectedNoise,
    PoseErrors,
    expected_noise,
    information_of,
    information_of_known,
    seen_through,
)
from planner.request import Solver
from planner.search.annealing import TEMPERATURES, annealed_start
from planner.search.feasibility import keep_limits, require_rest, shrunk_inside
from planner.search.nlp import regressor_kernel
from planner.search.problem import build_program
from planner.search.record import Failed, SolverStatus, StartRecord
from planner.search.restoration import closest_inside
from planner.search.solvers import Barrier, Watch, solve

QUICK_RATE = 1000.0  # [1/s] for comparing starts; the chosen plan is proven at the full rate
COARSE_RATE = 250.0  # [1/s] the same of explorations, which are shrunk to know what there is if the search ends now
SLIPPED = 5e-4  # further unused share of each limit in the rows: for excess between constrained instants
# share of limits of struts, joints and sensors that moves leave which a controller times: it uses all of its limits of
# accelerations and jerks, of which the plan leaves `1 - LAW`
RESERVE = 2e-3
AGAIN = 3  # times at most that a refinement is solved again because what it found lost much on the way inside
REGAINED = 0.02  # of the objective: of an efficiency 2 %; to solve again for less is not worth its time
NEAR = 0.8  # share of a limit from which its instants are then constrained
UNSEEN = 1.2  # share of a limit at an instant without a row from which a refinement begins anew, with rows there
FAR = 0.6  # share of a non-linear limit below which a refinement does not constrain an instant, until it comes near
UNLAWFUL = 1.05  # share of a limit that a controller's law may use of what was explored without it
DRAWN_BACK = 0.98  # share: of an exploration that had to shrink to less the closest motion inside is looked for
HARDLY = 0.998  # the same of refinements
SHARPER = (2, 5, 8)  # halvings of the p-norms of K and N, one round after the other: p = 8, 64, 512


@dataclass(frozen=True, slots=True)
class Start:
    """Result of one start."""

    record: StartRecord
    unknowns: Array  # unknowns of the motion within the limits
    family: Family  # family of the unknowns
    shrunk: float  # share to which the motion was shrunk towards the middle of the box at last
    begin: Array  # unknowns before that, from which a refinement goes on
    promise: float  # the criterion there, by which it is chosen for a refinement


@dataclass(frozen=True, slots=True)
class Task:
    """Task of a worker process: one start."""

    case: Case  # machine and limits
    model: int  # number of the identification model
    family: Family  # the motions to choose from
    criterion: Criterion  # of Table 4
    seed: int  # seed of the random start
    payload: int = 0  # number of the case's payloads that are mounted, for the noise
    begin: Array | None = None  # result of an exploration, which is refined; None for a random start
    reference: Case | None = None  # case of the reference scaling, where `case` has margins; None for the same
    solver: Solver | None = None  # None for the one that suits each stage
    known: Array | None = None  # covariance of u by the noise of earlier results, shape (u, u); None without any

    @property
    def refine(self) -> bool:
        """Whether an exploration is refined."""
        return self.begin is not None

    @property
    def of_moves(self) -> bool:
        """Whether the solver begins near an optimum even in an exploration: from an annealed walk."""
        return isinstance(self.family, PointToPointFamily)

    @property
    def most_calls(self) -> int:
        """How often a watch is called at most, but for what is solved again."""
        stages = sum(iterations for _, _, iterations in _stages(self))
        return stages + (TEMPERATURES if self.of_moves and not self.refine else 0)


# Unknowns up to which an active-set method explores: with quasi-Newton curvature it converges in less time than
# interior points with exact second derivatives take for their first iterations. With more its programs cost more.
FEW = 150
OTHERWISE = 60  # iterations by A, K and N, which begin from a D-optimal motion

# Far from an optimum the barrier adapts (None) and second derivatives are convex: better optima, sooner.
_NEAR: Barrier = (1e-4, 0.3, 1.05)
_AT_HAND: Barrier = (1e-5, 0.2, 1.5)
# Iterations at most, with convex second derivatives, that a refinement of many unknowns begins with. Where exploring
# ended far from the optimum (splines of a seven-joint arm) exact ones take a hundred more, each half as long again.
APPROACH = 80


def _stages(task: Task) -> Iterator[tuple[Criterion, int, int]]:
    """Stages of a start, the smooth criterion D first: criterion, halvings of its p-norm, and iterations at most."""
    if not task.refine:
        yield Criterion.D, 0, task.family.iterations
        return
    if task.criterion == Criterion.D:
        yield Criterion.D, 0, task.family.refining
    elif task.criterion == Criterion.A:
        yield Criterion.A, 0, OTHERWISE
    elif task.criterion in (Criterion.K, Criterion.N):
        for halvings in SHARPER:
            yield task.criterion, halvings, OTHERWISE


def run_start(task: Task, watch: Watch = lambda objective: False) -> Start:
    """Optimises one start.

    Raises:
        InfeasiblePlan: no motion satisfies the limits.
    """
    start = time.perf_counter()
    run = _Run(task, watch)
    unknowns = run.begin()
    exploring = not task.refine
    after, inside, share = -np.inf, None, 1.0
    for letter, halvings, iterations in _stages(task):
        if run.stopped and inside is not None:
            break
        unknowns = run.solve_for(letter, halvings, unknowns, iterations)
        if exploring:
            unknowns, candidate = run.inside(unknowns, DRAWN_BACK)
        else:
            candidate = run.refined(unknowns)
            unknowns = candidate[0]
        value = run.rate(candidate[0])
        if inside is None or value > after:
            after, (inside, share) = value, candidate
    if inside is None or not np.isfinite(after):
        raise InfeasiblePlan(
            problem=phrase(
                "no_start",
                "start {seed} found no motion inside the limits that determines all parameters of model {model}",
                seed=task.seed,
                model=task.model,
            ),
            remedy=f"widen [limits.motion], allow a longer {option('duration')} or choose a smaller {option('model')}"
            + (
                ""
                if task.solver in (None, Solver.IPOPT)
                else f", or leave {option('solver')} {task.solver} out: {run.status.words}"
            ),
            code=Code.INFEASIBLE,
        )
    promise = run.rate(unknowns) if exploring else after
    alone = task.criterion == Criterion.D and task.known is None
    record = StartRecord(
        seed=task.seed,
        refined=not exploring,
        logdet=after if alone else run.rate(inside, Criterion.D, alone=True),
        criterion_value=after,
        solver=run.status,
        converged=run.converged,
        iterations=run.iterations,
        seconds=time.perf_counter() - start,
    )
    return Start(record, inside, run.family, share, unknowns, promise)


def limited_as_searched(case: Case, family: Family) -> Case:
    """A case with the limits that the search of a family keeps."""
    own_law = isinstance(family, PointToPointFamily) and family.own_law
    return case.with_reserve(RESERVE) if own_law else case


@lru_cache(maxsize=2)
def _information_of(
    case: Case, reference: Case, number: int, payload: int
) -> tuple[Model, Array, ExpectedNoise, PoseErrors | None, Kernel]:
    """Model behind the weights, reference scaling, noise, errors of the pose, and the regressor of one state.

    They are the same for all starts of a search, and take as long to build as some iterations.

    Args:
        reference: case of the reference scaling.
        number: that of the model.
    """
    model = identification_model(case, number)
    scaling = reference_scaling(reference, model)
    noise = expected_noise(case, model, payload)
    whitened = seen_through(model, noise.whitening)
    return whitened, scaling, noise, PoseErrors.of(case, noise), regressor_kernel(whitened, scaling)


class _Run:
    """One start while it is optimised: its problem at present, and status and iterations of the solver."""

    def __init__(self, task: Task, watch: Watch) -> None:
        require_rest(task.case)
        self.task, self.family, self.watch = task, task.family, watch
        self.case = limited_as_searched(task.case, task.family)
        self.model, self.scaling, noise, self.errors, regressor = _information_of(
            task.case, task.reference or task.case, task.model, task.payload
        )
        self.known = None
        if task.known is not None:
            samples = task.case.recording.rate_Hz * self.family.duration
            self.known = information_of_known(task.known, self.scaling, noise.sensors**2 / samples)
        margin = UNUSED_SHARE + SLIPPED
        program = build_program(self.case, self.model, self.family, self.scaling, margin, self.errors, self.known)
        self.program = replace(program, regressor=regressor)
        self.iterations, self.status = 0, SolverStatus.NOT_RUN
        self.converged, self.stopped = False, False
        self.ahead = np.zeros(0)  # the iterate that ended it because it exceeds limits where they have no row

    def stops(self, objective: float) -> bool:
        """Whether the solver is to stop, called with the objective of each iteration."""
        self.stopped = self.watch(objective) or self.stopped
        return self.stopped

    def rate(self, unknowns: Array, letter: Criterion | None = None, alone: bool = False) -> float:
        """The requested criterion of a motion, or another: in reference scaling, from its samples at 1 kHz.

        With what is known, unless `alone`. Minus infinity where the motion does not determine all parameters.
        """
        information = information_of(self.model, self.scaling, self.family.motion(unknowns), self.errors)
        if self.known is not None and not alone:
            information = information + self.known
        try:
            mu = singular_values(information, self.model.names)
        except IdentificationError:
            return -np.inf
        return Criterion(letter or self.task.criterion).of_singular_values(mu)  # a letter will do

    def begin(self) -> Array:
        """Unknowns at which the solver begins."""
        task, family, draw = self.task, self.family, np.random.default_rng(self.task.seed)
        if task.begin is not None:
            self.program = self.program.with_rows_near(task.begin, FAR, NEAR)
            return task.begin
        if isinstance(family, PointToPointFamily):
            return annealed_start(self.case, self.model, self.scaling, family, draw, self.stops, self.known)
        return family.start(draw, self.program.worst)

    def by_law(self, unknowns: Array, begin: Array, most: float) -> Array | None:
        """Where a controller, timing the moves by its own law, would exceed limits that they satisfy: unknowns by it.

        The program has rows from here on by which moves satisfy the law.

        Args:
            unknowns: those of the moves.
            begin: unknowns by whose moves leading coordinates are chosen, and whose like are returned.
            most: share of limits up to which it does not count.
        """
        family = self.family
        if not isinstance(family, PointToPointFamily) or not family.own_law or family.leading is not None:
            return None
        if self.program.worst(family.lawful(unknowns)) <= most:
            return None
        begin = family.lawful(begin)
        self.family = family.led_by(begin)
        self.take_rows_of_family()
        return begin

    def take_rows_of_family(self) -> None:
        """Takes bounds and rows of the family itself, some of which follow from its choices."""
        layout = self.family.layout(self.case, UNUSED_SHARE + SLIPPED)
        if self.task.of_moves:
            self.program = self.program.with_own_rows(layout.rows)
        self.program = replace(self.program, lower=layout.lower, upper=layout.upper)

    def solve_for(self, letter: Criterion, halvings: int, unknowns: Array, iterations: int) -> Array:
        """Solves a stage: its problem is that of all that follows until the next."""
        task, self.program = self.task, replace(self.program, letter=letter, halvings=halvings)
        near = task.refine or task.of_moves
        interior = task.solver in (None, Solver.IPOPT)
        if task.refine and not task.of_moves and not self.few and interior and halvings == 0:
            unknowns = self.solve(unknowns, APPROACH, _NEAR, convex=True)
            self.program = self.program.with_rows_above(unknowns, NEAR)
            return self.solve(unknowns, iterations, _AT_HAND)
        solution = self.solve(unknowns, iterations, _NEAR if near else None)
        if not task.refine and (begin := self.by_law(solution, unknowns, UNLAWFUL)) is not None:
            solution = self.solve(begin, iterations, _NEAR)
        return solution

    @property
    def few(self) -> bool:
        """Whether the program has few unknowns."""
        return self.program.unknowns <= FEW

    def solve(self, unknowns: Array, iterations: int, barrier: Barrier | None, convex: bool = False) -> Array:
        """Runs the solver; anew from before an iterate that exceeds limits by far where it has no rows.

        Args:
            iterations: at most; what is begun anew has as many as mending has.
            convex: whether second derivatives are convex where they would be exact otherwise.
        """
        until = self.iterations + iterations
        unknowns = self.solve_once(unknowns, iterations, barrier, convex)
        while self.status is SolverStatus.BEYOND:
            self.program = self.program.with_rows_above(unknowns, FAR).with_rows_above(self.ahead, FAR)
            if convex or self.iterations >= until:  # exact ones go on
                self.status = SolverStatus.ITERATION_LIMIT
                break
            left = max(until - self.iterations, self.family.mending)
            unknowns = self.solve_once(unknowns, left, _AT_HAND, convex)
        return unknowns

    def beyond(self, unknowns: Array) -> bool:
        """Whether an iterate exceeds limits by far where they have no row; it is remembered, for the rows to add."""
        if self.program.unseen(unknowns) <= UNSEEN:
            return False
        self.ahead = unknowns.copy()
        return True

    def solve_once(self, unknowns: Array, iterations: int, barrier: Barrier | None, convex: bool) -> Array:
        """Runs the solver once; where the start is to end, its functions are not even built: that takes seconds."""
        if self.stopped:
            self.status, self.converged = SolverStatus.STOPPED, False
            return unknowns
        task = self.task
        # near an optimum exact curvature converges where convex one ends early; of few unknowns that finds no more
        program = replace(self.program, convex=convex or not (task.of_moves or (task.refine and not self.few)))
        usual = Solver.ACTIVE_SET if self.few and not (task.of_moves or task.refine) else Solver.IPOPT
        solver = task.solver or usual
        beyond = self.beyond if task.refine else None  # an exploration has its rows from the start
        solution, self.status, count = solve(program, unknowns, iterations, self.stops, barrier, solver, beyond)
        self.iterations += count
        self.converged = self.status.converged and bool(np.isfinite(solution).all())
        if not np.isfinite(solution).all():
            return unknowns
        return np.asarray(np.clip(solution, program.lower, program.upper))

    @property
    def rate_of_checks(self) -> float:
        """Rate at which motions are shrunk [1/s]."""
        # Bodies are looked at with the way that they go until half way to the next instant, which is long at few.
        apart = machine_of(self.case).named_distances != []
        return QUICK_RATE if self.task.refine or apart else COARSE_RATE

    def feasible(self, unknowns: Array) -> tuple[Array, float]:
        """Unknowns of the motion shrunk inside every limit, and the share to which it was shrunk."""
        return keep_limits(self.case, self.family.once, unknowns, self.rate_of_checks)

    def inside(self, unknowns: Array, share: float) -> tuple[Array, tuple[Array, float]]:
        """A motion that satisfies its limits, or nearly, and the same as `feasible`.

        The motion itself; where it had to shrink to less than a share, or is outside its bounds, the closest inside.
        Where that has to shrink as much, the better of both. A stopped exploration is shrunk: it is worth little, and
        others may be done.

        Raises:
            InfeasiblePlan: neither is inside.
        """
        within = np.clip(unknowns, self.program.lower, self.program.upper)
        if self.stopped and not self.task.refine:
            return within, self.feasible(within)
        once, rate = self.family.once, self.rate_of_checks
        if self.program.outside(unknowns) < SLIPPED:
            hardly = shrunk_inside(self.case, once, within, rate, share)
            if hardly is not None and hardly[1] >= share:
                return within, hardly
        bound = 1.0 - UNUSED_SHARE - SLIPPED
        closest, bounds = closest_inside(self.program, self.case, self.family, unknowns, bound)
        self.program = self.program.bounded(bounds)
        restored = shrunk_inside(self.case, once, closest, rate, share)
        if restored is not None:
            return closest, restored
        try:
            shrunk = self.feasible(within)
        except InfeasiblePlan:  # a controller that times moves itself accelerates as hard in shorter ones
            return closest, self.feasible(closest)
        try:
            restored = self.feasible(closest)
        except InfeasiblePlan:
            return within, shrunk
        better = self.rate(restored[0], self.program.letter) > self.rate(shrunk[0], self.program.letter)
        return (closest, restored) if better else (within, shrunk)

    def refined(self, unknowns: Array) -> tuple[Array, float]:
        """As `feasible`, of what refining found: brought inside, and solved again from there where that cost much.

        What the solver exceeds limits by, at instants without a row and between them, is mostly a short way back.
        """
        self.family = self.family.refined(unknowns)
        self.take_rows_of_family()
        if (lawful := self.by_law(unknowns, unknowns, 1.0 - UNUSED_SHARE)) is not None:
            unknowns = lawful
        best, lowest, ended = None, np.inf, (self.status, self.converged)
        for _ in range(1 + AGAIN):
            closest, candidate = self.inside(unknowns, HARDLY)
            value, wanted = self.program.value(candidate[0]), self.program.value(unknowns)
            gained = lowest - value
            if best is None or gained > 0.0:
                best, lowest, ended = candidate, value, (self.status, self.converged)
            if self.stopped or value - wanted < REGAINED or gained < REGAINED:
                break
            self.program = self.program.with_rows_above(unknowns, NEAR)
            unknowns = self.solve(closest, self.family.mending, _AT_HAND)
        assert best is not None
        self.status, self.converged = ended
        return best


def run_safely(task: Task, watch: Watch) -> Start | Failed:
    """Runs a start; the reason why it found no feasible motion is an answer, so that others go on."""
    try:
        return run_start(task, watch)
    except HexciteError as error:
        return Failed(task.seed, error.message)
