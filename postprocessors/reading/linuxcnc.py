"""Reads LinuxCNC programs: the part of RS-274/NGC that an excitation needs, and an error for all else.

A word that is not understood is an error, never skipped: a proof of a text that was half understood proves nothing.
Meanings follow the LinuxCNC documentation: G93 F is 1/min on every line; G94 F counts XYZ only, or degrees where only
ABC moves; M62/M63 switch with the next motion, M64/M65 at once; G4 P is in seconds. A machine whose axes are the joints
of a chain moves between exact stops only: G64 guards corners of X, Y, Z and cuts those of rotary axes by degrees.
"""

import math
import re
from dataclasses import replace

import numpy as np

from cases.errors import ProgramError
from cases.schema import Case
from postprocessors.reading import NUMBER, Reading, axis_letters, each_word, program_lines
from postprocessors.reading.modal import ModalState, Word

LONGEST_LINE = 252  # measured with rs274: 253 characters are "Command too long"
LOOSEST = 1.0  # [mm] largest tolerance of G64: on 10 ms blocks corners are cut by far less

_WORD = re.compile(rf"\s*(?:(?P<comment>\([^()]*\)|;.*)|(?P<letter>[A-Za-z])\s*(?P<number>{NUMBER}))")
# Modal words, of which two of a group on a line are an error to the controller. Those of groups of one are words that
# change nothing that a program here relies on: no compensation, no offset; relative centres.
_GROUPS = (
    ("G0", "G1", "G2", "G3", "G80"),
    ("G17", "G18", "G19"),
    ("G21",),
    ("G90",),
    ("G91.1",),
    ("G93", "G94"),
    ("G61", "G64"),
    ("G40",),
    ("G49",),
    ("G54",),
    ("G92.1",),
    ("M62", "M63", "M64", "M65"),
    ("M2", "M30"),
)
_OFFSETS_OFF = ("G49", "G54", "G92.1")  # neither the interpreter's start nor M2 switches all of them off
_SWITCHES = {"M62": (True, False), "M63": (False, False), "M64": (True, True), "M65": (False, True)}  # on, at once
_OTHERS = {
    "G20": "inches; write G21",
    "G91": "incremental; write G90",
    "G92": "a shift of all coordinates by an amount that is not known; write G92.1",
    "G60": "not known to LinuxCNC; write G61",
    **dict.fromkeys(("G70", "G71"), "a cycle here; write G21 for millimetres"),
    "G90.1": "for absolute arc centres; write G91.1",
}

_OF_A_POSE = {"G2": "an arc", "G3": "an arc", "G64": "rounding of corners", "G93": "a time for a block"}
_BY_MOVES = "write G1 moves with G94 and G61"


class _LinuxCncInterpreter(ModalState):
    """Meaning of the words."""

    name, groups, others, last = "LinuxCNC", _GROUPS, _OTHERS, "M2"
    straight_word, block_time = "G1", "F = 60 / seconds"

    def __init__(self, file: str, case: Case) -> None:
        axes = axis_letters(case, "LinuxCNC", file)
        super().__init__(file, axes, not case.need_motion("a program")[1].of_pose)
        self.needed = {name: (name,) for name in ("G21", "G90")}
        self.activate("G94")  # the interpreter's start
        self.loose: ProgramError | None = None
        self.moved = False

    def read(self, words: list[Word]) -> None:
        block = self.once_each(words)
        codes = [word for word in words if word.value is None]
        for word in words:
            if word.value is not None:
                if word.name not in (*self.axes, *"FPQIJK"):
                    self.fail(word, f"{word.name}{word.value:g} is not a word of an excitation; remove it")
                self.require_number(word)
        for word in codes:
            self._code(word, block)
        if not self.moved:
            self.said |= {word.name for word in codes}
        for letter, owners in (("P", {"G4", "G64", *_SWITCHES}), ("Q", {"G64"})):
            if letter in block and owners.isdisjoint(block):
                self.fail(block[letter], f"{letter} without {' or '.join(sorted(owners))}; remove it")
        self.take_feed(block)
        first = next((word for word in words if word.name in (*self.axes, "I", "J", "K")), None)
        if first is not None:
            self._move(block, first)
            return
        for code in ("G2", "G3"):
            if code in block:
                self.fail(block[code], f"{code} without a centre; write I and J, or remove it")
        if self.active("G93"):
            if "G1" in block and "F" not in block:
                self.fail(block["G1"], f"G1 without F under G93; add {self.block_time}, or remove it")
            self.feed = None

    def _code(self, word: Word, block: dict[str, Word]) -> None:
        code = word.name
        seconds = block["P"].value if "P" in block else None
        if self.own_axes and code in _OF_A_POSE:
            self.fail(word, f"{code} is {_OF_A_POSE[code]}, which no proof covers where rotary axes move; {_BY_MOVES}")
        if code == "G4":
            self.pause(word, seconds, "G4 P0.3")
        elif code in _SWITCHES:
            if seconds != 0.0:
                self.fail(word, f"{code} needs P0, the output that the trigger is wired to")
            self.motions.switch(self.line, *_SWITCHES[code])
        elif code in ("M2", "M30"):
            self.end(word)
        elif code in self.group_of:
            self.activate(code)
            if code == "G64":
                self.loose = self._looseness(word, block)
        else:
            self.refuse(word)

    def _looseness(self, word: Word, block: dict[str, Word]) -> ProgramError | None:
        """Error of a G64 that is too loose: P cuts corners by up to P; Q merges blocks, and is P where not written."""
        cut, merge = (math.inf if name not in block else float(block[name].value or 0.0) for name in "PQ")
        if cut <= LOOSEST and (merge if "Q" in block else cut) <= 0.0:
            return None
        remedy = f"G64 lets the controller leave the path; write G64 P{LOOSEST:g} Q0"
        return ProgramError(self.file, self.line, word.column, remedy)

    def _move(self, block: dict[str, Word], first: Word) -> None:
        self.require_said(first)
        self.moved = True
        exact = self.active("G61")
        if self.active("G2", "G3"):
            self.arc(block, first, exact)
            return
        end, duration, feed = self.target(block, first)
        if duration is not None and self.loose is not None and not np.isnan(self.pose).any():
            raise self.loose
        self.straight(end, duration, feed, exact)


def _words(text: str, line: int, file: str) -> list[Word]:
    """Words of a line; a comment has none."""
    words, remedy = [], "words are a letter and a plain decimal number"
    for match, column in each_word(text, 0, _WORD, (file, line), lambda bad: remedy):
        if not match["comment"]:
            letter, number = match["letter"].upper(), float(match["number"])
            words.append(Word(f"{letter}{number:g}", column) if letter in "GM" else Word(letter, column, number))
    return words


def read_linuxcnc(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`, byte by byte: only a line feed ends a line, as for the controller."""
    interpreter = _LinuxCncInterpreter(file, case)
    reading = interpreter.read_program(program_lines(content, file, LONGEST_LINE), _words)
    return replace(reading, unsaid=tuple(word for word in _OFFSETS_OFF if word not in interpreter.said))
