"""Texts of two megabytes that patterns could try in ever so many ways: each reader answers, or refuses in a line.

A piece is repeated within a text of its kind, in a line or between two. A pattern that takes the square of the length
would take hours, which a tally counts as a defect.
"""

import random
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

from cases.schema import Case, load_case
from cases.tables import built_in_cases
from cases.urdf import read_urdf
from identification.looks.looking import look
from identification.recording.recording import read
from postprocessors.controllers.linuxcnc.machine_ini import read_ini
from postprocessors.program import dialect, read_program
from postprocessors.writing import proven_program
from tests.bench.reliability.programs import CASE, originals
from tests.bench.reliability.tally import Tally, tallied
from tests.bench.reliability.texts import bases
from tests.cases.test_collision_bodies import bent, obj
from tests.cases.test_collision_bodies import robot as robot_of_meshes
from tests.cases.test_urdf import ROBOTS
from tests.postprocessors.joint_walks import ROBOT, walk

SIZE = 2_000_000  # characters
PIECES = (
    *" \t\n\r01+-_.,;:()[]{}<>&\"'\\#%$=/*|aA~\u00a0\u2028", "\r\n", "1.", "1e", "''", '""', "'''", '"""', "[[", "<!--",
    "-->", "<a>", "<a ", "<![CDATA[", "&lt;", "a ", "a.", "a\n", "a=", "a=1\n", "[a]\n", "X1", "X1 ", "G1X1", "N1\n",
    ";\n", "o101 if ", "1,", "1;", "1\t", "1,1\n", "- ", "[a", "(a", "_a", "(N) ", "in ", "force unit ", "sample ",
    "scan_", "counts per ", "12:34 ", "sec: ", "positions: [", 'MESSAGE = r"""\n', "\n#INCLUDE a ", "\\\n", "v ", "v\n",
    "vertex ", "leaves out as planned: jerk, ", "<link name='a'/>", "<joint/>",
)  # fmt: skip


class Reader(NamedTuple):
    """What reads a kind of text."""

    name: str  # of the file that it reads
    text: str  # one that it reads
    read: Callable[[Path], Any]


def _readers() -> dict[str, Callable[[], Reader]]:
    suffixes = {"linuxcnc": ".ngc", "sinumerik": ".mpf", "twincat": ".nc"}
    found = {name: partial(_of_dialect, name, f"p{suffix}") for name, suffix in suffixes.items()}
    found |= {f"ros2 {suffix}": partial(_of_ros2, f"p{suffix}") for suffix in (".yaml", ".json", ".py")}
    for name in ("commas", "semicolons", "headless", "session", "trace", "Scope, delimiter '\\t'"):
        found |= {f"look at {name}": partial(_of_look, name), f"read {name}": partial(_of_recording, name)}
    return found | {"case": _of_case, "URDF": _of_urdf, "mesh": _of_mesh, "INI": _of_ini}


def _of_dialect(name: str, file: str) -> Reader:
    return _of_program(originals(name)[0], file, CASE)


def _of_ros2(file: str) -> Reader:
    content = proven_program(walk(ROBOT), ROBOT, dialect("ros2"), file, ("a walk",)).content
    return _of_program(content.decode("ascii"), file, ROBOT)


def _of_look(name: str) -> Reader:
    return Reader("run.txt", bases()[name][1], look)


def _of_recording(name: str) -> Reader:
    case, text = bases()[name]
    return Reader("run.txt", text, lambda file: read(file, case))


def _of_case() -> Reader:
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8")
    return Reader("case.toml", text, lambda file: load_case(str(file)))


def _of_urdf() -> Reader:
    robot, flange = ROBOTS["ur10"]
    return Reader("r.urdf", robot, lambda file: read_urdf(file, flange))


def _of_mesh() -> Reader:
    return Reader("c.obj", obj(bent(2)).decode("ascii"), _with_mesh)


def _of_ini() -> Reader:
    text = "[TRAJ]\nLINEAR_UNITS = mm\n#INCLUDE more.inc\n[AXIS_X]\nMAX_VELOCITY = 1\n"
    return Reader("m.ini", text, _ini_beside_another)


READERS = _readers()
"""What makes a reader of each kind of text."""


@cache
def reader_of(name: str) -> Reader:
    """The reader of a kind of text."""
    return READERS[name]()


def _of_program(text: str, name: str, case: Case) -> Reader:
    return Reader(name, text, lambda file: read_program(file, case))


def _with_mesh(file: Path) -> object:
    """Reads the mesh as that of a link of a robot in a package around it."""
    package = file.parent / "package"
    urdf = next(package.rglob("*.urdf"), None) if package.exists() else robot_of_meshes(package)
    assert urdf is not None
    target = next(package.rglob("c.obj"))
    target.write_bytes(file.read_bytes())
    return read_urdf(urdf, "link_2")


def _ini_beside_another(file: Path) -> object:
    (file.parent / "more.inc").write_text("[DISPLAY]\n", encoding="ascii")
    return read_ini(file)


def lengthened(text: str, piece: str, draw: random.Random) -> str:
    """The text with a piece repeated at some place, alone in its line or within one."""
    long = piece * (SIZE // len(piece))
    place = draw.randrange(len(text) + 1)
    if draw.random() < 0.5:
        place = text.find("\n", place) + 1
        long += "\n"
    return text[:place] + long + text[place:]


def tally_of_long_texts(seeds: range, folder: Path) -> Tally:
    """Long texts for each reader in turn, with any piece at any place."""
    names = list(READERS)

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        reader = reader_of(names[seed % len(names)])
        piece = draw.choice(PIECES)
        file = folder / reader.name
        file.write_text(lengthened(reader.text, piece, draw), encoding="utf-8", newline="")
        before = len(tally.defects)
        tally.attempt(seed, lambda: reader.read(file), "")
        if len(tally.defects) > before:
            tally.defect(seed, f"this was {names[seed % len(names)]} with {piece!r}")

    return tallied("long texts", seeds, one)
