"""Families of motions as a user asks for them: values with their own defaults, limits and messages."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import Field, dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cases.base.doors import checks_arguments
from cases.base.errors import CaseError, Code, HexciteError, choice, option
from cases.base.options import documented
from cases.base.phrases import enumerated, phrase
from cases.controller import ControllerName
from cases.readiness import languages_of, require_machine
from cases.schema import Case
from identification.estimation.criteria import Criterion, box_middle
from identification.limits.limit import PLANNABLE_WITHOUT
from identification.motion.motion import Trajectory
from planner.controller_limits import controlled, steps_of, times_itself
from planner.families import ptp, spline
from planner.families.family import Family
from planner.families.fourier import FourierFamily, FreePeriod
from planner.families.manual import in_turn, load_poses, load_sequence, manual_motion, sequence_file
from planner.options import FourierOptions, ManualOptions, MoveOptions, SplineOptions

SHORTEST_PERIOD, LONGEST_PERIOD = 0.01, 600.0  # [s]
USUAL_PERIOD = 2.0  # [s]; of order 5 as informative as 2.4 s, more than 3 s, and of all the best conditioned
KNOTS_A_SECOND = 10.0
SHORTEST = spline.FEWEST / KNOTS_A_SECOND  # [s] of a spline, and of any motion whose duration is searched
ORDERS = range(1, 8)
FREE_ORDERS = range(2, 8)  # where the order is free: order 1 needs a run-in and finds less than any
FIRST_PERIODS = 4  # number of periods at which the search for a free one begins; half as many where the order is free
LOWEST, HIGHEST = 1 / 3, 2.0  # of the highest harmonic, in units of the frequency at which both limits meet
HALF = 0.5  # of the limit of acceleration
SHARES = (1.0, 0.6, 0.36)  # of the moves that a duration has room for
ROUNDING = 1e-9  # of a duration
TIMED = "point-to-point moves in whole controller cycles"  # splines begin from such moves too


def _require(value: float | None, name: str, low: float, high: float, usual: str) -> None:
    """Raises HexciteError where a setting is outside its range; None is a default."""
    if value is not None and not low <= value <= high:
        raise HexciteError(
            problem=f"{name} {value:g} is outside {low:g} to {high:g}", remedy=f"choose {usual}", code=Code.OUT_OF_RANGE
        )


def require_plannable_without(family: str | None) -> None:
    """Raises HexciteError unless a plan may leave a family of limits out; None for none."""
    if family is not None and family not in PLANNABLE_WITHOUT:
        raise HexciteError(
            problem=f"{option('without')} {family!r} names no limit that a plan may leave out",
            remedy="choose jerk",
            code=Code.UNKNOWN,
        )


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

    def check(self, duration: float) -> None:
        """Raises HexciteError where a motion cannot last so long [s]."""
        if not duration > 0.0:
            raise HexciteError(
                problem=phrase(
                    "duration_not_positive", "duration {duration} s is not positive", duration=f"{duration:g}"
                ),
                remedy=phrase("choose_12", "choose about 12 s"),
                code=Code.OUT_OF_RANGE,
            )

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError where no search can succeed on this machine."""

    @property
    def step(self) -> float:
        """Between two durations that a search for the shortest may try: a hundredth of a second [s]."""
        return 0.01

    def least(self, case: Case) -> float:
        """Duration below which no search can succeed on this machine [s]."""
        return self.step

    def made_for(self, case: Case) -> str | None:
        """The controller whose time law the motion is planned with; None where all limits of the case count."""
        return None

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """The sets of motions to search: several where a setting is free, none where nothing is optimised."""
        return ()

    def motion(self, case: Case) -> tuple[Trajectory, str] | None:
        """The motion, and the file that it is from or what it is, where nothing is optimised."""
        return None

    def refinements(self, criterion: Criterion) -> int:
        """Number of explored starts that are refined."""
        return 2

    def idle(self, criterion: Criterion) -> int:
        """Number of starts in a row without a gain after which more are not worth their time.

        For criterion D one start without a gain is enough: on twelve machines, waiting for another gained 3 % at most,
        and took half of the time again.
        """
        return 1 if criterion == Criterion.D else 2


@checks_arguments
@documented(FourierOptions)
@dataclass(frozen=True, slots=True)
class Fourier(FourierOptions, FamilySettings):
    """Periodic Fourier series (34)-(36) from rest to rest.

    >>> hx.Fourier(order=3, period=4.0)
    Fourier(order=3, period=4.0, free_order=False, free_period=False, centred=False, equal_start=False)

    Args:
        OPTIONS
    """

    def __post_init__(self) -> None:
        _require(self.order, "order", ORDERS[0], ORDERS[-1], "3 to 7")
        _require(self.period, "period", SHORTEST_PERIOD, LONGEST_PERIOD, f"about {USUAL_PERIOD:g} s")

    @property
    def fewest(self) -> int:
        """Fewest periods of a motion: one of two halves leads into a series of order 1 and out of it."""
        return 2 if self.order == 1 else 1

    def base_period(self, duration: float) -> float:
        """Period [s]; where it is not stated, one that the duration is a whole number of."""
        return self.period or duration / max(self.fewest, round(duration / USUAL_PERIOD))

    def check(self, duration: float) -> None:
        """Raises HexciteError unless the duration is positive, and a whole number of a stated period."""
        if self.free_period or self.period is None:
            super(Fourier, self).check(duration)  # of a dataclass with slots
            return
        repeats = duration / self.period
        if not (repeats >= 1.0 - ROUNDING and abs(repeats - round(repeats)) < ROUNDING):
            raise HexciteError(
                problem=phrase(
                    "broken_periods",
                    "duration {duration} s is not a whole number of periods of {period} s",
                    duration=f"{duration:g}",
                    period=f"{self.period:g}",
                ),
                remedy=phrase(
                    "choose_duration",
                    "choose {duration} s",
                    duration=f"{max(self.fewest, round(repeats)) * self.period:g}",
                ),
                code=Code.OUT_OF_RANGE,
            )
        if round(repeats) < self.fewest:
            raise HexciteError(
                problem=f"duration {duration:g} s is one period of order 1, which needs two: one is spent on "
                "the ways in and out",
                remedy=f"choose {option('duration')} {self.fewest * self.period:g} or more",
                code=Code.OUT_OF_RANGE,
            )

    @property
    def step(self) -> float:
        """Between two durations: a period where one is stated [s]."""
        return super(Fourier, self).step if self.period is None else self.period

    def least(self, case: Case) -> float:
        """That of the fewest periods of which the filter of the evaluation passes the lowest order [s]."""
        lowest = FREE_ORDERS[0] if self.free_order else self.order
        return max(self.fewest * (self.period or lowest / _highest_frequency(case)), self.step)

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError unless the filter of the evaluation passes the highest harmonic."""
        limit = _highest_frequency(case)
        for family in self.families(case, duration):
            order, period = family.order, family.period
            if order / period > limit * (1.0 + ROUNDING):
                most = int(duration * limit / order * (1 + ROUNDING))  # whole periods that pass
                longer = option("period" if self.period or most >= self.fewest else "duration")
                raise HexciteError(
                    problem=phrase(
                        "short_period",
                        "period {period} s is too short: order {order} reaches {frequency} Hz, the evaluation passes "
                        "up to {limit} Hz (half of recording.filter_cutoff_Hz)",
                        period=f"{period:g}",
                        order=order,
                        frequency=f"{order / period:g}",
                        limit=f"{limit:g}",
                    ),
                    remedy=phrase(
                        "choose_or_more",
                        "choose {option} {least} or more",
                        option=longer,
                        least=f"{duration / most if most >= self.fewest else self.fewest * order / limit:g}",
                    ),
                    code=Code.OUT_OF_RANGE,
                )

    def families(self, case: Case, duration: float) -> tuple[FourierFamily, ...]:
        """Families of each order worth a look, and of each period at which the search for a free one begins."""
        middle, half = box_middle(case)
        chosen = []
        for order in FREE_ORDERS if self.free_order else (self.order,):
            of_order = replace(self, order=order)
            if not self.free_period:
                period = of_order.base_period(duration)
                if self.free_order and order / period > _highest_frequency(case):
                    continue
                periods = round(duration / period)
                family = FourierFamily.lasting(order, period, periods, middle, half, self.centred)
                chosen.append(replace(family, equal_start=self.equal_start))
                continue
            for period, free in of_order._free_periods(case, duration):
                periods = max(of_order.fewest, int(duration / period))
                family = FourierFamily.lasting(order, period, periods, middle, half, self.centred, free)
                chosen.append(replace(family, equal_start=self.equal_start))
        if not chosen:
            raise HexciteError(
                problem=phrase(
                    "no_period_fits",
                    "no period fits: {duration} s is too short or the filter of the evaluation too low",
                    duration=f"{duration:g}",
                ),
                remedy=phrase(
                    "longer_duration",
                    "choose a longer {duration}, or fix {period}",
                    duration=option("duration"),
                    period=option("period"),
                ),
                code=Code.OUT_OF_RANGE,
            )
        return tuple(chosen)

    def _free_periods(self, case: Case, duration: float) -> list[tuple[float, FreePeriod]]:
        """Periods at which a search begins [s], and what the optimiser may make of them; none where none fits.

        Worth a look are those whose highest harmonic lies near the frequency at which a harmonic reaches its limits of
        velocity and of acceleration at once, A / (2 pi V): far below it accelerations go to waste, far above it
        velocities. The series that is best for one of them is seldom best for another, so that the search begins at
        several.
        """
        box = case.need_motion("planning")[1]
        meets = float(np.max(box.acceleration / box.rate)) / (2 * np.pi)
        shortest = self.order / min(HIGHEST * meets, _highest_frequency(case))
        longest = min(self.order / (LOWEST * meets), duration / self.fewest)
        if not shortest <= longest:
            return []
        count = FIRST_PERIODS // 2 if self.free_order else FIRST_PERIODS
        shares = (np.arange(count) + 0.5) / count
        free = FreePeriod(shortest, longest, duration)
        return [(float(shortest * (longest / shortest) ** share), free) for share in shares]

    def refinements(self, criterion: Criterion) -> int:
        """One for criterion D: of nine machines, the second best was better in the end on one, by 0.5 %.

        Two where a setting is free, and four for the other criteria, which have more local optima.
        """
        if criterion != Criterion.D:
            return 4
        return 2 if self.free_order or self.free_period else 1


def _highest_frequency(case: Case) -> float:
    """Highest frequency that the filter of the evaluation passes whole [Hz]; infinity without one."""
    return np.inf if case.recording.filter_cutoff_Hz is None else case.recording.filter_cutoff_Hz / 2


@checks_arguments
@documented(MoveOptions)
@dataclass(frozen=True, slots=True)
class PointToPoint(MoveOptions, FamilySettings):
    """Straight moves in the coordinates, each from rest to rest.

    >>> hx.PointToPoint(moves=40, without="jerk")
    PointToPoint(moves=40, controller=None, without='jerk')

    Args:
        OPTIONS
    """

    of_moves: ClassVar[bool] = True

    def __post_init__(self) -> None:
        _require(self.moves, "moves", ptp.FEWEST, ptp.MOST, "about 40")
        if self.controller not in (None, *ControllerName):
            raise HexciteError(
                problem=f"controller {self.controller!r} is unknown",
                remedy=choice(str(self.controller), ControllerName),
                code=Code.UNKNOWN,
            )
        require_plannable_without(self.without)

    def made_for(self, case: Case) -> str | None:
        """The controller that is named here, else the one that the case plans for."""
        return case.controller.plan_for if self.controller is None and case.controller is not None else self.controller

    def counts(self, case: Case, duration: float) -> tuple[int, ...]:
        """Numbers of moves that are worth a look: the stated one, else as many as there is room for, and fewer.

        How many moves are best depends on which limits bind along the way, which only a search shows.

        Args:
            case: case with the limits that count, see `ptp.controlled`.
            duration: duration of all moves [s].
        """
        if self.moves is not None:
            return (self.moves,)
        fitting = ptp.moves_in(case.need_motion("planning")[1], duration)
        return tuple(dict.fromkeys(int(np.clip(round(fitting * share), ptp.FEWEST, ptp.MOST)) for share in SHARES))

    def count(self, case: Case, duration: float) -> int:
        """The first of `counts`."""
        return self.counts(case, duration)[0]

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError where a move is too short for four phases of jerk, or two of acceleration.

        A move whose coordinates cannot reach half of their limits of acceleration hardly leaves its place: the search
        would take minutes to make few moves of many, and find less than with few.
        """
        case.need_controller(TIMED)
        self._require_choice(case)
        count, least = self.count(controlled(case, self.made_for(case))[0], duration), self._least_move(case)
        if duration < count * least * (1.0 - ROUNDING):
            raise HexciteError(
                problem=phrase(
                    "short_for_moves",
                    "duration {duration} s is too short for {count} moves: by controller.cycle_ms and limits of jerk "
                    "each takes {least} s",
                    duration=f"{duration:g}",
                    count=count,
                    least=f"{least:g}",
                ),
                remedy=enumerated(
                    "comma_or",
                    [
                        phrase("choose_at_least", "choose at least {least} s", least=f"{count * least:g}"),
                        *(
                            [
                                phrase(
                                    "fewer_moves",
                                    "fewer {option} ({fewest} or more)",
                                    option=option("moves"),
                                    fewest=ptp.FEWEST,
                                )
                            ]
                            if count > ptp.FEWEST
                            else []
                        ),
                    ],
                ),
                code=Code.OUT_OF_RANGE,
            )

    def least(self, case: Case) -> float:
        """That of the stated number of moves, else of the fewest [s]."""
        return (self.moves or ptp.FEWEST) * self._least_move(case)

    def _least_move(self, case: Case) -> float:
        """Shortest duration of a move, by the controller's cycle and by half of an acceleration under its jerk [s]."""
        box = controlled(case, self.made_for(case))[0].need_motion("planning")[1]
        phases = (4 if box.limits_jerk else 2) * ptp.shortest_phase(case.need_controller(TIMED).cycle)
        return max(phases, 4 * HALF * float(np.min(box.acceleration / box.jerk)))

    def _require_choice(self, case: Case) -> None:
        """Raises HexciteError where the controller cannot keep a limit that is not left out, or keeps one that is."""
        controller = self.made_for(case)
        if controller is not None:
            another = f"choose another controller: {option('controller', 'for')}, or controller.plan_for of the case"
            require_machine(case, controller, another)
        steps = steps_of(case, controller) > 0.0
        if steps and self.without is None:
            named = "" if self.controller else f' (controller.plan_for = "{controller}")'
            raise HexciteError(
                problem=phrase(
                    "jerk_not_limited",
                    "limits.motion of case {case} states jerk, which {controller}{named} does not limit: no "
                    "program can keep it there",
                    case=case.name,
                    controller=controller,
                    named=named,
                ),
                remedy=phrase(
                    "without_jerk",
                    "plan with {without} jerk if the machine bears steps of acceleration, or with {to} virtual, "
                    "whose motion keeps it on controllers that limit jerk",
                    without=option("without"),
                    to=option("controller", "for"),
                ),
                code=Code.NOT_SUPPORTED,
            )
        if self.without is not None and not steps:
            if controller:
                raise HexciteError(
                    problem=f"{option('without')} {self.without}: {controller} limits the jerk, and keeps it",
                    remedy="leave it out",
                    code=Code.CONTRADICTION,
                )
            named = (
                " or ".join(name for name in languages_of(case) if _steps(case, name)) or "one that this machine has"
            )
            raise HexciteError(
                problem=f"{option('without')} {self.without} leaves it out for a controller that does not "
                "limit it, and none is named",
                remedy=f"name it ({option('controller', 'for')} {named}), or leave {option('without')} out",
                code=Code.CONTRADICTION,
            )

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """One of each number of moves."""
        own_law = times_itself(case, self.made_for(case))
        return tuple(ptp.PointToPointFamily.of(case, count, duration, own_law) for count in self.counts(case, duration))

    def idle(self, criterion: Criterion) -> int:
        """One for any criterion: for K and N six starts gave nothing better than two, in three times the time."""
        return 1


def _steps(case: Case, controller: str) -> bool:
    """Whether a controller that a case is set up for makes accelerations step."""
    with suppress(CaseError):
        return steps_of(case, controller) > 0.0
    return False


@checks_arguments
@documented(SplineOptions)
@dataclass(frozen=True, slots=True)
class Spline(SplineOptions, FamilySettings):
    """Cubic splines limited in jerk, from rest to rest.

    >>> hx.Spline().intervals(12.0)
    120

    Args:
        OPTIONS
    """

    def __post_init__(self) -> None:
        _require(self.knots, "knots", spline.FEWEST, spline.MOST, "about 120")

    def intervals(self, duration: float) -> int:
        """Number of intervals between knots."""
        return self.knots if self.knots is not None else min(round(KNOTS_A_SECOND * duration), spline.MOST)

    def check(self, duration: float) -> None:
        """Raises HexciteError where the duration has no room for the fewest knots."""
        if not duration >= SHORTEST:
            raise HexciteError(
                problem=phrase(
                    "short_for_spline", "duration {duration} s is too short for a spline", duration=f"{duration:g}"
                ),
                remedy=phrase("choose_at_least", "choose at least {least} s", least=f"{SHORTEST:g}"),
                code=Code.OUT_OF_RANGE,
            )

    def least(self, case: Case) -> float:
        """That of the fewest knots [s]."""
        return SHORTEST

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises CaseError where the case states no controller cycle: controllers time splines in whole cycles."""
        case.need_controller(TIMED)

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """One."""
        return (spline.SplineFamily.of(case, self.intervals(duration), duration),)

    def idle(self, criterion: Criterion) -> int:
        """Number of starts without a gain: starts of splines differ more than those of other families."""
        return 2


IN_TURN = "each coordinate to both ends of its way, then all at once"
"""What a hand-made motion is where nobody wrote one."""


@checks_arguments
@documented(ManualOptions)
@dataclass(frozen=True, slots=True)
class Manual(ManualOptions, FamilySettings):
    """The manual motion of a file, as fast as the limits allow.

    >>> hx.Manual("steps.toml").file(hx.load_case("hexapod")).name
    'steps.toml'

    Args:
        OPTIONS
    """

    optimised: ClassVar[bool] = False

    def file(self, case: Case) -> Path | None:
        """The file of steps or poses; None where each coordinate moves in turn."""
        return sequence_file(case) if self.sequence is None else Path(self.sequence)

    def check(self, duration: float) -> None:
        """Accepts every duration: the file and the limits determine it."""

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError unless such files suit the machine and the file can be read."""
        limits = case.need_motion("a manual motion")[1]
        file = self.file(case)
        if file is None:
            return
        if file.suffix.lower() == ".csv":
            load_poses(file, limits.columns)
        else:
            load_sequence(file, limits.columns)

    def motion(self, case: Case) -> tuple[Trajectory, str]:
        """The motion, and the file that it is of, or what it is."""
        file = self.file(case)
        return (in_turn(case), IN_TURN) if file is None else (manual_motion(case, file), str(file))


@dataclass(frozen=True, slots=True)
class Best(FamilySettings):
    """The best of all families that are searched for, each by its defaults: each has starts, the leading ones more.

    Splines and series need a controller that follows a path; where the case plans for a controller with a time law of
    its own, only moves are searched.
    """

    name: ClassVar[str] = "best"

    def candidates(self, case: Case, duration: float) -> tuple[FamilySettings, ...]:
        """Families that are searched; raises HexciteError where none can be planned."""
        every = self._every(case)
        plannable, refused = list[FamilySettings](), list[HexciteError]()
        for family in every:
            try:
                family.check(duration)
                family.require_plannable(case, duration)
                plannable.append(family)
            except HexciteError as error:
                refused.append(error)
        if not plannable:
            raise refused[0]
        return tuple(plannable)

    def _every(self, case: Case) -> tuple[FamilySettings, ...]:
        moves = PointToPoint()
        return (moves,) if moves.made_for(case) is not None else (Spline(), moves, Fourier())

    def least(self, case: Case) -> float:
        """The least of all families [s]."""
        return min(family.least(case) for family in self._every(case))

    def require_plannable(self, case: Case, duration: float) -> None:
        """Raises HexciteError where no family can be planned."""
        self.candidates(case, duration)

    def made_for(self, case: Case) -> str | None:
        """The controller that the case plans for."""
        return PointToPoint().made_for(case)

    def families(self, case: Case, duration: float) -> tuple[Family, ...]:
        """All of all families, splines first: where time is short they mostly are the best that there is."""
        return tuple(sets for family in self.candidates(case, duration) for sets in family.families(case, duration))

    def chosen(self, case: Case, duration: float, name: str) -> FamilySettings:
        """The family of a name."""
        return next(family for family in self.candidates(case, duration) if family.name == name)


FamilyKind = type[Fourier] | type[PointToPoint] | type[Spline] | type[Manual]
FAMILIES: Mapping[str, FamilyKind] = {kind.name: kind for kind in (Manual, Fourier, PointToPoint, Spline)}


def family_class(name: str) -> FamilyKind:
    """The family of a name, for the command line and for files; raises HexciteError where it is unknown."""
    if name not in FAMILIES:
        raise HexciteError(problem=f"family {name!r} is unknown", remedy=choice(name, FAMILIES), code=Code.UNKNOWN)
    return FAMILIES[name]
