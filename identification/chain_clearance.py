"""Distances of the bodies of a chain from boxes and from each other, as CasADi expressions for the search.

Bodies enter as balls along their axes, half a radius apart, with a clearance for what is between these; what it does
not hold back is left to the proof, which has its own distances, and to drawing back.
"""

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cases.chain import Chain
from cases.machine import Tool
from cases.units import MM
from identification.limit import LimitKind
from identification.machines import Share

Array = NDArray[np.float64]

MOST_BALLS = 20  # of a body
ROUNDING = 0.001  # [m] by about which least distances are rounded
CLEARANCE = 0.01  # [m] for what comes near between two balls or instants; less where the middle of the box is nearer
VICINITY = 0.25  # [m] in which the share falls by a factor of e: comparable with the ways of motions


class Placed(NamedTuple):
    """A frame in {B}: the number of its link, from 0 for the base, origin and R."""

    link: int
    origin: ca.SX
    turn: ca.SX


class _Balls(NamedTuple):
    link: int
    centres: list[ca.SX]
    radius: float


def clearance_shares(chain: Chain, q: ca.SX, middle: Array, frames: Sequence[Placed], sensor: Placed) -> list[Share]:
    """Shares of what keeps bodies from boxes and from each other: 1 where the clearance begins, 0 far away.

    Args:
        chain: chain with bodies of links and tool, and boxes to keep out of.
        q: positions of the joints, shape (n,).
        middle: middle of the motion box, shape (n,) [rad or m].
        frames: moved frame of each joint.
    """
    still = Placed(0, ca.SX(3, 1), ca.SX.eye(3))
    places = [(still, chain.base), *((f, j.bodies) for f, j in zip(frames, chain.joints, strict=True))]
    bodies = [_balls(place, body) for place, own in (*places, (sensor, chain.tool)) for body in own]
    distances = []
    for k, one in enumerate(bodies):
        if one.link:
            distances += [_least([_box(c, box.corners) for c in one.centres], one.radius) for box in chain.keep_out]
        for other in bodies[k + 1 :]:
            if abs(other.link - one.link) > 1:
                gaps = [ca.norm_2(a - b) for a in one.centres for b in other.centres]
                distances.append(_least(gaps, one.radius + other.radius))
    if not distances:
        return []
    clearances = ca.Function("distances", [q], [ca.vertcat(*distances)])(middle).full()[:, 0]
    margins = np.clip(clearances / 2, 0.0, CLEARANCE)
    return [
        Share(LimitKind.DISTANCE_FROM_BOX, 0, ca.exp((k - distance) / VICINITY))
        for k, distance in zip(margins, distances, strict=True)
    ]


def _balls(place: Placed, body: Tool) -> _Balls:
    """Balls along the axis of a body."""
    low, high = body.axis
    length, radius = float(np.linalg.norm(high - low)), body.radius_mm * MM
    count = int(np.clip(np.ceil(2 * length / max(radius, 1e-3)) + 1, 2, MOST_BALLS))
    centres = [place.origin + place.turn @ ca.DM(low + s * (high - low)) for s in np.linspace(0.0, 1.0, count)]
    return _Balls(place.link, centres, radius)


def _box(point: ca.SX, corners: Array) -> ca.SX:
    """Distance along the axis that separates point and box most, at edges a little less, so that it is smooth [m]."""
    gaps = ca.fabs(point - ca.DM(corners.mean(axis=0))) - ca.DM(np.ptp(corners, axis=0) / 2)
    most = ca.mmax(gaps)
    return most + ROUNDING * ca.log(ca.sum1(ca.exp((gaps - most) / ROUNDING)) / 3)


def _least(distances: list[ca.SX], radius: float) -> ca.SX:
    """The least of some distances, less the radius, a little less where several are alike, so that it is smooth [m]."""
    every = ca.vertcat(*distances)
    least = ca.mmin(every)
    return least - ROUNDING * ca.log(ca.sum1(ca.exp((least - every) / ROUNDING))) - radius
