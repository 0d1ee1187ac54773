"""Reads programs in a machine's own axes, of SINUMERIK and of TwinCAT CNC: moves from rest to rest, and nothing else.

No transformation is active. Everything that is not such a move, a dwell, the trigger or a setting that the proof
relies on is refused with line and column.
"""

from abc import abstractmethod
from dataclasses import replace

import numpy as np

from cases.controller import SinumerikAxes, TwinCatAxes
from cases.schema import Case
from cases.units import DEG, MM
from postprocessors.reading import Pause, Reading, Switch, Timing, axis_letters, program_lines
from postprocessors.reading import sinumerik_words as siemens
from postprocessors.reading import twincat_words as isg
from postprocessors.reading.modal import LARGEST, LARGEST_FEED, ModalState, Spelling, Word

SAME_RADIUS = 1e-5  # [mm] of FGREF
MM_A_DEGREE = 180.0 / np.pi


class _OwnAxes(ModalState):
    """What the words of both have in common."""

    wanted: tuple[str, ...] = ()

    def __init__(self, file: str, spelling: Spelling, letters: str) -> None:
        turning = tuple(letter for letter in letters if letter in "ABC")
        super().__init__(
            file, spelling, list(letters), turning, np.array([DEG if a in turning else MM for a in letters])
        )
        self.said: set[str] = set()  # settings that stand in blocks of their own
        self.lengths = tuple(letter for letter in letters if letter not in turning)

    def read(self, words: list[Word]) -> None:
        block = self.once_each(words)
        self.require_one_of_each_group(block)
        for name, word in block.items():
            if name in self.axes or name == "F":
                if word.value is None or abs(word.value) > (LARGEST_FEED if name == "F" else LARGEST):
                    self.fail(word, f"{name} needs a plain number of a machine's size; correct it")
            elif name not in ("N", "G4", ""):
                self.setting(name, word, block)
        if "G4" in block:
            self.dwell(block)
            return
        if "" in block:
            self.fail(block[""], "a number without a letter; write its letter")
        self.take_feed(block)
        if coordinates := [block[name] for name in self.axes if name in block]:
            self._move(block, min(coordinates, key=lambda word: word.column))
        elif "G60" in block and self.in_a_motion:
            self.fail(block["G60"], "G60 without a motion in its block (error 20003); move it to a motion")
        if "M30" in block:
            self.ended = True

    @property
    @abstractmethod
    def in_a_motion(self) -> bool:
        """Whether G60 holds for the motion of its block alone."""

    @abstractmethod
    def setting(self, name: str, word: Word, seen: dict[str, Word]) -> None:
        """Takes a word that is no coordinate, feed or dwell."""

    @abstractmethod
    def dwell(self, seen: dict[str, Word]) -> None:
        """Takes a dwell."""

    def pause(self, word: Word, seconds: float | None) -> None:
        """A dwell of some seconds."""
        if seconds is None or not 0.0 <= seconds <= LARGEST:
            self.fail(word, f"{word.name} needs a duration in seconds that is not negative")
        self.events.append(Pause(self.line, seconds))

    def before_motion(self) -> None:
        """What happens with the next motion."""

    def _move(self, block: dict[str, Word], first: Word) -> None:
        for name in self.wanted:
            if name not in self.said and not self.active(name):
                self.fail(first, f"a move before {name}; what it means is not known, add it")
        if not self.active("G1"):
            self.fail(first, f"coordinates without {self.spelling.straight}; add it")
        if not (self.active("G60") or "G60" in block):
            self.fail(first, "a move without exact stop runs into the next, its path is not known; write G60")
        end = self.end_of(block, first)
        known = not np.isnan(self.pose).any()
        if not known:  # from anywhere: the feed must hold for every axis
            if self.feed is None or set(self.feed_axes or ()) != set(self.axes):
                group = self.spelling.feed_group.format(",".join(self.axes))
                self.fail(first, f"the first move comes from anywhere; write {group} and F, so that F counts all axes")
            timing, value = Timing.FEED, self.feed * (MM if self.lengths else DEG) / 60.0
        else:
            timing, value = self.timing(block, end, first)
        move = self.straight(end, timing, value, exact=True)
        self.before_motion()
        axes = np.flatnonzero(self.linear if move.linear else ~self.linear)
        self.events.append(replace(move, counted=tuple(map(int, axes))) if known else move)


class _Sinumerik(_OwnAxes):
    wanted: tuple[str, ...] = ("G90", "G710", "G500", "SOFT", "TRAFOOF", "COMPOF", "G94")

    def __init__(self, file: str, letters: str, settings: SinumerikAxes) -> None:
        spelling = Spelling(
            "SINUMERIK", siemens.GROUPS, last="M30", rapid="G0", straight="G1",
            block_time="F = 60 / seconds", inverse_time=True, feed_group="FGROUP({})",
        )  # fmt: skip
        super().__init__(file, spelling, letters)
        self.settings = settings
        self.switch: Switch | None = None
        self.wanted = (*self.wanted, *(f"FGREF[{a}]" for a in self.angles))

    @property
    def in_a_motion(self) -> bool:
        return False

    def setting(self, name: str, word: Word, seen: dict[str, Word]) -> None:
        allowed = {"G1", "G17", "G90", "G94", "G710", "G500", "G60", "COMPOF", "SOFT"}
        if name in allowed:
            self.activate(name)
        elif name == "%" or name in siemens.NEUTRAL:
            pass
        elif name == "TRAFOOF":
            self.said.add(name)
        elif name == "FGREF":
            radius = float((word.arguments or ("nan",))[0])
            if word.selector not in self.angles or not abs(radius - MM_A_DEGREE) <= SAME_RADIUS:
                self.fail(word, f"FGREF[{word.selector}]={radius:g} is not 1 mm a degree; write {MM_A_DEGREE:.6f}")
            self.said.add(f"FGREF[{word.selector}]")
        elif name == "FGROUP":
            self.feed_axes = word.arguments or ()
        elif name == "DO":
            self._action(word)
        elif name == "M30":
            if self.switch is not None:
                self.fail(None, "the action waits for a next block that never comes; write a dwell after it")
        else:
            remedy = siemens.REMEDY.get(name, "not a word of a program in own axes; remove it")
            self.fail(word, f"{name.rstrip('=')} is {remedy}")

    def _action(self, word: Word) -> None:
        """A non-modal synchronised action acts with the next executable block."""
        output, index, value = word.arguments or ("", "", "")
        number = str(self.settings.trigger_output)
        if word.selector is not None or (output, index) != ("$A_OUT", number) or value not in ("0", "1"):
            self.fail(word, f"the action is not the trigger's; write DO $A_OUT[{number}]=1 or =0")
        self._flush(at_once=True)
        self.switch = Switch(self.line, value == "1", at_once=False)

    def _flush(self, at_once: bool) -> None:
        if self.switch is not None:
            self.events.append(replace(self.switch, at_once=at_once))
            self.switch = None

    def before_motion(self) -> None:
        self._flush(at_once=False)

    def dwell(self, seen: dict[str, Word]) -> None:
        if set(seen) - {"G4", "F", "N"}:
            self.fail(seen["G4"], "G4 stands in a block of its own with its seconds as F; write G4 F0.3")
        self._flush(at_once=True)
        self.pause(seen["G4"], seen["F"].value if "F" in seen else None)


class _TwinCat(_OwnAxes):
    wanted: tuple[str, ...] = ("G90", "G71", "G94", "#SLOPE", "#TRAFO OFF")

    def __init__(self, file: str, letters: str, settings: TwinCatAxes) -> None:
        spelling = Spelling(
            "TwinCAT", isg.GROUPS, last="M30", rapid="G00", straight="G01",
            block_time="F, the block's time in seconds", inverse_time=False, feed_group="#FGROUP [{}]",
        )  # fmt: skip
        super().__init__(file, spelling, letters)
        self.settings = settings

    @property
    def in_a_motion(self) -> bool:
        return True

    def setting(self, name: str, word: Word, seen: dict[str, Word]) -> None:
        s = self.settings
        if name in ("G1", "G17", "G90", "G94", "G71") and word.value is None:
            self.activate(name)
        elif name in ("G60", "%", "M30"):
            pass
        elif name in (f"M{s.trigger_on_m}", f"M{s.trigger_off_m}"):
            if set(seen) - {name, "N"}:
                self.fail(word, f"{name} stands in a block of its own; move the other words")
            self.events.append(Switch(self.line, name == f"M{s.trigger_on_m}", at_once=True))
        elif name == "#SLOPE":
            if word.arguments != (f"TYPE={s.slope}",):
                self.fail(word, f"#SLOPE is not what the case says; write #SLOPE [TYPE={s.slope}]")
            self.said.add(name)
        elif name == "#TRAFO OFF":
            self.said.add(name)
        elif name == "#FGROUP":
            self.feed_axes = word.arguments or ()
        else:
            self.fail(word, f"{name} is {isg.REMEDY.get(name, 'not a word of a program in own axes; remove it')}")

    def dwell(self, seen: dict[str, Word]) -> None:
        arguments = [word for name, word in seen.items() if name not in ("G4", "N")]
        if len(arguments) != 1 or arguments[0].name not in ("", "X"):
            self.fail(seen["G4"], "G04 stands in a block of its own with its seconds; write G04 0.3")
        self.pause(seen["G4"], arguments[0].value)


def read_sinumerik_axes(content: bytes, file: str, case: Case) -> Reading:
    """Reads a SINUMERIK program.

    Args:
        content: content of the file.
        file: its name, for messages.
        case: names the axes, and gives the trigger's output and the limits of the program memory.

    Raises:
        ProgramError: anything that is not understood, with line and column; no end of program.
        CaseError: the case has no settings of this dialect.
    """
    chain, _ = case.need_chain("a program")
    settings = case.need_controller("a SINUMERIK program").need_sinumerik_axes(case.name)
    letters = axis_letters(chain, "SINUMERIK", file, endless=False)
    lines = program_lines(content.decode("latin-1"), file, siemens.LONGEST_LINE, settings.most_blocks)
    return _Sinumerik(file, letters, settings).read_program(lines, siemens.sinumerik_words)


def read_twincat_axes(content: bytes, file: str, case: Case) -> Reading:
    """Reads a TwinCAT program; see `read_sinumerik_axes`."""
    chain, _ = case.need_chain("a program")
    settings = case.need_controller("a TwinCAT program").need_twincat_axes(case.name)
    letters = axis_letters(chain, "TwinCAT", file, endless=False)
    lines = program_lines(content.decode("latin-1"), file, isg.LONGEST_LINE, settings.most_blocks)
    return _TwinCat(file, letters, settings).read_program(lines, isg.twincat_words)
