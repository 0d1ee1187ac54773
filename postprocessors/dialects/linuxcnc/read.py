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

from cases.base.errors import Code, ProgramError
from cases.base.units import Array
from cases.schema import Case
from postprocessors.dialects.modal import ROUND, STILL, ModalState, Word
from postprocessors.reading import NUMBER, PLAIN, Reading, axis_letters, program_lines

LONGEST_LINE = 252  # measured with rs274: 253 characters are "Command too long"
LOOSEST = 1.0  # [mm] largest tolerance of G64: on 10 ms blocks corners are cut by far less

_READS = (
    "LinuxCNC programs consist of G0 and G1 under G61.1 (of a platform also arcs, and G93 under G64 P1 Q0), G4 P, M62 "
    "to M65 P0, M48 to M50, modal words as hexcite post writes them, M0, and M2 or M30"
)
# What a program relies on, and what an operator's commands may have left otherwise. They stand in blocks before the
# first move: in its own block LinuxCNC takes F before the unit.
_SETTINGS = ("G21", "G90", "G94", "G40", "G49", "G54", "G92.1")
_NEARLY_STRAIGHT = np.cos(np.radians(30.0))  # of the angle below which G61 may not stop; LinuxCNC's own is 15 degrees
_OVERRIDES = {"M48": True, "M49": False}  # commands that switch the feed override on or off; M50 does it by its P
_SWITCHES = {"M62": (True, False), "M63": (False, False), "M64": (True, True), "M65": (False, True)}  # on, at once
_EXECUTED = re.compile(  # comments that begin with a name and a comma, whatever the name, and those without a comma
    r"\s*(?:(?!msg\s*,)[a-z_]\w*\s*,|log(?:open|append|close)|probe(?:open|close)|py(?:run|reload))", re.IGNORECASE
)
# Text that stops the program unless G54 is zero, as hexcite post writes it
_ZERO_OFFSETS = re.compile(
    r"o(?P<number>\d+) if \[\[abs\[#5221\]\+abs\[#5222\]\+abs\[#5223\]\+abs\[#5224\]\+abs\[#5225\]\+abs\[#5226\]"
    r"\+abs\[#5230\]\] gt 0\]\n\(abort,[A-Za-z0-9 .:,]*\)\no(?P=number) endif"
)
_OF_A_POSE = {"G2", "G3", "G64", "G93"}  # no proof covers arcs and paths where rotary axes move


class _LinuxCncInterpreter(ModalState):
    """Meaning of the words, and of the conditional stops at the start (o101 if .. endif) in one form each."""

    name, last, reads, fractions = "LinuxCNC", ("M2", "M30"), _READS, True
    stops, exact_stop, switch_at_rest = ("M0", "M1", "M60"), "G61.1", "M64 P0 or M65 P0"
    number = re.compile(r"\s*N\s*\d+(?:\.\d+)?", re.IGNORECASE)
    word = re.compile(rf"(?P<comment>\([^()]*\)|;.*)|(?P<letter>[A-Za-z])\s*(?P<number>{NUMBER})")
    home_check = re.compile(
        rf"o(?P<number>\d+) if \[abs\[#<_(?P<axis>[xyzabc])>(?P<place>[+-]{PLAIN})\] gt (?P<within>{PLAIN})\]\n"
        r"\(abort,[A-Za-z0-9 .:,+-]*(?:#<_[xyzabc]>)?[A-Za-z0-9 .:,+-]*\)\no(?P=number) endif"
    )
    home_check_lines, condition = 3, "o"
    # those of groups of one change nothing that a program here relies on: no compensation, no offset; relative centres
    groups = (
        *("G0 G1 G2 G3 G80", "G17 G18 G19", "G93 G94", "G61 G61.1 G64", "M62 M63 M64 M65", "M0 M1 M2 M30 M60"),
        *("G8", "G21", "G90", "G91.1", "G40", "G49", "G54", "G92.1", "M48 M49 M50"),
    )

    def __init__(self, file: str, case: Case) -> None:
        axes = axis_letters(case, "LinuxCNC", file)
        super().__init__(file, axes, not case.need_motion("a program")[1].of_pose)
        self.needed = {name: (name,) for name in _SETTINGS}
        self.activate("G94")
        self.numbers: set[str] = set()  # of statements of several lines
        self.way: Array | None = None  # direction of the last move, where the machine need not stand at its end
        self.loose: ProgramError | None = None
        self.override = True  # whether the operator's feed override counts, as an operator or M2 leaves it
        self.overridden = False  # whether it counts in a move

    @classmethod
    def comment_problem(cls, text: str, match: re.Match[str]) -> tuple[str, str] | None:
        """LinuxCNC executes what a comment says behind names such as LOGOPEN, PRINT and PY; (MSG,..) is only shown.

        Behind a semicolon it takes the text from the first one of the line on, be that within parentheses.
        """
        begin = match.start()
        executed = _EXECUTED.match(text, begin + 1)
        if executed is None and text[begin] == ";" and (first := text.index(";")) < begin:
            executed = _EXECUTED.match(text, first + 1)
        if executed is None:
            return None
        return f"LinuxCNC may execute the comment {match['comment'][:40]!r}", "remove it, or begin it with a dash"

    def read_program(self, lines: Iterable[str]) -> Reading:
        reading = super().read_program(self._within_percent_signs(list(lines)))
        return replace(reading, override_off=not self.overridden)

    def statement(self, lines: list[str], number: int) -> int:
        """Reads a check of home, or that G54 is zero, whose number no other statement has."""
        if not np.isnan(self.coordinates).any():
            return 0
        texts = "\n".join(self._without_number(text) for text in lines[number - 1 : number - 1 + self.home_check_lines])
        match = _ZERO_OFFSETS.fullmatch(texts) or self.home_check.fullmatch(texts)
        if match is None:
            return 0
        self.line = number
        if match["number"] in self.numbers:
            self.fail(Word("o", 1), f"a second statement o{match['number']}", "give each a number of its own")
        self.numbers.add(match["number"])
        return self.home_check_lines if match.re is _ZERO_OFFSETS else super().statement(lines, number)

    def _within_percent_signs(self, lines: list[str]) -> list[str]:
        """The lines of a program without a percent sign above and one below, which also ends it; in their places."""
        signs = [k for k, text in enumerate(lines) if text.strip() == "%"]
        if not signs or any(text.strip() for text in lines[: signs[0]]):
            return lines
        below = next(iter(signs[1:]), None)
        self.enclosed = below is not None
        if below is not None and (more := next((k for k in range(below + 1, len(lines)) if lines[k].strip()), None)):
            raise ProgramError(
                file=self.file,
                line=more + 1,
                problem="text behind the % that ends the program",
                remedy="remove it",
                code=Code.SYNTAX,
            )
        return ["" if k in (signs[0], below) else text for k, text in enumerate(lines)]

    def read(self, block: dict[str, Word]) -> None:
        for word in block.values():
            self._word(word, block)
        if (arc := block.get("G2") or block.get("G3")) and "P" in block:
            self.fail(block["P"], f"P counts turns beside {arc.name}", "remove it, or move its own command away")
        for letter, owners in (("P", {"G4", "G64", "M50", *_SWITCHES}), ("Q", {"G64"})):
            if letter in block and owners.isdisjoint(block):
                self.refuse(block[letter])
        self.take_feed(block)
        first = next((word for word in block.values() if word.name in (*self.axes, "I", "J", "K")), None)
        if first is not None:
            self._move(block, first)
        elif code := block.get("G2") or block.get("G3") or (block.get("G1") if self.active("G93") else None):
            self.fail(code, f"{code.name} without a motion in its block", "remove it")
        elif self.active("G93"):
            self.feed = None
        self.said |= set(block)

    def _word(self, word: Word, block: dict[str, Word]) -> None:
        code = word.name
        if code in (*self.axes, *"FPQIJK"):
            return
        if code == "G4":
            self.pause(word, block.get("P"), "G4 P0.3")
            self.way = None
        elif code in _SWITCHES:
            if "P" not in block or block["P"].value != 0.0:
                self.fail(word, f"{code} needs P0, the output that the trigger is wired to")
            self.motions.switch(self.line, *_SWITCHES[code])
        elif code in self.last:
            self.end(word)
        elif code == "M50" or code in _OVERRIDES:
            self.activate(code)
            self.override = _OVERRIDES.get(code, "P" not in block or block["P"].value != 0.0)
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
        return ProgramError(
            file=self.file,
            line=self.line,
            column=word.column,
            problem="G64 lets the controller leave the path",
            remedy=f"write G64 P{LOOSEST:g} Q0",
            code=Code.SYNTAX,
        )

    def execute(self, block: dict[str, Word]) -> None:
        super().execute(block)
        if any(name in self.stops for name in block):
            self.way = None

    def require_said(self, word: Word) -> None:
        """Refuses a move before all that it needs was said in blocks before it."""
        if missing := [text for text in self.needed if text not in self.said]:
            problem = f"a move before a block with {' '.join(missing)}; an operator may have left something else"
            self.fail(word, problem, "write it first")

    def _move(self, block: dict[str, Word], first: Word) -> None:
        self.require_said(first)
        self.overridden |= self.override
        exact, before = self.active("G61", "G61.1"), self.coordinates
        if self.active("G2", "G3"):
            if "G91.1" not in self.said:
                self.fail(first, "an arc before a block with G91.1; I, J, K may be absolute", "write it first")
            self._require_stop(first, None)
            end = self._end_of(block, first)
            if 0.0 < np.abs(end - before)[self.linear].max() < ROUND:
                self.fail(first, "the arc ends next to where it begins", "leave X, Y, Z out for a full circle")
            self.arc(block, first, exact)
            self.way = np.full(len(self.coordinates), np.nan)
            return
        end, duration, feed = self.target(block, first)
        if duration is not None and self.loose is not None and not np.isnan(self.coordinates).any():
            raise self.loose
        if duration is not None and np.all(np.abs(end - before) <= STILL):
            self.fail(first, "a timed block in which nothing moves, which LinuxCNC leaves out", "wait with G4 P0.1")
        if duration is None:
            self._require_stop(first, end - before)
        self.straight(end, duration, feed, exact)
        self.way = None if duration is not None or np.isnan(before).any() else end - before

    def _require_stop(self, first: Word, way: Array | None) -> None:
        """Refuses a move that G61 does not separate from the one before: it stops at corners alone.

        Measured: collinear moves run into each other, and so does what turns by less than some degrees.
        """
        if self.way is None or not self.active("G61"):
            return
        if way is not None and not np.isnan(self.way).any():
            axes = self.linear if np.any(self.way[self.linear]) and np.any(way[self.linear]) else ~self.linear
            one, other = self.way[axes], way[axes]
            lengths = float(np.linalg.norm(one) * np.linalg.norm(other))
            if lengths > 0.0 and float(one @ other) < _NEARLY_STRAIGHT * lengths:
                return
        self.fail(first, "under G61 the move before may run into this one", "write G61.1, or G4 P0.1 between them")


def read_linuxcnc(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`, byte by byte: only a line feed ends a line, as for the controller."""
    return _LinuxCncInterpreter(file, case).read_program(program_lines(content, file, LONGEST_LINE))
