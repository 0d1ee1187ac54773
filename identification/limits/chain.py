"""What a case with a chain limits, and how its load moves: in NumPy from the definitions, for the proof.

Frames are homogeneous matrices T, multiplied from the base to the sensor; their derivatives follow by the product rule.
Torques are those of Lagrange's equations in this form: the sum over bodies of tr(dT/dq J (T'' - G)^T), J the integral
of r r^T over the mass (Uicker 1965), G the acceleration of gravity. No contact of bodies is missed between two
instants: each distance is reduced by the way that the axes of its bodies can move in half a step.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain as joined
from typing import NamedTuple

import numpy as np

from cases.base.convex import least_separation
from cases.base.units import MM, Array, Flags
from cases.chain import Chain, Joint
from cases.machine import Frame as Place
from cases.machine import KeepOut, Tool
from cases.schema import Case
from cases.sensors import RigidBody, payload_words
from identification.limits.hexapod import distance_of_segments
from identification.limits.limit import Limit, LimitKind, Quantity
from identification.limits.sensor_loads import SHARE
from identification.motion.motion import LoadMotion, Motion, axis_rotation

_Frames = tuple[Array, Array, Array]
Frames = Sequence[_Frames]
"""T, T', T'' of the moved frame of each joint, then of the sensor's, shapes (n, 4, 4)."""


@dataclass(frozen=True, slots=True)
class LimitedChain:
    """A `LimitedMachine` whose coordinates are the positions of its joints."""

    case: Case
    chain: Chain
    turns: Flags  # which joints turn, shape (n,)

    @classmethod
    def of(cls, case: Case) -> "LimitedChain":
        """The chain of a case; raises CaseError where the case lacks it or its limits."""
        chain, limits = case.need_chain("the proof of limits")
        return cls(case, chain, limits.turns)

    def ranges(self, motion: Motion) -> Iterable[Quantity]:
        """Where the joints are, between the ends of each; a joint that turns without end has none."""
        ends = np.isfinite(self.chain.position).all(axis=0)
        for kind, axes in ((LimitKind.JOINT_POSITION, ends & ~self.turns), (LimitKind.JOINT_ANGLE, ends & self.turns)):
            if axes.any():
                labels = tuple(label for label, k in zip(self.chain.names, axes, strict=True) if k)
                low, high = self.chain.position[:, axes]
                yield Quantity.between(kind, labels, motion.coordinates[:, axes], low, high)

    def drives(self, motion: Motion) -> tuple[Array, Array, Array]:
        """The joints themselves."""
        return motion.coordinates, motion.rates, motion.accelerations

    def mechanics(self, motion: Motion) -> tuple[LoadMotion, Iterable[Quantity]]:
        """Torques of the drives, and distances of bodies."""
        frames = chain_frames(motion, self.chain)
        efforts = joint_efforts(frames, self.chain, self.case.gravity, self.case.bodies)
        return sensor_motion(frames), joined(efforts, body_clearances(motion.t, frames, self.chain))

    def fastest(self, rate: Array, acceleration: Array) -> tuple[float, float, float]:
        """Sums over the joints, each with the largest distance of the sensor from its axis."""
        turns = self.turns
        omega = float(rate[turns].sum())
        alpha = float(acceleration[turns].sum()) + omega**2 / 2.0  # each joint's axis turns with those before it
        reach = _reach(self.chain)
        slide = float(rate[~turns].sum())
        pull = float(acceleration[turns] @ reach[turns] + acceleration[~turns].sum())
        return omega, alpha, pull + omega**2 * float(reach[0]) + 2.0 * omega * slide

    def from_anywhere(self, speed: float, rate: Array, acceleration: Array) -> Iterable[tuple[LimitKind, float, float]]:
        """None: the drives are the coordinates."""
        return ()


def _reach(chain: Chain) -> Array:
    """Largest distance of the sensor from the axis of each joint, wherever the joints after it are, shape (n,) [m]."""
    lengths = [float(np.linalg.norm(joint.origin)) for joint in (*chain.joints, chain.sensor)]
    slides = [0.0 if joint.turns else max(abs(v) for v in joint.position) for joint in chain.joints]
    reaches = np.cumsum([b + s for b, s in zip(lengths[:0:-1], slides[::-1], strict=True)])
    return np.asarray(reaches[::-1])


def sensor_motion(frames: Frames) -> LoadMotion:
    """Motion of the sensor's frame, the last one."""
    *_, (place, first, second) = frames
    return (place[:, :3, :3], first[:, :3, :3], second[:, :3, :3]), second[:, :3, 3]


def joint_efforts(frames: Frames, chain: Chain, gravity: Array, bodies: Sequence[RigidBody]) -> Iterable[Quantity]:
    """Torques or forces of the drives to move links and load, without friction, against 80 % of the largest.

    Nothing is limited without the inertia of every link. `bodies` may be behind the sensor, one at a time.
    """
    if not chain.limits_effort:
        return
    pull = np.zeros((4, 4))
    pull[:3, 3] = gravity
    links = [
        _mechanics(frame, joint.link, pull) for frame, joint in zip(frames, chain.joints, strict=False) if joint.link
    ]
    loads = [(str(payload_words(n)), _mechanics(frames[-1], body, pull)) for n, body in enumerate(bodies)]
    turns = np.array([joint.turns for joint in chain.joints])
    limited = np.isfinite([joint.effort for joint in chain.joints])
    for kind, axes in ((LimitKind.JOINT_FORCE, limited & ~turns), (LimitKind.JOINT_TORQUE, limited & turns)):
        columns, labels, most = [], [], []
        for words, load in loads or [("no load", np.zeros_like(links[0]))]:
            inertia = load
            for k in range(len(chain.joints) - 1, -1, -1):
                inertia = inertia + links[k]
                if axes[k]:
                    columns.append(_generalised(frames[k][0], chain.joints[k], inertia))
                    labels.append(f"{chain.joints[k].name}, {words}")
                    most.append(SHARE * chain.joints[k].effort)
        if columns:
            limit = np.array(most)
            yield Quantity.between(kind, tuple(labels), np.column_stack(columns), -limit, limit)


def _mechanics(frame: _Frames, body: RigidBody, pull: Array) -> Array:
    """T J (T'' - G)^T of a body in a frame, shape (n, 4, 4)."""
    centre = np.append(body.centre_of_gravity, 1.0)
    central = np.zeros((4, 4))
    central[:3, :3] = np.trace(body.inertia) / 2 * np.eye(3) - body.inertia
    return np.asarray(
        frame[0] @ (central + body.mass_kg * np.outer(centre, centre)) @ (frame[2] - pull).transpose(0, 2, 1)
    )


def _generalised(frame: Array, joint: Joint, inertia: Array) -> Array:
    """tr(D `inertia`), D = (dT/dq) T^-1 the joint's screw in {B}, shape (n,)."""
    axis = frame[:, :3, :3] @ (np.array(joint.axis) / np.linalg.norm(joint.axis))
    if not joint.turns:
        return np.asarray(np.einsum("ni,ni->n", axis, inertia[:, 3, :3]))
    moment = np.stack([inertia[:, j, i] - inertia[:, i, j] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1)
    return np.asarray(np.einsum("ni,ni->n", axis, moment - np.cross(frame[:, :3, 3], inertia[:, 3, :3])))


def chain_frames(motion: Motion, chain: Chain) -> Frames:
    """T, T', T'' of the moved frame of each joint, then of the sensor's, shapes (n, 4, 4)."""
    count, frames = len(motion.t), []
    total: _Frames = (np.tile(np.eye(4), (count, 1, 1)), np.zeros((count, 4, 4)), np.zeros((count, 4, 4)))
    for k, joint in enumerate(chain.joints):
        total = _times(total, _moved(joint, motion.coordinates[:, k], motion.rates[:, k], motion.accelerations[:, k]))
        frames.append(total)
    joint_from_sensor = _parent_from_frame(chain.sensor)
    first, second, third = (frame @ joint_from_sensor for frame in total)
    return [*frames, (first, second, third)]


def _times(before: _Frames, then: _Frames) -> _Frames:
    (a, a1, a2), (b, b1, b2) = before, then
    return a @ b, a1 @ b + a @ b1, a2 @ b + 2.0 * (a1 @ b1) + a @ b2


def _parent_from_frame(place: Place) -> Array:
    """Matrix of a frame in the one before it, shape (4, 4)."""
    still = np.zeros(1)
    x, y, z = (axis_rotation(axis, np.array([angle]), still, still)[0][0] for axis, angle in enumerate(place.rpy))
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = z @ y @ x, place.origin
    return frame


def _moved(joint: Joint, position: Array, rate: Array, acceleration: Array) -> _Frames:
    """What a joint adds: its place, and a screw along or a turn about z of a frame whose z is the axis, and back."""
    aligned = np.eye(4)
    axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    aligned[:3, :3] = np.column_stack([across, np.cross(axis, across), axis])
    frames = [np.zeros((len(position), 4, 4)) for _ in range(3)]
    frames[0][:, 3, 3] = 1.0
    if joint.turns:
        for frame, turn in zip(frames, axis_rotation(2, position, rate, acceleration), strict=True):
            frame[:, :3, :3] = turn
    else:
        frames[0][:, :3, :3] = np.eye(3)
        for frame, value in zip(frames, (position, rate, acceleration), strict=True):
            frame[:, 2, 3] = value
    before, inverse = _parent_from_frame(joint) @ aligned, aligned.T
    return before @ frames[0] @ inverse, before @ frames[1] @ inverse, before @ frames[2] @ inverse


class _Body(NamedTuple):
    """A body in {B}: round about an axis, or the hull of some corners, and the way of these in half a step."""

    link: int  # number of its link
    name: str
    start: Array  # ends of its axis, or of that of a capsule that covers it, shapes (n, 3) [m]
    end: Array
    radius: float  # about that axis [m]
    way: Array  # shape (n,) [m]
    corners: Array | None  # of a convex body, shape (n, k, 3) [m]; None of a round one
    more: float  # by which a convex body is larger all around [m]

    @property
    def points(self) -> Array:
        """Points whose convex hull it is but for `rounding`, shape (n, k, 3) [m]."""
        return np.stack([self.start, self.end], axis=1) if self.corners is None else self.corners

    @property
    def rounding(self) -> float:
        """By which it is larger than the hull of `points`, all around [m]."""
        return self.radius if self.corners is None else self.more


def body_clearances(t: Array, frames: Frames, chain: Chain) -> Iterable[Quantity]:
    """Distances of bodies from boxes and from each other, at each instant and until half way to those beside it.

    Bodies of one link, or of two that meet, may touch. The share is 1 at the surface and above 1 inside. For a box it
    falls to 0 at a distance of half the box's diagonal, for two bodies at the sum of their radii.
    """
    if not chain.has_bodies:
        return
    count = len(t)
    still = np.tile(np.eye(4), (count, 1, 1)), np.zeros((count, 4, 4)), np.zeros((count, 4, 4))
    gaps = np.diff(t)
    half = np.maximum(np.append(gaps, 0.0), np.insert(gaps, 0, 0.0)) / 2
    last = len(chain.joints)
    owners = [(0, still, chain.base), *((k + 1, frames[k], joint.bodies) for k, joint in enumerate(chain.joints))]
    bodies = [
        _body(link, frame, body, half)
        for link, frame, bodies_of_link in (*owners, (last, frames[-1], chain.tool))
        for body in bodies_of_link
    ]
    moving = [body for body in bodies if body.link]
    for box in chain.keep_out:
        if moving:
            columns = [_from_box(body, box) for body in moving]
            limit = Limit(LimitKind.DISTANCE_FROM_BOX, box.name)
            yield Quantity.clear(limit, tuple(body.name for body in moving), np.column_stack(columns), box.vicinity)
    pairs = [
        (a, b)
        for k, a in enumerate(bodies)
        for b in bodies[k + 1 :]
        if chain.keeps_apart(a.link, a.name, b.link, b.name)
    ]
    if pairs:
        labels, reach = (
            tuple(f"{a.name}, {b.name}" for a, b in pairs),
            np.array([a.radius + b.radius for a, b in pairs]),
        )
        yield Quantity.clear(Limit(LimitKind.DISTANCE_BETWEEN_LINKS), labels, _between_all(pairs), reach)


def _body(link: int, frames: tuple[Array, Array, Array], body: Tool, half: Array) -> _Body:
    """A body in {B}, and its way in half a step, shape (n,) [s]: no point between others is faster than all of them."""
    points = np.array(body.points).T
    corners = frames[0][:, :3, :3] @ points + frames[0][:, :3, 3, None]
    speed, acceleration = (_fastest(frame[:, :3, :3] @ points + frame[:, :3, 3, None]) for frame in frames[1:])
    way = (speed + acceleration * half / 2) * half
    if body.corners_mm is None:
        return _Body(link, body.name, corners[:, :, 0], corners[:, :, 1], body.radius, way, None, 0.0)
    start, end = (frames[0][:, :3, :3] @ point + frames[0][:, :3, 3] for point in body.axis)
    every = np.ascontiguousarray(corners.transpose(0, 2, 1))
    return _Body(link, body.name, start, end, body.radius, way, every, body.radius_mm * MM)


def _fastest(vectors: Array) -> Array:
    """Length of the longest of vectors, shape (n, 3, k), at each instant, shape (n,)."""
    return np.asarray(np.sqrt(np.einsum("nik,nik->nk", vectors, vectors).max(axis=1)))


def _from_box(body: _Body, box: KeepOut) -> Array:
    """Distance of a body from a box, shape (n,) [m].

    Of a round one along the axis of the box that separates most, which is less than the true one beside its edges; of
    a convex one the true one where it is closest.
    """
    segment = body.start[:, None], (body.end - body.start)[:, None]
    distance = distance_of_segments(*segment, box.corners)[:, 0] - body.radius
    if body.corners is not None:
        corners = np.array([np.where(upper, box.corners[1], box.corners[0]) for upper in np.ndindex(2, 2, 2)])
        far = np.abs(body.corners).max() + FAR  # a side that is left open is far away
        others = np.broadcast_to(np.clip(corners, -far, far), (len(distance), 8, 3))
        distance = least_separation(body.corners, others, distance + body.more) - body.more
    return np.asarray(distance - body.way)


FAR = 1e3  # [m] beyond every corner, where the open sides of boxes are


def _between_all(pairs: Sequence[tuple[_Body, _Body]]) -> Array:
    """Distances of pairs of bodies, shape (n, pairs) [m]; of convex ones of the closest where they are, else less.

    Those whose capsules come closest go first: of pairs whose capsules stay farther apart than these do, capsules do.
    """
    distances = np.column_stack([_of_capsules(a, b) - a.way - b.way for a, b in pairs])
    least = np.inf
    for k in np.argsort(distances.min(axis=0)):
        one, other = pairs[k]
        if one.corners is not None or other.corners is not None:
            more = one.rounding + other.rounding + one.way + other.way
            points = one.points, other.points
            distances[:, k] = least_separation(*points, distances[:, k] + more, least + more) - more
        least = min(least, float(distances[:, k].min()))
    return distances


def _of_capsules(one: _Body, other: _Body) -> Array:
    """Distance of the capsules of two bodies, shape (n,) [m]: that of their axes less the radii.

    Ericson, Real-Time Collision Detection, 5.1.9.
    """
    d, e, r = one.end - one.start, other.end - other.start, one.start - other.start
    dd, ee, de, dr, er = (np.einsum("ni,ni->n", u, v) for u, v in ((d, d), (e, e), (d, e), (d, r), (e, r)))
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.nan_to_num(np.clip((de * er - dr * ee) / (dd * ee - de**2), 0.0, 1.0))
        t = np.nan_to_num(np.clip((de * s + er) / ee, 0.0, 1.0))
        s = np.nan_to_num(np.clip((de * t - dr) / dd, 0.0, 1.0))
    gap = r + s[:, None] * d - t[:, None] * e
    return np.asarray(np.linalg.norm(gap, axis=1) - one.radius - other.radius)
