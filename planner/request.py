"""What to plan: settings as a user states them, refused before any work where they cannot be met."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cases.errors import HexciteError
from identification.criteria import CRITERIA
from planner.families.ptp import FEWEST, MOST
from planner.families.spline import FEWEST as FEWEST_INTERVALS
from planner.families.spline import MOST as MOST_INTERVALS

CONTROLLERS = ("linuxcnc", "virtual", "sinumerik", "twincat", "setpoints")
FAMILIES = ("manual", "fourier", "ptp", "spline")
LONGEST = 600.0  # [s] of an excitation; the method is for production breaks
KNOTS_A_SECOND = 10.0
MOST_PERIODS = 1e6
MOST_SECONDS = 86_400.0  # of a search
USUAL_PERIOD = 2.0  # [s]; of order 5 as informative as 2.4 s, more than 3 s, and of all the best conditioned
MOVES_A_SECOND = 10.0 / 3.0


@dataclass(frozen=True, slots=True)
class Request:
    """What to plan.

    Args:
        case_file: name or file of the case.
        family: manual, fourier, ptp or spline.
        criterion: letter of Table 4.
        model: number in Table 2.
        duration: of the excitation [s].
        order: N of (34), family fourier.
        period: [s], family fourier; the duration is a whole number of it. None for the one nearest to 2 s.
        free_order: family fourier: `order` is open, the best is searched for.
        free_period: family fourier: `period` is open, likewise; the duration is a whole number of what is found.
        centred: family fourier: x0 is the middle of the box.
        moves: family ptp; None for ten in three seconds, or where accelerations step as many as reach their velocity.
        knots: family spline, intervals between knots; None for ten a second.
        sequence: family manual: file of steps or poses; None for the one beside the case.
        payload: number of the case's payloads that are mounted, at most.
        payload_from: at least; None for just as many. Predicted standard deviations are the largest of the range.
        controller: family ptp: whose time law the moves are planned with; None for the one that the case plans for.
        targets: standard deviations to be met, such as m=0.05kg; the duration is then the longest allowed.
        starts: number of random starts; None for as many as pay.
        seconds: time for the search; None until more starts stop paying.
        seed: of the starts.
    """

    case_file: str
    family: str = "ptp"
    criterion: str = "D"
    model: int = 9
    duration: float = 12.0
    order: int = 5
    period: float | None = None
    free_order: bool = False
    free_period: bool = False
    centred: bool = False
    moves: int | None = None
    knots: int | None = None
    sequence: Path | None = None
    payload: int = 0
    payload_from: int | None = None
    controller: str | None = None
    targets: tuple[str, ...] = ()
    starts: int | None = None
    seconds: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        _one_of("family", self.family, FAMILIES)
        _one_of("criterion", self.criterion, CRITERIA)
        if self.controller is not None:
            _one_of("controller", self.controller, CONTROLLERS)
            if self.family != "ptp":
                raise HexciteError(
                    f"--for {self.controller}: a {self.family} motion is written with the times of its own, not by the "
                    "time law of a controller; leave out --for, or choose --family ptp"
                )
        if np.isnan(self.duration) or self.duration == -np.inf:
            raise HexciteError(f"duration {self.duration:g} s is no duration; choose about 12 s")
        if not self.duration <= LONGEST:
            raise HexciteError(f"duration {self.duration:g} s is longer than {LONGEST:g} s; choose about 12 s")
        if self.family == "fourier":
            self._fourier()
        elif self.family == "ptp":
            self._ptp()
        elif self.family == "spline":
            self._spline()
        if self.starts is not None and not 1 <= self.starts <= 1000:
            raise HexciteError(f"{self.starts} starts; choose 1 to 1000")
        if self.seconds is not None and not 0.0 < self.seconds <= MOST_SECONDS:
            raise HexciteError(f"seconds {self.seconds:g} is outside 0 to {MOST_SECONDS:g}; choose about 30")
        if self.seed < 0:
            raise HexciteError(f"seed {self.seed} is negative; choose 0 or more")
        if self.payload_from is not None and not 0 <= self.payload_from <= self.payload:
            raise HexciteError(
                f"payloads {self.payload_from}-{self.payload} are no range; give the fewest first, as 0-{self.payload}"
            )

        if self.targets and self.family == "manual":
            raise HexciteError("targets need a family that is optimised; choose fourier, ptp or spline")

    @property
    def payloads(self) -> range:
        """Numbers of payloads that may be mounted."""
        return range(self.payload if self.payload_from is None else self.payload_from, self.payload + 1)

    @property
    def mounted(self) -> str:
        """What is mounted, in words."""
        first = "" if len(self.payloads) == 1 else f"{self.payloads[0]} to "
        return f"{first}{self.payload} payload{'' if self.payload == 1 else 's'}"

    def allowed_duration(self, duration: float) -> float:
        """The next longer duration that the family can have [s]."""
        if self.family == "fourier" and not self.free_period and self.period is not None:
            return max(self._fewest_periods, int(np.ceil(duration / self.period - 1e-9))) * self.period
        return max(duration, FEWEST_INTERVALS / KNOTS_A_SECOND)

    def knots_for(self, duration: float) -> str:
        """The option that a spline of this duration needs, or nothing."""
        if self.family != "spline" or self.knots is not None or duration * KNOTS_A_SECOND <= MOST_INTERVALS:
            return ""
        return f" --knots {MOST_INTERVALS}"

    def lasting(self, duration: float) -> "Request":
        """The same for another duration, with as many moves and knots a second."""
        share = duration / self.duration
        moves, knots = self.moves, self.knots
        if moves is not None:
            moves = int(np.clip(round(moves * share), FEWEST, MOST))
        if knots is not None:
            knots = int(np.clip(round(knots * share), FEWEST_INTERVALS, MOST_INTERVALS))
        return replace(self, duration=duration, moves=moves, knots=knots)

    def _fourier(self) -> None:
        if not 1 <= self.order <= 7:
            raise HexciteError(f"order {self.order} is outside 1 to 7; above 7 only jerk grows: choose 3 to 7")
        if self.free_period or self.period is None:
            if not self.duration > 0.0:
                raise HexciteError(f"duration {self.duration:g} s is not positive; choose about 12 s")
            return
        if not self.period > 0.0 or not np.isfinite(self.period):
            raise HexciteError(f"period {self.period:g} s is not positive; choose about {USUAL_PERIOD:g} s")
        repeats = self.duration / self.period
        if not abs(repeats) < MOST_PERIODS:
            raise HexciteError(
                f"period {self.period:g} s is too short for {self.duration:g} s; choose about {USUAL_PERIOD:g} s"
            )
        if not (round(repeats) >= 1 and abs(repeats - round(repeats)) < 1e-9):
            raise HexciteError(
                f"duration {self.duration:g} s is not a whole number of periods of {self.period:g} s; choose "
                f"{max(1, round(repeats)) * self.period:g} s"
            )
        if round(repeats) < self._fewest_periods:
            raise HexciteError(
                f"order 1 needs two periods: it is led in and out of over one of them; choose --duration "
                f"{2 * self.period:g} or more"
            )

    @property
    def periods(self) -> int:
        """Number of periods of a Fourier motion."""
        return max(self._fewest_periods, round(self.duration / (self.period or USUAL_PERIOD)))

    @property
    def base_period(self) -> float:
        """Period of a Fourier motion [s]; where it is not stated, one that the duration is a whole number of."""
        return self.duration / self.periods if self.period is None else self.period

    @property
    def _fewest_periods(self) -> int:
        return 2 if self.order == 1 else 1

    def _ptp(self) -> None:
        if not self.duration > 0.0:
            raise HexciteError(f"duration {self.duration:g} s is not positive; choose about 12 s")
        if not FEWEST <= self.move_count <= MOST:
            raise HexciteError(f"{self.move_count} moves are outside {FEWEST} to {MOST}; choose about 40")

    @property
    def move_count(self) -> int:
        """Number of moves of a point-to-point motion; where it is not stated, of any duration one that can be had."""
        if self.moves is not None:
            return self.moves
        return int(np.clip(round(MOVES_A_SECOND * self.duration), FEWEST, MOST))

    @property
    def intervals(self) -> int:
        """Intervals of a spline."""
        return self.knots if self.knots is not None else round(KNOTS_A_SECOND * self.duration)

    def _spline(self) -> None:
        if not self.duration >= FEWEST_INTERVALS / KNOTS_A_SECOND:
            raise HexciteError(
                f"duration {self.duration:g} s is too short for a spline; choose at least "
                f"{FEWEST_INTERVALS / KNOTS_A_SECOND:g} s"
            )
        if not FEWEST_INTERVALS <= self.intervals <= MOST_INTERVALS:
            remedy = "choose --knots about 120"
            if self.knots is None:
                remedy += f", or --duration {MOST_INTERVALS / KNOTS_A_SECOND:g} or less for {KNOTS_A_SECOND:g} a second"
            raise HexciteError(f"{self.intervals} knots are outside {FEWEST_INTERVALS} to {MOST_INTERVALS}; {remedy}")


def _one_of(what: str, value: str, allowed: object) -> None:
    names = list(allowed)  # type: ignore[call-overload]
    if value not in names:
        raise HexciteError(f"{what} {value!r} is unknown; choose {', '.join(names)}")


def read_payloads(text: str) -> tuple[int, int | None]:
    """The most payloads that may be mounted, and the fewest where `text` is a range such as 0-5.

    Raises:
        HexciteError: neither.
    """
    found = re.fullmatch(r"(?:(\d{1,4})-)?(\d{1,4})", text.strip())
    if found is None:
        raise HexciteError(f"payload {text!r} is neither a number of payloads nor a range of them; give 2, or 0-5")
    return int(found[2]), None if found[1] is None else int(found[1])
