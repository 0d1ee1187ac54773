"""The limits of one stretch of a program: what its text proves, what the controller keeps, and what nobody does."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cases.errors import ProgramError
from cases.machine import Machine, MotionLimits
from cases.schema import Case
from cases.units import MM
from identification.circle import CircularMove
from identification.limits import PROOF_RATE, LimitCheck, LimitReport, Status, prove, prove_at, worst_of
from identification.motion import Array, Standstill, Trajectory
from identification.polynomial import PolynomialMotion
from identification.profile import StraightMove
from identification.tabulated import Tabulated
from postprocessors.guarantees import Guarantees, family
from postprocessors.joints import joint_checks
from postprocessors.predicted import predicted
from postprocessors.sampling import telling_instants
from postprocessors.stretches import Still, Stretch, Timed, Untimed

FEWEST, MOST = 64, 1000  # samples of a move that the controller times: smooth, whatever its duration
OWN = ", untimed moves"  # names apart what a controller does by itself, lest it hide what is proven
BY_TIME_LAW = ("acceleration", "jerk", "strut acceleration")


def judge(part: Stretch, case: Case, guarantees: Guarantees, file: str, clock: float) -> tuple[LimitReport, float]:
    """Limits and duration [s] of a stretch that starts at `clock`.

    Timed paths and moves with the trigger on are excitations, which keep the box of `[limits.motion]`; moves without it
    take the machine to a place and keep `[workspace]`, and so do the rows of a table, in which every move is timed.

    Raises:
        ProgramError: a timed block that the controller cannot time as written.
    """
    if isinstance(part, Timed):
        _require_timing(part, guarantees, file)
        in_box = part.trigger or not isinstance(part.points, Tabulated)
        instants = telling_instants(part.points, part.points.times, case)
        report = prove_at(part.points, case, instants, clock, in_box)
        if isinstance(part.points, PolynomialMotion):
            limits = case.need_machine("the check of a program")[2].motion
            steps = tuple(joint_checks(part.points, limits, guarantees.shortest_block, clock))
            report = worst_of([report, LimitReport(steps)])
        return LimitReport(tuple(_timed(c, guarantees) for c in report.checks)), part.points.duration
    if isinstance(part, Still):
        return LimitReport(()), part.duration
    motion = predicted(part, case.need_machine("the check of a program")[2].motion, guarantees)
    if motion is None:
        return LimitReport(tuple(_at_its_end(part, case, guarantees, clock))), 0.0
    return LimitReport(tuple(_own_time(part, motion, case, guarantees, clock))), motion.duration


def _require_timing(part: Timed, guarantees: Guarantees, file: str) -> None:
    """A block shorter than the controller's cycle does not keep its time; of one that is too long nothing is known."""
    steps = np.diff(part.points.times)
    short = steps < guarantees.shortest_block * (1 - 1e-6)
    if short.any():
        k = int(np.argmax(short))
        raise ProgramError(
            file,
            part.lines[k],
            0,
            f"the block takes {1e3 * steps[k]:.4g} ms, less than a cycle of {guarantees.controller} "
            f"({1e3 * guarantees.shortest_block:g} ms); write longer blocks",
        )
    long = steps > guarantees.longest_block * (1 + 1e-6)
    if long.any():
        k = int(np.argmax(long))
        raise ProgramError(
            file,
            part.lines[k],
            0,
            f"the timed block takes {steps[k]:.4g} s; how {guarantees.controller} moves within more than "
            f"{guarantees.longest_block:g} s is not known: write shorter blocks, or a move at a feed (G94, G61)",
        )


def _timed(check: LimitCheck, guarantees: Guarantees) -> LimitCheck:
    """What a timed path reaches between its points is proven only of a controller that follows the assumed curve."""
    if guarantees.follows_paths or family(check.name) not in BY_TIME_LAW:
        return check
    return replace(check, status=_answer(check, guarantees))


def _answer(check: LimitCheck, guarantees: Guarantees) -> Status:
    return Status.ENFORCED if family(check.name) in guarantees.enforced else Status.NOT_ENFORCED


def _renamed(check: LimitCheck, addition: str) -> str:
    kind, _, where = check.name.partition(" (")
    return f"{kind}{addition} ({where}" if where else f"{kind}{addition}"


def _own(check: LimitCheck, status: Status) -> LimitCheck:
    """A limit in a move that the controller times: a prediction, for which the text is not answerable."""
    return replace(check, name=_renamed(check, OWN), status=status, binding=False)


def _own_time(
    part: Untimed, motion: StraightMove | CircularMove, case: Case, guarantees: Guarantees, clock: float
) -> Iterable[LimitCheck]:
    """Geometry and programmed speed are proven; what follows from the controller's law is predicted."""
    limits = case.need_machine("the check of a program")[2].motion
    count = int(np.clip(np.ceil(motion.duration * PROOF_RATE), FEWEST, MOST))
    report = prove_at(motion, case, np.linspace(0.0, motion.duration, count + 1), clock, part.trigger)
    asked = {c.name.split(" (")[0]: c for c in _asked(part, motion, case, clock)}
    for check in report.checks:
        kind = check.name.split(" (")[0]
        match family(kind):
            case "velocity":
                yield asked.get(kind, replace(check, status=_answer(check, guarantees)))
            case "strut velocity":
                fastest = asked.get(kind)
                if fastest is not None and fastest.kept:
                    yield fastest  # even at the full feed everywhere on the way
                else:
                    yield _own(check, _answer(check, guarantees))
            case "acceleration" | "strut acceleration":
                yield _own(check, _answer(check, guarantees))
            case "sensor force":  # follows from accelerations
                kept = "acceleration" in guarantees.enforced
                yield _own(check, Status.ENFORCED if kept else Status.NOT_ENFORCED)
            case "jerk":
                yield _jerk(check, motion, limits, guarantees)
            case _:
                yield check


def _jerk(check: LimitCheck, motion: Trajectory, limits: MotionLimits, guarantees: Guarantees) -> LimitCheck:
    """Where a law has no jerk limit its acceleration steps within a cycle, by twice its peak where it reverses."""
    if guarantees.jerk_time <= 0.0:
        return _own(check, _answer(check, guarantees))
    axes = slice(3, 6) if check.name.startswith("angular") else slice(0, 3)
    peak = np.abs(motion.at(np.linspace(0.0, motion.duration, FEWEST + 1)).accelerations).max(axis=0)
    steps = 2.0 * peak[axes] / guarantees.jerk_time
    k = int(np.argmax(steps / limits.jerk[axes]))
    ratio = float(steps[k] / limits.jerk[axes][k])
    stepped = replace(check, worst=float(steps[k]), limit=float(limits.jerk[axes][k]), ratio=ratio)
    return _own(stepped, _answer(check, guarantees))


class _Constant(NamedTuple):
    """One speed from end to end, which no law under that feed exceeds anywhere on the way."""

    duration: float

    @property
    def peak_velocity(self) -> float:
        return 1.0 / self.duration

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        time = np.asarray(t, dtype=float)
        none = np.zeros_like(time)
        return time / self.duration, none + self.peak_velocity, none, none

    def slowed(self, speed: float) -> "_Constant":
        return _Constant(self.duration / speed)


def _asked(part: Untimed, motion: StraightMove | CircularMove, case: Case, clock: float) -> Iterable[LimitCheck]:
    """Velocities if the programmed feed held from end to end: the text asks for them, whoever would slow it down."""
    if part.feed is None:
        return
    steady = replace(motion, profile=_Constant(part.length / part.feed))
    for check in prove_at(steady, case, np.linspace(0.0, steady.duration, FEWEST + 1), clock).checks:
        if family(check.name) in ("velocity", "strut velocity"):
            yield check


def _at_its_end(part: Untimed, case: Case, guarantees: Guarantees, clock: float) -> Iterable[LimitCheck]:
    """A move from an unknown pose, or none at all: its end is known, and that A, B, C turn as fast as they must."""
    machine, _, limits = case.need_machine("the check of a program")
    motion = limits.motion
    unknown = part.start is None
    for check in prove(Standstill(part.end, 0.0), case, 1.0, clock, part.trigger).checks:
        match family(check.name):
            case "acceleration" | "strut acceleration" | "jerk" if unknown:
                yield _own(check, _answer(check, guarantees))
            case "velocity" if unknown and check.name.startswith("angular"):
                yield _own(check, _answer(check, guarantees))
            case "strut velocity" if unknown:
                yield _strut_velocity_home(part, check, machine, motion, guarantees)
            case _:
                yield check
    if unknown and part.feed is not None:
        # It may run along any axis.
        lowest = float(motion.rate[:3].min())
        name = "velocity (feed to home)"
        yield LimitCheck(name, part.feed / MM, lowest / MM, "mm/s", part.feed / lowest, clock, Status.PROVEN)


def _strut_velocity_home(
    part: Untimed, check: LimitCheck, machine: Machine, limits: MotionLimits, guarantees: Guarantees
) -> LimitCheck:
    """The feed and the controller's limits of its rotary axes together bound a strut's velocity, wherever it stands."""
    arm = float(np.linalg.norm(machine.platform.points, axis=1).max())
    linear = float(np.linalg.norm(limits.rate[:3])) if part.feed is None else part.feed
    bound = linear + arm * float(limits.rate[3:].sum())  # |omega| <= |roll'| + |pitch'| + |yaw'|
    ratio = bound / limits.strut_velocity_m_s
    kept = ratio <= 1.0 and "velocity" in guarantees.enforced
    status = Status.ENFORCED if kept else Status.NOT_ENFORCED
    return _own(replace(check, worst=bound, limit=limits.strut_velocity_m_s, ratio=ratio), status)
