"""The chain of joints from the root of a URDF file to its flange.

A URDF states geometry, ends, speeds and efforts of joints, and inertias of links. The file as a whole must be a tree,
and the geometry on the way to the flange must be sound: all that is not is reported at once. What only says how far,
fast or strongly joints move may be missing or impossible: it counts as not stated, and a note says so.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np
from pydantic import ValidationError

from cases.base.errors import ALSO, CaseError, Code, FileProblem, first_problems, option
from cases.base.file_reading import read_whole
from cases.base.units import DEG, MM, Array
from cases.chain import JOINT_NAME, JOINT_NAME_WORDS, LEAST_AXIS, MOST_JOINTS, Joint, JointLimit
from cases.collision_bodies import covering
from cases.machine import Frame, Tool, turned
from cases.sensors import RigidBody, rigid_body

MOST_BYTES = 8 * 2**20
LONGEST_NAME = 200  # characters of a link or joint
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_LONGEST_NUMBER = 64  # characters
_INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
_MOST = 1e6  # of any number, in units of SI: beyond any machine
_MOVING = ("revolute", "continuous", "prismatic")
_DEEPEST = 5  # robot, link, collision, geometry, mesh: what lies deeper is not read
_LISTED = 40  # names of links that a message lists
_PARENT, _CHILD = "#parent", "#child"
"""Keys of a joint's links, which no attribute can have."""
XACRO = "is xacro, not URDF; expand it first: xacro FILE.urdf.xacro > robot.urdf"
TOOL0 = "tool0"  # ROS-Industrial: the frame that the robot's controller counts tools from
MOST_TURN, MOST_SPEED = 4.0 * math.pi, 20.0  # [rad, rad/s] beyond them numbers look like degrees
MOST_WAY = 20.0  # [m] of an origin or an end, beyond it numbers look like millimetres


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


class _Findings:
    """All that is wrong with a file, and what is only odd: sentences by the links or joints that they are about."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self.odd: dict[tuple[str, str], list[str]] = {}

    def note(self, kind: str, name: str, sentence: str) -> None:
        """Adds a joint or link to those of which a sentence is true."""
        names = self.odd.setdefault((kind, sentence), [])
        if name not in names:
            names.append(name)

    def notes(self) -> tuple[str, ...]:
        """One sentence for each thing that is odd, with the names of all joints or links that it is true of."""
        return tuple(
            f"{kind}{'s' * (len(names) > 1)} {', '.join(names)}: {words}" for (kind, words), names in self.odd.items()
        )

    def require_none(self) -> None:
        if self.problems:
            raise _Unsound(first_problems([*dict.fromkeys(self.problems)]))


class _Unsound(ValueError):
    """The file cannot be used; `problems` are all reasons."""

    def __init__(self, problems: tuple[str, ...]) -> None:
        super().__init__(problems[0])
        self.problems = problems


def read_urdf(file: Path, flange: str | None, sensor: str | None = None) -> Arm:
    """The joints that move the link `flange`, and where it and the link `sensor` (the same, unless given) are.

    Raises:
        CaseError: the file is not a sound tree, not sound on the way to the flange, or has no such links.
    """
    return _read(file, lambda root: _arm(root, flange, sensor, file.parent))


Read = TypeVar("Read")


def _read(file: Path, of: Callable[[Element], Read]) -> Read:
    """What a function makes of a file's root; errors as `read_urdf`."""
    content = b""
    try:
        content = read_whole(file, MOST_BYTES)
        return of(_parsed(content))
    except FileProblem as error:
        raise CaseError(
            file=file, problem=error.problem, remedy="name a readable URDF file", code=Code.UNREADABLE
        ) from error
    except (expat.ExpatError, LookupError) as error:
        unexpanded = b"<xacro:" in content
        raise CaseError(
            file=file, problem=XACRO if unexpanded else f"is not XML: {error}; correct that line", code=Code.DAMAGED
        ) from error
    except _Unsound as error:
        raise CaseError(
            file=file, problem=ALSO.join(error.problems), problems=error.problems, code=Code.WRONG_KIND
        ) from error
    except ValueError as error:
        raise CaseError(file=file, problem=str(error), code=Code.WRONG_KIND) from error


def read_links(file: Path) -> tuple[LinkPlace, ...]:
    """The links of a URDF file, to choose one among them.

    Raises:
        CaseError: the file is not a sound tree.
    """

    def links_of(root: Element) -> tuple[LinkPlace, ...]:
        findings = _Findings()
        links = _named(root, "link", findings)
        carriers = _carriers(root, links, findings)
        findings.require_none()
        chain_links = []
        for name in links:
            way, place = _way(name, carriers), np.eye(4)
            for joint in way:
                place = place @ _origin(joint, _Findings())
            moved_by = sum(joint.get("type") in _MOVING and joint.find("mimic") is None for joint in way)
            chain_links.append(LinkPlace(name, way[-1].attrib[_PARENT] if way else "", place[:3, 3], moved_by))
        return tuple(chain_links)

    return _read(file, links_of)


def _parsed(content: bytes) -> Element:
    """The root with its links and joints; what else stands in a file (controllers, simulators) is not looked at.

    Prefixes need not be declared: extensions of simulators use them as they like.
    """
    builder, parser, path = TreeBuilder(), expat.ParserCreate(), list[str]()

    def kept() -> bool:
        if len(path) > _DEEPEST:
            return False
        return len(path) < 2 or path[1] in ("link", "joint") or path[1].startswith("xacro:")

    def start(tag: str, attributes: dict[str, str]) -> None:
        path.append(tag)
        if kept():
            builder.start(tag, attributes)

    def end(tag: str) -> None:
        if kept():
            builder.end(tag)
        path.pop()

    def doctype(*_: object) -> None:  # what could expand without end, in whatever encoding
        raise ValueError("has a DOCTYPE, which a URDF does not need; remove it")

    parser.StartElementHandler, parser.EndElementHandler, parser.StartDoctypeDeclHandler = start, end, doctype
    parser.Parse(content, True)
    return builder.close()


def _arm(root: Element, flange: str | None, sensor: str | None, folder: Path) -> Arm:
    """As `read_urdf`; raises ValueError."""
    findings = _Findings()
    links = _named(root, "link", findings)
    carriers = _carriers(root, links, findings)
    a_tree = not findings.problems
    for name, link in (("flange", flange), ("sensor", sensor if sensor is not None else flange)):
        if link not in links and not (name == "sensor" and sensor in (None, flange)):
            problem = f"has no link {link}" if link else "does not say which link carries the sensor"
            findings.problems.append(f"{problem}; name one of {_listed(list(links))} with {option(name)}")
    if flange not in links:
        findings.require_none()
    assert flange is not None  # a link's name
    fixed = _fixed_to(carriers) if a_tree else {}
    way = _way(flange, carriers)
    base = way[0].attrib[_PARENT] if way else flange
    moving = [element for element in way if _moves(element, findings)]
    if not moving:
        findings.problems.append(
            f"no joint moves link {flange}; name another one of {_listed(list(links))} as {option('flange')}"
        )
        findings.require_none()
    elif len(moving) > MOST_JOINTS:
        problem = f"{len(moving)} joints move link {flange}, at most {MOST_JOINTS} can"
        findings.problems.append(f"{problem}; name a {option('flange')} nearer to {base}, or fix joints in the file")
        findings.require_none()
    joints, place = list[tuple[Joint, JointLimit]](), np.eye(4)
    for element in way:
        _require_once(element, findings)
        place = place @ _origin(element, findings)
        if element in moving:
            body = _body(_cluster(element.attrib[_CHILD], fixed, flange), links, findings) if a_tree else None
            joints.append(_joint(element, place, body, findings))
            place = np.eye(4)
    if not a_tree:
        findings.require_none()
    behind = dict(_cluster(moving[-1].attrib[_CHILD], fixed))
    if sensor is not None and sensor in links and sensor not in behind:
        problem = f"link {sensor} is not fixed to link {flange}"
        findings.problems.append(f"{problem}; name with {option('sensor')} one that is: {_listed(list(behind))}")
    findings.require_none()
    sensed = place if sensor is None else behind[sensor]
    stated = sensor is not None or _is_controllers(flange, behind, findings)
    starts = [base, *(element.attrib[_CHILD] for element in moving)]
    standing, *bodies = (_bodies(_cluster(start, fixed, flange), links, folder, findings) for start in starts)
    flange_frame = _frame(place) if stated else None
    carrier = sensor if sensor is not None else flange
    carried = [(name, at) for name, at in _cluster(carrier, fixed) if name != carrier]
    load = _body(iter(carried), links, findings)
    heavy = tuple(name for name, _ in carried if links[name].find("inertial") is not None)
    frames = (flange_frame, _frame(sensed))
    tool = _bodies(iter(carried), links, folder, findings)
    return Arm(base, tuple(joints), *frames, findings.notes(), standing, tuple(bodies), load, heavy, tool)


def _bodies(
    cluster: Iterator[tuple[str, Array]], links: Mapping[str, Element], folder: Path, findings: _Findings
) -> tuple[Tool, ...]:
    """Round bodies that cover a link and those fixed to it, in the link's frame."""
    bodies = []
    for name, place in cluster:
        for body in covering(links[name], place, folder, name):
            if isinstance(body, str):
                findings.note("link", name, f"{body}: no round body covers it")
            else:
                bodies.append(body)
    return tuple(bodies)


def _is_controllers(flange: str, behind: Mapping[str, Array], findings: _Findings) -> bool:
    """Whether a flange is where the controller counts tools from: the file has no other link that ROS says is."""
    for link in (link for link in behind if link.endswith(TOOL0)):
        if np.allclose(behind[link], behind[flange], atol=1e-6):
            return True
        findings.note(
            "link",
            flange,
            f"it carries the sensor, but {link} is where ROS-Industrial's robots count tools from; "
            f"machine.chain.flange is left open: give --flange {link} --sensor {flange}, "
            "or state it in the case",
        )
        return False
    return True


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"{', '.join(names[:_LISTED])}{more}"


def _named(root: Element, tag: str, findings: _Findings) -> dict[str, Element]:
    """Links or joints by their names, of which none is there twice."""
    if any(element.tag.startswith("xacro:") for element in root.iter()):
        raise ValueError(XACRO)
    elements: dict[str, Element] = {}
    for element in root.findall(tag):
        name = element.get("name", "").strip()
        if "${" in name:
            raise ValueError(XACRO)
        if not name or name in elements:
            findings.problems.append(f"a {tag} has the name {name[:LONGEST_NAME]!r}; give each {tag} a name of its own")
        elif not name.isprintable() or len(name) > LONGEST_NAME:
            findings.problems.append(
                f"a {tag} has the name {name[:60]!r}; names have no control characters and at most {LONGEST_NAME} "
                "characters, correct it"
            )
        element.set("name", name)
        elements.setdefault(name, element)
    if not elements:
        raise ValueError(f"<{root.tag[:LONGEST_NAME]}> holds no {tag}; name a complete URDF file")
    return elements


def _carriers(root: Element, links: Mapping[str, Element], findings: _Findings) -> dict[str, Element]:
    """The joint that carries each link but the root, and what keeps links and joints from being a tree."""
    carriers: dict[str, Element] = {}
    for name, joint in _named(root, "joint", findings).items():
        for side, key in (("parent", _PARENT), ("child", _CHILD)):
            link = next((end.get("link", "").strip() for end in joint.findall(side)), "")
            if link not in links:
                findings.problems.append(
                    f"joint {name} has the {side} {link[:LONGEST_NAME]!r}, but there is no such link; correct the name"
                )
            joint.set(key, link)
        if (other := carriers.setdefault(link, joint)) is not joint:
            both = f"joints {other.attrib['name']} and {name}"
            findings.problems.append(f"link {link} has two parents, {both}; remove one of them")
    if findings.problems:
        return carriers
    children: dict[str, list[str]] = {}
    for link, joint in carriers.items():
        children.setdefault(joint.attrib[_PARENT], []).append(link)
    waiting = [link for link in links if link not in carriers][:1]
    reachable = set(waiting)
    while waiting:
        more = children.get(waiting.pop(), ())
        reachable.update(more)
        waiting.extend(more)
    if apart := [link for link in links if link not in reachable]:
        findings.problems.append(f"links {_listed(apart)} are not joined to one root; a URDF is a tree, join them")
    return carriers


def _way(link: str, carriers: Mapping[str, Element]) -> list[Element]:
    """Joints from the root to a link; where they go round in a circle, each once."""
    way = dict[str, Element]()
    while link in carriers and link not in way:
        way[link] = carriers[link]
        link = carriers[link].attrib[_PARENT]
    return [*way.values()][::-1]


def _fixed_to(carriers: Mapping[str, Element]) -> dict[str, list[Element]]:
    """Joints that fix a link to each link."""
    fixed: dict[str, list[Element]] = {}
    for joint in carriers.values():
        if joint.get("type") == "fixed":
            fixed.setdefault(joint.attrib[_PARENT], []).append(joint)
    return fixed


def _cluster(link: str, fixed: Mapping[str, list[Element]], flange: str | None = None) -> Iterator[tuple[str, Array]]:
    """A link and all that is fixed to it: name, and place in that link, shape (4, 4) [-, m].

    What stands behind the flange is left out: it is the load's. Origins that are unsound are reported on the way to
    the flange only; elsewhere they are taken as they can be.
    """
    waiting = [(link, np.eye(4))]
    while waiting:
        name, place = waiting.pop()
        yield name, place
        if name != flange:
            waiting.extend((joint.attrib[_CHILD], place @ _origin(joint, _Findings())) for joint in fixed.get(name, ()))


def _require_once(joint: Element, findings: _Findings) -> None:
    """Reports what a joint states twice, each time otherwise: readers of URDF do not agree on which one counts."""
    for tag in ("parent", "child", "origin", "axis", "limit"):
        first, *others = joint.findall(tag) or [joint]
        if any(other.attrib != first.attrib for other in others):
            findings.problems.append(f"joint {joint.attrib['name']} states {tag} more than once; remove all but one")


def _moves(joint: Element, findings: _Findings) -> bool:
    name = joint.attrib["name"]
    kind = "mimic" if joint.find("mimic") is not None else joint.get("type", "")
    if kind not in (*_MOVING, "fixed"):
        problem = f"joint {name} is {kind[:LONGEST_NAME]}, which no program moves"
        findings.problems.append(f"{problem}; choose a {option('flange')} before it, or {', '.join(_MOVING)} or fixed")
    elif kind != "fixed" and not JOINT_NAME.fullmatch(name):
        findings.problems.append(f"joint {name!r} moves, but {JOINT_NAME_WORDS}; give it another name in the file")
    return kind in _MOVING


def _joint(joint: Element, place: Array, link: RigidBody | None, findings: _Findings) -> tuple[Joint, JointLimit]:
    """A joint that moves and its limits, as far as they are stated."""
    name, kind = joint.attrib["name"], joint.attrib["type"]
    axis = np.array([1.0, 0.0, 0.0])  # URDF's default
    for element in joint.findall("axis"):
        axis = _vector(element, "xyz", f"axis of joint {name}", findings)
        if np.linalg.norm(axis) < LEAST_AXIS:
            findings.problems.append(f"the axis of joint {name} has no direction; give one, such as 0 0 1")
            axis = np.array([1.0, 0.0, 0.0])
    slides = kind == "prismatic"
    unit, si, effort_key = ("mm", MM, "force_N") if slides else ("deg", DEG, "torque_Nm")
    limit = joint.find("limit")
    ends = None if kind == "continuous" else _ends(name, limit, slides, findings)
    if kind == "revolute" and ends == (-math.inf, math.inf):
        kind, ends = "continuous", None
        findings.note("joint", name, "its ends are infinite: it is taken as continuous")
    stated = _frame(place).model_dump() | {"name": name, "kind": kind, "axis": tuple(axis / np.linalg.norm(axis))}
    limits = JointLimit.model_construct(name=name)
    if (velocity := _positive(limit, "velocity")) is None:
        findings.note("joint", name, "no velocity above 0 is stated: fill in that of limits.motion")
    else:
        limits = limits.model_copy(update={f"velocity_{unit}_s": velocity / si})
    if (effort := _positive(limit, "effort")) is None:
        findings.note("joint", name, f"no effort above 0 is stated: {effort_key} limits nothing until you state it")
    else:
        stated[effort_key] = effort
    if ends is not None:
        stated[f"position_{unit}"] = ends[0] / si, ends[1] / si
    _note_units(name, slides, ends, velocity or 0.0, findings)
    return Joint.model_construct(**stated, link=link), limits


def _note_units(
    name: str, slides: bool, ends: tuple[float, float] | None, velocity: float, findings: _Findings
) -> None:
    """Notes numbers that look like degrees or millimetres."""
    farthest = max(map(abs, ends or (0.0,)))
    if slides and farthest > MOST_WAY:
        findings.note("joint", name, f"ends beyond {MOST_WAY:g} m look like millimetres: a URDF counts in metres")
    elif not slides and farthest > MOST_TURN + 1e-9:
        findings.note("joint", name, "ends beyond two turns look like degrees: a URDF counts in radians")
    elif not slides and velocity > MOST_SPEED:
        words = f"more than {MOST_SPEED:g} rad/s is fast for an arm: a URDF counts in radians"
        findings.note("joint", name, words)


def _ends(name: str, limit: Element | None, slides: bool, findings: _Findings) -> tuple[float, float] | None:
    """Lower and upper end of a joint [rad or m]; None where the file states none."""
    values = list[float]()
    for key in ("lower", "upper"):
        text = None if limit is None else limit.get(key)
        value = 0.0 if text is None else _number(text)  # 0 is the format's default
        if value is None:
            findings.problems.append(
                f"{key} of the limit of joint {name} is {_shown(text)}; it takes a number, correct it"
            )
            return None
        values.append(value)
    lower, upper = values
    if lower > upper:
        findings.problems.append(f"joint {name} has lower {lower:g}, upper {upper:g}; give lower below upper")
        return None
    if not slides and (lower, upper) == (-math.inf, math.inf):
        return lower, upper
    if lower == upper or not math.isfinite(upper - lower):
        findings.note("joint", name, f"no ends are stated (from {lower:g} to {upper:g}): fill them in")
        return None
    return lower, upper


def _body(cluster: Iterator[tuple[str, Array]], links: Mapping[str, Element], findings: _Findings) -> RigidBody | None:
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
    keys, findings = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), _Findings()
    mass = 0.0 if mass_element is None else _number(mass_element.get("value", "0"))
    entries = [0.0] * 6 if tensor is None else [_number(tensor.get(key, "0")) for key in keys]
    place = _origin(inertial, findings)
    numbers = [value for value in (mass, *entries) if value is not None and math.isfinite(value)]
    if len(numbers) < 7 or findings.problems or numbers[0] < 0.0:
        return None
    mass, ixx, ixy, ixz, iyy, iyz, izz = numbers
    own = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    if mass == 0.0:
        return None if own.any() else (mass, place, own)
    smallest, middle, largest = np.linalg.eigvalsh(own)
    if smallest < -_ROUNDING * largest or smallest + middle < largest * (1.0 - _ROUNDING):
        return None
    return mass, place, own


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


def _origin(element: Element, findings: _Findings) -> Array:
    """Place of a joint or an inertia in its link, shape (4, 4) [-, m]."""
    frame, name = np.eye(4), element.get("name", "")
    of = f"origin of joint {name}" if name else "origin of the inertial"
    if (origin := element.find("origin")) is not None:
        frame[:3, 3] = _vector(origin, "xyz", of, findings, "0 0 0")
        frame[:3, :3] = turned(_vector(origin, "rpy", of, findings, "0 0 0"))
        if name and np.linalg.norm(frame[:3, 3]) > MOST_WAY:
            words = f"an origin beyond {MOST_WAY:g} m looks like millimetres: a URDF counts in metres"
            findings.note("joint", name, words)
    return frame


def _vector(element: Element, key: str, of: str, findings: _Findings, default: str = "") -> Array:
    """Three numbers of an attribute, shape (3,); zeros where they are not, which is reported."""
    text = element.get(key, default)
    if "${" in text:
        raise ValueError(XACRO)
    values = [_number(word) for word in text.split(None, 4)]
    if len(values) == 3:
        x, y, z = values
        if x is not None and y is not None and z is not None and math.isfinite(x + y + z):
            return np.array([x, y, z])
    findings.problems.append(f"{key} of the {of} is {_shown(text)}; it takes 3 of numbers up to {_MOST:g}, correct it")
    return np.zeros(3)


def _positive(limit: Element | None, key: str) -> float | None:
    """A finite number above 0 of an attribute; None where it states something else."""
    value = None if limit is None else _number(limit.get(key, ""))
    return value if value is not None and 0.0 < value < math.inf else None


def _number(text: str) -> float | None:
    """The number that a text is, infinite where it says so or is beyond any machine; None where it is not one."""
    text = text.strip()
    if len(text) > _LONGEST_NUMBER:
        return None
    if _INFINITE.fullmatch(text):
        return float(text)
    if not _NUMBER.fullmatch(text):
        return None
    value = float(text)
    return value if abs(value) <= _MOST else math.copysign(math.inf, value)


def _shown(text: str | None) -> str:
    return repr(text if text is None or len(text) <= 60 else f"{text[:60]}..")
