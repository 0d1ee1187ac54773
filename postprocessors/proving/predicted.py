"""The motion that a controller makes of a move which it times itself: its own law under the limits of the case."""

import numpy as np
from numpy.typing import NDArray

from identification.limited import Box
from identification.trajectories.circle import CircularMove
from identification.trajectories.profile import StraightMove, limits_along
from postprocessors.proving.guarantees import Guarantees
from postprocessors.proving.stretches import Untimed

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
