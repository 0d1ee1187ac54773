"""Limits of a machine beside those of its coordinates, as CasADi expressions for the search.

A hexapod has limits of struts, joints, singularity and boxes, the latter for the platform's origin, its joints and
points of struts and tools. Joint angles enter by their cosine, smooth at zero: (1 - cos angle) / (1 - cos limit).

A chain has limits of the distances of its bodies from boxes and from each other; a body is balls along its axis, half a
radius apart, of a convex one along that of a capsule around it. A clearance allows for what is between points. The
proof, which has its own distances, finds what remains beyond it, and the motion then shrinks.
"""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from cases.base.convex import separation
from cases.base.units import Array
from cases.chain import Chain
from cases.machine import Tool
from identification.limits.limit import Limit, LimitKind
from identification.machines.machine import VICINITY, Share

ROUNDING = 0.003  # [m] by about which corners of boxes are rounded
MOST_BALLS = 20  # largest number of balls of a body
BALL_ROUNDING = 0.001  # [m] by about which least distances of bodies are rounded
BALL_CLEARANCE = 0.01  # [m] the same between two balls; less where the middle of the box is nearer


def distance_from_box(point: ca.SX, corners: Array, rounding: float) -> ca.SX:
    """Distance along the axis that separates point and box most, at edges a little less, so that it is smooth [m]."""
    gaps = ca.fabs(point - ca.DM(corners.mean(axis=0))) - ca.DM(np.ptp(corners, axis=0) / 2)
    most = ca.mmax(gaps)
    return most + rounding * ca.log(ca.sum1(ca.exp((gaps - most) / rounding)) / 3)


def clearance_shares(chain: Chain, q: ca.SX, middle: Array, frames: Sequence[tuple[ca.SX, ca.SX]]) -> list[Share]:
    """Shares of the clearances of bodies from boxes and from each other: 1 where the clearance begins, 0 far away.

    Args:
        middle: middle of the motion box, shape (n,) [rad or m].
        frames: origin and R in {B} of the moved frame of each joint, then of the sensor's.
    """
    placed = bodies_of(chain, frames)
    bodies = [(link, body, _balls(frame, body)) for link, frame, body in placed]
    hulls = ca.Function("hulls", [q], [points_of(frame, body) for _, frame, body in placed])
    corners = [points.full().T for points in hulls.call([ca.DM(middle)])]
    distances, around, exact = [], [], []
    for k, (link, body, centres) in enumerate(bodies):
        if link:
            distances += [
                _least([distance_from_box(c, box.corners, BALL_ROUNDING) for c in centres], body.radius)
                for box in chain.keep_out
            ]
            around += [_hull(body)] * len(chain.keep_out)
            exact += [0.0] * len(chain.keep_out)
        for n, (other_link, other, others) in enumerate(bodies[k + 1 :], k + 1):
            if chain.keeps_apart(link, body.name, other_link, other.name):
                gaps = [ca.norm_2(a - b) for a in centres for b in others]
                distances.append(_least(gaps, body.radius + other.radius))
                around.append(_hull(body) or _hull(other))
                separated = float(separation(corners[k][None], corners[n][None])[0]) if around[-1] else 0.0
                exact.append(separated - body.beyond - other.beyond)
    if not distances:
        return []
    clearances = ca.Function("distances", [q], [ca.vertcat(*distances)])(middle).full()[:, 0]
    margins = np.clip(clearances / 2, 0.0, BALL_CLEARANCE)
    # Capsules around convex bodies may overlap where these are apart: the search then keeps them from coming closer
    # than the bodies themselves may, as if both distances changed alike.
    closer = np.maximum(exact, 0.0)
    bounds = clearances - closer + np.minimum(closer / 2, BALL_CLEARANCE)
    margins = np.where(np.array(around) & (clearances < 2 * BALL_CLEARANCE), np.minimum(bounds, margins), margins)
    return [
        (LimitKind.DISTANCE_FROM_BOX, 0, ca.exp((k - distance) / VICINITY))
        for k, distance in zip(margins, distances, strict=True)
    ]


def clearance_names(chain: Chain) -> list[str]:
    """Names of the limits of `clearance_shares` in its order, as a proof names them."""
    still = (ca.SX(3, 1), ca.SX.eye(3))
    bodies = [(link, body.name) for link, _, body in bodies_of(chain, [still] * (len(chain.joints) + 1))]
    names = []
    for k, (link, name) in enumerate(bodies):
        if link:
            names += [Limit(LimitKind.DISTANCE_FROM_BOX, box.name).at(name) for box in chain.keep_out]
        apart = [n for other_link, n in bodies[k + 1 :] if chain.keeps_apart(link, name, other_link, n)]
        names += [Limit(LimitKind.DISTANCE_BETWEEN_LINKS).at(f"{name}, {other}") for other in apart]
    return names


def bodies_of(chain: Chain, frames: Sequence[tuple[ca.SX, ca.SX]]) -> list[tuple[int, tuple[ca.SX, ca.SX], Tool]]:
    """Bodies of a chain, each with the number of its link, 0 of what stands, and with the link's origin and R in {B}.

    Args:
        frames: origin and R in {B} of the moved frame of each joint, then of the sensor's.
    """
    still, last = (ca.SX(3, 1), ca.SX.eye(3)), len(chain.joints)
    moved = zip(range(1, last + 1), frames, (joint.bodies for joint in chain.joints), strict=False)
    links = ((0, still, chain.base), *moved, (last, frames[-1], chain.tool))
    return [(link, frame, body) for link, frame, bodies in links for body in bodies]


def _balls(frame: tuple[ca.SX, ca.SX], body: Tool) -> list[ca.SX]:
    """Centres of balls along the axis of a body."""
    (origin, turn), (low, high) = frame, body.axis
    length, radius = float(np.linalg.norm(high - low)), body.radius
    count = int(np.clip(np.ceil(2 * length / max(radius, 1e-3)) + 1, 2, MOST_BALLS))
    return [origin + turn @ ca.DM(low + s * (high - low)) for s in np.linspace(0.0, 1.0, count)]


def points_of(frame: tuple[ca.SX, ca.SX], body: Tool) -> ca.SX:
    """Points whose hull, larger by `body.beyond`, is a body, in {B}, shape (3, k) [m]."""
    origin, turn = frame
    return ca.horzcat(*(origin + turn @ ca.DM(point) for point in body.points))


def _hull(body: Tool) -> bool:
    return body.corners_mm is not None


def _least(distances: list[ca.SX], radius: float) -> ca.SX:
    """The least of some distances, less the radius, a little less where several are alike, so that it is smooth [m]."""
    every = ca.vertcat(*distances)
    least = ca.mmin(every)
    return least - BALL_ROUNDING * ca.log(ca.sum1(ca.exp((least - every) / BALL_ROUNDING))) - radius
