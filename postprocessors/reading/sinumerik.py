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
from postprocessors.reading import Reading, axis_letters, program_lines
from postprocessors.reading.modal import ModalState, Word
from postprocessors.reading.sinumerik_words import (
    GROUPS,
    LONGEST_LINE,
    MODAL,
    NEUTRAL,
    REMEDY,
    polynomial,
    sinumerik_words,
)

_COMPRESSED = {"N", "G1", "X", "Y", "Z", "F"}
_OF_OWN_AXES = {"G1", "G17", "G90", "G94", "G710", "G500", "G60", "COMPOF", "SOFT"}  # modal words
SAME_RADIUS = 1e-5  # [mm] tolerance of the radius of FGREF
MM_A_DEGREE = 180.0 / np.pi


class _SinumerikInterpreter(ModalState):
    """Meaning of the words."""

    name, groups, last, straight_word, block_time = "SINUMERIK", GROUPS, "M30", "G1", "F = 60 / seconds"
    feed_group = "FGROUP({})"

    def __init__(self, file: str, settings: SinumerikAxes, case: Case) -> None:
        self.settings = settings
        self.of_pose = settings if isinstance(settings, Sinumerik) else None  # None: in the machine's own axes
        if self.of_pose is not None:
            words = self.of_pose.orientation_words
            axes = ["X", "Y", "Z", *(w + "=" if w[-1].isdigit() else w for w in words)]
            rpy = ["ORIWKS", "ORIRPY"] if any(w[-1].isdigit() for w in words) else []
            self.needed = ["G90", "G710", "G500", "SOFT", "ORIAXES", *rpy]
        else:
            axes = list(axis_letters(case, "SINUMERIK", file, endless=False))
            radii = (f"FGREF[{axis}]" for axis in axes if axis in "ABC")
            self.needed = ["G90", "G710", "G500", "SOFT", "TRAFOOF", "COMPOF", "G94", *radii]
        super().__init__(file, axes, self.of_pose is None)
        if self.of_pose is not None:
            self.angles = self.of_pose.orientation_axes
        self.action: tuple[int, bool] | None = None  # line of a switch that waits for the next block, and whether on

    def read(self, words: list[Word]) -> None:
        polynomials = [word for word in words if word.name == "PO"]
        if polynomials and self.own_axes:
            self._refuse("PO", polynomials[0])
        block = self.once_each(word for word in words if word.name != "PO")
        for name, word in block.items():
            self._modal(name, word, block)
        if "G4" in block:
            self._dwell(block)
        else:
            self._feed_and_move(block, polynomials)
        if end := block.get("M30") or block.get("M2"):
            self._end(end)

    def _modal(self, name: str, word: Word, block: dict[str, Word]) -> None:
        if name in NEUTRAL or name in ("G4", "M2", "M30"):
            return
        if name in (_OF_OWN_AXES if self.own_axes else MODAL):
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
        else:
            self._refuse(name, word)

    def _of_own_axes(self, name: str, word: Word) -> None:
        if name == "TRAFOOF":
            self.said.add(name)
        elif name == "FGREF":
            radius = float((word.arguments or ("nan",))[0])
            if word.selector not in self.angles or not abs(radius - MM_A_DEGREE) <= SAME_RADIUS:
                self.fail(word, f"FGREF[{word.selector}]={radius:g} is not 1 mm a degree; write {MM_A_DEGREE:.6f}")
            self.said.add(f"FGREF[{word.selector}]")
        else:
            self._refuse(name, word)

    def _refuse(self, name: str, word: Word) -> NoReturn:
        if (s := self.of_pose) is not None:
            angles = s.orientation_words
            if name in ("A", "B", "C") and name not in angles:
                remedy = f"the angles are {', '.join(angles)}, as {angles[0]}="
                self.fail(word, f"{name} is a rotary axis of the machine; {remedy}")
            if name.startswith("TRA"):
                remedy = f"{s.transformation} and {s.transformation_off}"
                self.fail(word, f"{self._called(word)} is not the case's transformation; write {remedy}")
        if name.endswith("=") and name[:-1] in REMEDY | dict.fromkeys("XYZABCF"):
            self.fail(word, f"{name[:-1]} is not read here as an assignment; write {name[:-1]} and its number")
        label = "Q" if name == "Q" else name.rstrip("=")
        self.fail(word, f"{label} is {REMEDY.get(name, 'not a word of an excitation; remove it')}")

    @staticmethod
    def _called(word: Word) -> str:
        return word.name if word.arguments is None else f"{word.name}({','.join(word.arguments)})"

    def _action(self, word: Word) -> None:
        """Reads a non-modal synchronised action, which acts with the next executable block."""
        output, index, value = word.arguments or ("", "", "")
        number = str(self.settings.trigger_output)
        if word.selector is not None:
            self.fail(word, f"{word.selector.split()[0].upper()} makes the action wait for a condition; write DO alone")
        if output != "$A_OUT" or index != number or value not in ("0", "1"):
            self.fail(word, f"the action is not the trigger's; write $A_OUT[{number}]=1 or =0")
        self._flush_trigger(before_motion=False)
        self.action = self.line, value == "1"

    def _flush_trigger(self, before_motion: bool) -> None:
        if self.action is not None:
            self.motions.switch(*self.action, at_once=not before_motion)
            self.action = None

    def _dwell(self, block: dict[str, Word]) -> None:
        word = block["G4"]
        if set(block) - {"G4", "F", "N"}:
            other = next(w for name, w in block.items() if name not in ("G4", "F", "N"))
            self.fail(other, "G4 stands in a block of its own with its seconds as F; write G4 F0.3")
        self._flush_trigger(before_motion=False)
        self.pause(word, block["F"].value if "F" in block else None, "G4 F0.3")

    def _feed_and_move(self, block: dict[str, Word], polynomials: list[Word]) -> None:
        self.take_feed(block)
        coordinates = [name for name in (*self.axes, "I", "J", "K", "PL=") if name in block]
        if not coordinates and not polynomials:
            return
        first = polynomials[0] if polynomials else block[coordinates[0]]
        self._require_ready(first)
        if self.of_pose is not None and (polynomials or self.active("POLY")):
            piece = polynomial(self, self.of_pose, block, polynomials, first)
            self._flush_trigger(before_motion=True)
            self.motions.block(piece)
        elif self.active("G2", "G3"):
            self._arc(block, first)
        elif "PL=" in block:
            self.fail(block["PL="], "PL without PO; remove it")
        else:
            self._line(block, first)
        self.flowing = self.active("G64", "G642")

    def _require_ready(self, word: Word) -> None:
        for name in self.needed:
            if name not in self.said and not self.active(name):
                self.fail(word, f"a move before {name}; what it means is not known, add {name}")
        if self.of_pose is not None and not self.transformed:
            name = self.of_pose.transformation
            self.fail(word, f"a move before {name}; without it X, Y, Z are not coordinates of the platform, add it")
        if not self.active("G60", "G64", "G642"):
            stops = "G60" if self.own_axes else "G60 or G64"
            self.fail(word, f"a move before {stops}; whether the machine stops after it is not known, add {stops}")

    def _line(self, block: dict[str, Word], first: Word) -> None:
        if not self.active("G0", "G1"):
            self.fail(first, "coordinates without G0 or G1; add G1")
        self.refuse_centres(block, "G2 or G3")
        if self.active("COMPCAD"):
            allowed = _COMPRESSED | set(self.axes)
            other = next((w for name, w in block.items() if name not in allowed), None)
            if other is not None or not self.active("G1"):
                self.fail(other or first, "the compressor takes nothing but G1, coordinates and F; write COMPOF before")
        end = self.end_of(block, first)
        duration, feed = self.timing(block, end, first)
        exact = self.active("G60")
        if duration is not None and exact and not np.isnan(self.pose).any():
            self.fail(first, "a timed block under G60 stops at its end and does not keep the time; write G64")
        if duration is None and not exact:
            self.fail(
                first, "a move at a feed is blended into the next (G64), its path is not known; write G60, or G93"
            )
        if duration is None:
            self._require_standing(first)
        self._flush_trigger(before_motion=True)
        self.straight(end, duration, feed, exact)

    def _require_standing(self, first: Word) -> None:
        if self.flowing:
            self.fail(first, "the path before runs into this move (G64); let the machine stop first, write G4 F0.1")

    def _arc(self, block: dict[str, Word], first: Word) -> None:
        if not self.active("G60"):
            self.fail(first, "a move at a feed is blended into the next (G64), its path is not known; write G60")
        self._require_standing(first)
        self._flush_trigger(before_motion=True)
        self.arc(block, first, True)

    def _end(self, word: Word) -> None:
        if self.action is not None:
            self.line = self.action[0]
            self.fail(None, "the action waits for a next block that never comes; write a dwell after it")
        if self.of_pose is not None and self.transformed:
            self.fail(word, f"the transformation is still on; write {self.of_pose.transformation_off} before")
        self.ended = True


def read_sinumerik(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    settings = case.need_settings(SinumerikAxes, "a SINUMERIK program")
    lines = program_lines(content, file, LONGEST_LINE, settings.most_blocks)
    return _SinumerikInterpreter(file, settings, case).read_program(lines, sinumerik_words)
