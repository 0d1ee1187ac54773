"""Three arms as URDF, from public dimensions, with a force/torque sensor and a tool behind their flanges.

Dimensions, ends, speeds, efforts and masses of links are those of the makers' own descriptions (Kinova
kortex_description, Universal_Robots_ROS2_Description, franka_description); inertias of links are those of round bodies
of such masses.
"""

from dataclasses import dataclass
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
HALF = pi / 2


@dataclass(frozen=True)
class Joint:
    """A joint of an arm, turning about its own z, and the link behind it."""

    xyz: tuple[float, float, float]
    rpy: tuple[float, float, float]
    end: tuple[float, float]  # [rad]; infinite without end
    speed: float  # [rad/s]
    effort: float  # [N m]
    mass: float  # of the link [kg]


@dataclass(frozen=True)
class Arm:
    """An arm, how its sensor is mounted behind its flange, and where its programs begin."""

    name: str
    joints: tuple[Joint, ...]
    flange: tuple[tuple[float, float, float], tuple[float, float, float]]
    sensor: tuple[tuple[float, float, float], tuple[float, float, float]]  # in the flange
    home: tuple[float, ...]  # [rad]
    box: float  # most that joints move from home [rad]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the joints."""
        return tuple(f"joint_{k}" for k in range(1, len(self.joints) + 1))

    def urdf(self, more: str = "") -> str:
        """The description, from `base_link` to `tool0` and the sensor's `ft`; `more` stands at its end."""
        links, joints = ['<link name="base_link"/>'], []
        for k, (name, joint) in enumerate(zip(self.names, self.joints, strict=True), 1):
            small = 0.004 * joint.mass
            body = f'<inertial><origin xyz="0.01 -0.02 0.03"/><mass value="{joint.mass}"/><inertia ixx="{small}" '
            body += f'iyy="{1.2 * small}" izz="{0.8 * small}" ixy="{0.05 * small}" ixz="0" iyz="0"/></inertial>'
            links.append(f'<link name="link_{k}">{body}</link>')
            endless, parent = joint.end[1] == inf, f"link_{k - 1}" if k > 1 else "base_link"
            ends = "" if endless else f'lower="{joint.end[0]}" upper="{joint.end[1]}" '
            joints.append(
                f'<joint name="{name}" type="{"continuous" if endless else "revolute"}"><parent link="{parent}"/>'
                f'<child link="link_{k}"/>{_origin(joint.xyz, joint.rpy)}'
                f'<axis xyz="0 0 1"/><limit {ends}velocity="{joint.speed}" effort="{joint.effort}"/></joint>'
            )
        for link, parent, place in (("tool0", f"link_{len(self.joints)}", self.flange), ("ft", "tool0", self.sensor)):
            links.append(f'<link name="{link}"/>')
            joints.append(
                f'<joint name="to_{link}" type="fixed"><parent link="{parent}"/><child link="{link}"/>'
                f"{_origin(*place)}</joint>"
            )
        return f'<?xml version="1.0"?><robot name="{self.name}">{"".join([*links, *joints])}{more}</robot>'


@dataclass(frozen=True)
class Load:
    """A body on the sensor, in the sensor's frame."""

    mass: float  # [kg]
    centre: tuple[float, float, float]  # [m]
    inertia: tuple[float, float, float, float, float, float]  # xx, xy, xz, yy, yz, zz about it [kg m^2]

    @property
    def urdf(self) -> str:
        """The body as a link behind `ft`."""
        xx, xy, xz, yy, yz, zz = self.inertia
        matrix = f'ixx="{xx}" ixy="{xy}" ixz="{xz}" iyy="{yy}" iyz="{yz}" izz="{zz}"'
        return (
            f'<link name="load"><inertial>{_origin(self.centre, (0.0, 0.0, 0.0))}<mass value="{self.mass}"/>'
            f'<inertia {matrix}/></inertial></link><joint name="to_load" type="fixed"><parent link="ft"/>'
            '<child link="load"/></joint>'
        )


def _origin(xyz: tuple[float, float, float], rpy: tuple[float, float, float]) -> str:
    return f'<origin xyz="{" ".join(map(repr, xyz))}" rpy="{" ".join(map(repr, rpy))}"/>'


def _gen3() -> Arm:
    turns, large, small = (-inf, inf), (1.39, 39.0), (1.22, 9.0)
    return Arm(
        "gen3_like",
        (
            Joint((0.0, 0.0, 0.15643), (pi, 0.0, 0.0), turns, *large, 1.377),
            Joint((0.0, 0.005375, -0.12838), (HALF, 0.0, 0.0), (-2.41, 2.41), *large, 1.163),
            Joint((0.0, -0.21038, -0.006375), (-HALF, 0.0, 0.0), turns, *large, 1.163),
            Joint((0.0, 0.006375, -0.21038), (HALF, 0.0, 0.0), (-2.66, 2.66), *large, 0.93),
            Joint((0.0, -0.20843, -0.006375), (-HALF, 0.0, 0.0), turns, *small, 0.678),
            Joint((0.0, 0.00017505, -0.10593), (HALF, 0.0, 0.0), (-2.23, 2.23), *small, 0.678),
            Joint((0.0, -0.10593, -0.00017505), (-HALF, 0.0, 0.0), turns, *small, 0.364),
        ),
        ((0.0, 0.0, -0.0615), (pi, 0.0, 0.0)),
        ((0.0, 0.0, 0.034), (0.0, 0.0, 0.4)),
        (0.0, 0.26, pi, -1.9, 0.0, 0.96, HALF),
        0.7,
    )


def _ur16e() -> Arm:
    around, slow, fast = (-2 * pi, 2 * pi), (2 * pi / 3, 330.0), (pi, 56.0)
    return Arm(
        "ur16e_like",
        (
            Joint((0.0, 0.0, 0.1807), (0.0, 0.0, 0.0), around, *slow, 7.369),
            Joint((0.0, 0.0, 0.0), (HALF, 0.0, 0.0), around, *slow, 10.45),
            Joint((-0.4784, 0.0, 0.0), (0.0, 0.0, 0.0), (-pi, pi), pi, 150.0, 4.321),
            Joint((-0.36, 0.0, 0.17415), (0.0, 0.0, 0.0), around, *fast, 2.18),
            Joint((0.0, -0.11985, 0.0), (HALF, 0.0, 0.0), around, *fast, 2.033),
            Joint((0.0, 0.11655, 0.0), (HALF, pi, pi), around, *fast, 0.907),
        ),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.04), (0.0, 0.0, -0.8)),
        (0.0, -1.66, -1.4, -1.7, HALF, 0.0),
        0.6,
    )


def _franka() -> Arm:
    big, little = (2.175, 87.0), (2.61, 12.0)
    side, first = (-2.8973, 2.8973), (-1.7628, 1.7628)
    return Arm(
        "franka_like",
        (
            Joint((0.0, 0.0, 0.333), (0.0, 0.0, 0.0), side, *big, 3.0),
            Joint((0.0, 0.0, 0.0), (-HALF, 0.0, 0.0), first, *big, 2.9),
            Joint((0.0, -0.316, 0.0), (HALF, 0.0, 0.0), side, *big, 3.2),
            Joint((0.0825, 0.0, 0.0), (HALF, 0.0, 0.0), (-3.0718, -0.0698), *big, 3.6),
            Joint((-0.0825, 0.384, 0.0), (-HALF, 0.0, 0.0), side, *little, 1.2),
            Joint((0.0, 0.0, 0.0), (HALF, 0.0, 0.0), (-0.0175, 3.7525), *little, 1.7),
            Joint((0.088, 0.0, 0.0), (HALF, 0.0, 0.0), side, *little, 0.7),
        ),
        ((0.0, 0.0, 0.107), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.05), (0.0, 0.0, 0.785)),
        (0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.785),
        0.6,
    )


ARMS = {arm.name: arm for arm in (_gen3(), _ur16e(), _franka())}
LOADS = {
    "gen3_like": Load(1.4, (0.012, -0.021, 0.073), (0.0061, 0.0004, -0.0003, 0.0068, 0.0005, 0.0032)),
    "ur16e_like": Load(4.6, (-0.018, 0.027, 0.094), (0.031, -0.0015, 0.002, 0.036, -0.001, 0.017)),
    "franka_like": Load(1.1, (0.009, 0.014, 0.061), (0.0044, 0.0002, 0.0003, 0.0039, -0.0003, 0.0025)),
}
