"""A machine that is a serial chain of joints with the sensor behind the last: a robot, a five-axis table."""

import math
import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, field_validator, model_validator

from cases.base.phrases import enumerated, phrase, said
from cases.base.renamed import renamed
from cases.base.units import DEG, MM, Array
from cases.machine import Frame, KeepOut, MotionLimits, Tool, Workspace, require_flange
from cases.sensors import RigidBody
from cases.table_problems import of_named
from cases.tables import (
    NonNegative,
    Number,
    Part,
    Positive,
    Range,
    Text,
    Vector,
    frozen,
    kind_of,
    own_units,
    spelled,
)

MOST_JOINTS = 12
LEAST_AXIS = 1e-6  # length of an axis below which it has no direction


# Not what YAML takes for a number, such as 1e5 or 0x1F: programs of ROS 2 hold names.
JOINT_NAME = re.compile(r"(?=[\w./-]*[^\W\d_])(?!0[xo][0-9a-fA-F_]*$|[0-9._]+e[0-9]+$)\w[\w./-]{0,199}")
JOINT_NAME_WORDS = phrase("joint_names", "names have letters, digits and any of _ . / -, with a letter among them")


class Joint(Frame):
    """A joint and the link behind it, whose frame is the joint's where the joint stands at 0.

    A `continuous` joint turns without end and has no `position_deg`; a `revolute` one has, a `prismatic` one has
    `position_mm`. Evaluation asks for neither ends nor home; limits of motion go with both.
    """

    name: Annotated[str, spelled(JOINT_NAME.pattern, phrase("joint_name", "a name: {words}", words=JOINT_NAME_WORDS))]
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
            raise ValueError(
                phrase("no_direction", "has no direction; give the axis of the joint, such as [0.0, 0.0, 1.0]")
            )
        return value

    @model_validator(mode="after")
    def _of_its_kind(self) -> "Joint":
        unit, other = ("deg", "mm") if self.turns else ("mm", "deg")
        position, home = f"position_{unit}", f"home_{unit}"
        foreign = [f"position_{other}", f"home_{other}", "force_N" if self.turns else "torque_Nm"]
        for key in (*foreign, position) if self.kind == "continuous" else foreign:
            if getattr(self, key) is not None:
                raise ValueError(
                    of_named(
                        self.name,
                        phrase(
                            "not_of_kind",
                            "is {kind} and has no {key}; remove it or change the kind",
                            kind=self.kind,
                            key=key,
                        ).about(key, "kind"),
                    )
                )
        low, high = self.position
        if self.home < low or self.home > high:  # neither, where none is stated
            raise ValueError(
                of_named(
                    self.name,
                    phrase(
                        "home_outside",
                        "{home} = {value} is outside {position}; choose one within",
                        home=home,
                        value=f"{getattr(self, home):g}",
                        position=position,
                    ).about(home, position),
                )
            )
        return self

    @property
    def lacks(self) -> tuple[str, ...]:
        """Keys that it needs to be moved, and does not have."""
        unit = "deg" if self.turns else "mm"
        needed = (f"home_{unit}",) if self.kind == "continuous" else (f"home_{unit}", f"position_{unit}")
        return tuple(key for key in needed if getattr(self, key) is None)

    @property
    def drawn_at(self) -> float:
        """Where pictures have it [rad or m]: at home; without one at 0, or in the middle of its way."""
        low, high = self.position
        if not math.isnan(self.home):
            return self.home
        return 0.0 if low <= 0.0 <= high else (low + high) / 2.0

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
        """Lower and upper end [rad or m]; infinite of a continuous joint, and where the case states none."""
        ends = self.position_deg or self.position_mm
        return (-math.inf, math.inf) if ends is None else (ends[0] * self.unit, ends[1] * self.unit)

    @property
    def home(self) -> float:
        """Where programs begin and end [rad or m]; nan where the case states none, nor limits of motion."""
        position = self.home_deg if self.turns else self.home_mm
        return math.nan if position is None else position * self.unit

    @property
    def effort(self) -> float:
        """Largest torque or force of its drive [N m or N]; infinite where the case states none."""
        return self.torque_Nm or self.force_N or math.inf


Joints = TypeVar("Joints", bound="tuple[Joint, ...] | tuple[JointLimit, ...]")


def _distinct(joints: Joints) -> Joints:
    names = [joint.name for joint in joints]
    if twice := [name for k, name in enumerate(names) if name in names[:k]]:
        raise ValueError(phrase("two_joints", "has two joints {name}; each joint has a name of its own", name=twice[0]))
    return joints


class Chain(Part):
    """Joints from the base to the sensor."""

    joints: Annotated[tuple[Joint, ...], Field(min_length=1, max_length=MOST_JOINTS), AfterValidator(_distinct)]
    """Joints from the base to the sensor."""
    sensor: Frame = Frame()
    """The sensor frame {P} in the last joint's moved frame."""
    flange: Frame | None = None
    """The robot's flange in the same frame, as its controller counts it: payloads are handed to the robot in it."""
    tcp: Frame | None = None
    """The frame of the robot's tool in the flange, as its controller states a TCP: results can be had in it."""
    base: tuple[Tool, ...] = ()
    """Round bodies that stand, in {B}: a pedestal."""
    tool: tuple[Tool, ...] = ()
    """Round bodies behind the sensor, in {P}: tool and workpiece."""
    keep_out: tuple[KeepOut, ...] = ()
    """Boxes in {B} that neither links nor tool may enter: floor, table, neighbour."""
    may_touch: tuple[tuple[Text, Text], ...] = ()
    """Pairs of bodies by their names that are not kept apart: `[["forearm", "hand"]]`. Those of one link, or of two
    that a joint joins, need not be named."""

    @model_validator(mode="after")
    def _bodies_named(self) -> "Chain":
        bodies = [*self.base, *self.tool, *(body for joint in self.joints for body in joint.bodies)]
        known = {body.name for body in bodies}
        if unknown := sorted({name for pair in self.may_touch for name in pair} - known):
            there = ", ".join(sorted(known)) or phrase("none_there", "there are none")
            raise ValueError(
                phrase(
                    "no_such_body",
                    "may_touch names {names}, but no body has that name; name bodies: {there}",
                    names=", ".join(unknown),
                    there=there,
                )
            )
        return self

    def keeps_apart(self, link: int, body: str, other_link: int, other: str) -> bool:
        """Whether two bodies are kept apart: neither of one link, nor of two that meet, nor a pair of `may_touch`.

        Args:
            link: number of the link of the first, 0 of what stands; `other_link` that of the second.
            body: name of the first; `other` that of the second.
        """
        return abs(link - other_link) > 1 and not {(body, other), (other, body)} & {*self.may_touch}

    @model_validator(mode="after")
    def _tcp_in_flange(self) -> "Chain":
        require_flange(self.flange, self.tcp)
        return self

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
        """Coordinates where programs begin and end, shape (n,) [rad or m]; nan where the case states none."""
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
    def has_bodies(self) -> bool:
        """Whether something that moves is kept clear of boxes and of other bodies."""
        return bool(self.tool) or any(joint.bodies for joint in self.joints)

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
    """Largest acceleration; `acceleration_deg_s2` states it in degrees."""
    acceleration_deg_s2: Positive | None = None
    acceleration_m_s2: Positive | None = None
    jerk_rad_s3: Positive | None = None
    """Largest jerk; `jerk_deg_s3` states it in degrees."""
    jerk_deg_s3: Positive | None = None
    jerk_m_s3: Positive | None = None

    @model_validator(mode="after")
    def _complete(self) -> "JointLimit":
        present = {
            key for kind in (_TURNING, _SLIDING) for keys in kind for key in keys if getattr(self, key) is not None
        }
        turning, sliding = ([key for keys in kind for key in keys if key in present] for kind in (_TURNING, _SLIDING))
        both = phrase(
            "limits_of_kind",
            "give {turning} where it turns, else {sliding}",
            turning=_choices(_TURNING),
            sliding=_choices(_SLIDING),
        )
        if not present:
            raise ValueError(of_named(self.name, phrase("no_limits", "no limits are stated; {both}", both=both)))
        if turning and sliding:
            raise ValueError(
                of_named(
                    self.name,
                    phrase(
                        "both_kinds",
                        "{turning} stand beside {sliding}; {both}",
                        turning=", ".join(turning),
                        sliding=", ".join(sliding),
                        both=both,
                    ).about(*turning, *sliding),
                )
            )
        stated_keys = [[key for key in keys if key in present] for keys in self._kind]
        if missing := [keys for keys, found in zip(self._kind, stated_keys, strict=True) if not found]:
            raise ValueError(
                of_named(
                    self.name,
                    phrase("limits_missing", "{keys} not stated; add what is missing", keys=_choices(missing)),
                )
            )
        if twice := [keys for keys in stated_keys if len(keys) > 1]:
            raise ValueError(
                of_named(
                    self.name,
                    phrase(
                        "state_the_same", "{keys} state the same; remove one", keys=enumerated("both", twice[0])
                    ).about(*twice[0]),
                )
            )
        low, high = getattr(self, position := self.keys[0])
        if not low <= 0.0 <= high:
            raise ValueError(
                of_named(
                    self.name,
                    phrase(
                        "without_zero",
                        "{position} does not contain 0; it is relative to home, widen it",
                        position=position,
                    ).about(position),
                )
            )
        return self

    @property
    def _kind(self) -> Sequence[Sequence[str]]:
        return _TURNING if all(getattr(self, key) is None for keys in _SLIDING for key in keys) else _SLIDING

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of its position and the derivatives, as they are stated."""
        return tuple(next((key for key in keys if getattr(self, key) is not None), keys[0]) for keys in self._kind)

    @property
    def turns(self) -> bool:
        """Whether its position is an angle."""
        return self._kind is _TURNING


_TURNING = (
    ("position_deg",),
    ("velocity_deg_s",),
    ("acceleration_rad_s2", "acceleration_deg_s2"),
    ("jerk_rad_s3", "jerk_deg_s3"),
)
_SLIDING = (("position_mm",), ("velocity_mm_s",), ("acceleration_m_s2",), ("jerk_m_s3",))


def _choices(keys: Sequence[Sequence[str]]) -> str:
    return ", ".join(" or ".join(of) for of in keys)


def _of_joints(order: int) -> cached_property[Array]:
    """Limits of the joints' positions, or of a derivative, in SI."""

    def values(limits: "JointMotionLimits") -> Array:
        keys = [joint.keys[order] for joint in limits.joints]
        limits_of_joints = [getattr(joint, key) for joint, key in zip(limits.joints, keys, strict=True)]
        return frozen(np.transpose(limits_of_joints) * own_units(keys))

    return cached_property(values)


@renamed(pose="coordinates")
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

    coordinates: ClassVar = _of_joints(0)  # lower and upper limit relative to home, shape (2, n) [rad or m]
    rate: ClassVar = _of_joints(1)  # largest rate of each coordinate, shape (n,) [rad/s or m/s]
    acceleration: ClassVar = _of_joints(2)
    """Largest second derivative of each coordinate, shape (n,) [rad/s^2 or m/s^2]."""
    jerk: ClassVar = _of_joints(3)  # largest third derivative of each coordinate, shape (n,) [rad/s^3 or m/s^3]

    @property
    def limits_jerk(self) -> bool:
        """Whether jerks are limited: those of a case are, but not those of every controller."""
        return bool(math.isfinite(max(self.jerk)))

    def with_jerk(self, jerk: Array) -> "JointMotionLimits":
        """The same with other limits of jerk, shape (n,) [rad/s^3 or m/s^3]; infinite: accelerations step."""
        keys = [joint.keys[3] for joint in self.joints]
        jerks = (jerk / own_units(keys)).tolist()
        joints = [
            joint.model_copy(update={key: value}) for joint, key, value in zip(self.joints, keys, jerks, strict=True)
        ]
        return JointMotionLimits.model_construct(joints=tuple(joints))


MOST_MARGIN = 10.0  # percent of a way at each of its ends
ENDS = frozenset(
    {f"{axis}_mm" for axis in "xyz"}
    | {f"{axis}_deg" for axis in "abc"}
    | {"strut_length_mm", "position_mm", "position_deg", "base_joint_angle_deg", "platform_joint_angle_deg"}
)
"""Keys of ends of ways in tables of limits."""
PartWithEnds = TypeVar("PartWithEnds", MotionLimits, Workspace, JointLimit, Joint)


Box = MotionLimits | JointMotionLimits
"""Limits of the coordinates of a machine: of a case, from home, all in SI."""


class Margin(Part):
    """What motions that are searched for leave free before each end of a way: of axes, joints, struts, motion boxes.

    It is a share of the way, but not more than a length or an angle. The proof judges by the limits themselves. Motions
    by hand and grids of poses go where they are stated to, and boxes are kept as they are stated: make these larger.
    """

    travel_percent: Annotated[NonNegative, Field(le=MOST_MARGIN)] = 0.5
    """Share of the way from one end to the other; 0 for no margin."""
    most_mm: NonNegative = 1.0
    """Largest margin of a length."""
    most_deg: NonNegative = 0.1
    """Largest margin of an angle: 0.1 degrees move a point at half a metre by 1 mm."""

    def narrowed(self, table: PartWithEnds) -> PartWithEnds:
        """A table in which all ends of ways have moved inwards."""
        ends: dict[str, tuple[float, float] | float] = {}
        for key in ENDS & table.model_fields_set:
            value = getattr(table, key)
            most = self.most_deg if key.endswith("_deg") else self.most_mm
            if isinstance(value, float):  # an angle to any side
                ends[key] = value - min(2.0 * value * self.share, most)
            elif value is not None:
                low, high = value
                margin = min((high - low) * self.share, most)
                ends[key] = low + margin, high - margin
        return table.model_copy(update=ends)

    def of_way(self, low: float, high: float, turns: bool) -> float:
        """Margin of a way between two ends [m], of an angle [rad]; 0 where there are no ends."""
        most = self.most_deg * DEG if turns else self.most_mm * MM
        return min((high - low) * self.share, most) if math.isfinite(high - low) else 0.0

    @property
    def share(self) -> float:
        """Share of a way."""
        return self.travel_percent / 100.0


class Limits(Part):
    """The limits of a case, by kind of excitation."""

    motion: Annotated[Box, kind_of(JointMotionLimits, MotionLimits)]
    """Limits of moving excitations."""
    margin: Margin = Margin()
    """What planned motions leave free before each end of a way."""


def _unmoved(chain: Chain) -> tuple[str, ...]:
    """What joints lack before the chain can be moved, keys behind the names of the joints that lack them."""
    by_keys: dict[tuple[str, ...], list[str]] = {}
    for joint in chain.joints:
        by_keys.setdefault(joint.lacks, []).append(joint.name)
    return tuple(f"{', '.join(names)}: {' and '.join(keys)} missing" for keys, names in by_keys.items() if keys)


def joint_problems(chain: Chain, limits: JointMotionLimits) -> Iterator[str]:
    """Limits of motion that do not fit the chain, in words that name the keys."""
    names = tuple(limit.name for limit in limits.joints)
    if names != chain.names:
        yield phrase(
            "other_joints_listed",
            "limits.motion.joints are {names}; list those of machine.chain: {own}",
            names=", ".join(names),
            own=", ".join(chain.names),
        )
        return
    if lacks := _unmoved(chain):
        yield from (
            phrase("joints_lack", "machine.chain.joints: {what}; limits of motion go with it, add it", what=said(words))
            for words in lacks
        )
        return
    for k, (joint, limit, (low, high)) in enumerate(
        zip(chain.joints, limits.joints, limits.coordinates.T + chain.home[:, None], strict=True), 1
    ):
        if joint.turns != limit.turns:
            yield phrase(
                "keys_of_kind",
                "limits.motion.joints: {name} is {kind}; give the keys of such a joint",
                name=joint.name,
                kind=joint.kind,
            ).about(f"limits.motion.joints[{k}].{limit.keys[0]}")
        elif low < joint.position[0] or high > joint.position[1]:
            ends, own = (
                phrase("from_to", "{low} to {high}", low=f"{pair[0] / joint.unit:g}", high=f"{pair[1] / joint.unit:g}")
                for pair in ((low, high), joint.position)
            )
            yield phrase(
                "joint_beyond",
                "limits.motion.joints: {name} moves from {ends}, beyond {own}; narrow the limit or move home",
                name=joint.name,
                ends=ends,
                own=own,
            ).about(f"limits.motion.joints[{k}].{limit.keys[0]}")


def _columns(joints: Sequence[Joint | JointLimit]) -> tuple[str, ...]:
    return tuple(f"q{k}_{'deg' if joint.turns else 'mm'}" for k, joint in enumerate(joints, 1))
