"""Reads LinuxCNC programs: the part of RS-274/NGC that a hexapod excitation needs, and an error for all else.

A word that is not understood is an error, never skipped: a proof of a text that was half understood proves nothing.
Meanings follow the LinuxCNC documentation: G93 F is 1/min on every line; G94 F counts XYZ only, or degrees where only
ABC moves; M62/M63 switch with the next motion, M64/M65 at once; G4 P is in seconds.
"""

import math
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cases.errors import ProgramError
from cases.schema import Case
from cases.units import DEG, MINUTE, MM
from identification.trajectories.circle import Plane
from postprocessors.reading.arcs import Arc, PlaneProblem, arc_through
from postprocessors.reading.words import Array, Event, Move, Pause, Reading, Switch, Timing, Turn

LONGEST_LINE = 252  # measured with rs274: 253 characters are "Command too long"
STILL = 1e-7  # a coordinate moves if it changes by more, in mm or degrees (the interpreter's own threshold)

_WORD = re.compile(r"\s*(?:(?P<comment>\([^()]*\)|;.*)|(?P<letter>[A-Za-z])\s*(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)))")
_AXES = "XYZABC"
SCALE = np.r_[np.full(3, MM), np.full(3, DEG)]
LARGEST = 1e6  # mm, degrees, seconds: no machine has such numbers
LOOSEST = 1.0  # [mm] of a corner that G64 may cut: on 10 ms blocks the corners themselves keep it far below
LARGEST_FEED = 1e9  # per minute; 60 over a microsecond is 6e7
# Two words of one modal group on a line are an error to the controller.
_GROUPS = (
    ("G0", "G1", "G2", "G3", "G80"),
    ("G17", "G18", "G19"),
    ("G20", "G21"),
    ("G90", "G91"),
    ("G91.1",),
    ("G93", "G94"),
    ("G61", "G64"),
    ("G40",),
    ("G49",),
    ("G54",),
    ("G92.1",),
    ("G4",),
    ("M62", "M63", "M64", "M65"),
    ("M2", "M30"),
)
_GROUP_OF = {code: group[0] for group in _GROUPS for code in group}
# Words that change nothing that a hexapod program here relies on: no compensation, offset, cycle; relative centres.
_NEUTRAL = {"G40", "G49", "G54", "G80", "G91.1", "G92.1"}
_OFFSETS_OFF = ("G49", "G54", "G92.1")  # neither the interpreter's start nor M2 switches all of them off
_PLANES = {"G17": Plane.XY, "G18": Plane.ZX, "G19": Plane.YZ}
_CENTRES = "IJK"
_SWITCHES = {"M62": (True, False), "M63": (False, False), "M64": (True, True), "M65": (False, True)}  # on, at once
_REMEDY = {
    "G20": "inches, which are not used here; write G21",
    "G91": "incremental, which is not used here; write G90",
    "G92": "a shift of all coordinates by an amount that is not known; write G92.1",
    "G60": "not known to LinuxCNC; write G61",
    "G70": "a finishing cycle here; write G21 for millimetres",
    "G71": "a turning cycle here; write G21 for millimetres",
    "G90.1": "for absolute arc centres, which are not used here; write G91.1",
}


class _Word(NamedTuple):
    letter: str
    value: float
    column: int

    @property
    def code(self) -> str:
        """G and M words as they are usually written: G1, G91.1."""
        return f"{self.letter}{self.value:g}"


class _Interpreter:
    """Modal state of the controller while the program is read."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.events: list[Event] = []
        self.pose = np.full(6, np.nan)  # mm, degrees; unknown until the first move has named all six
        self.units = self.absolute = self.exact = self.ended = False
        self.inverse_time = False
        self.loose: ProgramError | None = None
        self.feed: float | None = None
        self.motion: str | None = None
        self.plane: Plane | None = None
        self.said: set[str] = set()
        self.moved = False

    def error(self, line: int, word: _Word | None, problem: str) -> ProgramError:
        return ProgramError(self.file, line, word.column if word else 0, problem)

    def read(self, line: int, words: list[_Word]) -> None:
        if self.ended:
            raise self.error(line, words[0], "a word after the end of the program; M2 must be last")
        seen: dict[str, _Word] = {}
        codes: list[_Word] = []
        for word in words:
            if word.letter in "GM":
                codes.append(word)
            elif word.letter in "XYZABCFPQIJK":
                if abs(word.value) > (LARGEST_FEED if word.letter == "F" else LARGEST):
                    raise self.error(line, word, f"{word.letter}{word.value:g} is no machine's number; correct it")
                if word.letter in seen:
                    raise self.error(line, word, f"a second {word.letter} word on one line; remove one")
                seen[word.letter] = word
            else:
                raise self.error(line, word, f"{word.letter}{word.value:g} is not a word of an excitation; remove it")
        self._require_one_of_each_group(line, codes)
        for word in codes:
            self._code(line, word, seen)
        written = {w.code for w in codes}
        if not self.moved:
            self.said |= written
        for letter, owners in (("P", {"G4", "G64", *_SWITCHES}), ("Q", {"G64"})):
            if letter in seen and not written & owners:
                raise self.error(line, seen[letter], f"{letter} without {' or '.join(sorted(owners))}; remove it")
        for letter in _CENTRES:
            if letter in seen and self.motion not in ("G2", "G3"):
                raise self.error(line, seen[letter], f"{letter} without G2 or G3; remove it")
        if "F" in seen:
            if not seen["F"].value > 0.0:
                raise self.error(line, seen["F"], f"feed F{seen['F'].value:g} is not positive; correct it")
            self.feed = seen["F"].value
        if any(letter in seen for letter in _AXES + _CENTRES):
            self._move(line, seen)
        elif self.inverse_time:
            self.feed = None

    def _require_one_of_each_group(self, line: int, codes: list[_Word]) -> None:
        first: dict[str, _Word] = {}
        for word in codes:
            before = first.setdefault(_GROUP_OF.get(word.code, word.code), word)
            if before is not word and word.code in _GROUP_OF:
                raise self.error(
                    line, word, f"{before.code} and {word.code} on one line exclude each other; remove one"
                )

    def _code(self, line: int, word: _Word, seen: dict[str, _Word]) -> None:
        code = word.code
        if code == "G80":
            self.motion = None
        if code in _NEUTRAL:
            return
        if code == "G21":
            self.units = True
        elif code == "G90":
            self.absolute = True
        elif code in _PLANES:
            self.plane = _PLANES[code]
        elif code in ("G0", "G1", "G2", "G3"):
            self.motion = code
        elif code in ("G93", "G94"):
            self.inverse_time = code == "G93"
            self.feed = None  # a feed of the other kind has no meaning any more
        elif code in ("G61", "G64"):
            self.exact = code == "G61"
            if code == "G64":
                self.loose = self._looseness(line, word, seen)
        elif code == "G4":
            if "P" not in seen or seen["P"].value < 0.0:
                raise self.error(line, word, "G4 needs a duration in seconds that is not negative; write G4 P0.3")
            self.events.append(Pause(line, seen["P"].value))
        elif code in _SWITCHES:
            if "P" not in seen or seen["P"].value != 0.0:
                raise self.error(line, word, f"{code} needs P0, the output that the trigger is wired to")
            self.events.append(Switch(line, *_SWITCHES[code]))
        elif code in ("M2", "M30"):
            self.ended = True
        else:
            raise self.error(line, word, f"{code} is {_REMEDY.get(code, 'not a word of an excitation; remove it')}")

    def _looseness(self, line: int, word: _Word, seen: dict[str, _Word]) -> ProgramError | None:
        """G64 P cuts corners by up to P; Q merges blocks, and is what P is where it is not written."""
        cut = seen["P"].value if "P" in seen else math.inf
        merge = seen["Q"].value if "Q" in seen else cut
        if cut > LOOSEST or merge > 0.0:
            return self.error(line, word, f"G64 lets the controller leave the path; write G64 P{LOOSEST:g} Q0")
        return None

    def _move(self, line: int, seen: dict[str, _Word]) -> None:
        if not (self.units and self.absolute):
            raise self.error(line, None, "a move before G21 and G90; units and coordinates are not known, add them")
        if self.motion is None:
            raise self.error(line, None, "axis words without G0 or G1; add G1")
        self.moved = True
        end = self.pose.copy()
        for k, letter in enumerate(_AXES):
            if letter in seen:
                end[k] = seen[letter].value
        if np.isnan(end).any():
            missing = _AXES[int(np.flatnonzero(np.isnan(end))[0])]
            raise self.error(line, None, f"the first move leaves {missing} open; name all six axes")
        if self.motion in ("G2", "G3"):
            self._turn(line, seen, end)
            return
        timing, value = self._timing(line, seen, end)
        if timing is Timing.DURATION and self.loose is not None and not np.isnan(self.pose).any():
            raise self.loose
        self.events.append(Move(line, end * SCALE, timing, value, self.exact, self._linear(end)))
        self.pose = end

    def _turn(self, line: int, seen: dict[str, _Word], end: Array) -> None:
        """An arc with relative centre words; without end words it is a full circle."""
        if np.isnan(self.pose).any():
            raise self.error(line, None, "an arc starts from an unknown pose; first move home at a feed (G94)")
        if self.plane is None:
            raise self.error(line, None, f"{self.motion} before a plane was chosen; write G17, G18 or G19")
        if self.inverse_time or self.feed is None:
            raise self.error(line, None, f"{self.motion} needs a feed per minute; write G94 and F")
        centres = {letter: seen[letter].value for letter in _CENTRES if letter in seen}
        asked = Arc(self.plane, self.motion == "G3", self.pose, end, centres)
        try:
            centre, angle = arc_through(asked)
        except PlaneProblem as problem:
            raise self.error(line, seen.get(problem.word), str(problem)) from problem
        value = self.feed * MM / MINUTE
        self.events.append(Turn(line, end * SCALE, self.plane, centre * MM, angle, value, self.exact))
        self.pose = end

    def _timing(self, line: int, seen: dict[str, _Word], end: Array) -> tuple[Timing, float]:
        if self.motion == "G0":
            return Timing.RAPID, math.nan
        if self.inverse_time:
            if "F" not in seen:
                raise self.error(line, None, "G1 without F in inverse time (G93); add F = 60 / seconds")
            return Timing.DURATION, MINUTE / seen["F"].value
        if self.feed is None:
            raise self.error(line, None, "G1 without a feed; add F")
        return Timing.FEED, self.feed * (MM if self._linear(end) else DEG) / MINUTE

    def _linear(self, end: Array) -> bool:
        """Whether X, Y or Z moves; from an unknown pose they are taken to."""
        return bool(np.isnan(self.pose).any() or np.any(np.abs(end - self.pose)[:3] > STILL))


def _words(file: str, number: int, text: str) -> Iterator[_Word]:
    if len(text) > LONGEST_LINE:
        raise ProgramError(file, number, 0, f"{len(text)} characters, the controller takes {LONGEST_LINE}; split it")
    if not text.isascii() or not text.replace("\t", " ").isprintable():
        strange = next(k for k, c in enumerate(text) if c != "\t" and not " " <= c <= "~")
        raise ProgramError(file, number, strange + 1, f"character {text[strange]!r} is not plain ASCII; remove it")
    position, end = 0, len(text.rstrip())
    while position < end:
        match = _WORD.match(text, position)
        if match is None:
            column = position + len(text[position:]) - len(text[position:].lstrip()) + 1
            bad = text[column - 1 : column + 11]
            raise ProgramError(
                file, number, column, f"cannot read {bad!r}; words are a letter and a plain decimal number"
            )
        if match["letter"]:
            yield _Word(match["letter"].upper(), float(match["number"]), match.start("letter") + 1)
        position = match.end()


def read_linuxcnc_bytes(content: bytes, file: str, case: Case) -> Reading:
    """Reads a file as it is, byte by byte: no notion of lines but the controller's own (line feed).

    Args:
        content: of the file.
        file: its name, for messages.
        case: not needed for this dialect.

    Raises:
        ProgramError: see `read_linuxcnc`.
    """
    return read_linuxcnc(content.decode("latin-1"), file)  # one character a byte; what is not ASCII is refused there


def read_linuxcnc(text: str, file: str) -> Reading:
    """Reads a program.

    Args:
        text: of the program.
        file: its name, for messages.

    Raises:
        ProgramError: anything that is not understood, with line and column; no end of program.
    """
    interpreter = _Interpreter(file)
    blocks = 0
    for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), start=1):
        if words := list(_words(file, number, line)):
            interpreter.read(number, words)
            blocks += 1
    if not interpreter.ended:
        raise ProgramError(file, 0, 0, "no M2 at the end; the file is truncated or not a LinuxCNC program")
    unsaid = tuple(word for word in _OFFSETS_OFF if word not in interpreter.said)
    return Reading(file, tuple(interpreter.events), blocks, unsaid)
