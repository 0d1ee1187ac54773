"""Bodies of a chain that touch wherever its joints stand: of a wrist whose links lie in each other."""

from collections.abc import Sequence

import numpy as np

from cases.base.convex import separation
from cases.base.units import MM, Array
from cases.chain import Joint
from cases.machine import Frame, Tool, turned

STATES = 256  # of the joints that are looked at
ENDLESS = 180.0  # [deg] to either side of 0 where a joint has no ends
LONG = 500.0  # [mm] the same


def always_touching(
    joints: Sequence[Joint],
    sensor: Frame,
    standing: Sequence[Tool],
    bodies: Sequence[Sequence[Tool]],
    tool: Sequence[Tool],
) -> tuple[tuple[str, str], ...]:
    """Names of bodies of links that do not meet, but touch in each of `STATES` seeded states of all joints.

    Args:
        joints: from the base to the sensor, with the ends that they state.
        sensor: the sensor's frame behind the last.
        standing: bodies in {B}.
        bodies: of each joint's link, in its frame.
        tool: bodies in the sensor's frame.
    """
    frames = _frames(joints, sensor)
    last = len(joints)
    owners = [(0, frames[0], standing), *((k + 1, frames[k + 1], own) for k, own in enumerate(bodies))]
    placed = [
        (link, body.name, _placed(frame, body), body.radius_mm * MM)
        for link, frame, own in (*owners, (last, frames[-1], tool))
        for body in own
    ]
    return tuple(
        (name, other)
        for k, (link, name, corners, radius) in enumerate(placed)
        for other_link, other, others, other_radius in placed[k + 1 :]
        if abs(link - other_link) > 1 and np.all(separation(corners, others) <= radius + other_radius)
    )


def _frames(joints: Sequence[Joint], sensor: Frame) -> list[Array]:
    """Frames of the base, of each moved joint and of the sensor in {B}, shape (STATES, 4, 4) [-, m]."""
    random = np.random.default_rng(0)
    frames = [np.tile(np.eye(4), (STATES, 1, 1))]
    for joint in joints:
        ends = joint.position_deg or joint.position_mm
        far = ENDLESS if joint.turns else LONG
        low, high = ends if ends is not None else (-far, far)
        positions = random.uniform(low, high, STATES) * joint.unit
        frames.append(frames[-1] @ _frame(joint) @ _moved(joint, positions))
    frames.append(frames[-1] @ _frame(sensor))
    return frames


def _frame(place: Frame) -> Array:
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = turned(place.rpy), place.origin
    return frame


def _moved(joint: Joint, positions: Array) -> Array:
    """Turns about the axis of a joint, or ways along it, shape (n, 4, 4)."""
    axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
    frames = np.tile(np.eye(4), (len(positions), 1, 1))
    if not joint.turns:
        frames[:, :3, 3] = positions[:, None] * axis
        return frames
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, versed = np.sin(positions)[:, None, None], 1.0 - np.cos(positions)[:, None, None]
    frames[:, :3, :3] = np.eye(3) + sine * cross + versed * (cross @ cross)  # Rodrigues
    return frames


def _placed(frame: Array, body: Tool) -> Array:
    """Points whose hull, larger by its radius, is a body, in {B}, shape (STATES, k, 3) [m]."""
    points: Array = np.einsum("nij,kj->nki", frame[:, :3, :3], body.points) + frame[:, None, :3, 3]
    return points
