"""Arcs from words: end, relative centre and direction become centre and angle, or a reason why they are no arc."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identification.trajectories.circle import Plane

Array = NDArray[np.float64]

ROUND = 2e-3  # [mm] between the radii at both ends: rounding of words; LinuxCNC itself lets pass 5e-3
STILL = 1e-7  # [mm] between places that are the same


class PlaneProblem(Exception):
    """Words that are no arc.

    Args:
        word: the one that is wrong, empty where they are as a whole.
        problem: what is wrong and how to mend it.
    """

    def __init__(self, word: str, problem: str) -> None:
        super().__init__(problem)
        self.word = word


class Arc(NamedTuple):
    """What a block says.

    Args:
        plane: in which it lies.
        counter_clockwise: G3, seen from the positive end of the plane's normal; else G2.
        start: shape (6,) [mm, deg].
        end: shape (6,) [mm, deg].
        centres: I, J, K as written, relative to the start [mm].
    """

    plane: Plane
    counter_clockwise: bool
    start: Array
    end: Array
    centres: dict[str, float]


def arc_through(asked: Arc) -> tuple[Array, float]:
    """Centre in the plane, shape (2,) [mm], and signed angle [rad].

    Raises:
        PlaneProblem: no arc.
    """
    first, second, normal = asked.plane.axes
    if "IJK"[normal] in asked.centres:
        name = "IJK"[normal]
        raise PlaneProblem(name, f"{name} is no centre in this plane; remove it, or choose another plane")
    if not asked.centres:
        raise PlaneProblem("", f"an arc without a centre; add {'IJK'[first]} and {'IJK'[second]}")
    if abs(asked.end[normal] - asked.start[normal]) > STILL:
        raise PlaneProblem("XYZ"[normal], "helices are not used here; write an arc in its plane")
    offset = np.array([asked.centres.get("IJK"[k], 0.0) for k in (first, second)])
    centre = asked.start[[first, second]] + offset
    target = asked.end[[first, second]] - centre
    radius, reached = float(np.hypot(*offset)), float(np.hypot(*target))
    if radius <= 0.0:
        raise PlaneProblem("", "the arc has no radius; correct its centre")
    if abs(reached - radius) > ROUND:
        raise PlaneProblem(
            "", f"radius {radius:g} mm at the start and {reached:g} mm at the end of the arc; correct its centre"
        )
    if float(np.hypot(*(target + offset))) <= STILL:
        turned = 2 * np.pi
    else:
        arm = -offset
        turned = float(np.arctan2(arm[0] * target[1] - arm[1] * target[0], arm @ target)) % (2 * np.pi)
        turned = turned if asked.counter_clockwise else 2 * np.pi - turned
    return centre, turned if asked.counter_clockwise else -turned
