"""Moves that a controller times itself: predicted by its own law, and the first one, from an unknown pose, bounded.

For the first move, feed and end are proven; all other limits are bounds.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cases.errors import HexciteError
from cases.units import DEG, MM
from identification.limit import Limit, LimitCheck, LimitKind, OwnMove, Status
from identification.limit_proof import limited_machine, prove
from identification.motion import Array, Joined, Standstill, Trajectory
from identification.trajectories.moves import CircularMove, StraightMove, limits_along
from postprocessors.proving.guarantees import Guarantees
from postprocessors.reading import Reading, Stretch, Timed, Untimed

if TYPE_CHECKING:
    from postprocessors.dialects import Program


def predicted(part: Untimed, guarantees: Guarantees) -> StraightMove | CircularMove | None:
    """The predicted motion of a move under the limits of the controller's set-up.

    None where its start is not known or nothing moves.
    """
    if part.start is None or not part.moves:
        return None
    limits, way = guarantees.limits, np.abs(part.end - part.start)
    if part.arc is not None:
        way[list(part.arc[0].axes[:2])] = part.length  # either axis may carry all of it
    velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)
    feed = np.inf if part.share_rate is None else part.share_rate
    if part.arc is not None:
        plane, centre, angle = part.arc
        law = guarantees.arc_law(min(feed, velocity), acceleration, jerk, abs(angle))
        return CircularMove(part.start, part.end[3:], plane, centre, angle, law)
    if part.acceleration is not None:
        velocity, acceleration = feed, part.acceleration / part.length
    return StraightMove(part.start, part.end, guarantees.law(min(feed, velocity), acceleration, jerk))


def motions(reading: Reading, guarantees: Guarantees) -> Iterator[tuple[Stretch, Trajectory]]:
    """Each stretch of a program that takes time, with its motion as its controller is expected to make it."""
    pose, _ = guarantees.case.need_motion("a run")
    for part in reading.stretches:
        motion: Trajectory | None
        if isinstance(part, Timed):
            motion = part.points
        elif isinstance(part, Untimed):
            motion = predicted(replace(part, start=pose), guarantees)
        else:
            motion = Standstill(pose, part.duration) if part.duration > 0.0 else None
        if motion is not None:
            yield part, motion
            pose = motion.at([motion.duration]).pose[0]


def planned_excitation(read: "Program") -> Trajectory:
    """The programmed motion while the trigger is on; raises HexciteError where nothing moves then."""
    excited = [motion for part, motion in motions(read.reading, read.guarantees) if part.trigger]
    while excited and isinstance(excited[0], Standstill):  # pauses between moves count
        excited.pop(0)
    while excited and isinstance(excited[-1], Standstill):
        excited.pop()
    if not excited:
        raise HexciteError(read.path, "nothing moves with the trigger on", "write it with hexcite post")
    return excited[0] if len(excited) == 1 else Joined(tuple(excited))


_COORDINATES = "xyzabc"
_AT_MOST = "from anywhere, at most"
_TRANSLATION = LimitKind.VELOCITY, LimitKind.ACCELERATION, LimitKind.JERK
_ROTATION = LimitKind.ANGULAR_VELOCITY, LimitKind.ANGULAR_ACCELERATION, LimitKind.ANGULAR_JERK


def way_home(part: Untimed, by: Guarantees) -> Iterable[LimitCheck]:
    """Limits of a move from an unknown pose, whose duration is not known either.

    The feed must not be above the case's safe feed (a rapid is), for obstacles cannot be checked on an unknown way.
    A, B and C of a pose turn as fast as the feed requires, and only the controller limits them.
    """
    for check in prove(Standstill(part.end, 0.0), by.case, 1.0, part.trigger).checks:
        if not check.kind.kinetic:
            yield check
    if by.limits.of_pose:
        yield from _of_a_pose(part, by)
        share = 1.0
    else:
        share = by.case.need_controller("the check of a program").safe_share if part.acceleration is not None else 1.0
        yield from _of_own_axes(part, by)
    for bound in by.force_bounds(share, stated=part.acceleration is not None):
        of = bound.of._replace(move=OwnMove.WAY_HOME)
        yield replace(bound, of=of, binding=bound.status is Status.PROVEN)


def _of_own_axes(part: Untimed, by: Guarantees) -> Iterable[LimitCheck]:
    """Limits of axes of the machine's own, whose ways are unknown."""
    limits, share = by.limits, by.case.need_controller("the check of a program").safe_share
    feed = np.inf if part.feed is None else part.feed
    # a feed in mm/min along X, Y and Z is one in degrees where none of them moves
    speeds = np.where(limits.turns & part.linear, feed / MM * DEG, feed)
    k = int(np.argmax(speeds / limits.rate))
    kind = LimitKind.ANGULAR_VELOCITY if limits.turns[k] else LimitKind.VELOCITY
    yield _feed_to_home(float(speeds[k]), share * float(limits.rate[k]), kind)
    cycle = by.jerk_time
    for own, (velocity, acceleration, jerking) in ((~limits.turns, _TRANSLATION), (limits.turns, _ROTATION)):
        if not own.any():
            continue
        rate, most, jerk = (float(v[own].min()) for v in (limits.rate, limits.acceleration, limits.jerk))
        fastest = float(speeds[own].max())
        status = Status.PROVEN if part.acceleration is not None else None
        yield _row(velocity, min(fastest, rate), rate, by, status)
        peak = part.acceleration if part.acceleration is not None else most
        yield _row(acceleration, peak, most, by, status)
        yield _row(jerking, 2.0 * peak / cycle if cycle > 0.0 else jerk, jerk, by)


def _of_a_pose(part: Untimed, by: Guarantees) -> Iterable[LimitCheck]:
    """Limits of the coordinates of a pose, and of the drives behind it."""
    limits = by.limits
    rate = limits.rate.copy()
    safe = min(by.case.need_controller("the check of a program").safe_feed, float(rate[:3].min()))
    feed = float(rate[:3].max()) if part.feed is None else part.feed
    yield _feed_to_home(feed, safe, LimitKind.VELOCITY)
    rate[:3] = np.minimum(rate[:3], feed)
    k = int(np.argmax(rate[3:] / limits.rate[3:])) + 3
    yield _row(LimitKind.ANGULAR_VELOCITY, float(rate[k]), float(limits.rate[k]), by)
    # peaks by the controller's own law over a long way [m/s^2, rad/s^2]
    laws = [by.law(*v) for v in zip(rate, limits.acceleration, limits.jerk, strict=True)]
    peaks = np.array([np.abs(law.at(np.linspace(0.0, law.duration, 1001))[2]).max() for law in laws])
    yield _largest(LimitKind.ACCELERATION, LimitKind.ANGULAR_ACCELERATION, peaks, limits.acceleration, by)
    cycle = by.jerk_time
    jerks = 2.0 * peaks / cycle if cycle > 0.0 else limits.jerk  # an acceleration that reverses within a cycle
    yield _largest(LimitKind.JERK, LimitKind.ANGULAR_JERK, jerks, limits.jerk, by)
    for kind, worst, most in limited_machine(by.case).from_anywhere(feed, rate, peaks):
        # rates of the drives follow from those of the pose, and so are enforced with these
        follows = kind is LimitKind.STRUT_VELOCITY and worst <= most and LimitKind.VELOCITY in by.enforced
        yield _row(kind, worst, most, by, Status.ENFORCED if follows else None)


def _largest(kind: LimitKind, angular: LimitKind, values: Array, limits: Array, by: Guarantees) -> LimitCheck:
    """The worst of all six coordinates, in its own unit, under the kind of translations."""
    k = int(np.argmax(values / limits))
    row = _row(kind, float(values[k]), float(limits[k]), by)
    return replace(row, unit=(kind if k < 3 else angular).unit)


def _row(kind: LimitKind, worst: float, limit: float, by: Guarantees, status: Status | None = None) -> LimitCheck:
    """A bound and its limit [SI]."""
    answer = by.status_of(kind) if status is None else status
    if answer is Status.ENFORCED:
        worst = min(worst, limit)
    check = LimitCheck(
        Limit(kind), _AT_MOST, worst * kind.scale, limit * kind.scale, kind.unit, worst / limit, 0.0, answer
    )
    return by.prediction(check, OwnMove.WAY_HOME, answer)


def _feed_to_home(feed: float, safe: float, kind: LimitKind) -> LimitCheck:
    """The programmed feed against the safe one [SI], in the unit of a kind of velocity."""
    values = feed * kind.scale, safe * kind.scale, kind.unit
    return LimitCheck(Limit(LimitKind.FEED_TO_HOME), "", *values, feed / safe, 0.0, Status.PROVEN)
