"""Reads LinuxCNC programs: the part of RS-274/NGC that an excitation needs, and an error for all else.

A word that is not understood is an error, never skipped: a proof of a text that was half understood proves nothing.
Meanings follow the LinuxCNC documentation: G93 F is 1/min on every line; G94 F counts XYZ only, or degrees where only
ABC moves; M62/M63 switch with the next motion, M64/M65 at once; G4 P is in seconds. A machine whose axes are the joints
of a chain moves between exact stops only: G64 guards corners of X, Y, Z and cuts those of rotary axes by degrees.
"""

import re
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from cases.errors import ProgramError
from cases.schema import Case
from postprocessors.reading import NUMBER, Reading, axis_letters, program_lines
from postprocessors.reading.modal import ModalState, Word

LONGEST_LINE = 252  # measured with rs274: 253 characters are "Command too long"
LOOSEST = 1.0  # [mm] largest tolerance of G64: on 10 ms blocks corners are cut by far less

_READS = (
    "LinuxCNC programs consist of G0 and G1 under G61 (of a platform also arcs, and G93 under G64 P1 Q0), G4 P, M62 to "
    "M65 P0, modal words as hexcite post writes them, M0, and M2 or M30"
)
_OFFSETS_OFF = ("G49", "G54", "G92.1")  # neither the interpreter's start nor M2 switches all of them off
_SWITCHES = {"M62": (True, False), "M63": (False, False), "M64": (True, True), "M65": (False, True)}  # on, at once
_EXECUTED = re.compile(  # comments that begin with a name and a comma, whatever the name, and those without a comma
    r"\s*(?:(?!msg\s*,)[a-z_]\w*\s*,|log(?:open|append|close)|probe(?:open|close)|py(?:run|reload))", re.IGNORECASE
)
_OF_A_POSE = {"G2", "G3", "G64", "G93"}  # no proof covers arcs and paths where rotary axes move


class _LinuxCncInterpreter(ModalState):
    """Meaning of the words."""

    name, last, reads, fractions = "LinuxCNC", ("M2", "M30"), _READS, True
    stops, exact_stop, switch_at_rest = ("M0", "M1", "M60"), "G61", "M64 P0 or M65 P0"
    number = re.compile(r"\s*N\s*\d+(?:\.\d+)?", re.IGNORECASE)
    word = re.compile(rf"(?P<comment>\([^()]*\)|;.*)|(?P<letter>[A-Za-z])\s*(?P<number>{NUMBER})")
    # those of groups of one change nothing that a program here relies on: no compensation, no offset; relative centres
    groups = (
        *("G0 G1 G2 G3 G80", "G17 G18 G19", "G93 G94", "G61 G64", "M62 M63 M64 M65", "M0 M1 M2 M30 M60"),
        *("G21", "G90", "G91.1", "G40", "G49", "G54", "G92.1"),
    )

    def __init__(self, file: str, case: Case) -> None:
        axes = axis_letters(case, "LinuxCNC", file)
        super().__init__(file, axes, not case.need_motion("a program")[1].of_pose)
        self.needed = {name: (name,) for name in ("G21", "G90")}
        self.activate("G94")  # the interpreter's start
        self.loose: ProgramError | None = None
        self.moved = False

    @classmethod
    def comment_problem(cls, text: str, match: re.Match[str]) -> str:
        """LinuxCNC executes what a comment says behind names such as LOGOPEN, PRINT and PY; (MSG,..) is only shown.

        Behind a semicolon it takes the text from the first one of the line on, be that within parentheses.
        """
        comment = match["comment"]
        texts = [comment[1:-1]] if comment.startswith("(") else [comment[1:], text.partition(";")[2]]
        if not any(_EXECUTED.match(said) for said in texts):
            return ""
        return f"LinuxCNC may execute the comment {comment[:40]!r}; remove it, or begin it with a dash"

    def read_program(self, lines: Iterable[str]) -> Reading:
        return super().read_program(self._within_percent_signs(list(lines)))

    def _within_percent_signs(self, lines: list[str]) -> list[str]:
        """The lines of a program without a percent sign above and one below, which also ends it; in their places."""
        signs = [k for k, text in enumerate(lines) if text.strip() == "%"]
        if not signs or any(text.strip() for text in lines[: signs[0]]):
            return lines
        below = next(iter(signs[1:]), None)
        self.enclosed = below is not None
        if below is not None and (more := next((k for k in range(below + 1, len(lines)) if lines[k].strip()), None)):
            raise ProgramError(self.file, more + 1, 0, "text behind the % that ends the program; remove it")
        return ["" if k in (signs[0], below) else text for k, text in enumerate(lines)]

    def read(self, block: dict[str, Word]) -> None:
        for word in block.values():
            self._word(word, block)
        if not self.moved:
            self.said |= set(block)
        for letter, owners in (("P", {"G4", "G64", *_SWITCHES}), ("Q", {"G64"})):
            if letter in block and owners.isdisjoint(block):
                self.refuse(block[letter])
        self.take_feed(block)
        first = next((word for word in block.values() if word.name in (*self.axes, "I", "J", "K")), None)
        if first is not None:
            self._move(block, first)
        elif code := block.get("G2") or block.get("G3") or (block.get("G1") if self.active("G93") else None):
            self.fail(code, f"{code.name} without a motion in its block; remove it")
        elif self.active("G93"):
            self.feed = None

    def _word(self, word: Word, block: dict[str, Word]) -> None:
        code = word.name
        if code in (*self.axes, *"FPQIJK"):
            return
        if code == "G4":
            self.pause(word, block.get("P"), "G4 P0.3")
        elif code in _SWITCHES:
            if "P" not in block or block["P"].value != 0.0:
                self.fail(word, f"{code} needs P0, the output that the trigger is wired to")
            self.motions.switch(self.line, *_SWITCHES[code])
        elif code in self.last:
            self.end(word)
        elif code in self.group_of and not (self.own_axes and code in _OF_A_POSE):
            self.activate(code)
            if code == "G64":
                self.loose = self._looseness(word, block)
        else:
            self.refuse(word)

    def _looseness(self, word: Word, block: dict[str, Word]) -> ProgramError | None:
        """Error of a G64 that is too loose: P cuts corners by up to P; Q merges blocks, and is P where not written."""
        cut, merge = (block[name].value if name in block else None for name in "PQ")
        if cut is not None and cut <= LOOSEST and (cut if merge is None else merge) <= 0.0:
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


def read_linuxcnc(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`, byte by byte: only a line feed ends a line, as for the controller."""
    interpreter = _LinuxCncInterpreter(file, case)
    reading = interpreter.read_program(program_lines(content, file, LONGEST_LINE))
    return replace(reading, unsaid=tuple(word for word in _OFFSETS_OFF if word not in interpreter.said))
