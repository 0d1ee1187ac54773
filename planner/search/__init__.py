"""The search for a motion: the non-linear program, its solvers, and starts in parallel; the record of it in a plan."""

from dataclasses import dataclass

from planner.precision import SolverStatus


@dataclass(frozen=True, slots=True)
class StartRecord:
    """One start of a search, as a plan records it."""

    seed: int  # seed of the random start
    refined: bool  # whether all limits were constrained wherever they come close; else it was explored only
    logdet: float  # log det F of the motion within the limits, W as in the identification
    criterion_value: float  # value of the requested criterion for the same motion, to be maximised
    solver: SolverStatus  # the solver's last
    converged: bool  # whether its last stage converged
    iterations: int  # iterations of the solver, all stages
    seconds: float  # time spent


@dataclass(frozen=True, slots=True)
class Failed:
    """A start without a feasible motion."""

    seed: int  # seed of the random start
    reason: str  # why, in one line
