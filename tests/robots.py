"""Chains that many tests share: a planar arm, one with slides and odd axes, and two robots as URDF.

Dimensions and limits of the robots are those that their makers publish: UR10 (Universal Robots, DH parameters of the
CB3 series), Panda (Franka Emika, Robot and interface specifications); inertias are round numbers.
"""

from collections.abc import Sequence
from math import pi

from cases.chain import Chain
from cases.sensors import RigidBody


def joint(name: str, kind: str = "revolute", **keys: object) -> dict[str, object]:
    """A joint of a case file, with a wide range and home at 0 where nothing else is said."""
    unit = "mm" if kind == "prismatic" else "deg"
    ends = {} if kind == "continuous" else {f"position_{unit}": (-900.0, 900.0)}
    return {"name": name, "kind": kind, "axis": (0.0, 0.0, 1.0), f"home_{unit}": 0.0} | ends | keys


def chain(*joints: dict[str, object], **sensor: object) -> Chain:
    """A chain of such joints; `sensor` has the keys of its mount."""
    return Chain.model_validate({"joints": joints, "sensor": sensor})


def planar(first: float, second: float) -> Chain:
    """Two links in the plane x, y, of some lengths [mm]."""
    return chain(joint("one"), joint("two", origin_mm=(first, 0.0, 0.0)), origin_mm=(second, 0.0, 0.0))


def odd() -> Chain:
    """Seven joints with axes in all directions, two of which slide, and a sensor that is mounted askew."""
    return chain(
        joint("a", origin_mm=(0.0, 0.0, 180.7)),
        joint("b", "prismatic", origin_mm=(10.0, -40.0, 25.0), rpy_deg=(20.0, -35.0, 100.0), axis=(0.0, 3.0, 4.0)),
        joint("c", "continuous", origin_mm=(0.0, 120.0, 0.0), rpy_deg=(90.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0)),
        joint("d", rpy_deg=(0.0, 90.0, 0.0), origin_mm=(612.7, 0.0, 0.0), axis=(1.0, -2.0, 0.5)),
        joint("e", "prismatic", origin_mm=(0.0, 0.0, 99.0), axis=(-1.0, 0.0, 0.0)),
        joint("f", origin_mm=(0.0, 300.0, 0.0), rpy_deg=(0.0, 0.0, 180.0), axis=(0.0, 0.0, -2.0)),
        joint("g", origin_mm=(5.0, 6.0, 7.0), rpy_deg=(-50.0, 10.0, 5.0), axis=(0.0, 1.0, 0.0)),
        origin_mm=(3.0, -8.0, 45.0),
        rpy_deg=(180.0, 15.0, -70.0),
    )


def weighing(of: Chain, effort: float = 100.0) -> Chain:
    """The chain with a link of its own behind each joint, and drives of some strength [N m or N]."""
    joints = []
    for k, found in enumerate(of.joints):
        link = RigidBody(
            mass_kg=1.0 + k / 3,
            centre_of_gravity_mm=(10.0 * k, -20.0, 35.0),
            inertia_kg_m2=(0.02, 0.001 * k, -0.002, 0.03, 0.001, 0.025),
        )
        joints.append(found.model_copy(update={"link": link, "torque_Nm" if found.turns else "force_N": effort}))
    return of.model_copy(update={"joints": tuple(joints)})


Row = tuple[str, str, str, str, str, str, str]
"""A joint of a URDF: name, type, parent, child, xyz, rpy, and what stands inside it."""

_ROUND = "<mass value='{mass}'/><inertia ixx='0.04' ixy='0.002' ixz='0' iyy='0.05' iyz='-0.003' izz='0.03'/>"


def urdf(rows: Sequence[Row], name: str = "robot") -> str:
    """A URDF; each link that is not called base or tool has an inertia, off its frame and turned."""
    links = dict.fromkeys(link for row in rows for link in row[2:4])
    text = "".join(_link(link, 1.0 + k / 4) for k, link in enumerate(links))
    for joint_name, kind, parent, child, xyz, rpy, inside in rows:
        text += (
            f'<joint name="{joint_name}" type="{kind}">\n<parent link="{parent}"/><child link="{child}"/>\n'
            f'<origin xyz="{xyz}" rpy="{rpy}"/>{inside}\n</joint>\n'
        )
    return f'<?xml version="1.0"?>\n<robot name="{name}">\n{text}</robot>\n'


def _link(name: str, mass: float) -> str:
    if name.startswith(("base", "tool", "flange")):
        return f'<link name="{name}"/>\n'
    place = "<origin xyz='0.01 -0.02 0.1' rpy='0.3 -0.2 0.1'/>"
    return f'<link name="{name}"><inertial>{place}{_ROUND.format(mass=mass)}</inertial></link>\n'


def _limit(lower: float, upper: float, velocity: float, effort: float) -> str:
    ends = f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="{effort}"/>'
    return '<axis xyz="0 0 1"/>' + ends


def ur10() -> str:
    """A UR10 from base_link to tool0."""
    slow, wrist = (_limit(-2 * pi, 2 * pi, v, effort) for v, effort in ((2 * pi / 3, 330), (pi, 54)))
    elbow = _limit(-pi, pi, pi, 150)
    half, whole = repr(pi / 2), repr(pi)
    return urdf(
        [
            ("base_fixed", "fixed", "base_link", "base_inertia", "0 0 0", f"0 0 {whole}", ""),
            ("shoulder_pan_joint", "revolute", "base_inertia", "shoulder", "0 0 0.1273", "0 0 0", slow),
            ("shoulder_lift_joint", "revolute", "shoulder", "upper_arm", "0 0 0", f"{half} 0 0", slow),
            ("elbow_joint", "revolute", "upper_arm", "forearm", "-0.612 0 0", "0 0 0", elbow),
            ("wrist_1_joint", "revolute", "forearm", "wrist_1", "-0.5723 0 0.163941", "0 0 0", wrist),
            ("wrist_2_joint", "revolute", "wrist_1", "wrist_2", "0 -0.1157 0", f"{half} 0 0", wrist),
            ("wrist_3_joint", "revolute", "wrist_2", "wrist_3", "0 0.0922 0", f"{half} {whole} {whole}", wrist),
            ("flange_fixed", "fixed", "wrist_3", "flange", "0 0 0", f"0 -{half} -{half}", ""),
            ("tool_fixed", "fixed", "flange", "tool0", "0 0 0", f"{half} 0 {half}", ""),
        ],
        "ur10",
    )


def panda() -> str:
    """A Panda from base to tool, its hand with a finger that mimics the other."""
    ends = [(-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698), (-2.8973, 2.8973)]
    ends += [(-0.0175, 3.7525), (-2.8973, 2.8973)]
    speeds, efforts = [2.175] * 4 + [2.61] * 3, [87] * 4 + [12] * 3
    half = repr(pi / 2)
    places = [("0 0 0.333", "0 0 0"), ("0 0 0", f"-{half} 0 0"), ("0 -0.316 0", f"{half} 0 0")]
    places += [("0.0825 0 0", f"{half} 0 0"), ("-0.0825 0.384 0", f"-{half} 0 0"), ("0 0 0", f"{half} 0 0")]
    places += [("0.088 0 0", f"{half} 0 0")]
    links = ["base", *(f"link{k}" for k in range(1, 8))]
    rows: list[Row] = [
        (f"joint{k + 1}", "revolute", links[k], links[k + 1], *places[k], _limit(*ends[k], speeds[k], efforts[k]))
        for k in range(7)
    ]
    finger = '<axis xyz="0 {}1 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="20"/>'
    rows += [
        ("joint8", "fixed", "link7", "tool", "0 0 0.107", "0 0 0", ""),
        ("hand_joint", "fixed", "tool", "hand", "0 0 0", f"0 0 {-pi / 4!r}", ""),
        ("finger_joint1", "prismatic", "hand", "finger1", "0 0 0.0584", "0 0 0", finger.format("")),
        ("finger_joint2", "prismatic", "hand", "finger2", "0 0 0.0584", "0 0 0", finger.format("-") + MIMIC),
    ]
    return urdf(rows, "panda")


MIMIC = '<mimic joint="finger_joint1"/>'
