"""The motion that a controller makes of a move which it times itself: its own law under the limits of the case."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cases.errors import ExecutionError
from cases.schema import Case
from identification.limited import Box
from identification.motion import Joined, Standstill, Trajectory
from identification.trajectories.circle import CircularMove
from identification.trajectories.profile import StraightMove, limits_along
from postprocessors.proving.guarantees import Guarantees
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
