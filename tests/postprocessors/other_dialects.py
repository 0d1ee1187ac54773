"""SINUMERIK and TwinCAT programs for tests: typed line by line around a valid frame, read, proven, and turned back."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cases.schema import Case, load_case
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Standstill
from postprocessors.blocks import Block, Blocks, TimedPath, ToHome, Trigger, timed_path
from postprocessors.dialects.dialect import Dialect
from postprocessors.program import dialect
from postprocessors.proof.guarantees import Guarantees
from postprocessors.proof.homing import predicted
from postprocessors.proof.proof import ProgramProof, prove_program
from postprocessors.reading import Reading, Stretch, Timed
from tests.postprocessors.changed_case import changed
from tests.postprocessors.programs import HEAD, HOME
from tests.postprocessors.reported import Move, Pause, Switch, reports

CASE = load_case("hexapod")
LINES_CASE = changed(CASE, controller__sinumerik__path="lines")


@dataclass(frozen=True)
class Typed:
    """How a program of a dialect is typed.

    Args:
        name: of the dialect.
        head: lines up to home at rest.
        end: lines after the body.
        before: what opens a timed path.
        after: what closes it.
        angle: the word of roll.
    """

    name: str
    head: str
    end: str
    before: str
    after: str
    angle: str

    @property
    def first(self) -> int:
        """Line in which the body begins."""
        return self.head.count("\n") + 1

    @property
    def language(self) -> Dialect:
        """Its writer, reader and guarantees."""
        return dialect(self.name)

    def text(self, body: str) -> str:
        """A whole program around some lines."""
        return f"{self.head}{body.rstrip()}\n{self.end}"

    def read(self, text: str, case: Case = CASE) -> Reading:
        """Reads a whole program."""
        return self.language.read(text.encode("latin-1"), "p", case)

    def parts(self, body: str, case: Case = CASE) -> tuple[Stretch, ...]:
        """Stretches of a body."""
        return self.read(self.text(body), case).stretches

    def proof(self, text: str, case: Case = CASE) -> ProgramProof:
        """Proof of a whole program."""
        reading = self.read(text, case)
        return prove_program(reading, self.language.guarantees(reading, case))

    def point(self, seconds: float, words: str) -> str:
        """A timed line."""
        f = seconds if self.name == "twincat" else 60.0 / seconds
        return f"G1 {words} F{f:.9f}"

    def timed(self, lines: list[str]) -> str:
        """Timed lines as a path."""
        lines = [*lines]
        if self.name == "twincat":
            lines[-1] = lines[-1].replace("G1 ", "G1 G60 ")
        return "\n".join([self.before, *lines, self.after])


SINUMERIK = Typed(
    "sinumerik",
    "%_N_TEST_MPF\nG17 G90 G94 G710 G40 G500\nD0\nTRANS\nTRAORI\nORIWKS ORIRPY\nORIAXES\nSOFT\nFGROUP(X,Y,Z)\n"
    "COMPOF G60\n"
    "G1 X0 Y0 Z900 A2=0 B2=0 C2=0 F3000\n",
    "TRAFOOF\nM30\n",
    "G642 G93 COMPCAD CTOL=0.02 OTOL=0.05",
    "COMPOF\nG94 G60\nG4 F0.1",
    "A2=",
)
TWINCAT = Typed(
    "twincat",
    "%TEST\nG71 G90 G17 G94 G162\nG53 G40 G20\n#SLOPE [TYPE=TRAPEZ]\n#KIN ID[5]\n#TRAFO ON\n#FGROUP [X,Y,Z]\n"
    "G01 G60 X0 Y0 Z900 A0 B0 C0 F3000\n",
    "#TRAFO OFF\nM30\n",
    "#SPLINE TYPE AKIMA\n#SPLINE ON\nG93",
    "#SPLINE OFF\nG94",
    "A",
)
LINUXCNC = Typed("linuxcnc", HEAD, "M2\n", "G64 P1 Q0\nG93", "G94\nG61.1", "A")
BOTH = [SINUMERIK, TWINCAT]


def text_of(typed: Typed, program: Blocks, case: Case = CASE) -> str:
    """What the dialect's writer makes of a program."""
    return typed.language.write(program, case).decode("ascii")


def program_of(text: str, typed: Typed, case: Case = CASE) -> Blocks:
    """The neutral program that a text says; names of paths are those of its comments."""
    reading = typed.read(text, case)
    names = iter(re.findall(r"^(?:; |\(- )(.*): \d+ (?:POLY )?blocks", text, re.MULTILINE))
    guarantees = typed.language.guarantees(reading, case)
    home, *others = reports(typed.read, text, case)
    blocks: list[Block] = [ToHome(home.end, home.feed)]
    read = (part for part in reading.stretches if getattr(part, "within", None) is None)
    for event in _each_path_once([e for e in others if not (isinstance(e, Move) and e.crawl)]):
        if isinstance(event, Switch):
            blocks.append(Trigger(event.on))
        elif isinstance(event, Pause):
            blocks.append(Standstill(HOME, event.duration))
            next(read)
        else:
            blocks.append(_block(next(read), names, guarantees, case))
    return tuple(blocks)


def _each_path_once(events: Sequence[object]) -> list[object]:
    """Events with each timed path as one."""
    found: list[object] = []
    for event in events:
        path = isinstance(event, Switch | Pause) or (isinstance(event, Move) and event.duration is None)
        if path or not found or found[-1] != "path":
            found.append(event if path else "path")
    return found


def _block(stretch: Stretch, names, guarantees: Guarantees, case: Case) -> Block:
    if isinstance(stretch, Timed):
        if isinstance(stretch.points, PolynomialMotion):
            return timed_path(next(names), stretch.points, case.controller.block, 1.0)
        return TimedPath(next(names), stretch.points.times, stretch.points.poses, stretch.points)
    return predicted(stretch, guarantees)


def without_comments(text: str) -> list[str]:
    """The lines that a controller acts on."""
    return [line for line in text.splitlines() if not line.startswith(("; ", "(- "))]


def smooth_points(typed: Typed, letter: str, size: float, count: int = 20, seconds: float = 0.05) -> list[str]:
    """Timed lines there and back along one coordinate."""
    way = size * (1 - np.cos(np.linspace(0.0, 2 * np.pi, count + 1)[1:])) / 2
    return [typed.point(seconds, f"{letter}{x:.5f}") for x in way]
