"""The chain of joints from the root of a URDF file to its flange, read strictly.

A URDF states geometry, ends, speeds and efforts of joints, and inertias of links. Everything on the way to the flange
must be sound, and the file as a whole must be a tree.
"""

import math
import re
from collections.abc import Iterator, Mapping
from functools import reduce
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from pydantic import ValidationError

from cases.chain import LEAST_AXIS, ChainFrame, Joint, JointLimit
from cases.errors import CaseError
from cases.machine import turned
from cases.sensors import RigidBody, rigid_body, together
from cases.units import DEG, MM, Array

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_MOST = 1e6  # of any number, in units of SI: beyond any machine
_MOVING = ("revolute", "continuous", "prismatic")
_PARENT, _CHILD = "#parent", "#child"
"""Keys of a joint's links, which no attribute can have."""


_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


class _WithoutDoctype(ElementTree.TreeBuilder):
    """Refuses what could expand without end, in whatever encoding."""

    def doctype(self, *_: object) -> None:
        raise ValueError("has a DOCTYPE, which a URDF does not need; remove it")


def read_urdf(file: Path, flange: str | None) -> tuple[str, list[tuple[Joint, JointLimit]], ChainFrame]:
    """The root link, the joints that move a link, from the root on, and the link in the last one's moved frame.

    Joints and their limits are those of a case, as far as a URDF states them: some of their keys are missing. Raises
    CaseError where the file is not a sound tree, or not sound on the way to the link `flange` that carries the sensor.
    """
    try:
        text = file.read_bytes()
        plain = _COMMENT.sub(b"", text)  # xacro keeps comments as they are
        if b"xacro:" in plain or b"${" in plain:
            raise ValueError("is xacro, not URDF; expand it first: xacro FILE.urdf.xacro > robot.urdf")
        return _chain(ElementTree.fromstring(text, ElementTree.XMLParser(target=_WithoutDoctype())), flange)
    except OSError as error:
        raise CaseError(file, "", f"cannot be read ({error.strerror}); name a readable URDF file") from error
    except (ElementTree.ParseError, LookupError) as error:
        raise CaseError(file, "", f"is not XML: {error}; correct that line") from error
    except ValueError as error:
        raise CaseError(file, "", str(error)) from error


def _chain(root: Element, flange: str | None) -> tuple[str, list[tuple[Joint, JointLimit]], ChainFrame]:
    """As `read_urdf`; raises ValueError."""
    links = _named(root, "link")
    carriers = _carriers(root, links)
    if flange not in links:
        problem = f"has no link {flange}" if flange else "does not say which link carries the sensor"
        raise ValueError(f"{problem}; name one of {', '.join(links)} with --flange")
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
        raise ValueError(f"no joint moves link {flange}; name another one of {', '.join(links)} with --flange")
    return base, joints, _frame(place)


def _named(root: Element, tag: str) -> dict[str, Element]:
    """Links or joints by their names, of which none is there twice."""
    elements: dict[str, Element] = {}
    for element in root.findall(tag):
        name = element.get("name", "").strip()
        if not name or name in elements:
            raise ValueError(f"a {tag} has the name {name!r}; give each {tag} a name of its own")
        element.set("name", name)
        elements[name] = element
    if not elements:
        raise ValueError(f"<{root.tag}> holds no {tag}; name a complete URDF file")
    return elements


def _carriers(root: Element, links: Mapping[str, Element]) -> dict[str, Element]:
    """The joint that carries each link but the root, of links and joints that are proven to be a tree."""
    carriers: dict[str, Element] = {}
    for name, joint in _named(root, "joint").items():
        for side, key in (("parent", _PARENT), ("child", _CHILD)):
            link = next((end.get("link", "") for end in joint.findall(side)), "")
            if link not in links:
                raise ValueError(f"joint {name} has the {side} {link!r}, but there is no such link; correct the name")
            joint.set(key, link)
        if (other := carriers.setdefault(link, joint)) is not joint:
            both = f"joints {other.attrib['name']} and {name}"
            raise ValueError(f"link {link} has two parents, {both}; remove one of them")
    reachable = {next((link for link in links if link not in carriers), "")}
    while more := {link for link, joint in carriers.items() if joint.attrib[_PARENT] in reachable} - reachable:
        reachable |= more
    if apart := [link for link in links if link not in reachable]:
        raise ValueError(f"links {', '.join(apart)} are not joined to one root; a URDF is a tree, join them")
    return carriers


def _moves(joint: Element) -> bool:
    kind = "mimic" if joint.find("mimic") is not None else joint.get("type", "")
    if kind not in (*_MOVING, "fixed"):
        problem = f"joint {joint.attrib['name']} is {kind}, which no program moves"
        raise ValueError(f"{problem}; choose a --flange before it, or {', '.join(_MOVING)} or fixed")
    return kind != "fixed"


def _joint(joint: Element, place: Array, link: RigidBody | None) -> tuple[Joint, JointLimit]:
    """A joint that moves and its limits, as far as they are stated."""
    name, kind = joint.attrib["name"], joint.attrib["type"]
    axis = np.array([1.0, 0.0, 0.0])  # URDF's default
    for element in joint.findall("axis"):
        axis = _numbers(element, "xyz", f"axis of joint {name}")
        if np.linalg.norm(axis) < LEAST_AXIS:
            raise ValueError(f"the axis of joint {name} has no direction; give one, such as 0 0 1")
    unit, si, effort_key = ("mm", MM, "force_N") if kind == "prismatic" else ("deg", DEG, "torque_Nm")
    stated = _frame(place).model_dump() | {"name": name, "kind": kind, "axis": tuple(axis / np.linalg.norm(axis))}
    limits = JointLimit.model_construct(name=name)
    if (limit := joint.find("limit")) is not None:
        ends = ("0", "1") if kind == "continuous" else (None, None)
        velocity, effort, lower, upper = (
            float(_numbers(limit, key, f"limit of joint {name}", default)[0])
            for key, default in (("velocity", None), ("effort", None), ("lower", ends[0]), ("upper", ends[1]))
        )
        if velocity <= 0.0 or effort < 0.0 or lower >= upper:
            values = f"velocity {velocity:g}, effort {effort:g}, lower {lower:g}, upper {upper:g}"
            raise ValueError(f"joint {name} has {values}; give a speed, an effort from 0 on, and lower below upper")
        limits = limits.model_copy(update={f"velocity_{unit}_s": velocity / si})
        if effort > 0.0:
            stated[effort_key] = effort
        if kind != "continuous":
            stated[f"position_{unit}"] = lower / si, upper / si
    elif kind != "continuous":
        raise ValueError(f"joint {name} has no limit; add <limit lower=.. upper=.. velocity=.. effort=.. />")
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
    mass_element, tensor = inertial.find("mass"), inertial.find("inertia")
    if mass_element is None or tensor is None:
        raise ValueError(f"link {link} has an inertial without mass or inertia; add them or remove it")
    mass = float(_numbers(mass_element, "value", f"mass of link {link}")[0])
    ixx, ixy, ixz, iyy, iyz, izz = entries = [
        float(_numbers(tensor, key, f"inertia of link {link}")[0]) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
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
        raise ValueError(f"link {link}: mass {mass:g}: {words}; correct the inertial or remove it") from error


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
        frame[:3, 3] = _numbers(origin, "xyz", f"origin of {of}", "0 0 0")
        frame[:3, :3] = turned(_numbers(origin, "rpy", f"origin of {of}", "0 0 0"))
    return frame


def _numbers(element: Element, key: str, of: str, default: str | None = None) -> Array:
    """Numbers of an attribute, shape (3,) of points and angles, else (1,)."""
    text, count = element.get(key, default), 3 if key in ("xyz", "rpy") else 1
    words = "" if text is None else text.split()
    if len(words) != count or any(not _NUMBER.fullmatch(word) or abs(float(word)) > _MOST for word in words):
        raise ValueError(f"{key} of the {of} is {text!r}; it takes {count} of numbers up to {_MOST:g}, correct it")
    return np.array([float(word) for word in words])
