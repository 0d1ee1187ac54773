"""The first move, from a pose that the program cannot know: proven are its feed and its end, all else is bounds."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from cases.units import MM
from identification.limits import LimitCheck, Status, prove
from identification.motion import Array, Standstill
from postprocessors.proving.answering import Answering
from postprocessors.proving.guarantees import KINETIC, family
from postprocessors.proving.stretches import Untimed

WAY_HOME = ", way home"
FEED_TO_HOME = "feed to home"
_COORDINATES = "xyzabc"
_AT_MOST = "from anywhere, at most"


def way_home(part: Untimed, by: Answering, clock: float) -> Iterable[LimitCheck]:
    """Limits of a move from an unknown pose.

    The feed must not be above the case's safe feed (a rapid is), for nobody can look for obstacles on a way that is not
    known. A, B and C turn as fast as they must, and only the controller limits them.

    Args:
        part: the move.
        by: what it is judged by.
        clock: when it starts [s].
    """
    for check in prove(Standstill(part.end, 0.0), by.case, 1.0, clock, part.trigger).checks:
        if family(check.name) not in KINETIC:
            yield check
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
    if by.forces is not None:
        bound = by.forces.anywhere(clock)
        kept = by.forces_kept(lambda forces: bound, WAY_HOME)
        loose = replace(bound, name=bound.name.replace("at most", "at the limits"))
        yield kept or by.own(loose, WAY_HOME, Status.NOT_ENFORCED)


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
