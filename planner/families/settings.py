"""Families of motions as a user asks for them: values with their own defaults, limits and messages."""

from collections.abc import Mapping
from dataclasses import Field, dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cases import checks_arguments
from cases.controller import ControllerName
from cases.errors import HexciteError
from cases.schema import Case
from identification.criteria import Criterion, box_middle
from identification.motion import Trajectory
from planner.families import Family, ptp, spline
from planner.families.fourier import FourierFamily
from planner.families.manual import load_poses, load_sequence, manual_motion, sequence_file

MOST_PERIODS = 1e6
USUAL_PERIOD = 2.0  # [s]; of order 5 as informative as 2.4 s, more than 3 s, and of all the best conditioned
KNOTS_A_SECOND = 10.0
SHORTEST = spline.FEWEST / KNOTS_A_SECOND  # [s] of a spline, and of any motion whose duration is searched
ORDERS = range(2, 8)  # where the order is free
LOWEST, HIGHEST = 1 / 3, 2.0  # of the highest harmonic, in units of the frequency at which both limits meet
HALF = 0.5  # of the limit of acceleration
ROUNDING = 1e-9  # of a duration
TIMED = "point-to-point moves in whole controller cycles"  # splines begin from such moves too


class FamilySettings:
    """What requests and searches need of a family; the values here are those of most families."""

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    name: ClassVar[str]
    """Name in files and on the command line."""
    optimised: ClassVar[bool] = True
    """Whether there is anything to search."""
    of_moves: ClassVar[bool] = False
    """Whether motions are moves that a controller times by its own law."""

    @property
    def rival(self) -> "FamilySettings":
        """Another family, of which one start is made for comparison."""
        return Fourier()

    def check(self, duration: float) -> None:
        """Raises HexciteError where a motion cannot last so long [s]."""
        if not duration > 0.0:
            raise HexciteError(f"duration {duration:g} s is not positive; choose about 12 s")

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError where no search can succeed on this machine."""

    def made_for(self, case: Case) -> str | None:
        """The controller whose time law the motion is planned with; None where all limits of the case count."""
        return None

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """The sets of motions to search: several where a setting is free, none where nothing is optimised."""
        return ()

    def motion(self, case: Case) -> tuple[Trajectory, Path] | None:
        """The motion and the file that it is from, where nothing is optimised."""
        return None

    def refinements(self, criterion: Criterion) -> int:
        """Number of explored starts that are refined; 0 where every start is refined at once."""
        return 2

    def idle(self, criterion: Criterion) -> int:
        """Number of starts in a row without a gain after which more are not worth their time.

        For criterion D one start without a gain is enough: on twelve machines, waiting for another gained 3 % at most,
        and took half of the time again.
        """
        return 1 if criterion == Criterion.D else 2


@checks_arguments
@dataclass(frozen=True, slots=True)
class Fourier(FamilySettings):
    """Periodic Fourier series (34)-(36) from rest to rest.

    Args:
        order: N of (34), 1 to 7.
        period: [s]; the duration is a whole number of periods. None for the one nearest to 2 s.
        centred: whether x0 is the middle of the motion box.
        free_order: whether the best order from 2 to 7 is searched instead.
        free_period: whether the best period is searched instead.
    """

    order: int = 5
    period: float | None = None
    centred: bool = False
    free_order: bool = False
    free_period: bool = False

    name: ClassVar[str] = "fourier"

    def __post_init__(self) -> None:
        if not 1 <= self.order <= 7:
            raise HexciteError(f"order {self.order} is outside 1 to 7; above 7 only jerk grows: choose 3 to 7")
        if self.period is not None and not (self.period > 0.0 and np.isfinite(self.period)):
            raise HexciteError(f"period {self.period:g} s is not positive; choose about {USUAL_PERIOD:g} s")

    @property
    def rival(self) -> "FamilySettings":
        """Point-to-point moves."""
        return PointToPoint()

    @property
    def _fewest(self) -> int:
        return 2 if self.order == 1 else 1

    def periods(self, duration: float) -> int:
        """Number of periods of a motion."""
        return max(self._fewest, round(duration / (self.period or USUAL_PERIOD)))

    def base_period(self, duration: float) -> float:
        """Period [s]; where it is not stated, one that the duration is a whole number of."""
        return duration / self.periods(duration) if self.period is None else self.period

    def check(self, duration: float) -> None:
        """Raises HexciteError unless the duration is positive, and a whole number of a stated period."""
        if self.free_period or self.period is None:
            super(Fourier, self).check(duration)  # of a dataclass with slots
            return
        repeats = duration / self.period
        if not abs(repeats) < MOST_PERIODS:
            raise HexciteError(
                f"period {self.period:g} s is too short for {duration:g} s; choose about {USUAL_PERIOD:g} s"
            )
        if not (round(repeats) >= 1 and abs(repeats - round(repeats)) < 1e-9):
            raise HexciteError(
                f"duration {duration:g} s is not a whole number of periods of {self.period:g} s; choose "
                f"{max(1, round(repeats)) * self.period:g} s"
            )
        if round(repeats) < self._fewest:
            raise HexciteError(
                f"order 1 needs two periods: it is led in and out of over one of them; choose --duration "
                f"{2 * self.period:g} or more"
            )

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError unless the filter of the evaluation passes the highest harmonic."""
        cutoff = case.recording.filter_cutoff_Hz
        for choice in self._choices(case, duration):
            period = choice.base_period(duration)
            highest = choice.order / period
            if cutoff is None or highest <= cutoff / 2:
                continue
            shortest = choice.order / (cutoff / 2)
            most = int(duration / shortest * (1.0 + ROUNDING))  # periods
            remedy = f"--period {duration / most if most else shortest:g}"
            if choice.period is None and not most:
                remedy = f"--duration {shortest:g}"
            raise HexciteError(
                f"period {period:g} s is too short: order {choice.order} reaches {highest:g} Hz, the evaluation passes "
                f"up to {cutoff / 2:g} Hz (half of recording.filter_cutoff_Hz); choose {remedy} or more"
            )

    def families(self, case: Case, duration: float) -> tuple[FourierFamily, ...]:
        """Families of each order and period worth a look."""
        middle, half = box_middle(case)
        return tuple(
            FourierFamily.lasting(c.order, c.base_period(duration), c.periods(duration), middle, half, c.centred)
            for c in self._choices(case, duration)
        )

    def _choices(self, case: Case, duration: float) -> "tuple[Fourier, ...]":
        """Settings with every order and period worth a look; these settings where neither is free.

        A motion from rest to rest lasts a whole number of periods, so the base frequency takes discrete values: what
        an optimiser would treat as a variable is searched through value by value. Worth a look are those whose highest
        harmonic lies near the frequency at which a harmonic reaches its limits of velocity and of acceleration at once,
        A / (2 pi V): far below it accelerations go to waste, far above it velocities.
        """
        if not (self.free_order or self.free_period):
            return (self,)
        box = case.need_motion("planning")[1]
        meets = float(np.max(box.acceleration / box.rate)) / (2 * np.pi)
        cutoff = case.recording.filter_cutoff_Hz
        limit = np.inf if cutoff is None else cutoff / 2
        choices = []
        for order in ORDERS if self.free_order else (self.order,):
            fewest = 2 if order == 1 else 1
            most = max(fewest, int(HIGHEST * meets * duration / order))
            for periods in range(fewest, most + 1) if self.free_period else (self.periods(duration),):
                period = duration / periods
                inside = LOWEST * meets <= order / period <= HIGHEST * meets or not self.free_period
                if inside and order / period <= limit:
                    choices.append(Fourier(order, period, self.centred))
        if not choices:
            shortest = min(ORDERS if self.free_order else (self.order,)) * LOWEST / meets
            raise HexciteError(
                f"no period fits: {duration:g} s is too short or the filter of the evaluation too low; choose "
                f"--duration {max(2.0, np.ceil(shortest)):g} or more, or fix --period"
            )
        return tuple(choices)

    def refinements(self, criterion: Criterion) -> int:
        """One for criterion D: of nine machines, the second best was better in the end on one, by 0.5 %.

        Two where a setting is free, and four for the other criteria, which have more local optima.
        """
        if criterion != Criterion.D:
            return 4
        return 2 if self.free_order or self.free_period else 1


@checks_arguments
@dataclass(frozen=True, slots=True)
class PointToPoint(FamilySettings):
    """Straight moves in the coordinates, each from rest to rest.

    Args:
        moves: 8 to 64; None for as many as reach their velocity, where jerk is limited ten in three seconds at most.
        controller: controller whose time law the moves are planned with: linuxcnc, virtual, sinumerik, twincat,
            setpoints, urscript, ros2; None for the one that the case plans for, else limited jerk.
    """

    moves: int | None = None
    controller: str | None = None

    name: ClassVar[str] = "ptp"
    of_moves: ClassVar[bool] = True

    def __post_init__(self) -> None:
        if self.moves is not None and not ptp.FEWEST <= self.moves <= ptp.MOST:
            raise HexciteError(f"{self.moves} moves are outside {ptp.FEWEST} to {ptp.MOST}; choose about 40")
        if self.controller not in (None, *ControllerName):
            raise HexciteError(f"controller {self.controller!r} is unknown; choose {', '.join(ControllerName)}")

    def made_for(self, case: Case) -> str | None:
        """The controller that is named here, else the one that the case plans for."""
        return case.controller.plan_for if self.controller is None and case.controller is not None else self.controller

    def count(self, case: Case, duration: float) -> int:
        """Number of moves; where it is not stated, of any duration one that can be had.

        Args:
            case: case with the limits that count, see `ptp.controlled`.
            duration: duration of all moves [s].
        """
        if self.moves is not None:
            return self.moves
        fitting = ptp.moves_in(case.need_motion("planning")[1], duration)
        return int(np.clip(round(fitting), ptp.FEWEST, ptp.MOST))

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError where a move is too short for four phases of jerk, or two of acceleration, of 3 cycles.

        A move whose coordinates cannot reach half of their limits of acceleration hardly leaves its place: the search
        would take minutes to make few moves of many, and find less than with few.
        """
        cycle = case.need_controller(TIMED).cycle
        own, _ = ptp.controlled(case, self.made_for(case))
        box, count = own.need_motion("planning")[1], self.count(own, duration)
        number = 4 if box.limits_jerk else 2
        phases = number * ptp.SHORTEST_PHASE * cycle
        rise = 4 * HALF * float(np.min(box.acceleration / box.jerk))
        least = max(phases, rise)
        if duration >= count * least * (1.0 - ROUNDING):
            return
        reason = f"{number} phases of {ptp.SHORTEST_PHASE} controller cycles of {cycle * 1e3:g} ms take {least:g} s"
        if rise > phases:
            reason = (
                f"at the limits of jerk it takes {least:g} s to reach half of a limit of acceleration and come to rest"
            )
        fewer = int(duration / least * (1.0 + ROUNDING))
        remedy = f", or --moves {fewer} or fewer" if fewer >= ptp.FEWEST else ""
        raise HexciteError(
            f"duration {duration:g} s is too short for {count} moves: {reason}; choose at least "
            f"{count * least:g} s{remedy}"
        )

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """One."""
        return (ptp.PointToPointFamily.of(case, self.count(case, duration), duration),)

    def refinements(self, criterion: Criterion) -> int:
        """0: annealed walks are refined at once."""
        return 0

    def idle(self, criterion: Criterion) -> int:
        """One for any criterion: for K and N six starts gave nothing better than two, in three times the time."""
        return 1


@checks_arguments
@dataclass(frozen=True, slots=True)
class Spline(FamilySettings):
    """Cubic splines limited in jerk, from rest to rest.

    Args:
        knots: intervals between knots, 20 to 150; None for ten a second, 150 at most.
    """

    knots: int | None = None

    name: ClassVar[str] = "spline"

    def __post_init__(self) -> None:
        if self.knots is not None and not spline.FEWEST <= self.knots <= spline.MOST:
            raise HexciteError(
                f"{self.knots} knots are outside {spline.FEWEST} to {spline.MOST}; choose --knots about 120"
            )

    def intervals(self, duration: float) -> int:
        """Number of intervals between knots."""
        return self.knots if self.knots is not None else min(round(KNOTS_A_SECOND * duration), spline.MOST)

    def check(self, duration: float) -> None:
        """Raises HexciteError where the duration has no room for the fewest knots."""
        if not duration >= SHORTEST:
            raise HexciteError(f"duration {duration:g} s is too short for a spline; choose at least {SHORTEST:g} s")

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises CaseError where the case states no controller cycle: controllers time splines in whole cycles."""
        case.need_controller(TIMED)

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """One."""
        return (spline.SplineFamily.of(case, self.intervals(duration), duration),)

    def idle(self, criterion: Criterion) -> int:
        """Number of starts without a gain: starts of splines differ more than those of other families."""
        return 2


@checks_arguments
@dataclass(frozen=True, slots=True)
class Manual(FamilySettings):
    """The hand-made motion of a file, as fast as the limits allow.

    Args:
        sequence: file of steps (TOML) or of poses (CSV); None for `manual.toml` beside the case.
    """

    sequence: Path | str | None = None

    name: ClassVar[str] = "manual"
    optimised: ClassVar[bool] = False

    def file(self, case: Case) -> Path:
        """The file of steps or poses."""
        return sequence_file(case) if self.sequence is None else Path(self.sequence)

    def check(self, duration: float) -> None:
        """Accepts every duration: the file and the limits determine it."""

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError unless such files suit the machine and the file can be read."""
        limits = case.need_motion("a hand-made sequence")[1]
        file = self.file(case)
        if file.suffix.lower() == ".csv":
            load_poses(file, limits.columns)
        else:
            load_sequence(file, limits.columns)

    def motion(self, case: Case) -> tuple[Trajectory, Path]:
        """The motion of the file."""
        file = self.file(case)
        return manual_motion(case, file), file


FAMILIES: Mapping[str, type[Fourier] | type[PointToPoint] | type[Spline] | type[Manual]] = {
    kind.name: kind for kind in (Manual, Fourier, PointToPoint, Spline)
}


def family_class(name: str) -> type[Fourier] | type[PointToPoint] | type[Spline] | type[Manual]:
    """The family of a name, for the command line and for files; raises HexciteError where it is unknown."""
    if name not in FAMILIES:
        raise HexciteError(f"family {name!r} is unknown; choose {', '.join(FAMILIES)}")
    return FAMILIES[name]
