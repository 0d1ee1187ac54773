"""Reads TwinCAT CNC (TF5200, ISG kernel) programs as the controller would, as far as a hexapod's program can go.

Everything else is refused with line and column. Words: the TF5200 programming manual; kinematics, sign of B and M
functions are those of the case.
"""

import math
import re

import numpy as np

from cases.controller_twincat import PROGRAM_NAME, TwinCat
from cases.errors import ProgramError
from cases.schema import Case
from cases.units import DEG, MINUTE, MM
from postprocessors.reading.lines import program_lines
from postprocessors.reading.modal import LARGEST, LARGEST_FEED, ModalState, Word
from postprocessors.reading.twincat_groups import (
    FEWEST_SPLINE_POINTS,
    GROUPS,
    LONGEST_LINE,
    MODAL,
    MOST_MESSAGES,
    REMEDY,
)
from postprocessors.reading.twincat_words import twincat_words
from postprocessors.reading.words import Array, Move, Pause, Reading, Switch, Timing

_DEVIATION = re.compile(r"(?P<name>PATH_DEV|TRACK_DEV)=(?P<value>\d+\.?\d*|\.\d+)$")


class _Interpreter(ModalState):
    """What the words mean."""

    def __init__(self, file: str, settings: TwinCat) -> None:
        scale = np.r_[np.full(3, MM), np.full(3, DEG)] * [1, 1, 1, 1, settings.angle_sign_b, 1]
        super().__init__(file, GROUPS, list("XYZABC"), scale)
        self.settings = settings
        self.slope = self.kinematics = False
        self.feed_axes: tuple[str, ...] | None = None
        self.curve = ""  # what makes a path of points: SPLINE, HSC, CONTOUR
        self.akima = self.contour = False
        self.points = self.messages = 0
        self.in_struts = False  # #PTP ON
        self.stopped = False  # whether an exact stop has ended the points of a curve

    def read(self, line: int, words: list[Word]) -> None:
        self.line = line
        if self.ended:
            self.fail(words[0], "a word after the end of the program; M30 must be last")
        seen: dict[str, Word] = {}
        for word in words:
            if word.name in seen:
                self.fail(word, f"a second {word.name or 'bare number'} word in one block; remove one")
            seen[word.name] = word
        self.require_one_of_each_group(seen)
        command = next((w for name, w in seen.items() if name.startswith("#")), None)
        if command is not None:
            self._command(command)
            return
        for name, word in seen.items():
            self._word(name, word, seen)
        if "G4" in seen:
            self._dwell(seen)
        else:
            if "" in seen:
                self.fail(seen[""], "a number without a letter; write its letter")
            self._feed_and_move(seen)
        if "M30" in seen or "M2" in seen:
            self._end(seen.get("M30") or seen.get("M2"))

    def _word(self, name: str, word: Word, seen: dict[str, Word]) -> None:
        if name in ("N", "G4", "G60", "M2", "M30", ""):
            return
        if name in MODAL and word.value is None:
            self._mode(name, word)
        elif name in (*self.axes, "F", "I", "J", "K"):
            if word.value is None or abs(word.value) > (LARGEST_FEED if name == "F" else LARGEST):
                self.fail(word, f"{name} is no machine's number; correct it")
        elif name == "%":
            program = (word.arguments or ("",))[0]
            if self.events or self.modal or re.match(PROGRAM_NAME, program) is None:
                self.fail(word, f"program name {program!r} is not taken; one plain name at the start of the file")
        elif name in (f"M{self.settings.trigger_on_m}", f"M{self.settings.trigger_off_m}"):
            self._switch(name, word, seen)
        else:
            wanted = f"M{self.settings.trigger_on_m} and M{self.settings.trigger_off_m}"
            hint = f"not the trigger's M function; write {wanted}" if name[:1] == "M" else "not a word of an excitation"
            self.fail(word, f"{name} is {REMEDY.get(name, hint + '; remove it')}")

    def _mode(self, name: str, word: Word) -> None:
        if name in ("G93", "G94"):
            self.feed = None
        if name == "G261":
            if not self.contour or self.curve:
                self.fail(word, "G261 needs #CONTOUR MODE before it, and no other curve; correct that")
            self._open("CONTOUR", word)
        elif name == "G260":
            self._close("CONTOUR", word)
        self.activate(name)

    def _switch(self, name: str, word: Word, seen: dict[str, Word]) -> None:
        if set(seen) - {name, "N"}:
            self.fail(word, f"{name} stands in a block of its own; move the other words")
        if self.curve or self.flowing:
            self.fail(word, f"{name} while the machine moves on; let it stop first, write G60 in the block before")
        self.events.append(Switch(self.line, name == f"M{self.settings.trigger_on_m}", at_once=True))

    def _command(self, word: Word) -> None:
        name, s = word.name, self.settings
        arguments = word.arguments or ()
        if self.curve and name not in ("#SPLINE OFF", "#HSC OFF"):
            self.fail(word, f"{name} within a path of points; end it first")
        if self.in_struts and name not in ("#PTP OFF", "#MSG", "#MSG SYN", "#TIME"):
            self.fail(word, f"{name} under #PTP ON; write #PTP OFF before")
        match name:
            case "#PTP ON":
                self._equal(word, (), "alone")
                self._into_struts(word)
            case "#PTP OFF":
                self._equal(word, (), "alone")
                self.in_struts = False
            case "#SLOPE":
                self._equal(word, (f"TYPE={s.slope}",), f"[TYPE={s.slope}]")
                self.slope = True
            case "#KIN ID":
                self._equal(word, (str(s.kinematic_id),), f"[{s.kinematic_id}]")
                if self.transformed:
                    self.fail(word, "the kinematics cannot change while the transformation is on; write #TRAFO OFF")
                self.kinematics = True
            case "#TRAFO ON" | "#TRAFO OFF":
                self._equal(word, (), "alone")
                if name == "#TRAFO ON" and not self.kinematics:
                    self.fail(word, f"#TRAFO ON before #KIN ID[{s.kinematic_id}]; add it")
                self.transformed = name == "#TRAFO ON"
            case "#FGROUP":
                self.feed_axes = arguments
            case "#MSG" | "#MSG SYN":
                self.messages += 1
                if self.messages > MOST_MESSAGES:
                    self.fail(word, f"the controller stops at {MOST_MESSAGES} messages that nobody reads; remove some")
            case "#TIME":
                self._pause(word, word.value)
            case "#SPLINE TYPE AKIMA":
                self.akima = True
            case "#SPLINE ON":
                if not self.akima:
                    self.fail(word, "#SPLINE ON before #SPLINE TYPE AKIMA; add it")
                self._open("SPLINE", word)
            case "#SPLINE OFF":
                if self.curve == "SPLINE" and self.points < FEWEST_SPLINE_POINTS:
                    self.fail(word, f"a spline needs {FEWEST_SPLINE_POINTS} points, its start included; add some")
                self._close("SPLINE", word)
            case "#HSC ON":
                self._deviations(word, "BSPLINE", arguments)
                self._open("HSC", word)
            case "#HSC OFF":
                self._close("HSC", word)
            case "#CONTOUR MODE":
                self._deviations(word, "DEV", arguments)
                self.contour = True
            case _:
                self.fail(word, f"{name} is {REMEDY.get(name, 'not a command of an excitation; remove it')}")

    def _equal(self, word: Word, wanted: tuple[str, ...], written: str) -> None:
        if (word.arguments or ()) != wanted or word.value is not None:
            self.fail(word, f"{word.name} is not what the case says; write {word.name}{written.replace('alone', '')}")

    def _deviations(self, word: Word, kind: str, arguments: tuple[str, ...]) -> None:
        """The curve may leave its points by what the case allows; both must be stated, the defaults are loose."""
        s = self.settings
        limits = {"PATH_DEV": s.path_deviation_mm, "TRACK_DEV": s.track_deviation_deg}
        wanted = f"[{kind} PATH_DEV={s.path_deviation_mm:g} TRACK_DEV={s.track_deviation_deg:g}]"
        found = {m["name"]: float(m["value"]) for item in arguments[1:] if (m := _DEVIATION.match(item))}
        if arguments[:1] != (kind,) or len(arguments) != 3 or set(found) != set(limits):
            self.fail(word, f"{word.name} needs its deviations; write {word.name} {wanted}")
        for name, limit in limits.items():
            if not 0.0 < found[name] <= limit:
                self.fail(word, f"{name}={found[name]:g} is not above 0 and at most {limit:g}, the case's; correct it")

    def _into_struts(self, word: Word) -> None:
        if self.settings.ptp is None:
            self.fail(word, "#PTP ON is straight in the struts, whose drives are not known; add controller.twincat.ptp")
        if not self.transformed:
            self.fail(word, "#PTP ON without transformation (error 21527); write #TRAFO ON before")
        if self.flowing:
            self.fail(word, "#PTP ON while the machine moves on; write G60 in the block before")
        self.in_struts = True

    def _open(self, kind: str, word: Word) -> None:
        if self.in_struts:
            self.fail(word, f"{word.name} under #PTP ON; write #PTP OFF before")
        if self.curve:
            self.fail(word, f"{word.name} while another curve is open; end it first")
        if np.isnan(self.pose).any():
            self.fail(word, "a path of points starts from an unknown pose; first move home at a feed (G94)")
        if self.flowing:
            self.fail(word, "a path of points starts while the machine moves on; write G60 in the block before")
        self.curve, self.points, self.stopped = kind, 1, False

    def _close(self, kind: str, word: Word) -> None:
        if self.curve != kind:
            self.fail(word, f"{word.name} without its beginning; remove it")
        self.curve = ""

    def _pause(self, word: Word, seconds: float | None) -> None:
        if seconds is None or not 0.0 <= seconds <= LARGEST:
            self.fail(word, f"{word.name} needs a duration in seconds that is not negative; write G04 0.3")
        if self.curve:
            self.fail(word, "a dwell within a path of points; end it first")
        self.events.append(Pause(self.line, seconds))
        self.flowing = False

    def _dwell(self, seen: dict[str, Word]) -> None:
        """`G04 3.0` or `G04 X3.0`, seconds."""
        word = seen["G4"]
        given = [w for name, w in seen.items() if name not in ("G4", "N")]
        if len(given) != 1 or given[0].name not in ("", "X"):
            other = next((w for w in given if w.name not in ("", "X")), word)
            self.fail(other, "G04 stands in a block of its own with its seconds; write G04 0.3")
        self._pause(word, given[0].value)

    def _feed_and_move(self, seen: dict[str, Word]) -> None:
        self.take_feed(seen)
        named = [seen[name] for name in (*self.axes, "I", "J", "K") if name in seen]
        if not named:
            if "G60" in seen:
                self.fail(seen["G60"], "G60 without a motion in its block (error 20003); move it to a motion")
            return
        first = min(named, key=lambda w: w.column)
        self._require_ready(first)
        exact = "G60" in seen or self.active("G360")
        if self.active("G2", "G3"):
            self._arc(seen, first, exact)
        else:
            self._line(seen, first, exact)
        self.flowing = not exact

    def _require_ready(self, word: Word) -> None:
        for name in ("G90", "G71"):
            if not self.active(name):
                self.fail(word, f"a move before {name}; what it means is not known, add {name}")
        s = self.settings
        for done, name in (
            (self.slope, f"#SLOPE [TYPE={s.slope}]"),
            (self.kinematics, f"#KIN ID[{s.kinematic_id}]"),
            (self.transformed, "#TRAFO ON"),
        ):
            if not done:
                self.fail(word, f"a move before {name}; what it means is not known, add it")

    def _line(self, seen: dict[str, Word], first: Word, exact: bool) -> None:
        if not self.active("G0", "G1"):
            self.fail(first, "coordinates without G00 or G01; add G01")
        for name in ("I", "J", "K"):
            if name in seen:
                self.fail(seen[name], f"{name} without G02 or G03; remove it")
        end = self.end_of(seen, first)
        if self.in_struts:
            self._strut_line(seen, first, end, exact)
            return
        timing, value = self._timing(seen, end, first)
        if timing is Timing.DURATION:
            self._point(first, exact)
            exact = False  # the exact stop at the end of a whole path is no stop within it
        elif self.curve:
            self.fail(
                first, "a block of the controller's own timing within a path of points; write G93 and F in seconds"
            )
        elif not exact:
            self.fail(first, "whether the machine stops after this move is not known; write G60 in its block")
        self.events.append(Move(self.line, end * self.scale, timing, value, exact, self.moves_origin(end)))
        self.pose = end

    def _strut_line(self, seen: dict[str, Word], first: Word, end: Array, exact: bool) -> None:
        """F under G94 would count axes that differ from machine to machine; a time does not."""
        if not exact:
            self.fail(first, "whether the machine stops after this move is not known; write G60 in its block")
        rapid = self.active("G0")
        if not rapid and self.settings.ptp is not None and self.settings.ptp.feed == "rapid":
            self.fail(first, "controller.twincat.ptp.feed says that moves under #PTP ON are rapids; write G00")
        if not rapid and not (self.active("G93") and "F" in seen):
            self.fail(first, "what F counts under #PTP ON differs from machine to machine; write G93 and F in seconds")
        timing, value = self._timing(seen, end, first)
        share = math.nan if rapid else 1.0 / value
        kind = timing if rapid else Timing.FEED
        self.events.append(
            Move(self.line, end * self.scale, kind, share, exact, self.moves_origin(end), in_struts=True)
        )
        self.pose = end

    def _point(self, first: Word, exact: bool) -> None:
        if not self.curve:
            if not np.isnan(self.pose).any():
                self.fail(first, "a timed block (G93) is a corner without a curve; write #SPLINE ON before the points")
            return
        if self.stopped:
            self.fail(first, "a point after an exact stop within a path; write G60 in the last block alone")
        self.points += 1
        self.stopped = exact

    def _timing(self, seen: dict[str, Word], end: Array, first: Word) -> tuple[Timing, float]:
        if self.active("G0"):
            return Timing.RAPID, math.nan
        if self.active("G93"):
            if "F" not in seen:
                self.fail(first, "G01 without F under G93; add F, the block's time in seconds")
            return Timing.DURATION, float(seen["F"].value or math.nan)
        if not self.active("G94"):
            self.fail(first, "a feed before G93 or G94; what it means is not known, add G94")
        if self.feed is None:
            self.fail(first, "G01 without a feed; add F")
        linear = self.moves_origin(end)
        counted = ("X", "Y", "Z") if linear else ("A", "B", "C")
        if self.feed_axes != counted:
            named = ",".join(counted)
            self.fail(first, f"F counts {', '.join(counted)} in this move only after #FGROUP [{named}]; add it before")
        return Timing.FEED, self.feed * (MM if linear else DEG) / MINUTE

    def _arc(self, seen: dict[str, Word], first: Word, exact: bool) -> None:
        if np.isnan(self.pose).any():
            self.fail(first, "an arc starts from an unknown pose; first move home at a feed (G94)")
        plane = self.plane()
        if plane is None or self.feed is None or not self.active("G94") or not self.active("G162"):
            self.fail(first, "an arc needs a plane, relative centres and a feed per minute; write G17 G162 G94 and F")
        if self.feed_axes != ("X", "Y", "Z"):
            self.fail(first, "F counts X, Y, Z in this move only after #FGROUP [X,Y,Z]; add it before")
        if self.in_struts:
            self.fail(first, "an arc under #PTP ON; write #PTP OFF before")
        if self.curve or not exact:
            self.fail(first, "whether the machine stops after this arc is not known; write G60 in its block, no curve")
        self.events.append(self.turn(seen, first, plane, self.feed))

    def _end(self, word: Word | None) -> None:
        if self.curve:
            self.fail(word, "a path of points is still open at the end; close it")
        if self.in_struts:
            self.fail(word, "#PTP ON is still on at the end; write #PTP OFF before")
        if self.transformed:
            self.fail(word, "the transformation is still on; write #TRAFO OFF before")
        self.ended = True


def read_twincat(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program.

    Args:
        content: of the file.
        file: its name, for messages.
        case: gives kinematics, sign of B, M functions and the limits of the program memory.

    Raises:
        ProgramError: anything that is not understood, with line and column; no end of program.
        CaseError: the case has no settings of this dialect.
    """
    settings = case.need_controller("a TwinCAT program").need_twincat(case.name)
    interpreter = _Interpreter(file, settings)
    blocks = 0
    for number, text in enumerate(program_lines(content, file, LONGEST_LINE, settings.most_blocks), start=1):
        if words := twincat_words(text, number, file):
            interpreter.read(number, words)
            blocks += 1
    if not interpreter.ended:
        raise ProgramError(file, 0, 0, "no M30 at the end; the file is truncated or not a TwinCAT program")
    return Reading(file, tuple(interpreter.events), blocks)
