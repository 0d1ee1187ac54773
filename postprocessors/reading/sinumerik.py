"""Reads SINUMERIK 840D sl / ONE programs as the controller would, as far as a hexapod's program can go.

Everything else is refused with line and column. Words: 840D sl / ONE programming manuals; the orientation words, the
transformation and the trigger's output are those of the case. In a machine's own axes no transformation is active, and
moves go from rest to rest.
"""

import re
from typing import NoReturn

import numpy as np

from cases.controller import SINUMERIK_NAME, Sinumerik, SinumerikAxes
from cases.schema import Case
from postprocessors.reading import NUMBER, Reading, axis_letters, program_lines
from postprocessors.reading.modal import ModalState, Word
from postprocessors.reading.sinumerik_words import (
    GROUPS,
    LONGEST_LINE,
    OTHERS,
    polynomial,
    sinumerik_words,
)

_COMPRESSED = {"N", "G1", "X", "Y", "Z", "F"}
_OF_OWN_AXES = {
    *("G1", "G17", "G40", "G60", "G90", "G94", "G500", "G710", "COMPOF", "SOFT", "FFWON", "FFWOF", "DYNNORM", "DYNPOS")
}
SAME_RADIUS = 1e-5  # [mm] tolerance of the radius of FGREF
MM_A_DEGREE = 180.0 / np.pi


class _SinumerikInterpreter(ModalState):
    """Meaning of the words."""

    name, groups, others, last = "SINUMERIK", GROUPS, OTHERS, "M30"
    straight_word, block_time, feed_group = "G1", "F = 60 / seconds", "FGROUP({})"

    def __init__(self, file: str, settings: SinumerikAxes, case: Case) -> None:
        self.settings = settings
        self.of_pose = settings if isinstance(settings, Sinumerik) else None  # None: in the machine's own axes
        if self.of_pose is not None:
            words = self.of_pose.orientation_words
            axes = ["X", "Y", "Z", *(w + "=" if w[-1].isdigit() else w for w in words)]
            rpy = ["ORIWKS", "ORIRPY"] if any(w[-1].isdigit() for w in words) else []
            needed = ["ORIAXES", *rpy, self.of_pose.transformation]
        else:
            axes = list(axis_letters(case, "SINUMERIK", file, endless=False))
            needed = ["TRAFOOF", "COMPOF", "G94", *(f"FGREF[{axis}]" for axis in axes if axis in "ABC")]
        super().__init__(file, axes, self.of_pose is None)
        self.needed = {word: (word,) for word in ("G90", "G710", "G500", "SOFT", *needed)}
        if self.of_pose is not None:
            self.angles = self.of_pose.orientation_axes
        self.needed |= {"G60": ("G60",)} if self.own_axes else {"G60 or G64": ("G60", "G64", "G642")}

    def read(self, words: list[Word]) -> None:
        polynomials = [word for word in words if word.name == "PO"]
        if polynomials and self.own_axes:
            self.refuse(polynomials[0])
        block = self.once_each(word for word in words if word.name != "PO")
        for name, word in block.items():
            self._modal(name, word, block)
        if "G4" in block:
            self._dwell(block)
        else:
            self._feed_and_move(block, polynomials)
        if end := block.get("M30") or block.get("M2"):
            self.end(end, "" if self.of_pose is None else self.of_pose.transformation_off)

    def _modal(self, name: str, word: Word, block: dict[str, Word]) -> None:
        if name in ("N", "MSG", "G4", "M2", "M30"):
            return
        if name in (_OF_OWN_AXES if self.own_axes else self.group_of):
            self.activate(name)
        elif name in (*self.axes, "F") or (name in ("PL=", "I", "J", "K") and not self.own_axes):
            self.require_number(word)
        elif name == "%":
            program = (word.arguments or ("",))[0]
            if re.match(SINUMERIK_NAME, program) is None:
                problem = "is not taken; at most 24 letters, digits and _, two letters first"
                self.fail(word, f"program name {program!r} {problem}")
        elif name == "FGROUP":
            self.feed_axes = word.arguments or ()
        elif name == "DO":
            self._action(word)
        elif self.of_pose is None:
            self._of_own_axes(name, word)
        elif name in ("CTOL=", "OTOL="):
            s = self.of_pose
            limit = s.contour_tolerance_mm if name == "CTOL=" else s.orientation_tolerance_deg
            if word.value is None or not 0.0 < word.value <= limit:
                problem = f"is not above 0 and at most {limit:g}, the tolerance of the case; correct it"
                self.fail(word, f"{name[:-1]} {problem}")
        elif self._called(word) in (self.of_pose.transformation, self.of_pose.transformation_off):
            self.require_alone(word, block)
            self.transformed = self._called(word) == self.of_pose.transformation
            self.said = self.said - {self.of_pose.transformation} | {self._called(word)}
        else:
            self._refuse(word, self.of_pose)

    def _of_own_axes(self, name: str, word: Word) -> None:
        if name == "TRAFOOF":
            self.said.add(name)
        elif name == "FGREF":
            radius = (word.arguments or ("",))[0]
            same = re.fullmatch(NUMBER, radius) and abs(float(radius) - MM_A_DEGREE) <= SAME_RADIUS
            if word.selector not in self.angles or not same:
                self.fail(word, f"FGREF[{word.selector}]={radius} is not 1 mm a degree; write {MM_A_DEGREE:.6f}")
            self.said.add(f"FGREF[{word.selector}]")
        else:
            self.refuse(word)

    def _refuse(self, word: Word, settings: Sinumerik) -> NoReturn:
        name, angles = word.name, settings.orientation_words
        if name in ("A", "B", "C"):
            remedy = f"the angles are {', '.join(angles)}, as {angles[0]}="
            self.fail(word, f"{name} is a rotary axis of the machine; {remedy}")
        if name.startswith("TRA"):
            remedy = f"{settings.transformation} and {settings.transformation_off}"
            self.fail(word, f"{self._called(word)} is not the case's transformation; write {remedy}")
        self.refuse(word)

    @staticmethod
    def _called(word: Word) -> str:
        return word.name if word.arguments is None else f"{word.name}({','.join(word.arguments)})"

    def _action(self, word: Word) -> None:
        """Reads a non-modal synchronised action, which acts with the next executable block."""
        output = f"$A_OUT[{self.settings.trigger_output}]="
        text = (word.arguments or ("",))[0]
        if text not in (f"{output}0", f"{output}1"):
            self.fail(word, f"the action is not the trigger's; write {output}1 or =0")
        self.motions.switch(self.line, text[-1] == "1", at_once=False)

    def _dwell(self, block: dict[str, Word]) -> None:
        word = block["G4"]
        if set(block) - {"G4", "F", "N"}:
            other = next(w for name, w in block.items() if name not in ("G4", "F", "N"))
            self.fail(other, "G4 stands in a block of its own with its seconds as F; write G4 F0.3")
        self.pause(word, block["F"].value if "F" in block else None, "G4 F0.3", switches=True)

    def _feed_and_move(self, block: dict[str, Word], polynomials: list[Word]) -> None:
        self.take_feed(block)
        coordinates = [name for name in (*self.axes, "I", "J", "K", "PL=") if name in block]
        if not coordinates and not polynomials:
            return
        first = polynomials[0] if polynomials else block[coordinates[0]]
        self.require_said(first)
        if self.of_pose is not None and (polynomials or self.active("POLY")):
            self.motions.block(polynomial(self, self.of_pose, block, polynomials, first))
        elif self.active("G2", "G3"):
            self._require_standing(first)
            self.arc(block, first, self.active("G60"))
        elif "PL=" in block:
            self.fail(block["PL="], "PL without PO; remove it")
        else:
            self._line(block, first)
        self.flowing = self.active("G64", "G642")

    def _line(self, block: dict[str, Word], first: Word) -> None:
        if self.active("COMPCAD"):
            allowed = _COMPRESSED | set(self.axes)
            other = next((w for name, w in block.items() if name not in allowed), None)
            if other is not None or not self.active("G1"):
                self.fail(other or first, "the compressor takes nothing but G1, coordinates and F; write COMPOF before")
        end, duration, feed = self.target(block, first)
        if duration is None:
            self._require_standing(first)
        self.straight(end, duration, feed, self.active("G60"))

    def _require_standing(self, first: Word) -> None:
        if self.flowing:
            self.fail(first, "the path before runs into this move (G64); let the machine stop first, write G4 F0.1")


def read_sinumerik(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    settings = case.need_settings(SinumerikAxes, "a SINUMERIK program")
    lines = program_lines(content, file, LONGEST_LINE, settings.most_blocks)
    return _SinumerikInterpreter(file, settings, case).read_program(lines, sinumerik_words)
