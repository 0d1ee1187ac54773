"""Damaged URDF files: refused in one line, or read as their own text says, walked from the root by somebody else."""

import random
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.base.units import DEG, MM
from cases.schema import load_case
from cases.urdf import Arm, read_urdf
from hexcite._new_arm import new_arm
from tests.bench.reliability.recordings import stained
from tests.bench.reliability.tally import Tally, tallied
from tests.cases.test_urdf import HOMES, ROBOTS, filled_in

Array = NDArray[np.float64]

ODD: tuple[str, ...] = (
    "",
    "nan",
    "inf",
    "-inf",
    "0",
    "-1",
    "1e308",
    "0x10",
    "1,5",
    "1 2 3",
    "0 0 0",
    "1 2",
    "a\tb",
    "é",
    "\u202e",
    "x" * 300,
)
ODD += ("base_link", "tool0", "fixed", "revolute", "continuous", "prismatic", "floating", "${pi}", "&lt;b&gt;")
KINDS = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating", "Revolute", "")
FASTER = {"[-5.0, 5.0]": "[-30.0, 30.0]", "acceleration_rad_s2 = 5.0": "acceleration_rad_s2 = 50.0"}
FASTER |= {"jerk_rad_s3 = 50.0": "jerk_rad_s3 = 5000.0"}  # values that nobody doubts
TURN = 0.3  # [rad, m] by which every joint stands off zero where two readings are compared
AGREES = 1e-9  # [m]


def damaged(text: str, draw: random.Random) -> bytes:
    """A file with an attribute, an element or a piece of text changed, lost, doubled or put elsewhere."""
    if draw.random() < 0.25:
        return stained(text, draw)
    root = ElementTree.fromstring(text)
    parents = {child: parent for parent in root.iter() for child in parent}
    element = draw.choice(list(parents))
    parent, key = parents[element], draw.choice([*element.attrib, ""])
    match draw.randrange(8):
        case 0:
            parent.remove(element)
        case 1:
            parent.append(element)
        case 2:
            below = set(element.iter())
            draw.choice([root, *(other for other in parents if other not in below)]).append(element)
            if draw.random() < 0.5:
                parent.remove(element)
        case 3 if key:
            del element.attrib[key]
        case 4 if key:
            numbers = element.attrib[key].split()
            numbers[draw.randrange(len(numbers))] = draw.choice(ODD)
            element.attrib[key] = " ".join(numbers)
        case 5 if key:
            other = draw.choice([e for e in parents if key in e.attrib])
            element.attrib[key], other.attrib[key] = other.attrib[key], element.attrib[key]
        case 6:
            element.attrib[key or "type"] = draw.choice([*ODD, *KINDS])
        case _:
            element.tag = draw.choice(["joint", "link", "origin", "axis", "limit", "inertial", "xacro", "é"])
    return ElementTree.tostring(root, encoding=draw.choice(["utf-8", "utf-8", "us-ascii", "utf-16"]))


def _placed(origin: Array, rpy: Array) -> Array:
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), origin
    return place


def _moved(kind: str, axis: Array, by: float) -> Array:
    place = np.eye(4)
    if kind == "prismatic":
        place[:3, 3] = by * axis
    else:
        place[:3, :3] = Rotation.from_rotvec(by * axis).as_matrix()
    return place


def _as_written(content: bytes, flange: str) -> Array:
    """Place of the flange with every joint off zero, as the text of a file says, shape (4, 4) [m]."""
    above = {joint.find("child").get("link"): joint for joint in ElementTree.fromstring(content).findall("joint")}
    place, link = np.eye(4), flange
    while link in above:
        joint, numbers = above[link], {}
        for tag, key, usual in (("origin", "xyz", "0 0 0"), ("origin", "rpy", "0 0 0"), ("axis", "xyz", "1 0 0")):
            found = joint.find(tag)
            words = (usual if found is None else found.get(key, usual)).split()
            numbers[tag, key] = np.array([float(word) for word in words])
        axis = numbers["axis", "xyz"]
        own = _placed(numbers["origin", "xyz"], numbers["origin", "rpy"])
        if joint.get("type") != "fixed":
            own = own @ _moved(joint.get("type", ""), axis / np.linalg.norm(axis), TURN)
        place, link = own @ place, joint.find("parent").get("link")
    return place


def _as_read(arm: Arm) -> Array:
    """The same of the chain that was read."""
    place = np.eye(4)
    for joint, _ in arm.joints:
        place = place @ _placed(np.array(joint.origin_mm) * MM, np.array(joint.rpy_deg) * DEG)
        place = place @ _moved(joint.kind, np.array(joint.axis) / np.linalg.norm(joint.axis), TURN)
    return place @ _placed(np.array(arm.sensor.origin_mm) * MM, np.array(arm.sensor.rpy_deg) * DEG)


def tally_of_urdf(seeds: range, folder: Path) -> Tally:
    """Damaged URDF files: read, and made a case, which is loaded with what no URDF says filled in."""
    file = folder / "robot.urdf"

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        robot = list(ROBOTS)[seed % len(ROBOTS)]
        text, flange = ROBOTS[robot]
        content = text.encode()
        for _ in range(draw.choice([1, 1, 2, 3])):
            try:
                content = damaged(content.decode("latin-1"), draw)
            except (ElementTree.ParseError, UnicodeError):
                break  # what is no XML any more is damaged enough
        file.write_bytes(content)
        arm = tally.attempt(seed, lambda: read_urdf(file, flange), str(file))
        if arm is None:
            return
        off = np.abs(_as_written(content, flange) - _as_read(arm)).max()
        if not off <= AGREES:
            tally.defect(seed, f"the flange is {off:.3g} m or rad from where the file has it")
        place = folder / f"arm{seed}"
        if tally.attempt(seed, lambda: new_arm("arm", file, flange, place), str(file)) is None:
            tally.defect(seed, "what is read is no case")
            return
        written = (place / "case.toml").read_text(encoding="utf-8")
        tomllib.loads(written)
        homes = [*HOMES[robot], *[0.0] * written.count("# home_deg")]
        text = filled_in(written, homes)
        for key, value in FASTER.items():
            text = text.replace(key, value)
        (place / "case.toml").write_text(text, encoding="utf-8")
        tally.attempt(seed, lambda: load_case(str(place)), str(place))

    return tallied("URDF files", seeds, one)
