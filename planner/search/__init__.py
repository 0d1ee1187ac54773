"""The search for a motion: the non-linear program, its solvers, and starts in parallel; what a plan keeps of it."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tried:
    """One start of a search, as a plan keeps it."""

    seed: int  # of the random start
    refined: bool  # whether all limits were constrained wherever they come close; else it was explored only
    start_logdet: float | None  # log det F where it began, reference scaling; None where F was singular
    logdet: float  # log det F of the motion within the limits, W as identification will have it
    criterion_value: float  # of the same motion, by the criterion asked for, to be maximised
    solver: str  # the solver's last status
    converged: bool  # whether its last stage converged
    iterations: int  # of the solver, all stages
    seconds: float  # time spent


@dataclass(frozen=True, slots=True)
class Failed:
    """A start that led nowhere."""

    seed: int  # of the random start
    reason: str  # why, in one line
