"""What a case with a chain limits, and how its load moves: in NumPy from the definitions, for the proof.

Frames are homogeneous matrices, multiplied from the base to the sensor; their derivatives follow by the product rule.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cases.chain import Chain, Joint
from cases.chain import ChainFrame as Place
from identification.limited import Quantity, axis_rotation
from identification.motion import Motion

Array = NDArray[np.float64]

_Frames = tuple[Array, Array, Array]


def joint_ranges(motion: Motion, chain: Chain) -> Iterable[Quantity]:
    """Where the joints are, between the ends of each; a joint that turns without end has none."""
    turns = np.array([joint.turns for joint in chain.joints])
    ends = np.isfinite(chain.position).all(axis=0)
    for name, unit, own in (("joint position", "mm", ends & ~turns), ("joint angle", "deg", ends & turns)):
        if own.any():
            labels = tuple(label for label, k in zip(chain.names, own, strict=True) if k)
            low, high = chain.position[:, own]
            yield Quantity.between(name, unit, labels, motion.pose[:, own], low, high, 1.0 / float(chain.units[own][0]))


def frame_motion(motion: Motion, chain: Chain) -> tuple[tuple[Array, Array, Array], Array]:
    """Rotation of the sensor frame with its first and second time derivative, and the acceleration of its origin.

    Returns:
        R, R', R'', shapes (n, 3, 3), and p'', shape (n, 3) [m/s^2], in {B}.
    """
    count = len(motion.t)
    total: _Frames = (np.tile(np.eye(4), (count, 1, 1)), np.zeros((count, 4, 4)), np.zeros((count, 4, 4)))
    for k, joint in enumerate(chain.joints):
        total = _fixed(total, _placed(joint))
        total = _times(total, _moved(joint, motion.pose[:, k], motion.rates[:, k], motion.accelerations[:, k]))
    total = _fixed(total, _placed(chain.sensor))
    place, first, second = total
    return (place[:, :3, :3], first[:, :3, :3], second[:, :3, :3]), second[:, :3, 3]


def _fixed(before: _Frames, then: Array) -> _Frames:
    return before[0] @ then, before[1] @ then, before[2] @ then


def _times(before: _Frames, then: _Frames) -> _Frames:
    (a, a1, a2), (b, b1, b2) = before, then
    return a @ b, a1 @ b + a @ b1, a2 @ b + 2.0 * (a1 @ b1) + a @ b2


def _placed(place: Place) -> Array:
    """A frame in the one before it, shape (4, 4)."""
    still = np.zeros(1)
    x, y, z = (axis_rotation(axis, np.array([angle]), still, still)[0][0] for axis, angle in enumerate(place.rpy))
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = z @ y @ x, place.origin
    return frame


def _moved(joint: Joint, position: Array, rate: Array, acceleration: Array) -> _Frames:
    """What a joint adds: a screw along or a turn about z, between a frame whose z is the axis and back."""
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
    back = aligned.T
    return aligned @ frames[0] @ back, aligned @ frames[1] @ back, aligned @ frames[2] @ back
