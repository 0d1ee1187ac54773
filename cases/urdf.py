"""The chain of joints from the root of a URDF file to its flange.

A URDF states geometry, ends, speeds and efforts of joints, and inertias of links. The file as a whole must be a tree,
and the geometry on the way to the flange must be sound: all that is not is reported at once. What only says how far,
fast or strongly joints move may be missing or impossible: it counts as not stated, and a note says so.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from pydantic import ValidationError

from cases.base.errors import option
from cases.base.phrases import phrase
from cases.base.units import DEG, MM, Array
from cases.chain import JOINT_NAME, JOINT_NAME_WORDS, LEAST_AXIS, MOST_JOINTS, Joint, JointLimit
from cases.collision_bodies import covering
from cases.machine import Frame, Tool
from cases.sensors import RigidBody, rigid_body
from cases.urdf_tree import (
    CHILD,
    LONGEST_NAME,
    MOST_WAY,
    PARENT,
    Findings,
    carriers_of,
    cluster_of,
    fixed_to,
    in_unit,
    link_from_element,
    listed,
    named_elements,
    number_in,
    positive_in,
    read_tree,
    shown,
    vector_of,
    way_to,
)

_MOVING = ("revolute", "continuous", "prismatic")
TOOL0 = "tool0"  # ROS-Industrial: the frame that the robot's controller counts tools from
_SENSOR_WORDS = {"ft", "fts", "force", "torque", "forcetorque", "sensor", "wrench"}  # in names of links
MOST_TURN, MOST_SPEED = 4.0 * math.pi, 20.0  # [rad, rad/s] beyond them numbers look like degrees


class Arm(NamedTuple):
    """What a URDF says of the chain to a flange. Joints and limits are those of a case; some of their keys may lack."""

    base: str  # the root link
    joints: tuple[tuple[Joint, JointLimit], ...]  # those that move a link, from the root on
    flange: Frame | None  # the robot's flange in the last joint's moved frame; None where the file leaves it open
    sensor: Frame  # the sensor in the same frame
    notes: tuple[str, ...]  # what was odd or left out, each a sentence
    # bodies that cover what stands, and the link behind each joint, as far as the file has collision geometry
    standing: tuple[Tool, ...] = ()
    bodies: tuple[tuple[Tool, ...], ...] = ()
    # what is fixed behind the link of the sensor, in its frame, and the links that it is made of; None where the file
    # does not say
    load: RigidBody | None = None
    load_links: tuple[str, ...] = ()
    tool: tuple[Tool, ...] = ()  # bodies that cover it, in the same frame


class LinkPlace(NamedTuple):
    """A link of a URDF file with all joints at 0."""

    name: str
    parent: str  # empty of the root
    origin: Array  # in the root, shape (3,) [m]
    moved_by: int  # joints from the root on that move it


def read_urdf(file: Path, flange: str | None, sensor: str | None = None) -> Arm:
    """The joints that move the link `flange`, and where it and the link `sensor` (the same, unless given) are.

    Raises:
        CaseError: the file is not a sound tree, not sound on the way to the flange, or has no such links.
    """
    return read_tree(file, lambda root: _arm(root, flange, sensor, file.parent))


def read_links(file: Path) -> tuple[LinkPlace, ...]:
    """The links of a URDF file, to choose one among them.

    Raises:
        CaseError: the file is not a sound tree.
    """

    def links_of(root: Element) -> tuple[LinkPlace, ...]:
        findings = Findings()
        links = named_elements(root, "link", findings)
        carriers = carriers_of(root, links, findings)
        findings.require_none()
        chain_links = []
        for name in links:
            way, place = way_to(name, carriers), np.eye(4)
            for joint in way:
                place = place @ link_from_element(joint, Findings())
            moved_by = sum(joint.get("type") in _MOVING and joint.find("mimic") is None for joint in way)
            chain_links.append(LinkPlace(name, way[-1].attrib[PARENT] if way else "", place[:3, 3], moved_by))
        return tuple(chain_links)

    return read_tree(file, links_of)


def _arm(root: Element, flange: str | None, sensor: str | None, folder: Path) -> Arm:
    """As `read_urdf`; raises ValueError."""
    findings = Findings()
    links = named_elements(root, "link", findings)
    carriers = carriers_of(root, links, findings)
    a_tree = not findings.problems
    for name, link in (("flange", flange), ("sensor", sensor if sensor is not None else flange)):
        if link not in links and not (name == "sensor" and sensor in (None, flange)):
            problem = (
                phrase("no_such_link", "has no link {link}", link=link)
                if link
                else phrase("link_of_sensor", "does not say which link carries the sensor")
            )
            findings.problems.append(
                phrase(
                    "name_one_link",
                    "{problem}; name one of {links} with {option}",
                    problem=problem,
                    links=listed(list(links)),
                    option=option(name),
                )
            )
    if flange not in links:
        findings.require_none()
    assert flange is not None  # a link's name
    fixed = fixed_to(carriers) if a_tree else {}
    load_roots = _load_roots(flange, sensor, fixed)
    loaded = {name for root in load_roots for name, _ in cluster_of(root, fixed) if name not in load_roots}
    way = way_to(flange, carriers)
    base = way[0].attrib[PARENT] if way else flange
    moving = [element for element in way if _moves(element, findings)]
    if not moving:
        findings.problems.append(
            phrase(
                "link_stands",
                "no joint moves link {flange}; name another one of {links} as {option}",
                flange=flange,
                links=listed(list(links)),
                option=option("flange"),
            )
        )
        findings.require_none()
    elif len(moving) > MOST_JOINTS:
        findings.problems.append(
            phrase(
                "many_joints",
                "{count} joints move link {flange}, at most {most} can; name a {option} nearer to {base}, or fix "
                "joints in the file",
                count=len(moving),
                flange=flange,
                most=MOST_JOINTS,
                option=option("flange"),
                base=base,
            )
        )
        findings.require_none()
    joints, place = list[tuple[Joint, JointLimit]](), np.eye(4)
    for element in way:
        _require_once(element, findings)
        place = place @ link_from_element(element, findings)
        if element in moving:
            body = _body(cluster_of(element.attrib[CHILD], fixed, load_roots), links, findings) if a_tree else None
            joints.append(_joint(element, place, body, findings))
            place = np.eye(4)
    if not a_tree:
        findings.require_none()
    behind = dict(cluster_of(moving[-1].attrib[CHILD], fixed))
    if sensor is not None and sensor in links and sensor not in behind:
        findings.problems.append(
            phrase(
                "sensor_is_loose",
                "link {sensor} is not fixed to link {flange}; name with {option} one that is: {links}",
                sensor=sensor,
                flange=flange,
                option=option("sensor"),
                links=listed(list(behind)),
            )
        )
    findings.require_none()
    sensed = place if sensor is None else behind[sensor]
    stated = sensor is not None or _is_controllers(flange, behind, findings)
    starts = [base, *(element.attrib[CHILD] for element in moving)]
    standing, *bodies = (_bodies(cluster_of(start, fixed, load_roots), links, folder, findings) for start in starts)
    flange_frame = _frame(place) if stated else None
    if sensor is None:
        _note_sensors(flange, [name for name, _ in cluster_of(flange, fixed)][1:], findings)
    sensor_from_link = np.linalg.inv(sensed)
    carried = [(name, sensor_from_link @ behind[name]) for name in behind if name in loaded]
    load = _body(iter(carried), links, findings)
    heavy = tuple(name for name, _ in carried if links[name].find("inertial") is not None)
    frames = (flange_frame, _frame(sensed))
    tool = _bodies(iter(carried), links, folder, findings)
    return Arm(base, tuple(joints), *frames, findings.notes(), standing, tuple(bodies), load, heavy, tool)


def _load_roots(flange: str, sensor: str | None, fixed: Mapping[str, list[Element]]) -> tuple[str, ...]:
    """Links behind which everything loads the sensor: its own, and the flange where the sensor is not behind that.

    What stands between flange and sensor, as an adapter and the sensor's housing, moves with the last joint. A sensor
    beside the flange is built into the wrist, and the tool that a file fixes to the flange loads it too.
    """
    if sensor is None:
        return (flange,)
    if sensor in [name for name, _ in cluster_of(flange, fixed)]:
        return (sensor,)
    return (sensor,) if flange in [name for name, _ in cluster_of(sensor, fixed)] else (sensor, flange)


def _note_sensors(flange: str, behind: Sequence[str], findings: Findings) -> None:
    """Notes links behind the flange whose names say that one of them is the sensor's."""
    if any(_SENSOR_WORDS & {*re.findall("[a-z]+", name.lower())} for name in behind):
        findings.note(
            "link",
            flange,
            f"behind it stand {listed(behind)}: all of them count as the sensor's load; "
            f"where one is the frame of the sensor, name it as the sensor, and {flange} as the flange",
        )


def _bodies(
    cluster: Iterator[tuple[str, Array]], links: Mapping[str, Element], folder: Path, findings: Findings
) -> tuple[Tool, ...]:
    """Bodies that cover a link and those fixed to it, in the link's frame."""
    bodies = []
    for name, place in cluster:
        for body in covering(links[name], place, folder, name):
            if isinstance(body, str):
                findings.note("link", name, f"{body}: no body covers it")
            else:
                bodies.append(body)
    return tuple(bodies)


def _is_controllers(flange: str, behind: Mapping[str, Array], findings: Findings) -> bool:
    """Whether a flange is where the controller counts tools from: the file has no other link that ROS says is."""
    for link in (link for link in behind if link.endswith(TOOL0)):
        if np.allclose(behind[link], behind[flange], atol=1e-6):
            return True
        findings.note(
            "link",
            flange,
            f"it carries the sensor, but {link} is where ROS-Industrial's robots count tools from; "
            f"machine.chain.flange is left open: name {link} as the flange and {flange} as the sensor, "
            "or state it in the case",
        )
        return False
    return True


def _require_once(joint: Element, findings: Findings) -> None:
    """Reports what a joint states twice, each time otherwise: readers of URDF do not agree on which one counts."""
    for tag in ("parent", "child", "origin", "axis", "limit"):
        first, *others = joint.findall(tag) or [joint]
        if any(other.attrib != first.attrib for other in others):
            findings.problems.append(
                phrase(
                    "states_twice",
                    "joint {name} states {tag} more than once; remove all but one",
                    name=joint.attrib["name"],
                    tag=tag,
                )
            )


def _moves(joint: Element, findings: Findings) -> bool:
    name = joint.attrib["name"]
    kind = "mimic" if joint.find("mimic") is not None else joint.get("type", "")
    if kind not in (*_MOVING, "fixed"):
        findings.problems.append(
            phrase(
                "no_program_moves",
                "joint {name} is {kind}, which no program moves; choose a {option} before it, or {kinds} or fixed",
                name=name,
                kind=kind[:LONGEST_NAME],
                option=option("flange"),
                kinds=", ".join(_MOVING),
            )
        )
    elif kind != "fixed" and not JOINT_NAME.fullmatch(name):
        findings.problems.append(
            phrase(
                "odd_joint_name",
                "joint {name} moves, but {words}; give it another name in the file",
                name=repr(name),
                words=JOINT_NAME_WORDS,
            )
        )
    return kind in _MOVING


def _joint(joint: Element, place: Array, link: RigidBody | None, findings: Findings) -> tuple[Joint, JointLimit]:
    """A joint that moves and its limits, as far as they are stated."""
    name, kind = joint.attrib["name"], joint.attrib["type"]
    axis = np.array([1.0, 0.0, 0.0])  # URDF's default
    for element in joint.findall("axis"):
        axis = vector_of(element, "xyz", f"axis of joint {name}", findings)
        if np.linalg.norm(axis) < LEAST_AXIS:
            findings.problems.append(
                phrase("axis_of_urdf", "the axis of joint {name} has no direction; give one, such as 0 0 1", name=name)
            )
            axis = np.array([1.0, 0.0, 0.0])
    slides = kind == "prismatic"
    unit, si, effort_key = ("mm", MM, "force_N") if slides else ("deg", DEG, "torque_Nm")
    limit = joint.find("limit")
    ends = None if kind == "continuous" else _ends(name, limit, slides, findings)
    if kind == "revolute" and ends == (-math.inf, math.inf):
        kind, ends = "continuous", None
        findings.note("joint", name, "its ends are infinite: it is taken as continuous")
    entries = _frame(place).model_dump() | {"name": name, "kind": kind, "axis": tuple(axis / np.linalg.norm(axis))}
    limits = JointLimit.model_construct(name=name)
    texts = limit.attrib if limit is not None else {}
    if (velocity := positive_in(limit, "velocity")) is None:
        findings.note("joint", name, "no velocity above 0 is stated: fill in that of limits.motion")
    else:
        limits = limits.model_copy(update={f"velocity_{unit}_s": in_unit(texts["velocity"], velocity, si)})
    if (effort := positive_in(limit, "effort")) is None:
        findings.note("joint", name, f"no effort above 0 is stated: {effort_key} limits nothing until you state it")
    else:
        entries[effort_key] = effort
    if ends is not None:
        keys = ("lower", "upper")
        entries[f"position_{unit}"] = tuple(in_unit(texts.get(k, ""), v, si) for k, v in zip(keys, ends, strict=True))
    _note_units(name, slides, ends, velocity or 0.0, findings)
    return Joint.model_construct(**entries, link=link), limits


def _note_units(name: str, slides: bool, ends: tuple[float, float] | None, velocity: float, findings: Findings) -> None:
    """Notes numbers that look like degrees or millimetres."""
    farthest = max(map(abs, ends or (0.0,)))
    if slides and farthest > MOST_WAY:
        findings.note("joint", name, f"ends beyond {MOST_WAY:g} m look like millimetres: a URDF counts in metres")
    elif not slides and farthest > MOST_TURN + 1e-9:
        findings.note("joint", name, "ends beyond two turns look like degrees: a URDF counts in radians")
    elif not slides and velocity > MOST_SPEED:
        words = f"more than {MOST_SPEED:g} rad/s is fast for an arm: a URDF counts in radians"
        findings.note("joint", name, words)


def _ends(name: str, limit: Element | None, slides: bool, findings: Findings) -> tuple[float, float] | None:
    """Lower and upper end of a joint [rad or m]; None where the file states none."""
    values = list[float]()
    for key in ("lower", "upper"):
        text = None if limit is None else limit.get(key)
        value = 0.0 if text is None else number_in(text)  # 0 is the format's default
        if value is None:
            findings.problems.append(
                phrase(
                    "end_of_urdf",
                    "{key} of the limit of joint {name} is {text}; it takes a number, correct it",
                    key=key,
                    name=name,
                    text=shown(text),
                )
            )
            return None
        values.append(value)
    lower, upper = values
    if lower > upper:
        findings.problems.append(
            phrase(
                "ends_exchanged",
                "joint {name} has lower {lower}, upper {upper}; give lower below upper",
                name=name,
                lower=f"{lower:g}",
                upper=f"{upper:g}",
            )
        )
        return None
    if not slides and (lower, upper) == (-math.inf, math.inf):
        return lower, upper
    if lower == upper or not math.isfinite(upper - lower):
        findings.note("joint", name, f"no ends are stated (from {lower:g} to {upper:g}): fill them in")
        return None
    return lower, upper


def _body(cluster: Iterator[tuple[str, Array]], links: Mapping[str, Element], findings: Findings) -> RigidBody | None:
    """The body that a link and those fixed to it are, in the link's frame; None where the file does not say it.

    Masses, first moments and inertias about the link's origin add up, so that points without an inertia of their own
    count where another link has one.
    """
    mass, moment, tensor, heavy, doubtful = 0.0, np.zeros(3), np.zeros((3, 3)), list[str](), list[str]()
    for name, at in cluster:
        for inertial in links[name].findall("inertial"):
            inside = _inertia(inertial)
            if inside is None:
                doubtful.append(name)
            elif inside[0] > 0.0:
                own_mass, own_place, inertia_about_centre = inside
                place = at @ own_place
                arm, turn = place[:3, 3], place[:3, :3]
                mass, moment = mass + own_mass, moment + own_mass * arm
                tensor = (
                    tensor
                    + turn @ inertia_about_centre @ turn.T
                    + own_mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
                )
                heavy.append(name)
    if heavy and not doubtful:
        centre = moment / mass
        try:
            return rigid_body(mass, centre, tensor - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre)))
        except ValidationError:
            doubtful = heavy
    for name in doubtful:
        findings.note("link", name, "no rigid body has its mass and inertia: they are left out, state them yourself")
    return None


def _inertia(inertial: Element) -> tuple[float, Array, Array] | None:
    """Mass, place (4, 4) and inertia (3, 3) of a link; None where no body can have them. 0 where it has none."""
    mass_element, tensor = inertial.find("mass"), inertial.find("inertia")
    keys, findings = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), Findings()
    mass = 0.0 if mass_element is None else number_in(mass_element.get("value", "0"))
    entries = [0.0] * 6 if tensor is None else [number_in(tensor.get(key, "0")) for key in keys]
    place = link_from_element(inertial, findings)
    numbers = [value for value in (mass, *entries) if value is not None and math.isfinite(value)]
    if len(numbers) < 7 or findings.problems or numbers[0] < 0.0:
        return None
    mass, ixx, ixy, ixz, iyy, iyz, izz = numbers
    inertia = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if mass == 0.0:
        return None if inertia.any() else (mass, place, inertia)
    smallest, middle, largest = np.linalg.eigvalsh(inertia)
    if smallest < -_ROUNDING * largest or smallest + middle < largest * (1.0 - _ROUNDING):
        return None
    return mass, place, inertia


_ROUNDING = 1e-3  # share of the largest principal inertia: files state them with few digits


def _frame(place: Array) -> Frame:
    """A frame in another one, shape (4, 4) [-, m], as the table of a case."""
    r = place[:3, :3]
    yaw = math.atan2(r[1, 0], r[0, 0])
    (a, _, _), (_, c, d) = (  # rows of Rz(-yaw) R = Ry(pitch) Rx(roll), which no pitch makes singular
        math.cos(yaw) * r[0] + math.sin(yaw) * r[1],
        math.cos(yaw) * r[1] - math.sin(yaw) * r[0],
    )
    x, y, z = place[:3, 3] / MM
    roll, pitch = math.atan2(-d, c), math.atan2(-r[2, 0], a)
    return Frame(origin_mm=(x, y, z), rpy_deg=(roll / DEG, pitch / DEG, yaw / DEG))
