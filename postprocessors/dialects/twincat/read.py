"""Reads TwinCAT CNC (TF5200, ISG kernel) programs as the controller would, as far as an excitation needs.

All else is refused. Words: the TF5200 programming manual; kinematics, sign of B, deviations and M functions are those
of the case. In a machine's own axes no transformation is active, and moves go from rest to rest.
"""

import re

import numpy as np

from cases.controller import TWINCAT_NAME, TwinCat, TwinCatAxes
from cases.schema import Case
from postprocessors.dialects.modal import ModalState, Word
from postprocessors.reading import NUMBER, PLAIN, Reading, axis_letters, program_lines

LONGEST_LINE = 4096  # beyond it: error 20301
FEWEST_POINTS = 3  # fewest points of an AKIMA spline, its start included
MOST_MESSAGES = 10  # unread ones stop the controller
_READS = (
    "TwinCAT programs consist of G01 with G60 (of a platform also arcs, and G93 paths in #SPLINE, #HSC or G261), G04 "
    "0.3, the case's M functions, M00, commands and modal words as hexcite post writes them, comments behind ; and M30"
)
_PLAIN = re.compile(r'"[^"%]*"')  # a text for a message; behind % are formats of values
_OF_OWN_AXES = {"G1", "G17", "G90", "G94", "G71", "G53", "G40", "G20"}  # modal words
# what opens a path of points -> what must stand before it, and what closes it
_CURVES = {
    "#SPLINE ON": ("#SPLINE TYPE AKIMA", "#SPLINE OFF"),
    "#HSC ON": ("#TRAFO ON", "#HSC OFF"),
    "G261": ("#CONTOUR MODE", "G260"),
}


class TwinCatInterpreter(ModalState):
    """Meaning of the words."""

    name, last, reads, feed_group = "TwinCAT", ("M30", "M2"), _READS, "#FGROUP [{}]"
    title = re.compile(rf"%(?:{TWINCAT_NAME[1:-1]})\s*$")
    word = re.compile(
        rf"""(?P<comment>;.*)
        | (?P<command>\#[A-Z]+(?:\s+[A-Z_]{{2,}})*)\s*(?:\[(?P<items>(?:"[^"]*"|[^\]"])*)\])?\s*(?=;|$)
        | (?P<letter>[A-Z])(?P<number>{NUMBER})
        | (?P<bare>{NUMBER})""",
        re.IGNORECASE | re.VERBOSE,
    )
    home_check = re.compile(
        rf"\$IF ABS\[V\.A\.(?P<variable>ABS|ACT_POS)\.(?P<axis>[A-Z])(?P<place>[+-]{PLAIN})\] > (?P<within>{PLAIN})\n"
        r'#MSG \["[^"%\n]*"\]\n#ERROR \[ID=\d{1,4} RC=2\]\n\$ENDIF'
    )
    home_check_lines, condition, asks_where = 4, "$IF", "#CHANNEL INIT [CMDPOS]"
    resolution = 1e-4
    block_time, inverse_time = "F, the block's time in seconds", False
    groups = (
        *("G0 G1 G2 G3", "G17 G18 G19", "G93 G94", "G260 G261", "G359 G360"),
        *("G90", "G71", "G162", "G53", "G40", "G20", "M0 M1 M2 M30"),
    )

    def __init__(self, file: str, settings: TwinCatAxes, case: Case) -> None:
        letters = "XYZABC" if isinstance(settings, TwinCat) else axis_letters(case, "TwinCAT", file, endless=False)
        super().__init__(file, letters, not isinstance(settings, TwinCat))
        self.trigger = {f"M{settings.trigger_on_m}": True, f"M{settings.trigger_off_m}": False}
        # commands that state what the case says, with the text behind them
        self.to_state = {"#SLOPE": f"TYPE={settings.slope}", "#TRAFO OFF": "", "#CHANNEL INIT": "CMDPOS"}
        needed = ["G90", "G71", "G53", "#SLOPE", "G94", "#TRAFO OFF"]
        if isinstance(settings, TwinCat):
            self.scale[4] *= settings.angle_sign_b
            deviations = f"PATH_DEV={settings.path_deviation_mm:g} TRACK_DEV={settings.track_deviation_deg:g}"
            self.to_state |= {"#KIN ID": str(settings.kinematic_id), "#TRAFO ON": "", "#SPLINE TYPE AKIMA": ""}
            self.to_state |= {
                "#HSC ON": f"BSPLINE {deviations}",
                "#CONTOUR MODE": f"DEV {deviations}",
                "#SPLINE ON": "",
            }
            needed[4:] = ["#KIN ID", "#TRAFO ON"]
        self.needed = {self._stated(name): (name,) for name in needed}
        self.curve = ""  # the word that closes the open path of points
        self.points = 0  # of that path, its start included
        self.messages = 0

    @classmethod
    def word_of(cls, match: re.Match[str], column: int) -> Word:
        """The word of a match of `word`."""
        if match["command"]:
            items = (match["items"] or "").upper().replace(",", " ").split()
            return Word(" ".join(match["command"].upper().split()), column, None, tuple(items))
        return Word("", column, float(match["bare"])) if match["bare"] else super().word_of(match, column)

    def _stated(self, name: str) -> str:
        """A command with what it must state."""
        return f"{name} [{self.to_state[name]}]" if self.to_state.get(name) else name

    def confirms(self, match: re.Match[str]) -> bool:
        """V.A.ABS counts with the offsets that are active; V.A.ACT_POS has none."""
        return match["variable"].upper() == "ACT_POS"

    @classmethod
    def comment_problem(cls, text: str, match: re.Match[str]) -> tuple[str, str] | None:
        """The next line would belong to a comment that ends in a backslash."""
        if text.rstrip().endswith("\\"):
            return "the backslash makes the next line a part of this one", "remove it"
        return None

    def execute(self, block: dict[str, Word]) -> None:
        """Executes a block, within a path of points one of its points or its end."""
        of_a_path = {"G93", "G1", "G60", "F", *self.axes, self.curve}
        if self.curve and (other := next((w for n, w in block.items() if n not in of_a_path), None)):
            self.fail(other, f"{other.name} within a path of points", f"end it first with {self.curve}")
        super().execute(block)

    def read(self, block: dict[str, Word]) -> None:
        """Executes the words of one block, by their names."""
        for word in block.values():
            self._word(word, block)
        if "G4" in block:
            self.require_alone(block["G4"], block, "")
            self.pause(block["G4"], block.get(""), "G04 0.3")
        elif "" in block:
            self.refuse(block[""])
        else:
            self._move(block)
        if end := next((word for name, word in block.items() if name in self.last), None):
            self.end(end, "#TRAFO OFF")

    def _word(self, word: Word, block: dict[str, Word]) -> None:
        name = word.name
        if name.startswith("#"):
            self.require_alone(word, block)
        self.messages += name == "#MSG"
        if self.messages > MOST_MESSAGES:
            self.fail(word, f"the controller stops at {MOST_MESSAGES} messages that nobody reads", "remove some")
        if name == "#MSG" and not _PLAIN.fullmatch(",".join(word.arguments)):
            self.fail(word, "a message is one text without formats", 'write #MSG ["TEXT"]')
        if name in ("%", "G4", "G60", "F", "#MSG", "", *self.last, *self.axes):
            return
        if name in (_OF_OWN_AXES if self.own_axes else self.group_of):
            self.activate(name)
        elif name in self.trigger:
            self.require_alone(word, block)
            if self.flowing:
                self.fail(
                    word, f"{name} while the machine moves on", "let it stop first, write G60 in the block before"
                )
            self.motions.switch(self.line, self.trigger[name], at_once=True)
        elif name in self.to_state:
            if " ".join(word.arguments) != self.to_state[name]:
                self.fail(word, f"{name} is not what the case says", f"write {self._stated(name)}")
            if name == "#KIN ID" and self.transformed:
                self.fail(word, "the kinematics cannot change while the transformation is on", "write #TRAFO OFF")
            if name.startswith("#TRAFO"):
                self.transformed = name == "#TRAFO ON"
                self.said -= {"#TRAFO ON", "#TRAFO OFF", "#CHANNEL INIT"}
            self.said.add(name)
        elif name == "#FGROUP":
            self.feed_axes = word.arguments
        elif self.own_axes or name not in ("I", "J", "K", self.curve):
            self.refuse(word)
        if name in _CURVES:
            before, end = _CURVES[name]
            if before not in self.said or self.flowing or np.isnan(self.coordinates).any():
                problem = f"{name} opens a path of points behind {before}, where the machine stands at a known pose"
                self.fail(word, f"{problem}", "write G60 in the block before")
            self.curve, self.points = end, 1
        elif name == self.curve:
            if self.points < FEWEST_POINTS or self.flowing:
                self.fail(word, f"a path has {FEWEST_POINTS} points or more, its start included, the last with G60")
            self.curve = ""

    def _move(self, block: dict[str, Word]) -> None:
        self.take_feed(block)
        first = next((word for word in block.values() if word.name in (*self.axes, "I", "J", "K")), None)
        if first is None:
            if "G60" in block:
                self.fail(block["G60"], "G60 without a motion in its block (error 20003)", "move it to a motion")
            return
        self.require_said(first)
        exact = "G60" in block or self.active("G360")
        if self.active("G2", "G3"):
            if not self.active("G162"):
                self.fail(first, "an arc needs relative centres", "write G162")
            self.arc(block, first, exact)
        else:
            end, duration, feed = self.target(block, first)
            if (duration is not None) != bool(self.curve) or (self.points > 1 and self.curve and not self.flowing):
                problem = "G93 and a time belong to the points of a path, between #SPLINE ON and OFF, and to no others"
                self.fail(first, f"{problem}", "write G60 in the last point alone")
            self.points += 1
            # the exact stop at the end of a whole path is not a stop within it
            self.straight(end, duration, feed, exact and duration is None)
        self.flowing = not exact


def read_twincat(content: bytes, file: str, case: Case) -> Reading:
    """Reads a program, see `Dialect.read`."""
    settings = case.need_settings(TwinCatAxes, "a TwinCAT program")
    lines = program_lines(content, file, LONGEST_LINE, settings.most_blocks)
    return TwinCatInterpreter(file, settings, case).read_program(lines)
