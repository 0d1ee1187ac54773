"""Moves that a controller times itself: predicted by its own law, and the first one, from an unknown pose, bounded.

Of the first move, feed and end are proven, all else is bounds.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cases.errors import ExecutionError
from cases.machine import MotionLimits
from cases.schema import Case
from cases.units import DEG, MM
from identification.limited import Box
from identification.limits import LimitCheck, Status, prove
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.circle import CircularMove
from identification.trajectories.profile import StraightMove, limits_along
from postprocessors.proving.guarantees import KINETIC, Answering, Guarantees, family
from postprocessors.proving.stretches import Timed, Untimed, stretches

if TYPE_CHECKING:
    from postprocessors.program_file import Program

Array = NDArray[np.float64]


def predicted(part: Untimed, limits: Box, guarantees: Guarantees) -> StraightMove | CircularMove | None:
    """How a move will run; None where its start is not known or nothing moves.

    Args:
        limits: limits that the controller is set up with.
    """
    if part.start is None or not part.moves:
        return None
    way = np.abs(part.end - part.start)
    if part.turn is not None:
        return _arc(part, part.start, limits, guarantees)
    feed = np.inf if part.feed is None else part.feed / part.length
    velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)
    if part.acceleration is not None:
        velocity, acceleration = feed, part.acceleration / part.length
    return StraightMove(part.start, part.end, guarantees.law(min(feed, velocity), acceleration, jerk))


def _arc(part: Untimed, start: Array, limits: Box, guarantees: Guarantees) -> CircularMove:
    turn = part.turn
    assert turn is not None
    assert part.feed is not None
    first, second, _ = turn.plane.axes
    length = part.length
    way = np.abs(part.end - start)
    way[[first, second]] = length  # either axis may carry all of it
    velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)
    law = guarantees.arc_law(min(part.feed / length, velocity), acceleration, jerk, abs(turn.angle))
    return CircularMove(start, part.end[3:], turn.plane, turn.centre, turn.angle, law)


def planned_excitation(read: "Program", case: Case) -> Trajectory:
    """The motion that the program asks for while its trigger is on.

    Raises:
        ExecutionError: nothing moves then.
    """
    limits = case.need_motion("a run")[1]
    excited: list[Trajectory] = []
    for part in stretches(read.reading):
        if not part.trigger:
            continue
        if isinstance(part, Timed):
            excited.append(part.points)
        elif isinstance(part, Untimed):
            motion = predicted(part, limits, read.guarantees)
            excited += [] if motion is None else [motion]
        elif excited and part.duration > 0.0:  # a pause between moves
            excited.append(Standstill(excited[-1].at([excited[-1].duration]).pose[0], part.duration))
    while excited and isinstance(excited[-1], Standstill):
        excited.pop()
    if not excited:
        raise ExecutionError(read.path, "nothing moves with the trigger on", "write it with hexcite post")
    return excited[0] if len(excited) == 1 else Joined(tuple(excited))


WAY_HOME = ", way home"
FEED_TO_HOME = "feed to home"
_COORDINATES = "xyzabc"
_AT_MOST = "from anywhere, at most"


def way_home(part: Untimed, by: Answering, clock: float) -> Iterable[LimitCheck]:
    """Limits of a move from an unknown pose.

    The feed must not be above the case's safe feed (a rapid is), for nobody can look for obstacles on a way that is not
    known. A, B and C of a pose turn as fast as they must, and only the controller limits them.

    Args:
        clock: when it starts [s].
    """
    for check in prove(Standstill(part.end, 0.0), by.case, 1.0, clock, part.trigger).checks:
        if family(check.name) not in KINETIC:
            yield check
    if isinstance(by.limits, MotionLimits):
        yield from _of_a_pose(part, by, clock)
        share = 1.0
    else:
        share = by.case.need_controller("the check of a program").safe_share if part.acceleration is not None else 1.0
        yield from _of_joints(part, by, by.limits, clock)
    for bound in by.forces.anywhere(clock, share) if by.forces is not None else ():
        if part.acceleration is not None and bound.ratio <= 1.0:  # the text states all that the bound needs
            yield by.own(bound, WAY_HOME, Status.PROVEN)
            continue
        proof = by.forces_kept(family(bound.name), lambda forces: forces.anywhere(clock, share), WAY_HOME)
        loose = replace(bound, name=bound.name.replace("at most", "at the limits"))
        yield proof or by.own(loose, WAY_HOME, Status.NOT_ENFORCED)


def _of_joints(part: Untimed, by: Answering, limits: Box, clock: float) -> Iterable[LimitCheck]:
    """Limits of the joints of a chain, of which nobody knows how far each will move."""
    share = by.case.need_controller("the check of a program").safe_share
    feed = np.inf if part.feed is None else part.feed
    # a feed in mm/min along X, Y and Z is one in degrees where none of them moves
    speeds = np.where(limits.turns & part.linear, feed / MM * DEG, feed)
    k = int(np.argmax(speeds / limits.rate))
    scale, unit = (1 / DEG, "deg/s") if limits.turns[k] else (1 / MM, "mm/s")
    safe = share * limits.rate[k]
    yield LimitCheck(FEED_TO_HOME, speeds[k] * scale, safe * scale, unit, speeds[k] / safe, clock, Status.PROVEN)
    cycle = by.guarantees.jerk_time
    for turning, kind, word in ((False, "", "m"), (True, "angular ", "rad")):
        own = limits.turns == turning
        if not own.any():
            continue
        rate, most, jerk = (float(v[own].min()) for v in (limits.rate, limits.acceleration, limits.jerk))
        scale, unit = (1 / DEG, "deg/s") if turning else (1 / MM, "mm/s")
        fastest = float(speeds[own].max())
        status = Status.PROVEN if part.acceleration is not None else None
        yield _row(f"{kind}velocity", min(fastest, rate) * scale, rate * scale, unit, clock, by, status)
        peak = part.acceleration if part.acceleration is not None else most
        yield _row(f"{kind}acceleration", peak, most, f"{word}/s^2", clock, by, status)
        steps = 2.0 * peak / cycle if cycle > 0.0 else jerk
        yield _row(f"{kind}jerk", steps, jerk, f"{word}/s^3", clock, by)


def _of_a_pose(part: Untimed, by: Answering, clock: float) -> Iterable[LimitCheck]:
    """Limits of the coordinates of a hexapod, and of its struts."""
    limits = by.limits
    rate = limits.rate.copy()
    safe = min(by.case.need_controller("the check of a program").safe_feed, float(rate[:3].min()))
    feed = float(rate[:3].max()) if part.feed is None else part.feed
    yield LimitCheck(FEED_TO_HOME, feed / MM, safe / MM, "mm/s", feed / safe, clock, Status.PROVEN)
    rate[:3] = np.minimum(rate[:3], feed)
    yield _largest("angular velocity", rate[3:], limits.rate[3:], "deg/s", clock, by)
    peaks = _peak_accelerations(rate, by)
    yield _largest("acceleration", peaks, limits.acceleration, "m/s^2 or rad/s^2", clock, by)
    cycle = by.guarantees.jerk_time
    jerks = 2.0 * peaks / cycle if cycle > 0.0 else limits.jerk  # an acceleration that reverses within a cycle
    yield _largest("jerk", jerks, limits.jerk, "m/s^3 or rad/s^3", clock, by)
    yield from _of_struts(feed, rate, peaks, by, clock)


def _peak_accelerations(rate: Array, by: Answering) -> Array:
    """Of each coordinate by the controller's own law over a long way, shape (6,) [m/s^2, rad/s^2]."""
    limits = by.limits
    laws = [by.guarantees.law(*v) for v in zip(rate, limits.acceleration, limits.jerk, strict=True)]
    return np.array([np.abs(law.at(np.linspace(0.0, law.duration, 1001))[2]).max() for law in laws])


def _of_struts(feed: float, rate: Array, peaks: Array, by: Answering, clock: float) -> Iterable[LimitCheck]:
    """Bounds wherever the machine stands: |omega| <= |roll'| + |pitch'| + |yaw'|, and l'' <= |s''| + |s'|^2 / l."""
    machine, workspace, limits = by.case.need_machine("the check of a program")
    motion = limits.motion
    arm = float(np.linalg.norm(machine.platform.points, axis=1).max())
    omega = float(rate[3:].sum())
    speed = feed + arm * omega
    kept = speed <= motion.strut_velocity_m_s and "velocity" in by.guarantees.enforced
    yield _row("strut velocity", speed, motion.strut_velocity_m_s, "m/s", clock, by, Status.ENFORCED if kept else None)
    turning = float(peaks[3:].sum()) + omega**2
    shortest = max(motion.strut_length[0], workspace.strut_length[0])
    acceleration = float(np.linalg.norm(peaks[:3])) + arm * turning + speed**2 / shortest
    yield _row("strut acceleration", acceleration, motion.strut_acceleration_m_s2, "m/s^2", clock, by)


def _largest(name: str, values: Array, limits: Array, unit: str, clock: float, by: Answering) -> LimitCheck:
    scale = {"mm/s": 1 / MM, "deg/s": 180 / np.pi}.get(unit, 1.0)
    k = int(np.argmax(values / limits))
    unit = unit.split(" or ")[k // 3] if " or " in unit else unit
    return _row(name, float(values[k]) * scale, float(limits[k]) * scale, unit, clock, by)


def _row(
    name: str, worst: float, limit: float, unit: str, clock: float, by: Answering, status: Status | None = None
) -> LimitCheck:
    answer = by.answer(name) if status is None else status
    if answer is Status.ENFORCED:
        worst = min(worst, limit)
    return by.own(
        LimitCheck(f"{name} ({_AT_MOST})", worst, limit, unit, worst / limit, clock, answer), WAY_HOME, answer
    )
