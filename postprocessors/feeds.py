"""The feed that makes a controller's own time law take as long as planned."""

import numpy as np

from cases.machine import MotionLimits
from postprocessors.guarantees import Guarantees
from postprocessors.program import Arc, PointToPoint

NO_SLOWER = 1e-9
HALVINGS = 80  # of the interval of the feed: down to its last bit


def feed_of(block: PointToPoint | Arc, limits: MotionLimits, guarantees: Guarantees, linear: bool = True) -> float:
    """Feed of a move along X, Y, Z [m/s], or along the angles [rad/s].

    The largest that the move can reach where even that takes longer than planned.

    Args:
        block: the move, with its planned duration.
        limits: that the controller is set up with.
        guarantees: give its time law.
        linear: whether the feed counts X, Y, Z.
    """
    move = block.move
    way = np.abs(move.end - move.start)
    if isinstance(block, Arc):
        way[list(block.move.plane.axes[:2])] = block.move.length
    moves = way > 0.0
    velocity, acceleration, jerk = (
        float(np.min(limit[moves] / way[moves])) for limit in (limits.rate, limits.acceleration, limits.jerk)
    )

    def duration(speed: float) -> float:
        if isinstance(block, Arc):
            return guarantees.arc_law(speed, acceleration, jerk, abs(block.move.angle)).duration
        return guarantees.law(speed, acceleration, jerk).duration

    low, high = min(velocity, 1.0 / move.duration), velocity  # below the mean speed it takes longer for certain
    if duration(high) * (1.0 + NO_SLOWER) >= move.duration:
        low = high  # as fast as it can be: the peak is a flat optimum, no feed of its own belongs to it
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if duration(middle) > move.duration else (low, middle)
    if isinstance(block, Arc):
        return high * block.move.length
    return high * float(np.linalg.norm(way[:3] if linear else way[3:]))
