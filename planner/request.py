"""What to plan: settings as a user states them, refused before any work where they cannot be met."""

from dataclasses import dataclass

import numpy as np

from cases.errors import HexciteError
from identification.criteria import CRITERIA
from planner.families.ptp import FEWEST, MOST

FAMILIES = ("fourier", "ptp")
SOLVER_NAMES = ("ipopt", "sqp", "slsqp")
LONGEST = 600.0  # [s] of an excitation; the method is for production breaks
SHORTEST_MOVE = 0.06  # [s] mean duration of a move that a machine can make anything of


@dataclass(frozen=True, slots=True)
class Request:
    """What to plan.

    Args:
        case_file: name or file of the case.
        family: fourier or ptp.
        criterion: letter of Table 4.
        solver: ipopt, sqp or slsqp.
        model: number in Table 2.
        duration: of the excitation [s].
        order: N of (34), family fourier.
        period: [s], family fourier; the duration is a whole number of it.
        moves: family ptp.
        starts: random starts.
        seed: of these.
    """

    case_file: str
    family: str = "fourier"
    criterion: str = "D"
    solver: str = "ipopt"
    model: int = 9
    duration: float = 12.0
    order: int = 5
    period: float = 3.0
    moves: int = 40
    starts: int = 8
    seed: int = 0

    def __post_init__(self) -> None:
        _one_of("family", self.family, FAMILIES)
        _one_of("criterion", self.criterion, CRITERIA)
        _one_of("solver", self.solver, SOLVER_NAMES)
        if not self.duration <= LONGEST:
            raise HexciteError(f"duration {self.duration:g} s is longer than {LONGEST:g} s; choose about 12 s")
        {"fourier": self._fourier, "ptp": self._ptp}[self.family]()
        if not 1 <= self.starts <= 1000:
            raise HexciteError(f"{self.starts} starts; choose 1 to 1000")
        if self.seed < 0:
            raise HexciteError(f"seed {self.seed} is negative; choose 0 or more")

    def _fourier(self) -> None:
        if not 2 <= self.order <= 7:
            raise HexciteError(f"order {self.order} is outside 2 to 7; 1 cannot start at rest, above 7 only jerk grows")
        if not self.period > 0.0 or not np.isfinite(self.period):
            raise HexciteError(f"period {self.period:g} s is not positive; choose about 3 s")
        repeats = self.duration / self.period
        if not (round(repeats) >= 1 and abs(repeats - round(repeats)) < 1e-9):
            raise HexciteError(
                f"duration {self.duration:g} s is not a whole number of periods of {self.period:g} s; choose "
                f"{max(1, round(repeats)) * self.period:g} s"
            )

    def _ptp(self) -> None:
        if not FEWEST <= self.moves <= MOST:
            raise HexciteError(f"{self.moves} moves are outside {FEWEST} to {MOST}; choose about 40")
        shortest = self.moves * SHORTEST_MOVE
        if not self.duration >= shortest:
            raise HexciteError(
                f"duration {self.duration:g} s is too short for {self.moves} moves; choose at least {shortest:g} s or "
                "fewer moves"
            )


def _one_of(what: str, value: str, allowed: object) -> None:
    names = list(allowed)  # type: ignore[call-overload]
    if value not in names:
        raise HexciteError(f"{what} {value!r} is unknown; choose {', '.join(names)}")
