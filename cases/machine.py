"""The machine that moves the sensor frame: a hexapod, its reach and its limits of motion."""

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from cases.base.convex import MOST_CORNERS, capsule_around
from cases.base.phrases import Phrase, enumerated, phrase
from cases.base.renamed import renamed
from cases.base.units import DEG, MM, Array, Flags
from cases.table_problems import of_named
from cases.tables import (
    NonNegative,
    Number,
    Part,
    Positive,
    PositiveVector,
    Range,
    Six,
    Text,
    Vector,
    frozen,
    own_units,
    si,
)


def turned(angles: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw, shape (3,) [rad]; shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


class Frame(Part):
    """Where a frame lies in the one before it: R = Rz(yaw) Ry(pitch) Rx(roll), as in a URDF."""

    origin_mm: Vector = (0.0, 0.0, 0.0)
    """Its origin in the frame before it."""
    rpy_deg: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw of its axes, about fixed axes, in this order."""

    origin: ClassVar = si("origin_mm")  # its origin in the frame before it, shape (3,) [m]
    rpy: ClassVar = si("rpy_deg")  # roll, pitch, yaw, shape (3,) [rad]

    @property
    def parent_from_frame(self) -> Array:
        """Its axes and origin in the frame before it, shape (4, 4) [-, m]."""
        parent_from_frame = np.eye(4)
        parent_from_frame[:3, :3], parent_from_frame[:3, 3] = turned(self.rpy), self.origin
        return parent_from_frame


def require_flange(flange: Frame | None, tcp: Frame | None) -> None:
    """Raises ValueError where a robot's tool is stated without the flange that it is counted from."""
    if tcp is not None and flange is None:
        raise ValueError(
            phrase(
                "tcp_without_flange",
                "tcp lies in the flange, which is not stated; add flange = {{ origin_mm = [0.0, 0.0, 0.0] }}",
            )
        )


METRES = 50.0  # times smaller than others: a length that is not in mm, where the machine is singular
WORST_CONDITION = 1e3  # of six lines, moments divided by the size: beyond it errors are amplified a thousandfold


def require_spanning(points: Array, directions: Array, problem: Phrase, remedy: Phrase) -> None:
    """Raises ValueError unless forces along six lines add up to every force and moment.

    Args:
        points: one point on each line, shape (6, 3) [m]; moments are divided by their largest distance from the origin.
        directions: directions of any length but 0, shape (6, 3).
    """
    unit = directions / np.linalg.norm(directions, axis=1)[:, None]
    size = max(float(np.linalg.norm(points, axis=1).max()), 1e-9)
    condition = float(np.linalg.cond(np.hstack([unit, np.cross(points, unit) / size])))
    if not condition <= WORST_CONDITION:
        raise ValueError(
            phrase(
                "not_spanning",
                "{problem} (condition {condition}, at most {most}); {remedy}",
                problem=problem,
                condition=f"{condition:.3g}",
                most=f"{WORST_CONDITION:.0f}",
                remedy=remedy,
            ).about(*remedy.keys)
        )


POSE = ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")
ENDLESS = 1e6  # [mm] half of a side that has no end


class Ring(Part):
    """Six joints on a circle: in three pairs, or by six angles.

    Of pairs the joint order is pair by pair, minus side before plus side, as the drawing in
    [A machine of your own](../own-machine.md) shows. State one of `half_angle_deg` and `included_angle_deg` with
    `pair_centres_deg`, or `angles_deg` alone.
    """

    radius_mm: Positive
    """Radius of the circle."""
    half_angle_deg: Positive | None = None
    """Angle between the centre of a pair and each of its two joints."""
    included_angle_deg: Positive | None = None
    """Angle between the two joints of a pair, twice the half-angle: some drawings state this one."""
    pair_centres_deg: Vector | None = None
    """Directions of the centres of the three pairs, from x towards y."""
    angles_deg: Six | None = None
    """Directions of the six joints, from x towards y, in strut order."""
    z_mm: Number
    """Height of the circle in its frame."""

    @model_validator(mode="after")
    def _one_form(self) -> "Ring":
        pairs = [self.half_angle_deg, self.included_angle_deg]
        alone = self.angles_deg is not None and self.pair_centres_deg is None and pairs == [None, None]
        paired = self.angles_deg is None and self.pair_centres_deg is not None and pairs.count(None) == 1
        if not (alone or paired):
            raise ValueError(
                phrase(
                    "ring_form",
                    "a ring has half_angle_deg or included_angle_deg, one of them, with pair_centres_deg, or "
                    "angles_deg alone; state it so",
                ).about("half_angle_deg", "included_angle_deg", "angles_deg")
            )
        return self

    @property
    def angles(self) -> Array:
        """Directions of the joints, in strut order, shape (6,) [rad]."""
        if self.angles_deg is not None:
            return np.array(self.angles_deg) * DEG
        half = self.half_angle_deg if self.included_angle_deg is None else self.included_angle_deg / 2.0
        assert half is not None  # of pairs, which the form above says
        assert self.pair_centres_deg is not None
        return np.array([(c + s * half) * DEG for c in self.pair_centres_deg for s in (-1, 1)])

    @property
    def points(self) -> Array:
        """Joint positions, shape (6, 3) [m]."""
        return np.array([[self.radius_mm * np.cos(t), self.radius_mm * np.sin(t), self.z_mm] for t in self.angles]) * MM


class Joints(Part):
    """Six points, listed one by one or as a ring; exactly one of the two."""

    points_mm: Annotated[tuple[Vector, ...], Field(min_length=6, max_length=6)] | None = None
    """[x, y, z] of each joint, in strut order."""
    ring: Ring | None = None
    """Joints on a circle, in three pairs."""

    @model_validator(mode="after")
    def _one_form(self) -> "Joints":
        if (self.points_mm is None) == (self.ring is None):
            raise ValueError(
                phrase("points_or_ring", "give either points_mm (six [x, y, z]) or ring, not both or neither")
            )
        return self

    @cached_property
    def points(self) -> Array:
        """Positions, shape (6, 3) [m]."""
        return frozen(self.ring.points if self.ring is not None else np.array(self.points_mm) * MM)


class Pose(Part):
    """A pose of {P} in {B}: position and roll, pitch, yaw about the fixed axes x, y, z."""

    x_mm: Number
    """Position of the origin of {P} in {B}."""
    y_mm: Number
    z_mm: Number
    a_deg: Number
    """Roll, about the fixed axis x; applied first."""
    b_deg: Number
    """Pitch, about the fixed axis y; applied second."""
    c_deg: Number
    """Yaw, about the fixed axis z; applied last."""

    vector: ClassVar = si(*POSE)  # (x, y, z, roll, pitch, yaw), shape (6,) [m, rad]


class HexapodMachine(Part):
    """A hexapod: strut k joins base joint k to platform joint k."""

    base: Joints
    """Base joints in {B}, in strut order."""
    platform: Joints
    """Platform joints in {P}, in strut order."""
    home: Pose
    """Pose in which programs begin and end."""

    @model_validator(mode="after")
    def _stands_firmly(self) -> "HexapodMachine":
        arms = self.platform.points @ turned(self.home.vector[3:]).T
        cure = phrase("similar_hexagons", "joints of base and platform must not form similar hexagons")
        sizes = dict(self._sizes())
        small, large = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
        if 0.0 < sizes[small] < sizes[large] / METRES:
            cure = phrase(
                "length_in_metres",
                "{small} = {size} looks like metres beside {large} = {other}: write {value}",
                small=small,
                size=f"{sizes[small]:.4g}",
                large=large,
                other=f"{sizes[large]:.4g}",
                value=f"{1e3 * sizes[small]:.4g}",
            ).about(*(key.removeprefix("machine.") for key in (small, large)))
        require_spanning(
            arms,
            self.home.vector[:3] + arms - self.base.points,
            phrase("struts_not_spanning", "the struts do not hold the platform at home: it is singular"),
            cure,
        )
        return self

    def _sizes(self) -> Iterator[tuple[str, float]]:
        """Lengths of the machine by their keys [mm]: how far joints lie from their origin, and {P} from {B}."""
        for name, joints in (("base", self.base), ("platform", self.platform)):
            if joints.ring is not None:
                yield f"machine.{name}.ring.radius_mm", joints.ring.radius_mm
            else:
                yield f"machine.{name}.points_mm", float(np.linalg.norm(joints.points, axis=1).max()) / MM
        yield "machine.home.z_mm", float(np.linalg.norm(self.home.vector[:3])) / MM


class KeepOut(Part):
    """A box in {B} that neither platform, struts nor tools may enter; `z_mm` alone is a floor, `x_mm` alone a wall."""

    name: Text
    """What stands there; messages use it."""
    x_mm: Range | None = None
    """Lower and upper limit in {B}; left out, it has no end."""
    y_mm: Range | None = None
    z_mm: Range | None = None

    @model_validator(mode="after")
    def _stands(self) -> "KeepOut":
        if not self._sides():
            raise ValueError(
                phrase(
                    "box_no_side",
                    "{name} has no x_mm, y_mm or z_mm; state one side at least, or nothing may move",
                    name=self.name,
                )
            )
        return self

    def _sides(self) -> list[tuple[float, float]]:
        return [side for side in (self.x_mm, self.y_mm, self.z_mm) if side is not None]

    @cached_property
    def corners(self) -> Array:
        """Lower and upper corner, shape (2, 3) [m]; a side without end is 2 km long."""
        return frozen(np.array([side or (-ENDLESS, ENDLESS) for side in (self.x_mm, self.y_mm, self.z_mm)]).T * MM)

    @property
    def vicinity(self) -> float:
        """Distance at which its share as a limit falls to 0: half the diagonal of its stated sides [m]."""
        return math.hypot(*(high - low for low, high in self._sides())) / 2 * MM


class Tool(Part):
    """A body on the platform, a tool or a workpiece, which must not enter the boxes of `keep_out` either.

    It is round about an axis, or the convex hull of some corners.
    """

    name: Text
    """What it is; messages use it."""
    from_mm: Vector = (0.0, 0.0, 0.0)
    """One end of its axis in {P}, like `to_mm`."""
    to_mm: Vector | None = None
    """The other end; left out where `corners_mm` are stated."""
    corners_mm: Annotated[tuple[Vector, ...], Field(min_length=4, max_length=MOST_CORNERS)] | None = None
    """Corners of a convex body in {P}, in place of an axis. Machines with struts count the capsule around it."""
    radius_mm: NonNegative = 0.0
    """Radius about that axis, or by which the convex body is larger all around."""

    @model_validator(mode="after")
    def _one_shape(self) -> "Tool":
        if (self.to_mm is None) == (self.corners_mm is None):
            raise ValueError(
                of_named(
                    self.name,
                    phrase("axis_or_corners", "state the axis (from_mm, to_mm) or corners_mm, one of them").about(
                        "to_mm", "corners_mm"
                    ),
                )
            )
        if self.corners_mm is not None and "from_mm" in self.model_fields_set:
            raise ValueError(
                of_named(
                    self.name,
                    phrase("from_with_to", "from_mm goes with to_mm; remove it beside corners_mm").about("from_mm"),
                )
            )
        return self

    @cached_property
    def points(self) -> Array:
        """Points whose convex hull is the body without its radius: ends of the axis, or corners, shape (k, 3) [m]."""
        points = (self.from_mm, self.to_mm) if self.corners_mm is None else self.corners_mm
        return frozen(np.array(points, dtype=float) * MM)

    @property
    def beyond(self) -> float:
        """By which the body is larger than the hull of `points`, all around [m]."""
        return self.radius_mm * MM

    @cached_property
    def _capsule(self) -> tuple[Array, float]:
        if self.corners_mm is None:
            return self.points, self.radius_mm * MM
        ends, radius = capsule_around(self.points)
        return frozen(ends), radius + self.radius_mm * MM

    @property
    def axis(self) -> Array:
        """Both ends of the axis in {P} of the body, or of a capsule that covers it, shape (2, 3) [m]."""
        return self._capsule[0]

    @property
    def radius(self) -> float:
        """Radius about `axis` [m]."""
        return self._capsule[1]


class StrutLengths(Part):
    """Lengths that the struts of a machine can have."""

    strut_length_mm: Range
    """Shortest and longest strut, from joint centre to joint centre; in `[limits.motion]` inside that of
    `[workspace]`."""

    strut_length: ClassVar = si("strut_length_mm")  # shortest and longest strut, shape (2,) [m]

    @model_validator(mode="after")
    def _has_length(self) -> Self:
        if self.strut_length_mm[1] <= 0.0:  # a lower end below 0 is no limit
            raise ValueError(
                phrase(
                    "no_length",
                    "strut_length_mm ends at {most} mm; give lengths from joint centre to joint centre",
                    most=f"{self.strut_length_mm[1]:g}",
                ).about("strut_length_mm")
            )
        return self


class Workspace(StrutLengths):
    """What the machine can reach."""

    x_mm: Range
    """Lower and upper limit relative to home."""
    y_mm: Range
    z_mm: Range | None = None
    """The same of the height; left out, the struts alone limit it."""
    base_joint_angle_deg: Positive
    """Largest angle between a strut and the normal of its base joint."""
    platform_joint_angle_deg: Positive
    """Largest angle between a strut and the normal of its platform joint."""
    keep_out: tuple[KeepOut, ...] = ()
    """Boxes that nothing may enter."""
    tool: tuple[Tool, ...] = ()
    """Bodies that the platform carries."""
    strut_radius_mm: NonNegative = 0.0
    """Radius of the struts where they pass the boxes of `keep_out`; 0: they are lines from joint to joint."""

    @cached_property
    def room(self) -> Array:
        """Lower and upper limit of x, y and, where it is stated, z, relative to home, shape (2, 2 or 3) [m]."""
        return frozen(np.array([side for side in (self.x_mm, self.y_mm, self.z_mm) if side is not None]).T * MM)


_ANGULAR_ACCELERATION = "angular_acceleration_rad_s2", "angular_acceleration_deg_s2"
_ANGULAR_JERK = "angular_jerk_rad_s3", "angular_jerk_deg_s3"


@renamed(pose="coordinates")
class MotionLimits(StrutLengths):
    """The box in which moving excitations stay: pose relative to home, and its time derivatives, each coordinate.

    Home may lie on its edge. Of angular acceleration and jerk one key of each is needed, in rad or in deg.
    """

    of_pose: ClassVar[bool] = True  # whether the coordinates are the pose of a platform, else the machine's own axes
    labels: ClassVar[tuple[str, ...]] = ("x", "y", "z", "a", "b", "c")  # names of the coordinates
    columns: ClassVar[tuple[str, ...]] = POSE  # the same of columns, with their units
    turns: ClassVar[Flags] = np.arange(6) >= 3  # which coordinates are angles, shape (6,)
    x_mm: Range
    """Lower and upper limit relative to home."""
    y_mm: Range
    z_mm: Range
    a_deg: Range
    """Lower and upper limit of roll (a), pitch (b) and yaw (c) relative to home."""
    b_deg: Range
    c_deg: Range
    velocity_mm_s: PositiveVector
    """Largest velocity in x, y and z."""
    angular_velocity_deg_s: PositiveVector
    """Largest rate of roll, pitch and yaw."""
    acceleration_m_s2: PositiveVector
    """Largest acceleration in x, y and z."""
    angular_acceleration_rad_s2: PositiveVector | None = None
    """Largest second derivative of roll, pitch and yaw; `angular_acceleration_deg_s2` states it in degrees."""
    angular_acceleration_deg_s2: PositiveVector | None = None
    jerk_m_s3: PositiveVector
    """Largest jerk in x, y and z."""
    angular_jerk_rad_s3: PositiveVector | None = None
    """Largest third derivative of roll, pitch and yaw; `angular_jerk_deg_s3` states it in degrees."""
    angular_jerk_deg_s3: PositiveVector | None = None
    strut_velocity_m_s: Positive
    """Largest velocity of a strut."""
    strut_acceleration_m_s2: Positive
    """Largest acceleration of a strut."""

    @model_validator(mode="after")
    def _home_inside(self) -> "MotionLimits":
        for name in POSE:
            low, high = getattr(self, name)
            if not low <= 0.0 <= high:
                raise ValueError(
                    phrase(
                        "range_without_zero",
                        "{name} = [{low}, {high}] does not contain 0; it is relative to home, widen it",
                        name=name,
                        low=f"{low:g}",
                        high=f"{high:g}",
                    ).about(name)
                )
        return self

    @model_validator(mode="after")
    def _in_one_unit(self) -> "MotionLimits":
        for keys in (_ANGULAR_ACCELERATION, _ANGULAR_JERK):
            present = [key for key in keys if getattr(self, key) is not None]
            if not present:
                raise ValueError(
                    phrase("missing_or", "{key} is missing; add it, or {other}", key=keys[0], other=keys[1]).about(
                        *keys
                    )
                )
            if len(present) > 1:
                raise ValueError(
                    phrase("state_the_same", "{keys} state the same; remove one", keys=enumerated("both", keys)).about(
                        *keys
                    )
                )
        return self

    @cached_property
    def coordinates(self) -> Array:
        """Lower and upper limit relative to home, shape (2, 6) [m, rad]."""
        return frozen(np.transpose([getattr(self, key) for key in POSE]) * own_units(POSE))

    rate: ClassVar = si("velocity_mm_s", "angular_velocity_deg_s")
    """Largest rate of each coordinate, shape (6,) [m/s, rad/s]."""
    acceleration: ClassVar = si("acceleration_m_s2", _ANGULAR_ACCELERATION)
    """Largest second derivative of each coordinate, shape (6,) [m/s^2, rad/s^2]."""
    jerk: ClassVar = si("jerk_m_s3", _ANGULAR_JERK)
    """Largest third derivative of each coordinate, shape (6,) [m/s^3, rad/s^3]."""

    @property
    def limits_jerk(self) -> bool:
        """Whether jerks are limited: those of a case are, but not those of every controller."""
        return bool(np.isfinite(self.jerk).all())

    def with_jerk(self, jerk: Array) -> "MotionLimits":
        """The same with other limits of jerk, shape (6,) [m/s^3, rad/s^3]; infinite: accelerations step."""
        linear, angular = tuple(jerk[:3].tolist()), tuple(jerk[3:].tolist())
        of_angles = dict(zip(_ANGULAR_JERK, (angular, None), strict=True))
        return self.model_copy(update={"jerk_m_s3": linear, **of_angles})


def box_problems(workspace: Workspace, motion: MotionLimits) -> Iterator[str]:
    """Limits of motion that do not fit the workspace, in words that name the keys."""
    for name in ("x_mm", "y_mm", "z_mm"):
        inner, outer = getattr(motion, name), getattr(workspace, name)
        if outer is None:
            continue
        if inner[0] < outer[0] or inner[1] > outer[1]:
            yield phrase(
                "beyond_workspace",
                "limits.motion.{name} = {inner} reaches beyond workspace.{name} = {outer}; narrow it or widen that",
                name=name,
                inner=inner,
                outer=outer,
            ).about(f"limits.motion.{name}", f"workspace.{name}")
    inner, outer = motion.strut_length_mm, workspace.strut_length_mm
    if max(inner[0], outer[0]) >= min(inner[1], outer[1]):
        yield phrase(
            "no_common_length",
            "limits.motion.strut_length_mm and workspace.strut_length_mm have no length in common; correct one",
        ).about("limits.motion.strut_length_mm", "workspace.strut_length_mm")
