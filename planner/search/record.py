"""The search for a motion: the non-linear program, its solvers, and starts in parallel; the record of it in a plan."""

from dataclasses import dataclass
from enum import StrEnum

from cases.base.phrases import Phrase, phrase, said


class SolverStatus(StrEnum):
    """How a run of a solver ended: return statuses as CasADi names them, in small letters, and ours."""

    CONVERGED = "solve succeeded"
    ACCEPTABLE = "solved to acceptable level"
    FEASIBLE = "feasible point found"
    STOPPED = "user requested stop"
    ITERATION_LIMIT = "maximum iterations exceeded"
    SETTLED = "no more gained"
    SHORT_STEP = "search direction becomes too small"
    BEYOND = "beyond a limit that it did not see"
    NOT_RUN = ""
    FAILED = "failed"  # for whichever reason

    @classmethod
    def _missing_(cls, value: object) -> "SolverStatus":
        """The member of a status as CasADi writes it, such as `Solve_Succeeded`."""
        plain = str(value).replace("_", " ").lower()
        return next((status for status in cls if status.value == plain), cls.FAILED)

    @property
    def converged(self) -> bool:
        """Whether the solver converged, or gained so little that it was stopped."""
        return self in (SolverStatus.CONVERGED, SolverStatus.ACCEPTABLE, SolverStatus.FEASIBLE, SolverStatus.SETTLED)

    @property
    def words(self) -> Phrase:
        """What people are shown: to stop at the iterations that a stage has is not a failure."""
        return _SHOWN.get(self, said(str(self)))


_SHOWN = {
    SolverStatus.ITERATION_LIMIT: phrase("at_iterations", "at its iteration limit"),
    SolverStatus.STOPPED: phrase("search_stopped", "stopped by the time limit or by Ctrl-C"),
    SolverStatus.CONVERGED: phrase("converged", "converged"),
    SolverStatus.SHORT_STEP: phrase("short_steps", "its steps became too short"),
}


@dataclass(frozen=True, slots=True)
class StartRecord:
    """One start of a search, as a plan records it."""

    seed: int  # seed of the random start
    refined: bool  # whether all limits were constrained wherever they come close; else it was explored only
    logdet: float  # log det F of the motion within the limits, W as in the identification
    criterion_value: float  # value of the requested criterion with what is known, to be maximised
    solver: SolverStatus  # the solver's last
    converged: bool  # whether its last stage converged
    iterations: int  # iterations of the solver, all stages
    seconds: float  # time spent


@dataclass(frozen=True, slots=True)
class Failed:
    """A start without a feasible motion."""

    seed: int  # seed of the random start
    reason: str  # why, in one line
