"""Reads TwinCAT CNC (TF5200, ISG kernel) programs as the controller would, as far as a hexapod's program can go.

Everything else is refused with line and column. Words: the TF5200 programming manual; kinematics, sign of B and M
functions are those of the case. In a machine's own axes no transformation is active, and moves go from rest to rest.
"""

import re

import numpy as np

from cases.controller import TWINCAT_NAME, TwinCat, TwinCatAxes
from cases.schema import Case
from postprocessors.reading import Reading, axis_letters, program_lines
from postprocessors.reading.modal import ModalState, Word
from postprocessors.reading.twincat_words import (
    GROUPS,
    LONGEST_LINE,
    MOST_MESSAGES,
    OTHERS,
    twincat_words,
)

_OF_OWN_AXES = {"G1", "G17", "G90", "G94", "G71"}  # modal words
FEWEST_SPLINE_POINTS = 3  # fewest points of an AKIMA spline, its start included
_DEVIATION = re.compile(r"(?P<name>PATH_DEV|TRACK_DEV)=(?P<value>\d+\.?\d*|\.\d+)$")


class _TwinCatInterpreter(ModalState):
    """Meaning of the words."""

    name, groups, others, last, straight_word = "TwinCAT", GROUPS, OTHERS, "M30", "G01"
    block_time, inverse_time = "F, the block's time in seconds", False
    feed_group = "#FGROUP [{}]"

    def __init__(self, file: str, settings: TwinCatAxes, case: Case) -> None:
        self.settings = settings
        self.of_pose = settings if isinstance(settings, TwinCat) else None  # None: in the machine's own axes
        letters = "XYZABC"
        if self.of_pose is None:
            letters = axis_letters(case, "TwinCAT", file, endless=False)
        super().__init__(file, letters, self.of_pose is None)
        # commands that state what the case says, with the text behind them
        self.stated = {"#SLOPE": f"TYPE={settings.slope}", "#TRAFO OFF": ""}
        needed = ["G90", "G71", "#SLOPE", "G94", "#TRAFO OFF"]
        if self.of_pose is not None:
            self.scale[4] *= self.of_pose.angle_sign_b
            self.stated |= {"#KIN ID": str(self.of_pose.kinematic_id), "#TRAFO ON": ""}
            needed[3:] = ["#KIN ID", "#TRAFO ON"]
        self.needed = {f"{name} {self._behind(name)}".rstrip(): (name,) for name in needed}
        self.curve = ""  # SPLINE, HSC or CONTOUR while a path of points is open
        self.akima = self.contour = False  # whether the settings that SPLINE and CONTOUR need are active
        self.points = 0  # of the path, its start included
        self.stopped = False  # whether an exact stop has ended the points
        self.messages = 0

    def read(self, words: list[Word]) -> None:
        block = self.once_each(words)
        command = next((w for name, w in block.items() if name.startswith("#")), None)
        if command is not None:
            self._command(command)
            return
        for name, word in block.items():
            self._word(name, word, block)
        if "G4" in block:
            self._dwell(block)
        else:
            if "" in block:
                self.fail(block[""], "a number without a letter; write its letter")
            self._feed_and_move(block)
        if end := block.get("M30") or block.get("M2"):
            if self.curve:
                self.fail(end, "a path of points is still open at the end; close it")
            self.end(end, "#TRAFO OFF")

    def _word(self, name: str, word: Word, block: dict[str, Word]) -> None:
        if name in ("N", "G4", "G60", "M2", "M30", ""):
            return
        if name in (_OF_OWN_AXES if self.own_axes else self.group_of) and word.value is None:
            if name == "G261":
                self._open("CONTOUR", word)
            elif name == "G260":
                self._close("CONTOUR", word)
            self.activate(name)
        elif name in (*self.axes, "F") or (name in ("I", "J", "K") and not self.own_axes):
            self.require_number(word)
        elif name == "%":
            program = (word.arguments or ("",))[0]
            if self.motions.stretches or self.motions.switched or self.modal or re.match(TWINCAT_NAME, program) is None:
                self.fail(word, f"program name {program!r} is not taken; one plain name at the start of the file")
        elif name in (f"M{self.settings.trigger_on_m}", f"M{self.settings.trigger_off_m}"):
            self._switch(name, word, block)
        else:
            hint = "a word of an excitation; remove it"
            if name[:1] == "M":
                hint = (
                    f"the trigger's M function; write M{self.settings.trigger_on_m} and M{self.settings.trigger_off_m}"
                )
            self.refuse(word, f"not {hint}")

    def _switch(self, name: str, word: Word, block: dict[str, Word]) -> None:
        self.require_alone(word, block)
        if self.curve or self.flowing:
            self.fail(word, f"{name} while the machine moves on; let it stop first, write G60 in the block before")
        self.motions.switch(self.line, name == f"M{self.settings.trigger_on_m}", at_once=True)

    def _command(self, word: Word) -> None:
        name, s = word.name, self.of_pose
        if self.curve and name not in ("#SPLINE OFF", "#HSC OFF"):
            self.fail(word, f"{name} within a path of points; end it first")
        match name:
            case _ if name in self.stated:
                if ",".join(word.arguments or ()) != self.stated[name] or word.value is not None:
                    self.fail(word, f"{name} is not what the case says; write {name}{self._behind(name)}")
                if name == "#KIN ID" and self.transformed:
                    self.fail(word, "the kinematics cannot change while the transformation is on; write #TRAFO OFF")
                if name.startswith("#TRAFO"):
                    self.transformed = name == "#TRAFO ON"
                    self.said -= {"#TRAFO ON", "#TRAFO OFF"}
                self.said.add(name)
            case "#FGROUP":
                self.feed_axes = word.arguments or ()
            case "#MSG" | "#MSG SYN":
                self.messages += 1
                if self.messages > MOST_MESSAGES:
                    self.fail(word, f"the controller stops at {MOST_MESSAGES} messages that nobody reads; remove some")
            case "#TIME":
                self._pause(word, word.value)
            case "#SPLINE TYPE AKIMA" if s is not None:
                self.akima = True
            case "#SPLINE ON" if s is not None:
                self._open("SPLINE", word)
            case "#SPLINE OFF":
                self._close("SPLINE", word)
            case "#HSC ON" if s is not None:
                self._require_deviations(word, "BSPLINE", s)
                self._open("HSC", word)
            case "#HSC OFF":
                self._close("HSC", word)
            case "#CONTOUR MODE" if s is not None:
                self._require_deviations(word, "DEV", s)
                self.contour = True
            case _:
                self.refuse(word, "not a command of an excitation; remove it")

    def _open(self, kind: str, word: Word) -> None:
        """Begins a path where the machine stands, of a kind that was chosen before; refuses one within another."""
        if kind == "SPLINE" and not self.akima:
            self.fail(word, "#SPLINE ON before #SPLINE TYPE AKIMA; add it")
        if kind == "CONTOUR" and (not self.contour or self.curve):
            self.fail(word, "G261 needs #CONTOUR MODE before it, and no other curve; correct that")
        if self.curve:
            self.fail(word, f"{word.name} while another curve is open; end it first")
        if np.isnan(self.pose).any():
            self.fail(word, "a path of points starts from an unknown pose; first move home at a feed (G94)")
        if self.flowing:
            self.fail(word, "a path of points starts while the machine moves on; write G60 in the block before")
        self.curve, self.points, self.stopped = kind, 1, False

    def _close(self, kind: str, word: Word) -> None:
        """Ends a path; refuses one of another kind or with too few points."""
        if self.curve != kind:
            self.fail(word, f"{word.name} without its beginning; remove it")
        if kind == "SPLINE" and self.points < FEWEST_SPLINE_POINTS:
            self.fail(word, f"a spline needs {FEWEST_SPLINE_POINTS} points, its start included; add some")
        self.curve = ""

    def _point(self, first: Word, exact: bool) -> None:
        """Adds a timed block as a point of the path; the first move of a program needs no path."""
        if not self.curve:
            if not np.isnan(self.pose).any():
                problem = "a timed block (G93) is a corner without a curve; write #SPLINE ON before the points"
                self.fail(first, problem)
            return
        if self.stopped:
            self.fail(first, "a point after an exact stop within a path; write G60 in the last block alone")
        self.points += 1
        self.stopped = exact

    def _require_deviations(self, word: Word, kind: str, settings: TwinCat) -> None:
        """Refuses a curve that may leave its points by more than the case allows; both deviations must be stated."""
        s, arguments = settings, word.arguments or ()
        limits = {"PATH_DEV": s.path_deviation_mm, "TRACK_DEV": s.track_deviation_deg}
        text = f"[{kind} PATH_DEV={s.path_deviation_mm:g} TRACK_DEV={s.track_deviation_deg:g}]"
        deviations = {m["name"]: float(m["value"]) for item in arguments[1:] if (m := _DEVIATION.match(item))}
        if arguments[:1] != (kind,) or len(arguments) != 3 or set(deviations) != set(limits):
            self.fail(word, f"{word.name} needs its deviations; write {word.name} {text}")
        for name, limit in limits.items():
            if not 0.0 < deviations[name] <= limit:
                problem = f"{name}={deviations[name]:g} is not above 0 and at most {limit:g}, the case's; correct it"
                self.fail(word, problem)

    def _behind(self, name: str) -> str:
        """What a command states, in brackets."""
        text = self.stated.get(name, "")
        return f"[{text}]" if text else ""

    def _pause(self, word: Word, seconds: float | None) -> None:
        if self.curve:
            self.fail(word, "a dwell within a path of points; end it first")
        self.pause(word, seconds, "G04 0.3")

    def _dwell(self, block: dict[str, Word]) -> None:
        """Reads the dwell `G04 3.0` or `G04 X3.0` in seconds."""
        word = block["G4"]
        arguments = [w for name, w in block.items() if name not in ("G4", "N")]
        if len(arguments) != 1 or arguments[0].name not in ("", "X"):
            other = next((w for w in arguments if w.name not in ("", "X")), word)
            self.fail(other, "G04 stands in a block of its own with its seconds; write G04 0.3")
        self._pause(word, arguments[0].value)

    def _feed_and_move(self, block: dict[str, Word]) -> None:
        self.take_feed(block)
        coordinates = [block[name] for name in (*self.axes, "I", "J", "K") if name in block]
        if not coordinates:
            if "G60" in block:
                self.fail(block["G60"], "G60 without a motion in its block (error 20003); move it to a motion")
            return
        first = min(coordinates, key=lambda w: w.column)
        self.require_said(first)
        exact = "G60" in block or self.active("G360")
        if self.active("G2", "G3"):
            if not self.active("G162"):
                self.fail(first, "an arc needs relative centres; write G162")
            self._require_no_curve(first)
            self.arc(block, first, exact)
        else:
            end, duration, feed = self.target(block, first)
            if duration is None:
                self._require_no_curve(first)
            else:
                self._point(first, exact)
            # the exact stop at the end of a whole path is not a stop within it
            self.straight(end, duration, feed, exact and duration is None)
        self.flowing = not exact

    def _require_no_curve(self, first: Word) -> None:
        if self.curve:
            problem = "a block of the controller's own timing within a path of points; write G93 and F in seconds"
            self.fail(first, problem)


def read_twincat(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    settings = case.need_settings(TwinCatAxes, "a TwinCAT program")
    lines = program_lines(content, file, LONGEST_LINE, settings.most_blocks)
    return _TwinCatInterpreter(file, settings, case).read_program(lines, twincat_words)
