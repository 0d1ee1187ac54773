"""Moves that a controller times itself: predicted by its own law, and the first one bounded.

Where it begins within a checked distance of home, all its limits are proven. From an unknown pose feed and end are; all
other limits are bounds.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cases.base.errors import Code, HexciteError
from cases.base.phrases import phrase
from cases.base.units import DEG, MM
from identification.limits.limit import Limit, LimitCheck, LimitKind, OwnMove, Status
from identification.limits.proof import limited_machine, prove
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import CircularMove, StraightMove, limits_along
from postprocessors.proof.guarantees import Guarantees
from postprocessors.reading import STILL, Reading, Stretch, Timed, Untimed


def predicted(part: Untimed, guarantees: Guarantees) -> StraightMove | CircularMove | None:
    """The predicted motion of a move under the limits of the controller's set-up.

    None where its start is not known or nothing moves.
    """
    if part.start is None or not part.moves:
        return None
    if (
        part.feed is not None and part.length <= STILL
    ):  # behind an arc, whose end is where it was written up to rounding
        return None
    limits, way = guarantees.limits, np.abs(part.end - part.start)
    if part.arc is not None:
        way[list(part.arc[0].axes[:2])] = part.length  # either axis may carry all of it
    velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)
    feed = np.inf if part.feed is None else part.feed / part.length
    if part.arc is not None:
        plane, centre, angle = part.arc
        law = guarantees.arc_law(feed, velocity, acceleration, jerk, abs(angle))
        return CircularMove(part.start, part.end[3:], plane, centre, angle, law)
    if math.isfinite(most := guarantees.path_jerk[0 if part.linear else 1]):
        jerk = min(jerk, most / part.length)
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
            pose = motion.at([motion.duration]).coordinates[0]


def planned_excitation(reading: Reading, guarantees: Guarantees) -> Trajectory:
    """The programmed motion while the trigger is on; raises HexciteError where nothing moves then."""
    excited = [motion for part, motion in motions(reading, guarantees) if part.trigger]
    while excited and isinstance(excited[0], Standstill):  # pauses between moves count
        excited.pop(0)
    while excited and isinstance(excited[-1], Standstill):
        excited.pop()
    if not excited:
        raise HexciteError(
            place=reading.file,
            problem=phrase("nothing_triggered", "nothing moves with the trigger on"),
            remedy=phrase("write_by_post", "write it with hexcite post"),
            code=Code.TRIGGER,
        )
    return excited[0] if len(excited) == 1 else Joined(tuple(excited))


_OF_COORDINATES = (
    (LimitKind.VELOCITY, LimitKind.ANGULAR_VELOCITY),
    (LimitKind.ACCELERATION, LimitKind.ANGULAR_ACCELERATION),
    (LimitKind.JERK, LimitKind.ANGULAR_JERK),
)


def way_home(part: Untimed, by: Guarantees) -> Iterable[LimitCheck]:
    """Limits of a move from an unknown pose, whose duration is not known either.

    The feed must not be above the case's safe feed (a rapid is), for obstacles cannot be checked on an unknown way.
    A, B and C of a pose turn as fast as the feed requires, and only the controller limits them.
    """
    for check in prove(Standstill(part.end, 0.0), by.case, 1.0, part.trigger).checks:
        if not check.kind.kinetic:
            yield check
    limits, controller = by.limits, by.case.need_controller("the check of a program")
    feeds = np.full(len(limits.rate), np.inf if part.feed is None else part.feed)
    if limits.of_pose:
        feeds[3:] = np.inf
        k, safe = 0, min(controller.safe_feed, float(limits.rate[:3].min()))
        feed = float(limits.rate[:3].max()) if part.feed is None else part.feed
    else:
        if part.linear:  # a feed in mm/min along X, Y and Z is one in degrees where none of them moves
            feeds[limits.turns] *= DEG / MM
        k = int(np.argmax(feeds / limits.rate))
        feed, safe = float(feeds[k]), controller.safe_share * float(limits.rate[k])
    kind = _OF_COORDINATES[0][int(limits.turns[k])]
    values = feed * kind.scale, safe * kind.scale, kind.unit, feed / safe
    yield LimitCheck(Limit(LimitKind.FEED_TO_HOME), "", *values, 0.0, Status.PROVEN)
    # rates, and peaks of accelerations by the controller's own law over a long way, or as the text states them
    rates, stated = np.minimum(feeds, limits.rate), part.acceleration is not None
    laws = zip(rates, limits.acceleration, limits.jerk, strict=True)
    peaks = np.array([by.law(*v).acceleration if part.acceleration is None else part.acceleration for v in laws])
    # an acceleration that reverses within a cycle, where no law limits the jerk
    jerks = 2.0 * peaks / by.jerk_time if by.jerk_time > 0.0 else limits.jerk
    most = limits.rate, limits.acceleration, limits.jerk
    for kinds, extremes, limit in zip(_OF_COORDINATES, (rates, peaks, jerks), most, strict=True):
        k = int(np.argmax(extremes / limit))
        status = Status.PROVEN if stated and extremes is not jerks else None
        yield _row(kinds[int(limits.turns[k])], float(extremes[k]), float(limit[k]), by, status)
    for kind, worst, bound in limited_machine(by.case).from_anywhere(feed, rates, peaks):
        # rates of the drives follow from those of the pose, and so are enforced with these
        follows = kind is LimitKind.STRUT_VELOCITY and worst <= bound and LimitKind.VELOCITY in by.enforced
        yield _row(kind, worst, bound, by, Status.ENFORCED if follows else None)
    for force in by.force_bounds((rates, peaks) if stated else None):
        of = force.of._replace(move=OwnMove.WAY_HOME)
        yield replace(force, of=of, binding=force.status is Status.PROVEN)


def at_a_crawl(part: Untimed, by: Guarantees) -> Iterable[LimitCheck]:
    """Limits of a move to home from a place so near it, as the program has checked, that its path does not matter.

    Its speeds are at most the feed, reached within a cycle, for set points do not change faster. These bounds are
    reported where they exceed a limit: they would hide what the motion uses. Geometry and forces are those of the
    standstill at its end.
    """
    assert part.within is not None
    assert part.feed is not None
    limits, cycle = by.limits, by.cycle
    rates = np.where((part.within > 0.0) & np.isin(np.arange(len(part.within)), part.counted), part.feed, 0.0)
    peaks = np.minimum(rates / cycle, np.inf if part.acceleration is None else part.acceleration)
    bounds: list[tuple[LimitKind, float, float]] = []
    most = limits.rate, limits.acceleration, limits.jerk
    for kinds, extremes, limit in zip(_OF_COORDINATES, (rates, peaks, 2.0 * peaks / cycle), most, strict=True):
        for kind, axes in zip(kinds, (~limits.turns, limits.turns), strict=True):
            if axes.any():
                k = int(np.argmax(np.where(axes, extremes / limit, -1.0)))
                bounds.append((kind, float(extremes[k]), float(limit[k])))
    speed = float(np.linalg.norm(rates[:3])) if limits.of_pose else 0.0
    bounds += limited_machine(by.case).from_anywhere(speed, rates, peaks)
    for kind, worst, bound in bounds:
        if worst > bound:
            values = worst * kind.scale, bound * kind.scale, kind.unit, worst / bound
            yield LimitCheck(Limit(kind), "to home, at most", *values, 0.0, Status.PROVEN)
    bounded = {kind for kind, *_ in bounds}
    for check in prove(Standstill(part.end, 0.0), by.case, 1.0, part.trigger).checks:
        if check.kind not in bounded:
            yield check


def _row(kind: LimitKind, worst: float, limit: float, by: Guarantees, status: Status | None = None) -> LimitCheck:
    """A bound and its limit [SI]."""
    answer = by.status_of(kind) if status is None else status
    if answer is Status.ENFORCED:
        worst = min(worst, limit)
    values = worst * kind.scale, limit * kind.scale, kind.unit, worst / limit
    check = LimitCheck(Limit(kind), "from anywhere, at most", *values, 0.0, answer)
    return by.prediction(check, OwnMove.WAY_HOME, answer)
