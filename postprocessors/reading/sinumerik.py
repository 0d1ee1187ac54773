"""Reads SINUMERIK 840D sl / ONE programs as the controller would, as far as a hexapod's program can go.

Everything else is refused with line and column. Words: 840D sl / ONE programming manuals; the orientation words, the
transformation and the trigger's output are those of the case.
"""

import math
import re
from typing import NoReturn

import numpy as np

from cases.controller_sinumerik import PROGRAM_NAME, Sinumerik
from cases.errors import ProgramError
from cases.schema import Case
from cases.units import DEG, MINUTE, MM
from postprocessors.reading.lines import program_lines
from postprocessors.reading.modal import LARGEST, LARGEST_FEED, ModalState, Word
from postprocessors.reading.sinumerik_groups import (
    COEFFICIENTS,
    GROUPS,
    LONGEST_LINE,
    MODAL,
    NEUTRAL,
    REMEDY,
)
from postprocessors.reading.sinumerik_words import sinumerik_words
from postprocessors.reading.words import Array, Move, Pause, Polynomial, Reading, Switch, Timing

_COMPRESSED = {"N", "G1", "X", "Y", "Z", "F"}
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)$")


class _Interpreter(ModalState):
    """What the words mean."""

    def __init__(self, file: str, settings: Sinumerik) -> None:
        numbered = any(w[-1].isdigit() for w in settings.orientation_words)
        axes = ["X", "Y", "Z", *(w + "=" if w[-1].isdigit() else w for w in settings.orientation_words)]
        super().__init__(file, GROUPS, axes, np.r_[np.full(3, MM), np.full(3, DEG)])
        self.settings = settings
        self.path_axes: tuple[str, ...] | None = None
        self.trigger: Switch | None = None
        self.rpy_needed = numbered

    def read(self, line: int, words: list[Word]) -> None:
        self.line = line
        if self.ended:
            self.fail(words[0], "a word after the end of the program; M30 must be last")
        seen: dict[str, Word] = {}
        polynomials: list[Word] = []
        for word in words:
            if word.name == "PO":
                polynomials.append(word)
                continue
            if word.name in seen:
                self.fail(word, f"a second {word.name.rstrip('=')} word in one block; remove one")
            seen[word.name] = word
        self.require_one_of_each_group(seen)
        for name, word in seen.items():
            self._modal(name, word, seen)
        if "G4" in seen:
            self._dwell(seen)
        else:
            self._feed_and_move(seen, polynomials)
        if "M30" in seen or "M2" in seen:
            self._end(seen.get("M30") or seen.get("M2"))

    def _modal(self, name: str, word: Word, seen: dict[str, Word]) -> None:
        if name in NEUTRAL or name in ("G4", "M2", "M30"):
            return
        if name in MODAL:
            if name in ("G93", "G94"):
                self.feed = None  # changing the kind of feed deletes it
            if name == "PTP":
                self._into_struts(word)
            self.activate(name)
        elif name in self.axes or name in ("F", "PL=", "I", "J", "K"):
            largest = LARGEST_FEED if name == "F" else LARGEST
            if word.value is None or abs(word.value) > largest:
                self.fail(word, f"{name.rstrip('=')} needs a plain number of a machine's size; correct it")
        elif name == "%":
            self._program_name(word)
        elif name == "FGROUP":
            self.path_axes = word.arguments or ()
        elif name in ("CTOL=", "OTOL="):
            self._tolerance(name[:-1], word)
        elif name == "DO":
            self._action(word)
        elif self._called(word) == self.settings.transformation:
            self._alone(word, seen)
            self.transformed = True
        elif self._called(word) == self.settings.transformation_off:
            self._alone(word, seen)
            self.transformed = False
        else:
            self._refuse(name, word)

    def _into_struts(self, word: Word) -> None:
        if self.settings.ptp is None:
            self.fail(word, "PTP is straight in the struts, whose drives are not known; add controller.sinumerik.ptp")
        if not self.transformed:
            self.fail(
                word, f"PTP without transformation is no move of the platform; write {self.settings.transformation}"
            )

    def _refuse(self, name: str, word: Word) -> NoReturn:
        angles = self.settings.orientation_words
        if name in ("A", "B", "C") and name not in angles:
            self.fail(
                word, f"{name} is a rotary axis of the machine; the angles are {', '.join(angles)}, as {angles[0]}="
            )
        if name.endswith("=") and name[:-1] in REMEDY | dict.fromkeys("XYZABCF"):
            self.fail(word, f"{name[:-1]} is not read here as an assignment; write {name[:-1]} and its number")
        if name in ("TRAORI", "TRAFOOF") or name.startswith("TRA"):
            wanted = f"{self.settings.transformation} and {self.settings.transformation_off}"
            self.fail(word, f"{self._called(word)} is not the case's transformation; write {wanted}")
        what = "Q" if name == "Q" else name.rstrip("=")
        self.fail(word, f"{what} is {REMEDY.get(name, 'not a word of an excitation; remove it')}")

    @staticmethod
    def _called(word: Word) -> str:
        return word.name if word.arguments is None else f"{word.name}({','.join(word.arguments)})"

    def _alone(self, word: Word, seen: dict[str, Word]) -> None:
        if set(seen) - {word.name, "N"}:
            self.fail(word, f"{word.name} stands in a block of its own; move the other words")

    def _program_name(self, word: Word) -> None:
        name = (word.arguments or ("",))[0]
        if re.match(PROGRAM_NAME, name) is None:
            self.fail(word, f"program name {name!r} is not taken; at most 24 letters, digits and _, two letters first")

    def _tolerance(self, name: str, word: Word) -> None:
        s = self.settings
        limit = s.contour_tolerance_mm if name == "CTOL" else s.orientation_tolerance_deg
        if word.value is None or not 0.0 < word.value <= limit:
            self.fail(word, f"{name} is not above 0 and at most {limit:g}, the tolerance of the case; correct it")

    def _action(self, word: Word) -> None:
        """A non-modal synchronised action acts with the next executable block."""
        output, index, value = word.arguments or ("", "", "")
        number = str(self.settings.trigger_output)
        if word.selector is not None:
            self.fail(word, f"{word.selector.split()[0].upper()} makes the action wait for a condition; write DO alone")
        if output != "$A_OUT" or index != number or value not in ("0", "1"):
            self.fail(word, f"the action is not the trigger's; write $A_OUT[{number}]=1 or =0")
        self._flush_trigger(before_motion=False)
        self.trigger = Switch(self.line, value == "1", at_once=False)

    def _flush_trigger(self, before_motion: bool) -> None:
        if self.trigger is not None:
            self.events.append(Switch(self.trigger.line, self.trigger.on, at_once=not before_motion))
            self.trigger = None

    def _dwell(self, seen: dict[str, Word]) -> None:
        word = seen["G4"]
        if set(seen) - {"G4", "F", "N"}:
            other = next(w for name, w in seen.items() if name not in ("G4", "F", "N"))
            self.fail(other, "G4 stands in a block of its own with its seconds as F; write G4 F0.3")
        seconds = seen["F"].value if "F" in seen else None
        if seconds is None or seconds < 0.0:
            self.fail(word, "G4 needs a duration in seconds that is not negative; write G4 F0.3")
        self._flush_trigger(before_motion=False)
        self.events.append(Pause(self.line, seconds))
        self.flowing = False

    def _feed_and_move(self, seen: dict[str, Word], polynomials: list[Word]) -> None:
        self.take_feed(seen)
        named = [name for name in (*self.axes, "I", "J", "K", "PL=") if name in seen]
        if not named and not polynomials:
            return
        first = polynomials[0] if polynomials else seen[named[0]]
        self._require_ready(first)
        if self.active("PTP") and (polynomials or self.active("POLY", "G2", "G3", "COMPCAD")):
            self.fail(first, "PTP makes straight moves alone; write CP before")
        if polynomials or self.active("POLY"):
            self._polynomial(seen, polynomials, named, first)
        elif self.active("G2", "G3"):
            self._arc(seen, first)
        elif "PL=" in seen:
            self.fail(seen["PL="], "PL without PO; remove it")
        else:
            self._line(seen, first)
        self.flowing = self.active("G64", "G642")

    def _require_ready(self, word: Word) -> None:
        wanted = ["G90", "G710", "G500", "SOFT", "ORIAXES"] + (["ORIWKS", "ORIRPY"] if self.rpy_needed else [])
        for name in wanted:
            if not self.active(name):
                self.fail(word, f"a move before {name}; what it means is not known, add {name}")
        if not self.transformed:
            name = self.settings.transformation
            self.fail(word, f"a move before {name}; without it X, Y, Z are no coordinates of the platform, add it")
        if not self.active("G60", "G64", "G642"):
            self.fail(word, "a move before G60 or G64; whether the machine stops after it is not known, add one")

    def _line(self, seen: dict[str, Word], first: Word) -> None:
        if not self.active("G0", "G1"):
            self.fail(first, "coordinates without G0 or G1; add G1")
        for name in ("I", "J", "K"):
            if name in seen:
                self.fail(seen[name], f"{name} without G2 or G3; remove it")
        if self.active("COMPCAD"):
            allowed = _COMPRESSED | set(self.axes)
            other = next((w for name, w in seen.items() if name not in allowed), None)
            if other is not None or not self.active("G1"):
                self.fail(other or first, "the compressor takes nothing but G1, coordinates and F; write COMPOF before")
        end = self.end_of(seen, first)
        if self.active("PTP"):
            self._strut_line(seen, first, end)
            return
        timing, value = self._timing(seen, end, first)
        exact = self.active("G60")
        if timing is Timing.DURATION and exact and not np.isnan(self.pose).any():
            self.fail(first, "a timed block under G60 stops at its end and does not keep the time; write G64")
        if timing is not Timing.DURATION and not exact:
            self.fail(
                first, "a move at a feed is blended into the next (G64), its path is not known; write G60, or G93"
            )
        if timing is not Timing.DURATION:
            self._require_standing(first)
        self._flush_trigger(before_motion=True)
        self.events.append(Move(self.line, end * self.scale, timing, value, exact, self.moves_origin(end)))
        self.pose = end

    def _strut_line(self, seen: dict[str, Word], first: Word, end: Array) -> None:
        """F under G94 would count axes that differ from machine to machine; a time does not."""
        if not self.active("G60"):
            self.fail(first, "a move under PTP is blended into the next (G64), its path is not known; write G60")
        rapid = self.active("G0")
        if not rapid and self.settings.ptp is not None and self.settings.ptp.feed == "rapid":
            self.fail(first, "controller.sinumerik.ptp.feed says that moves under PTP are rapids; write G0")
        if not rapid and not (self.active("G93") and "F" in seen):
            self.fail(first, "what F counts under PTP differs from machine to machine; write G93 and F = 60 / seconds")
        timing, value = self._timing(seen, end, first)
        self._require_standing(first)
        self._flush_trigger(before_motion=True)
        share = math.nan if rapid else 1.0 / value
        kind = timing if rapid else Timing.FEED
        self.events.append(Move(self.line, end * self.scale, kind, share, True, self.moves_origin(end), in_struts=True))
        self.pose = end

    def _require_standing(self, first: Word) -> None:
        if self.flowing:
            self.fail(first, "the path before runs into this move (G64); let the machine stop first, write G4 F0.1")

    def _timing(self, seen: dict[str, Word], end: Array, first: Word) -> tuple[Timing, float]:
        if self.active("G0"):
            return Timing.RAPID, math.nan
        if self.active("G93"):
            if "F" not in seen:
                self.fail(first, "G1 without F in inverse time (G93); add F = 60 / seconds")
            return Timing.DURATION, MINUTE / float(seen["F"].value or math.nan)
        if not self.active("G94"):
            self.fail(first, "a feed before G93 or G94; what it means is not known, add G94")
        if self.feed is None:
            self.fail(first, "G1 without a feed; add F")
        linear = self.moves_origin(end)
        counted = ("X", "Y", "Z") if linear else self.settings.orientation_axes
        if self.path_axes != counted:
            named = ",".join(counted)
            self.fail(first, f"F counts {', '.join(counted)} in this move only after FGROUP({named}); add it before")
        return Timing.FEED, self.feed * (MM if linear else DEG) / MINUTE

    def _arc(self, seen: dict[str, Word], first: Word) -> None:
        if np.isnan(self.pose).any():
            self.fail(first, "an arc starts from an unknown pose; first move home at a feed (G94)")
        plane = self.plane()
        if plane is None or self.feed is None or not self.active("G94"):
            self.fail(first, "an arc needs a plane and a feed per minute; write G17 and G94 and F")
        if self.path_axes != ("X", "Y", "Z"):
            self.fail(first, "F counts X, Y, Z in this move only after FGROUP(X,Y,Z); add it before")
        if not self.active("G60"):
            self.fail(first, "a move at a feed is blended into the next (G64), its path is not known; write G60")
        self._require_standing(first)
        turn = self.turn(seen, first, plane, self.feed)
        self._flush_trigger(before_motion=True)
        self.events.append(turn)

    def _polynomial(self, seen: dict[str, Word], pieces: list[Word], named: list[str], first: Word) -> None:
        """X = a0 + a1 p + .. + a5 p^5 for p from 0 to PL, a1 from the end; p is assumed to pass evenly in time."""
        if not self.active("POLY"):
            self.fail(first, "PO without POLY; add POLY")
        other = next((seen[name] for name in named if name != "PL="), None)
        if other is not None:
            self.fail(other, f"{other.name.rstrip('=')} under POLY is a straight line among polynomials; write PO[ ]")
        if self.active("COMPCAD"):
            self.fail(first, "POLY under the compressor; write COMPOF before")
        if not self.active("G64"):
            self.fail(first, "POLY under exact stop or rounding does not keep its time; write G64")
        if not self.active("G93") or "F" not in seen:
            self.fail(first, "POLY without a time of its own; write G93 and F = 60 / seconds in the block")
        if np.isnan(self.pose).any():
            self.fail(first, "a polynomial starts from an unknown pose; first move home at a feed (G94)")
        if len(pieces) > self.settings.poly_axes:
            self.fail(pieces[-1], f"{len(pieces)} axes in a POLY block, the controller takes {self.settings.poly_axes}")
        length = float(seen["PL="].value or 0.0) if "PL=" in seen else 1.0
        if not length > 0.0:
            self.fail(seen["PL="], "PL is not positive; correct it")
        coefficients = np.zeros((COEFFICIENTS + 2, 6))
        coefficients[0] = self.pose
        end = self.pose.copy()
        axes = ("X", "Y", "Z", *self.settings.orientation_axes)
        moved: set[str] = set()
        for word in pieces:
            if word.selector not in axes or word.selector in moved:
                self.fail(
                    word, f"PO[{word.selector}] is not one of the six axes {', '.join(axes)}, each once; correct it"
                )
            moved.add(word.selector)
            k = axes.index(word.selector)
            end[k], higher = self._piece(word)
            coefficients[2 : 2 + len(higher), k] = [a * length**i for i, a in enumerate(higher, start=2)]
        coefficients[1] = end - coefficients[0] - coefficients[2:].sum(axis=0)
        self._flush_trigger(before_motion=True)
        duration = MINUTE / float(seen["F"].value or math.nan)
        self.events.append(Polynomial(self.line, coefficients * self.scale, duration))
        self.pose = end

    def _piece(self, word: Word) -> tuple[float, list[float]]:
        items = word.arguments or ()
        bad = next((item for item in items if _NUMBER.match(item) is None or abs(float(item)) > LARGEST), None)
        if bad is not None:
            self.fail(word, f"{bad!r} in PO[{word.selector}] is no plain number of a machine's size; correct it")
        end, *higher = (float(item) for item in items)
        if len(higher) > self.settings.poly_degree - 1:
            degree = self.settings.poly_degree
            self.fail(word, f"PO[{word.selector}] has degree {len(higher) + 1}, the controller takes {degree}")
        return end, higher

    def _end(self, word: Word | None) -> None:
        if self.trigger is not None:
            self.line = self.trigger.line
            self.fail(None, "the action waits for a next block that never comes; write a dwell after it")
        if self.transformed:
            self.fail(word, f"the transformation is still on; write {self.settings.transformation_off} before")
        self.ended = True


def read_sinumerik(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program.

    Args:
        content: of the file.
        file: its name, for messages.
        case: gives the words of the machine's transformation and the limits of its program memory.

    Raises:
        ProgramError: anything that is not understood, with line and column; no end of program.
        CaseError: the case has no settings of this dialect.
    """
    settings = case.need_controller("a SINUMERIK program").need_sinumerik(case.name)
    interpreter = _Interpreter(file, settings)
    blocks = 0
    for number, text in enumerate(program_lines(content, file, LONGEST_LINE, settings.most_blocks), start=1):
        if words := sinumerik_words(text, number, file):
            interpreter.read(number, words)
            blocks += 1
    if not interpreter.ended:
        raise ProgramError(file, 0, 0, "no M30 at the end; the file is truncated or not a SINUMERIK program")
    return Reading(file, tuple(interpreter.events), blocks)
