"""The tree of links and joints of a URDF file, read strictly: what is not sound is reported, all of it at once."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np

from cases.base.errors import CaseError, Code, FileProblem, first_problems
from cases.base.file_reading import read_whole
from cases.base.phrases import Phrase, enumerated, phrase
from cases.base.units import DEG, Array
from cases.machine import turned

MOST_BYTES = 8 * 2**20
LONGEST_NAME = 200  # characters of a link or joint
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_DECIMALS = re.compile(r"[+-]?\d*\.\d{4,}")  # of a number that was rounded, where it has so many
_LONGEST_NUMBER = 64  # characters
_INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
_MOST = 1e6  # of any number, in units of SI: beyond any machine
_DEEPEST = 5  # robot, link, collision, geometry, mesh: what lies deeper is not read
_LISTED = 40  # names of links that a message lists
XACRO = phrase("is_xacro", "is xacro, not URDF; expand it first: xacro FILE.urdf.xacro > robot.urdf")
MOST_WAY = 20.0  # [m] of an origin or an end, beyond it numbers look like millimetres
PARENT, CHILD = "#parent", "#child"
"""Keys of a joint's links, which no attribute can have."""


class Findings:
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
        """Raises Unsound with all that is wrong."""
        if self.problems:
            raise Unsound(first_problems([*dict.fromkeys(self.problems)]))


class Unsound(ValueError):
    """The file cannot be used; `problems` are all reasons."""

    def __init__(self, problems: tuple[str, ...]) -> None:
        super().__init__(problems[0])
        self.problems = problems


Read = TypeVar("Read")


def read_tree(file: Path, of: Callable[[Element], Read]) -> Read:
    """What a function makes of a file's root; errors as `read_urdf`."""
    content = b""
    try:
        content = read_whole(file, MOST_BYTES)
        return of(_parsed(content))
    except FileProblem as error:
        raise CaseError(
            file=file,
            problem=error.problem,
            remedy=phrase("name_urdf", "name a readable URDF file"),
            code=Code.UNREADABLE,
        ) from error
    except (expat.ExpatError, LookupError) as error:
        unexpanded = b"<xacro:" in content
        raise CaseError(
            file=file,
            problem=XACRO if unexpanded else phrase("not_xml", "is not XML: {error}; correct that line", error=error),
            code=Code.DAMAGED,
        ) from error
    except Unsound as error:
        raise CaseError(
            file=file, problem=enumerated("problems", error.problems), problems=error.problems, code=Code.WRONG_KIND
        ) from error
    except ValueError as error:
        (problem,) = error.args or ("",)
        raise CaseError(
            file=file, problem=problem if isinstance(problem, Phrase) else str(error), code=Code.WRONG_KIND
        ) from error


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


def listed(names: Sequence[str]) -> str:
    """Names as a message can list them."""
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return f"{', '.join(names[:_LISTED])}{more}"


def named_elements(root: Element, tag: str, findings: Findings) -> dict[str, Element]:
    """Links or joints by their names, of which none is there twice."""
    if any(element.tag.startswith("xacro:") for element in root.iter()):
        raise ValueError(XACRO)
    elements: dict[str, Element] = {}
    for element in root.findall(tag):
        name = element.get("name", "").strip()
        if "${" in name:
            raise ValueError(XACRO)
        if not name or name in elements:
            findings.problems.append(
                phrase(
                    "names_of_urdf",
                    "a {tag} has the name {name}; give each {tag} a name of its own",
                    tag=tag,
                    name=repr(name[:LONGEST_NAME]),
                )
            )
        elif not name.isprintable() or len(name) > LONGEST_NAME:
            findings.problems.append(
                f"a {tag} has the name {name[:60]!r}; names have no control characters and at most {LONGEST_NAME} "
                "characters, correct it"
            )
        element.set("name", name)
        elements.setdefault(name, element)
    if not elements:
        raise ValueError(
            phrase(
                "holds_no_tag",
                "<{root}> holds no {tag}; name a complete URDF file",
                root=root.tag[:LONGEST_NAME],
                tag=tag,
            )
        )
    return elements


def carriers_of(root: Element, links: Mapping[str, Element], findings: Findings) -> dict[str, Element]:
    """The joint that carries each link but the root, and what keeps links and joints from being a tree."""
    carriers: dict[str, Element] = {}
    for name, joint in named_elements(root, "joint", findings).items():
        for side, key in (("parent", PARENT), ("child", CHILD)):
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
        children.setdefault(joint.attrib[PARENT], []).append(link)
    waiting = [link for link in links if link not in carriers][:1]
    reachable = set(waiting)
    while waiting:
        more = children.get(waiting.pop(), ())
        reachable.update(more)
        waiting.extend(more)
    if unreachable := [link for link in links if link not in reachable]:
        findings.problems.append(f"links {listed(unreachable)} are not joined to one root; a URDF is a tree, join them")
    return carriers


def way_to(link: str, carriers: Mapping[str, Element]) -> list[Element]:
    """Joints from the root to a link; where they go round in a circle, each once."""
    way = dict[str, Element]()
    while link in carriers and link not in way:
        way[link] = carriers[link]
        link = carriers[link].attrib[PARENT]
    return [*way.values()][::-1]


def fixed_to(carriers: Mapping[str, Element]) -> dict[str, list[Element]]:
    """Joints that fix a link to each link."""
    fixed: dict[str, list[Element]] = {}
    for joint in carriers.values():
        if joint.get("type") == "fixed":
            fixed.setdefault(joint.attrib[PARENT], []).append(joint)
    return fixed


def cluster_of(link: str, fixed: Mapping[str, list[Element]], ends: Sequence[str] = ()) -> Iterator[tuple[str, Array]]:
    """A link and all that is fixed to it: name, and place in that link, shape (4, 4) [-, m].

    What stands behind one of the links `ends` is left out: it is the load's. Origins that are unsound are reported on
    the way to the flange only; elsewhere they are taken as they can be.
    """
    waiting = [(link, np.eye(4))]
    while waiting:
        name, link_from_fixed = waiting.pop()
        yield name, link_from_fixed
        if name not in ends:
            children = ((joint.attrib[CHILD], link_from_element(joint, Findings())) for joint in fixed.get(name, ()))
            waiting.extend((child, link_from_fixed @ place) for child, place in children)


def link_from_element(element: Element, findings: Findings) -> Array:
    """Place of a joint or an inertia in its link, shape (4, 4) [-, m]."""
    frame, name = np.eye(4), element.get("name", "")
    of = f"origin of joint {name}" if name else "origin of the inertial"
    if (origin := element.find("origin")) is not None:
        frame[:3, 3] = vector_of(origin, "xyz", of, findings, "0 0 0")
        angles = vector_of(origin, "rpy", of, findings, "0 0 0")
        if angles.any():  # else the file may state none
            texts = origin.attrib["rpy"].split()
            angles = DEG * np.array([in_unit(text, v, DEG) for text, v in zip(texts, angles, strict=True)])
        frame[:3, :3] = turned(angles)
        if name and np.linalg.norm(frame[:3, 3]) > MOST_WAY:
            words = f"an origin beyond {MOST_WAY:g} m looks like millimetres: a URDF counts in metres"
            findings.note("joint", name, words)
    return frame


def vector_of(element: Element, key: str, of: str, findings: Findings, default: str = "") -> Array:
    """Three numbers of an attribute, shape (3,); zeros where they are not, which is reported."""
    text = element.get(key, default)
    if "${" in text:
        raise ValueError(XACRO)
    values = [number_in(word) for word in text.split(None, 4)]
    if len(values) == 3:
        x, y, z = values
        if x is not None and y is not None and z is not None and math.isfinite(x + y + z):
            return np.array([x, y, z])
    findings.problems.append(f"{key} of the {of} is {shown(text)}; it takes 3 of numbers up to {_MOST:g}, correct it")
    return np.zeros(3)


def positive_in(limit: Element | None, key: str) -> float | None:
    """A finite number above 0 of an attribute; None where it states something else."""
    value = None if limit is None else number_in(limit.get(key, ""))
    return value if value is not None and 0.0 < value < math.inf else None


def number_in(text: str) -> float | None:
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


def in_unit(text: str, value: float, si: float) -> float:
    """A number of SI in another unit, with no more digits than its text states: 1.5708 rad are 90 deg.

    Of fewer than four decimals it is taken as exact.

    Args:
        si: the unit [SI].
    """
    decimals = len(text.strip().partition(".")[2])
    exact = value / si
    if not _DECIMALS.fullmatch(text.strip()):
        return exact
    return next((v for v in (round(exact, k) for k in range(12)) if abs(v - exact) * si <= 0.5 * 10**-decimals), exact)


def shown(text: str | None) -> str:
    """Text of a file as a message can show it."""
    return repr(text if text is None or len(text) <= 60 else f"{text[:60]}..")
