"""A machine that is a serial chain of joints with the sensor behind the last: a robot, a five-axis table."""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, field_validator, model_validator

from cases.machine import KeepOut, MotionLimits, Tool
from cases.sensors import RigidBody
from cases.tables import Number, Part, Positive, Range, Vector, frozen, kind_of, own_units, si, spelled
from cases.units import DEG, MM, Array

MOST_JOINTS = 12
LEAST_AXIS = 1e-6  # length of an axis below which it has no direction


class ChainFrame(Part):
    """Where a frame lies in the one before it: R = Rz(yaw) Ry(pitch) Rx(roll), as in a URDF."""

    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Its origin in the frame before it."""
    rpy_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of its axes, about fixed axes, in this order."""

    origin: ClassVar = si("origin_mm")  # its origin in the frame before it, shape (3,) [m]
    rpy: ClassVar = si("rpy_deg")  # roll, pitch, yaw, shape (3,) [rad]


class Joint(ChainFrame):
    """A joint and the link behind it, whose frame is the joint's where the joint stands at 0.

    A `continuous` joint turns without end and has no `position_deg`; a `revolute` one has, a `prismatic` one has
    `position_mm`.
    """

    name: Annotated[str, spelled(r"[A-Za-z][\w./-]*", "a name: letters, digits and any of _ . / -, a letter first")]
    """Name of the joint, as in ROS; messages use it."""
    kind: Literal["revolute", "continuous", "prismatic"]
    """Turns between ends (revolute), turns without ends (continuous), or slides (prismatic)."""
    axis: Vector
    """Axis in the joint's own frame, of any length."""
    position_deg: Range | None = None
    """Lower and upper end of the joint."""
    position_mm: Range | None = None
    home_deg: Number | None = None
    """Where programs begin and end; limits of motion are relative to it."""
    home_mm: Number | None = None
    torque_Nm: Positive | None = None
    """Largest torque of the joint's drive; plans use 80 % of it at most, where every joint states its link."""
    force_N: Positive | None = None
    """Largest force of the drive of a joint that slides."""
    link: RigidBody | None = None
    """The link behind the joint, in the joint's moved frame; centre of gravity, and inertia about it."""
    bodies: tuple[Tool, ...] = ()
    """Round bodies that cover the link, in the same frame; they stay out of boxes, and of links farther on."""

    @field_validator("axis")
    @classmethod
    def _directed(cls, value: tuple[float, float, float]) -> tuple[float, float, float]:
        if math.hypot(*value) < LEAST_AXIS:
            raise ValueError("has no direction; give the axis of the joint, such as [0.0, 0.0, 1.0]")
        return value

    @model_validator(mode="after")
    def _of_its_kind(self) -> "Joint":
        own, other = ("deg", "mm") if self.turns else ("mm", "deg")
        position, home = f"position_{own}", f"home_{own}"
        foreign = [f"position_{other}", f"home_{other}", "force_N" if self.turns else "torque_Nm"]
        needed = [home] if self.kind == "continuous" else [home, position]
        for key in (*foreign, position) if self.kind == "continuous" else foreign:
            if getattr(self, key) is not None:
                raise ValueError(f"{self.name} is {self.kind} and has no {key}; remove it or change the kind")
        if missing := [key for key in needed if getattr(self, key) is None]:
            raise ValueError(f"{self.name}: {', '.join(missing)} is missing; a {self.kind} joint has it, add it")
        low, high = self.position
        if not low <= self.home <= high:
            raise ValueError(f"{self.name}: {home} = {getattr(self, home):g} is outside {position}; choose one within")
        return self

    @property
    def turns(self) -> bool:
        """Whether its position is an angle."""
        return self.kind != "prismatic"

    @property
    def unit(self) -> float:
        """SI value of the unit of its keys [rad or m]."""
        return DEG if self.turns else MM

    @property
    def position(self) -> tuple[float, float]:
        """Lower and upper end [rad or m]; infinite of a continuous joint."""
        ends = self.position_deg or self.position_mm
        return (-math.inf, math.inf) if ends is None else (ends[0] * self.unit, ends[1] * self.unit)

    @property
    def home(self) -> float:
        """Where programs begin and end [rad or m]."""
        return (self.home_deg or self.home_mm or 0.0) * self.unit

    @property
    def effort(self) -> float:
        """Largest torque or force of its drive [N m or N]; infinite where the case states none."""
        return self.torque_Nm or self.force_N or math.inf


Joints = TypeVar("Joints", bound="tuple[Joint, ...] | tuple[JointLimit, ...]")


def _distinct(joints: Joints) -> Joints:
    names = [joint.name for joint in joints]
    if twice := [name for k, name in enumerate(names) if name in names[:k]]:
        raise ValueError(f"has two joints {twice[0]}; each joint has a name of its own")
    return joints


class Chain(Part):
    """Joints from the base to the sensor."""

    joints: Annotated[tuple[Joint, ...], Field(min_length=1, max_length=MOST_JOINTS), AfterValidator(_distinct)]
    """Joints from the base to the sensor."""
    sensor: ChainFrame = ChainFrame()
    """The sensor frame {P} in the last joint's moved frame."""
    base: tuple[Tool, ...] = ()
    """Round bodies that stand, in {B}: a pedestal."""
    tool: tuple[Tool, ...] = ()
    """Round bodies behind the sensor, in {P}: tool and workpiece."""
    keep_out: tuple[KeepOut, ...] = ()
    """Boxes in {B} that neither links nor tool may enter: floor, table, neighbour."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(joint.name for joint in self.joints)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of recorded positions, with their units, numbered from the base."""
        return _columns(self.joints)

    @cached_property
    def home(self) -> Array:
        """Coordinates where programs begin and end, shape (n,) [rad or m]."""
        return frozen([joint.home for joint in self.joints])

    @cached_property
    def position(self) -> Array:
        """Lower and upper end of each joint, shape (2, n) [rad or m]; infinite where a joint has none."""
        return frozen([joint.position for joint in self.joints]).T

    @cached_property
    def units(self) -> Array:
        """SI value of degrees or millimetres for each coordinate, shape (n,)."""
        return frozen([joint.unit for joint in self.joints])

    @property
    def limits_effort(self) -> bool:
        """Whether torques of drives are limited: they can be where every link's inertia is stated."""
        efforts = any(math.isfinite(joint.effort) for joint in self.joints)
        return efforts and all(joint.link is not None for joint in self.joints)


class SerialMachine(Part):
    """A machine whose coordinates are the positions of its joints."""

    chain: Chain
    """The joints and links."""


class JointLimit(Part):
    """What an excitation may use of one joint; degrees and radians where it turns, millimetres and metres else."""

    name: str
    """Name of the joint."""
    position_deg: Range | None = None
    """Relative to home."""
    position_mm: Range | None = None
    velocity_deg_s: Positive | None = None
    """Largest velocity."""
    velocity_mm_s: Positive | None = None
    acceleration_rad_s2: Positive | None = None
    """Largest acceleration."""
    acceleration_m_s2: Positive | None = None
    jerk_rad_s3: Positive | None = None
    """Largest jerk."""
    jerk_m_s3: Positive | None = None

    @model_validator(mode="after")
    def _complete(self) -> "JointLimit":
        stated = [key for key in (*_TURNING, *_SLIDING) if getattr(self, key) is not None]
        if set(stated) != set(self.keys):
            turning, sliding = ", ".join(_TURNING), ", ".join(_SLIDING)
            problem = f"{self.name} has {', '.join(stated) or 'no limits'}"
            raise ValueError(f"{problem}; give {turning} where it turns, else {sliding}")
        low, high = getattr(self, position := self.keys[0])
        if not low < 0.0 < high:
            raise ValueError(f"{self.name}: {position} does not contain 0; it is relative to home, widen it")
        return self

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of its position and the derivatives."""
        return _TURNING if all(getattr(self, key) is None for key in _SLIDING) else _SLIDING

    @property
    def turns(self) -> bool:
        """Whether its position is an angle."""
        return self.keys is _TURNING


_TURNING = ("position_deg", "velocity_deg_s", "acceleration_rad_s2", "jerk_rad_s3")
_SLIDING = ("position_mm", "velocity_mm_s", "acceleration_m_s2", "jerk_m_s3")


def _of_joints(order: int) -> cached_property[Array]:
    """Limits of the joints' positions, or of a derivative, in SI."""

    def values(limits: "JointMotionLimits") -> Array:
        keys = [joint.keys[order] for joint in limits.joints]
        stated = [getattr(joint, key) for joint, key in zip(limits.joints, keys, strict=True)]
        return frozen(np.transpose(stated) * own_units(keys))

    return cached_property(values)


class JointMotionLimits(Part):
    """The box in which moving excitations stay: joints relative to home, and their time derivatives."""

    of_pose: ClassVar[bool] = False
    """Whether the coordinates are the pose of a platform; these are the machine's own axes."""
    joints: Annotated[tuple[JointLimit, ...], AfterValidator(_distinct)]
    """Limits of the joints, in the order of the chain."""

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(joint.name for joint in self.joints)

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of the coordinates, with their units, numbered from the base."""
        return _columns(self.joints)

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """Which coordinates are angles, shape (n,)."""
        return np.array([joint.turns for joint in self.joints])

    pose: ClassVar = _of_joints(0)  # lower and upper limit relative to home, shape (2, n) [rad or m]
    rate: ClassVar = _of_joints(1)  # largest rate of each coordinate, shape (n,) [rad/s or m/s]
    acceleration: ClassVar = _of_joints(2)
    """Largest second derivative of each coordinate, shape (n,) [rad/s^2 or m/s^2]."""
    jerk: ClassVar = _of_joints(3)  # largest third derivative of each coordinate, shape (n,) [rad/s^3 or m/s^3]

    @property
    def limits_jerk(self) -> bool:
        """Whether jerks are limited: those of a case are, but not those of every controller."""
        return bool(math.isfinite(max(self.jerk)))

    def without_jerk(self) -> "JointMotionLimits":
        """The limits for a controller whose accelerations step: the jerk is unlimited."""
        free = [joint.model_copy(update={joint.keys[3]: math.inf}) for joint in self.joints]
        return JointMotionLimits.model_construct(joints=tuple(free))


Box = MotionLimits | JointMotionLimits
"""Limits of the coordinates of a machine: of a case, from home, all in SI."""


class Limits(Part):
    """The limits of a case, by kind of excitation."""

    motion: Annotated[Box, kind_of(JointMotionLimits, MotionLimits)]
    """Limits of moving excitations."""


def joint_problems(chain: Chain, limits: JointMotionLimits) -> Iterator[str]:
    """Limits of motion that do not fit the chain, in words that name the keys."""
    names = tuple(limit.name for limit in limits.joints)
    if names != chain.names:
        yield f"limits.motion.joints are {', '.join(names)}; list those of machine.chain: {', '.join(chain.names)}"
        return
    for joint, limit, (low, high) in zip(chain.joints, limits.joints, limits.pose.T + chain.home[:, None], strict=True):
        if joint.turns != limit.turns:
            yield f"limits.motion.joints: {joint.name} is {joint.kind}; give the keys of such a joint"
        elif low < joint.position[0] or high > joint.position[1]:
            ends = " to ".join(f"{end / joint.unit:g}" for end in (low, high))
            own = " to ".join(f"{end / joint.unit:g}" for end in joint.position)
            yield f"limits.motion.joints: {joint.name} moves from {ends}, beyond {own}; narrow the limit or move home"


def _columns(joints: Sequence[Joint | JointLimit]) -> tuple[str, ...]:
    return tuple(f"q{k}_{'deg' if joint.turns else 'mm'}" for k, joint in enumerate(joints, 1))
