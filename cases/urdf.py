"""The chain of joints from the root of a URDF file to its flange, read strictly.

A URDF states geometry, ends, speeds and efforts of joints, and inertias of links; it states no accelerations, jerks or
sensors. Everything on the way to the flange must be sound, and the file as a whole must be a tree; meshes, colours and
transmissions are not read.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element
from xml.parsers import expat

import numpy as np
from pydantic import ValidationError

from cases.chain import LEAST_AXIS
from cases.errors import CaseError
from cases.machine import turned
from cases.sensors import RigidBody, together
from cases.units import MM, Array

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_MOST = 1e6  # of any number, in units of SI: beyond any machine
_COORDINATES = {"revolute": 1, "continuous": 1, "prismatic": 1, "fixed": 0, "planar": 2, "floating": 6}


def rpy(frame: Array) -> Array:
    """Roll, pitch, yaw of a frame in another one, R = Rz(yaw) Ry(pitch) Rx(roll), shape (4, 4) -> (3,) [rad]."""
    r = frame[:3, :3]
    yaw = math.atan2(r[1, 0], r[0, 0])
    (a, _, _), (_, c, d) = (  # rows of Rz(-yaw) R = Ry(pitch) Rx(roll), which no pitch makes singular
        math.cos(yaw) * r[0] + math.sin(yaw) * r[1],
        math.cos(yaw) * r[1] - math.sin(yaw) * r[0],
    )
    return np.array([math.atan2(-d, c), math.atan2(-r[2, 0], a), yaw])


@dataclass(frozen=True)
class UrdfJoint:
    """A joint on the way to the flange, fixed ones before it included."""

    name: str  # name of the joint
    kind: str  # revolute, continuous or prismatic
    place: Array  # its frame in the moved frame of the joint before it, shape (4, 4) [-, m]
    axis: Array  # unit vector in its frame, shape (3,)
    position: tuple[float, float] | None  # lower and upper end [rad or m]; None of a continuous joint
    velocity: float | None  # largest speed [rad/s or m/s]; None of a continuous joint for which the file states none
    # largest torque or force [N m or N]; None where the file states 0 or, of a continuous joint, none
    effort: float | None
    # what it moves up to the next joint, in its moved frame; None where the file states no inertia
    link: RigidBody | None


@dataclass(frozen=True)
class UrdfChain:
    """The way from the root to the flange."""

    base: str  # name of the root link, the frame {B}
    flange: str  # name of the link that carries the sensor
    joints: tuple[UrdfJoint, ...]  # joints that move, from the root to the flange
    mount: Array  # the flange in the last joint's moved frame, shape (4, 4) [-, m]


def read_urdf(file: Path, flange: str | None) -> UrdfChain:
    """The chain of joints that carries a link.

    Args:
        file: URDF, expanded where it was xacro.
        flange: name of the link that carries the sensor.

    Raises:
        CaseError: the file cannot be read or is not a sound tree, no such link, or a joint on the way is not sound; one
            line names file, line, value and remedy.
    """
    tree = _Tree(file, _parsed(file))
    return tree.chain(flange)


_LINE = "#line"  # key of an element's line, which no attribute can have


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
        element = Element(tag, attributes | {_LINE: str(parser.CurrentLineNumber)})
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
        raise CaseError(file, f"line {parser.CurrentLineNumber}", f"is not XML: {error}; correct that line") from error
    (root,) = document
    if root.tag != "robot":
        raise CaseError(file, f"line {root.attrib[_LINE]}", f"holds <{root.tag}>, not <robot>; name a URDF file")
    return root


class _Tree:
    """Links and joints of a file, proven to be a tree."""

    def __init__(self, file: Path, root: Element) -> None:
        self.file = file
        self.links = self._named(root, "link")
        self.joints = self._named(root, "joint")
        self.parent_joint: dict[str, str] = {}
        self.parent_of: dict[str, str] = {}
        for name, joint in self.joints.items():
            parent, child = (self._link_of(name, joint, side) for side in ("parent", "child"))
            if child in self.parent_joint:
                other = self.parent_joint[child]
                self._refuse(joint, f"link {child} has two parents, joints {other} and {name}; remove one of them")
            self.parent_joint[child], self.parent_of[name] = name, parent
        self._require_tree(root)

    def chain(self, flange: str | None) -> UrdfChain:
        """The chain that carries a link; see `read_urdf`."""
        names = ", ".join(self.links)
        if flange is None:
            raise CaseError(self.file, "", f"which link carries the sensor is not said; name it with --flange: {names}")
        if flange not in self.links:
            raise CaseError(self.file, "", f"has no link {flange}; name one of {names} with --flange")
        way: list[str] = []  # names of joints, from the root to the flange
        link = flange
        while link in self.parent_joint:
            way.insert(0, self.parent_joint[link])
            link = self.parent_of[way[0]]
        joints: list[UrdfJoint] = []
        place = np.eye(4)
        for name in way:
            place = place @ self._origin(self.joints[name], f"joint {name}")
            if self._moves(name):
                joints.append(self._joint(name, flange, place))
                place = np.eye(4)
        if not joints:
            raise CaseError(self.file, "", f"no joint moves link {flange}; name another one of {names} with --flange")
        return UrdfChain(link, flange, tuple(joints), place)

    def _named(self, root: Element, tag: str) -> dict[str, Element]:
        elements: dict[str, Element] = {}
        for element in root.findall(tag):
            name = element.get("name", "").strip()
            if not name:
                self._refuse(element, f"a {tag} has no name; give it one")
            if name in elements:
                first = elements[name].attrib[_LINE]
                self._refuse(element, f"{tag} {name} is there twice, first in line {first}; rename one")
            elements[name] = element
        if not elements:
            self._refuse(root, f"the robot has no {tag}; name the complete URDF file")
        return elements

    def _link_of(self, name: str, joint: Element, side: str) -> str:
        ends = joint.findall(side)
        link = ends[0].get("link", "") if len(ends) == 1 else ""
        if not link:
            self._refuse(joint, f"joint {name} has no {side}, or more than one; give it one <{side} link=.. />")
        if link not in self.links:
            self._refuse(ends[0], f"joint {name} has the {side} {link}, but there is no such link; correct the name")
        return link

    def _require_tree(self, root: Element) -> None:
        roots = [link for link in self.links if link not in self.parent_joint]
        if len(roots) > 1:
            second = self.links[roots[1]]
            self._refuse(second, f"links {', '.join(roots)} have no parent, only the root may; join them to it")
        reachable, waiting = set(roots), list(roots)
        while waiting:
            link = waiting.pop()
            children = [child for child, joint in self.parent_joint.items() if self.parent_of[joint] == link]
            reachable.update(children)
            waiting.extend(children)
        loop = [link for link in self.links if link not in reachable]
        if loop:
            self._refuse(self.links[loop[0]], f"links {', '.join(loop)} form a loop; a URDF is a tree, open the loop")

    def _moves(self, name: str) -> bool:
        joint = self.joints[name]
        kind = joint.get("type", "")
        if kind not in _COORDINATES:
            self._refuse(joint, f"joint {name} has the type {kind!r}; URDF knows {', '.join(_COORDINATES)}")
        if _COORDINATES[kind] > 1:
            self._refuse(joint, f"joint {name} is {kind}, which no program moves; choose a --flange before it")
        if (mimic := joint.find("mimic")) is not None:
            self._refuse(mimic, f"joint {name} mimics another one; choose a --flange before it")
        return bool(_COORDINATES[kind])

    def _joint(self, name: str, flange: str, place: Array) -> UrdfJoint:
        """A joint that moves."""
        joint = self.joints[name]
        kind = joint.attrib["type"]
        axis = np.array([1.0, 0.0, 0.0])  # URDF's default
        for element in joint.findall("axis"):
            axis = self._vector(element, "xyz", f"axis of joint {name}")
            if np.linalg.norm(axis) < LEAST_AXIS:
                self._refuse(element, f"the axis of joint {name} has no direction; give one, such as 0 0 1")
        child = next(link for link, parent in self.parent_joint.items() if parent == name)
        bodies = list(self._bodies(child, flange))
        body = reduce(together, bodies) if bodies else None
        numbers = self._limits(name, joint, kind)
        return UrdfJoint(name, kind, place, axis / np.linalg.norm(axis), *numbers, body)

    def _limits(
        self, name: str, joint: Element, kind: str
    ) -> tuple[tuple[float, float] | None, float | None, float | None]:
        """Ends, speed and effort."""
        limit = joint.find("limit")
        if limit is None:
            if kind == "continuous":
                return None, None, None
            self._refuse(joint, f"joint {name} has no limit; add <limit lower=.. upper=.. velocity=.. effort=.. />")
        velocity, effort = (self._number(limit, key, f"limit of joint {name}") for key in ("velocity", "effort"))
        if velocity <= 0.0:
            self._refuse(limit, f"joint {name} has the velocity {velocity:g}; give its largest speed, more than 0")
        if effort < 0.0:
            self._refuse(limit, f"joint {name} has the effort {effort:g}; give its largest torque or force")
        if kind == "continuous":
            return None, velocity, effort or None
        lower, upper = (self._number(limit, key, f"limit of joint {name}") for key in ("lower", "upper"))
        if lower >= upper:
            self._refuse(
                limit, f"joint {name} has lower = {lower:g}, not below upper = {upper:g}; swap or correct them"
            )
        return (lower, upper), velocity, effort or None

    def _bodies(self, first: str, flange: str) -> Iterator[RigidBody]:
        """Inertias of a link and of what is fixed to it, but for what stands behind the flange."""
        waiting = [(first, np.eye(4))]
        while waiting:
            link, at = waiting.pop()
            for inertial in self.links[link].findall("inertial"):
                if (body := self._body(link, inertial, at)) is not None:
                    yield body
            for child, joint in self.parent_joint.items() if link != flange else ():
                if self.parent_of[joint] == link and self.joints[joint].get("type") == "fixed":
                    waiting.append((child, at @ self._origin(self.joints[joint], f"joint {joint}")))

    def _body(self, link: str, inertial: Element, at: Array) -> RigidBody | None:
        masses, tensors = inertial.findall("mass"), inertial.findall("inertia")
        if len(masses) != 1 or len(tensors) != 1:
            self._refuse(
                inertial, f"link {link} has an inertial without one mass and one inertia; add them or remove it"
            )
        mass = self._number(masses[0], "value", f"mass of link {link}")
        entries = {
            key: self._number(tensors[0], key, f"inertia of link {link}")
            for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        }
        if mass == 0.0 and not any(entries.values()):
            return None
        ixx, ixy, ixz, iyy, iyz, izz = entries.values()
        place = at @ self._origin(inertial, f"inertial of link {link}")
        turn = place[:3, :3]
        inertia = turn @ np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]) @ turn.T
        x, y, z = (float(v / MM) for v in place[:3, 3])
        i11, i12, i13, i22, i23, i33 = (float(inertia[i, j]) for i in range(3) for j in range(i, 3))
        try:
            return RigidBody(mass_kg=mass, centre_of_gravity_mm=(x, y, z), inertia_kg_m2=(i11, i12, i13, i22, i23, i33))
        except ValidationError as error:
            words = error.errors(include_url=False)[0]["msg"].removeprefix("Value error, ")
            self._refuse(inertial, f"link {link}: mass {mass:g}: {words}; correct the inertial or remove it")

    def _origin(self, element: Element, of: str) -> Array:
        frame = np.eye(4)
        if (origin := element.find("origin")) is not None:
            frame[:3, 3] = self._vector(origin, "xyz", f"origin of {of}", "0 0 0")
            frame[:3, :3] = turned(self._vector(origin, "rpy", f"origin of {of}", "0 0 0"))
        return frame

    def _vector(self, element: Element, key: str, of: str, default: str | None = None) -> Array:
        text = element.get(key, default)
        words = [] if text is None else text.split()
        if len(words) != 3:
            self._refuse(element, f"{key} of the {of} is {text!r}; give three numbers")
        return np.array([self._checked(element, word, f"{key} of the {of}") for word in words])

    def _number(self, element: Element, key: str, of: str) -> float:
        text = element.get(key)
        if text is None:
            self._refuse(element, f"the {of} has no {key}; add it")
        return self._checked(element, text.strip(), f"{key} of the {of}")

    def _checked(self, element: Element, word: str, name: str) -> float:
        if not _NUMBER.fullmatch(word):
            self._refuse(element, f"{name} is {word!r}, not a number; correct it")
        if abs(float(word)) > _MOST:
            self._refuse(element, f"{name} is {word}, beyond any machine ({_MOST:g}); correct it")
        return float(word)

    def _refuse(self, element: Element, problem: str) -> NoReturn:
        raise CaseError(self.file, f"line {element.attrib[_LINE]}", problem)
