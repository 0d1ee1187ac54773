"""The chain of joints from the root of a URDF file to its flange, read strictly.

A URDF states geometry, ends, speeds and efforts of joints, and inertias of links; it states no accelerations, jerks or
sensors. Everything on the way to the flange must be sound, and the file as a whole must be a tree; meshes, colours and
transmissions are not read.
"""

import math
import re
from collections.abc import Iterator, Mapping
from functools import reduce
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element
from xml.parsers import expat

import numpy as np
from pydantic import ValidationError

from cases.chain import LEAST_AXIS, ChainFrame, Joint, JointLimit
from cases.errors import CaseError
from cases.machine import turned
from cases.sensors import RigidBody, rigid_body, together
from cases.units import DEG, MM, Array

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_MOST = 1e6  # of any number, in units of SI: beyond any machine
_COORDINATES = {"revolute": 1, "continuous": 1, "prismatic": 1, "fixed": 0, "planar": 2, "floating": 6}


def read_urdf(file: Path, flange: str | None) -> tuple[str, list[tuple[Joint, JointLimit]], ChainFrame]:
    """The root link, the joints that move a link, from the root on, and the link in the last one's moved frame.

    Joints and their limits are those of a case, as far as a URDF states them: some of their keys are missing. Raises
    CaseError where the file is not a sound tree, or not sound on the way to the link `flange` that carries the sensor.
    """
    root = _parsed(file)
    links = _named(root, "link")
    carriers = _carriers(root, links)
    names = ", ".join(links)
    if flange is None:
        raise CaseError(file, "", f"which link carries the sensor is not said; name it with --flange: {names}")
    if flange not in links:
        raise CaseError(file, "", f"has no link {flange}; name one of {names} with --flange")
    way, base = list[Element](), flange
    while base in carriers:
        way.insert(0, carriers[base])
        base = way[0].attrib[_PARENT]
    joints, place = list[tuple[Joint, JointLimit]](), np.eye(4)
    for element in way:
        place = place @ _origin(element, f"joint {element.attrib['name']}")
        if _moves(element):
            bodies = list(_bodies(element, links, carriers, flange))
            joints.append(_joint(element, place, reduce(together, bodies) if bodies else None))
            place = np.eye(4)
    if not joints:
        raise CaseError(file, "", f"no joint moves link {flange}; name another one of {names} with --flange")
    return base, joints, _frame(place)


_FILE, _LINE, _PARENT, _CHILD = "#file", "#line", "#parent", "#child"
"""Keys of an element's place and of a joint's links, which no attribute can have."""


def _parsed(file: Path) -> Element:
    """The root element, read by expat, which gives line numbers and can refuse a DOCTYPE before anything expands."""
    parser = expat.ParserCreate()
    document = Element("")
    open_elements = [document]

    def refuse(problem: str) -> NoReturn:
        raise CaseError(file, f"line {parser.CurrentLineNumber}", problem)

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag.startswith("xacro:") or any("${" in value or "$(" in value for value in attributes.values()):
            refuse("is xacro, not URDF; expand it first: xacro FILE.urdf.xacro > robot.urdf")
        element = Element(tag, attributes | {_FILE: str(file), _LINE: str(parser.CurrentLineNumber)})
        open_elements[-1].append(element)
        open_elements.append(element)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: open_elements.pop()
    parser.StartDoctypeDeclHandler = lambda *_: refuse("has a DOCTYPE, which a URDF does not need; remove it")
    try:
        parser.Parse(file.read_bytes(), True)
    except CaseError:
        raise
    except OSError as error:
        raise CaseError(file, "", f"cannot be read ({error.strerror}); name a readable URDF file") from error
    except (expat.ExpatError, ValueError, LookupError) as error:
        refuse(f"is not XML: {error}; correct that line")
    (root,) = document
    if root.tag != "robot":
        _refuse(root, f"holds <{root.tag}>, not <robot>; name a URDF file")
    return root


def _refuse(element: Element, problem: str) -> NoReturn:
    raise CaseError(element.attrib[_FILE], f"line {element.attrib[_LINE]}", problem)


def _named(root: Element, tag: str) -> dict[str, Element]:
    """Links or joints by their names, of which none is there twice."""
    elements: dict[str, Element] = {}
    for element in root.findall(tag):
        name = element.get("name", "").strip()
        if not name:
            _refuse(element, f"a {tag} has no name; give it one")
        if name in elements:
            first = elements[name].attrib[_LINE]
            _refuse(element, f"{tag} {name} is there twice, first in line {first}; rename one")
        element.set("name", name)
        elements[name] = element
    if not elements:
        _refuse(root, f"the robot has no {tag}; name the complete URDF file")
    return elements


def _carriers(root: Element, links: Mapping[str, Element]) -> dict[str, Element]:
    """The joint that carries each link but the root, of links and joints that are proven to be a tree."""
    carriers: dict[str, Element] = {}
    for name, joint in _named(root, "joint").items():
        for side, key in (("parent", _PARENT), ("child", _CHILD)):
            ends = joint.findall(side)
            link = ends[0].get("link", "") if len(ends) == 1 else ""
            if not link:
                _refuse(joint, f"joint {name} has no {side}, or more than one; give it one <{side} link=.. />")
            if link not in links:
                _refuse(ends[0], f"joint {name} has the {side} {link}, but there is no such link; correct the name")
            joint.set(key, link)
        if (other := carriers.setdefault(link, joint)) is not joint:
            both = f"joints {other.attrib['name']} and {name}"
            _refuse(joint, f"link {link} has two parents, {both}; remove one of them")
    roots = [link for link in links if link not in carriers]
    if len(roots) > 1:
        _refuse(links[roots[1]], f"links {', '.join(roots)} have no parent, only the root may; join them to it")
    reachable = set(roots)
    while more := {link for link, joint in carriers.items() if joint.attrib[_PARENT] in reachable} - reachable:
        reachable |= more
    loop = [link for link in links if link not in reachable]
    if loop:
        _refuse(links[loop[0]], f"links {', '.join(loop)} form a loop; a URDF is a tree, open the loop")
    return carriers


def _moves(joint: Element) -> bool:
    name, kind = joint.attrib["name"], joint.get("type", "")
    if kind not in _COORDINATES:
        _refuse(joint, f"joint {name} has the type {kind!r}; URDF knows {', '.join(_COORDINATES)}")
    if _COORDINATES[kind] > 1:
        _refuse(joint, f"joint {name} is {kind}, which no program moves; choose a --flange before it")
    if (mimic := joint.find("mimic")) is not None:
        _refuse(mimic, f"joint {name} mimics another one; choose a --flange before it")
    return bool(_COORDINATES[kind])


def _joint(joint: Element, place: Array, link: RigidBody | None) -> tuple[Joint, JointLimit]:
    """A joint that moves and its limits, as far as they are stated."""
    name, kind = joint.attrib["name"], joint.attrib["type"]
    axis = np.array([1.0, 0.0, 0.0])  # URDF's default
    for element in joint.findall("axis"):
        axis = _vector(element, "xyz", f"axis of joint {name}")
        if np.linalg.norm(axis) < LEAST_AXIS:
            _refuse(element, f"the axis of joint {name} has no direction; give one, such as 0 0 1")
    unit, si, effort_key = ("mm", MM, "force_N") if kind == "prismatic" else ("deg", DEG, "torque_Nm")
    stated = _frame(place).model_dump() | {"name": name, "kind": kind, "axis": tuple(axis / np.linalg.norm(axis))}
    limits = JointLimit.model_construct(name=name)
    if (limit := joint.find("limit")) is not None:
        of = f"limit of joint {name}"
        velocity, effort = _number(limit, "velocity", of), _number(limit, "effort", of)
        if velocity <= 0.0:
            _refuse(limit, f"joint {name} has the velocity {velocity:g}; give its largest speed, more than 0")
        if effort < 0.0:
            _refuse(limit, f"joint {name} has the effort {effort:g}; give its largest torque or force")
        limits = limits.model_copy(update={f"velocity_{unit}_s": velocity / si})
        if effort > 0.0:
            stated[effort_key] = effort
        if kind != "continuous":
            lower, upper = _number(limit, "lower", of), _number(limit, "upper", of)
            if lower >= upper:
                _refuse(limit, f"joint {name} has lower = {lower:g}, not below upper = {upper:g}; swap or correct them")
            stated[f"position_{unit}"] = lower / si, upper / si
    elif kind != "continuous":
        _refuse(joint, f"joint {name} has no limit; add <limit lower=.. upper=.. velocity=.. effort=.. />")
    return Joint.model_construct(**stated, link=link), limits


def _bodies(
    joint: Element, links: Mapping[str, Element], carriers: Mapping[str, Element], flange: str
) -> Iterator[RigidBody]:
    """Inertias of the link that a joint moves and of what is fixed to it, but for what stands behind the flange."""
    waiting = [(joint.attrib[_CHILD], np.eye(4))]
    while waiting:
        link, at = waiting.pop()
        for inertial in links[link].findall("inertial"):
            if (body := _body(link, inertial, at)) is not None:
                yield body
        for child, other in carriers.items() if link != flange else ():
            if other.attrib[_PARENT] == link and other.get("type") == "fixed":
                waiting.append((child, at @ _origin(other, f"joint {other.attrib['name']}")))


def _body(link: str, inertial: Element, at: Array) -> RigidBody | None:
    masses, tensors = inertial.findall("mass"), inertial.findall("inertia")
    if len(masses) != 1 or len(tensors) != 1:
        _refuse(inertial, f"link {link} has an inertial without one mass and one inertia; add them or remove it")
    mass = _number(masses[0], "value", f"mass of link {link}")
    ixx, ixy, ixz, iyy, iyz, izz = entries = [
        _number(tensors[0], key, f"inertia of link {link}") for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    ]
    if mass == 0.0 and not any(entries):
        return None
    place = at @ _origin(inertial, f"inertial of link {link}")
    turn = place[:3, :3]
    inertia = turn @ np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]) @ turn.T
    try:
        return rigid_body(mass, place[:3, 3], inertia)
    except ValidationError as error:
        words = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
        _refuse(inertial, f"link {link}: mass {mass:g}: {words}; correct the inertial or remove it")


def _frame(place: Array) -> ChainFrame:
    """A frame in another one, shape (4, 4) [-, m], as the table of a case."""
    r = place[:3, :3]
    yaw = math.atan2(r[1, 0], r[0, 0])
    (a, _, _), (_, c, d) = (  # rows of Rz(-yaw) R = Ry(pitch) Rx(roll), which no pitch makes singular
        math.cos(yaw) * r[0] + math.sin(yaw) * r[1],
        math.cos(yaw) * r[1] - math.sin(yaw) * r[0],
    )
    x, y, z = place[:3, 3] / MM
    roll, pitch = math.atan2(-d, c), math.atan2(-r[2, 0], a)
    return ChainFrame(origin_mm=(x, y, z), rpy_deg=(roll / DEG, pitch / DEG, yaw / DEG))


def _origin(element: Element, of: str) -> Array:
    frame = np.eye(4)
    if (origin := element.find("origin")) is not None:
        frame[:3, 3] = _vector(origin, "xyz", f"origin of {of}", "0 0 0")
        frame[:3, :3] = turned(_vector(origin, "rpy", f"origin of {of}", "0 0 0"))
    return frame


def _vector(element: Element, key: str, of: str, default: str | None = None) -> Array:
    if (text := element.get(key, default)) is None or len(text.split()) != 3:
        _refuse(element, f"{key} of the {of} is {text!r}; give three numbers")
    return np.array([_checked(element, word, f"{key} of the {of}") for word in text.split()])


def _number(element: Element, key: str, of: str) -> float:
    if (text := element.get(key)) is None:
        _refuse(element, f"the {of} has no {key}; add it")
    return _checked(element, text.strip(), f"{key} of the {of}")


def _checked(element: Element, word: str, name: str) -> float:
    if not _NUMBER.fullmatch(word):
        _refuse(element, f"{name} is {word!r}, not a number; correct it")
    if abs(float(word)) > _MOST:
        _refuse(element, f"{name} is {word}, beyond any machine ({_MOST:g}); correct it")
    return float(word)
