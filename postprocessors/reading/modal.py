"""State of controllers with groups of modal words from block to block, whatever their language."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from typing import ClassVar, NamedTuple, NoReturn

import numpy as np

from cases.errors import ProgramError
from cases.units import DEG, MINUTE, MM
from identification.motion import Array
from identification.trajectories.moves import Plane
from postprocessors.reading import Grouping, Reading

ROUND = 2e-3  # [mm] largest difference of the radii at both ends, by rounding of words; LinuxCNC accepts 5e-3
STILL = 1e-7  # [mm] distance below which places are the same


LARGEST = 1e6  # mm, degrees, seconds: no machine has such numbers
LARGEST_FEED = 1e9  # per minute; 60 over a microsecond is 6e7
PLANES = {"G17": Plane.XY, "G18": Plane.ZX, "G19": Plane.YZ}


class Word(NamedTuple):
    """One word."""

    # address, keyword or command in capitals; of G and M with the number: G1, G162, M30. `%` is the program's name, `N`
    # a block number
    name: str
    column: int  # where it begins, counted from 1
    value: float | None = None  # number of the word
    arguments: tuple[str, ...] | None = None  # texts in parentheses or brackets behind it
    selector: str | None = None  # text in brackets before its value, or the condition of a synchronised action


class ModalState(ABC):
    """State of a controller while a program is read; subclasses define the words of their language.

    Args:
        axes: words of the coordinates, in their order; those of lengths are X, Y and Z.
        own_axes: whether the coordinates are the machine's own axes; else they are the pose of a platform.
    """

    name: ClassVar[str]  # name of the language, for messages
    groups: ClassVar[tuple[tuple[str, ...], ...]]  # groups of words of which one is active, and one may be in a block
    others: ClassVar[dict[str, str]]  # words of other meaning than a program needs, with a reason and a remedy
    last: ClassVar[str]  # the word that ends a program
    straight_word: ClassVar[str]  # the word of a straight move at a feed
    block_time: ClassVar[str]  # F under G93, for messages
    inverse_time: ClassVar[bool] = True  # whether that F is one over minutes; else seconds
    feed_group: ClassVar[str] = ""  # command that names the axes whose path F counts, with {} for them; empty: none

    def __init__(self, file: str, axes: Sequence[str], own_axes: bool) -> None:
        self.file = file
        self.group_of = {name: k for k, group in enumerate(self.groups) for name in group}
        self.axes = axes
        self.own_axes = own_axes
        self.line = 0
        self.motions = Grouping(file)
        self.linear = np.array([name in ("X", "Y", "Z") for name in axes])
        self.angles = tuple(name for name in axes if name not in ("X", "Y", "Z"))  # where F counts them
        self.scale = np.where(self.linear, MM, DEG)  # SI values of the coordinates' units [m or rad]
        self.said: set[str] = set()  # settings that were made, beside modal words
        # what a move needs before it, for messages -> modal words or settings of which any one is it
        self.needed: dict[str, tuple[str, ...]] = {}
        self.pose = np.full(len(axes), np.nan)  # as written; unknown until the first move has stated all
        self.modal: dict[int, str] = {}  # the active word of each group
        self.feed: float | None = None
        self.feed_axes: tuple[str, ...] | None = None
        self.transformed = self.ended = False
        self.flowing = False  # whether the machine need not stand at the end of the last block

    @abstractmethod
    def read(self, words: list[Word]) -> None:
        """Executes the words of one block; raises ProgramError for a word that is not understood."""

    def read_program(self, lines: Iterable[str], words_of: Callable[[str, int, str], list[Word]]) -> Reading:
        """Reads all lines, whose words are `words_of(text, line, file)`; errors as `Dialect.read`."""
        blocks = 0
        for number, text in enumerate(lines, start=1):
            if words := words_of(text, number, self.file):
                self.line = number
                if self.ended:
                    self.fail(words[0], f"a word after the end of the program; {self.last} must be last")
                self.read(words)
                blocks += 1
        if not self.ended:
            problem = f"no {self.last} at the end; the file is truncated or not a {self.name} program"
            raise ProgramError(self.file, 0, 0, problem)
        return self.motions.reading(blocks)

    def fail(self, word: Word, problem: str) -> NoReturn:
        """Raises ProgramError at a word."""
        raise ProgramError(self.file, self.line, word.column, problem)

    def activate(self, name: str) -> None:
        """Makes a word the active one of its group."""
        self.modal[self.group_of[name]] = name
        if name in ("G93", "G94"):
            self.feed = None  # a feed of the other kind has no meaning any more

    def active(self, *names: str) -> bool:
        """Whether one of these words is active."""
        return any(name in self.modal.values() for name in names)

    def once_each(self, words: Iterable[Word]) -> dict[str, Word]:
        """The words of a block by their names, each of which may stand in it once, and one of each group."""
        block: dict[str, Word] = {}
        first: dict[int, Word] = {}
        for word in words:
            if word.name in block:
                self.fail(word, f"a second {word.name.rstrip('=') or 'bare number'} word in one block; remove one")
            block[word.name] = word
        for word in block.values():
            if word.name in self.group_of and (before := first.setdefault(self.group_of[word.name], word)) is not word:
                self.fail(word, f"{before.name} and {word.name} in one block exclude each other; remove one")
        return block

    def take_feed(self, seen: dict[str, Word]) -> None:
        """Sets the feed of the block, if it has one."""
        if "F" in seen:
            value = seen["F"].value
            if value is None or not value > 0.0:
                self.fail(seen["F"], f"feed F{value:g} is not positive; correct it")
            self.feed = value

    def require_number(self, word: Word) -> None:
        """Refuses a coordinate or feed that no machine has."""
        if word.value is None or abs(word.value) > (LARGEST_FEED if word.name == "F" else LARGEST):
            written = word.name.rstrip("=") + ("" if word.value is None else f"{word.value:g}")
            self.fail(word, f"{written} is not a plain number of a machine's size; correct it")

    def refuse(self, word: Word, otherwise: str = "not a word of an excitation; remove it") -> NoReturn:
        """Refuses a word that has no meaning here."""
        self.fail(word, f"{word.name.rstrip('=')} is {self.others.get(word.name, otherwise)}")

    def require_said(self, word: Word) -> None:
        """Refuses a move before what it needs."""
        for text, words in self.needed.items():
            if self.said.isdisjoint(words) and not self.active(*words):
                self.fail(word, f"a move before {text}; what it means is not known, add {text}")

    def require_alone(self, word: Word, seen: dict[str, Word]) -> None:
        """Refuses other words in the block of one that needs it for itself."""
        if set(seen) - {word.name, "N"}:
            self.fail(word, f"{word.name} stands in a block of its own; move the other words")

    def pause(self, word: Word, seconds: float | None, usual: str, switches: bool = False) -> None:
        """Adds a dwell; `usual` is its usual form, for messages, `switches` as in `Grouping.pause`."""
        if seconds is None or not 0.0 <= seconds <= LARGEST:
            self.fail(word, f"{word.name} needs a duration of 0 to {LARGEST:g} s; write {usual}")
        self.motions.pause(self.line, seconds, switches)
        self.flowing = False

    def target(self, seen: dict[str, Word], first: Word) -> tuple[Array, float | None, float | None]:
        """End of a straight move, shape (k,) as written, and its duration [s] or feed; neither of a rapid."""
        if not self.active("G0", "G1"):
            self.fail(first, f"coordinates without G0 or {self.straight_word}; add {self.straight_word}")
        for name in ("I", "J", "K"):
            if name in seen:
                self.fail(seen[name], f"{name} without G2 or G3; remove it")
        end = self.end_of(seen, first)
        return end, *self.timing(seen, end, first)

    def end(self, word: Word, transformation_off: str = "") -> None:
        """Ends the program."""
        if self.transformed:
            self.fail(word, f"the transformation is still on; write {transformation_off} before")
        self.ended = True

    def end_of(self, seen: dict[str, Word], first: Word) -> Array:
        """The coordinates in which a block ends, as written, shape (k,)."""
        end = self.pose.copy()
        for k, name in enumerate(self.axes):
            if name in seen:
                end[k] = float(seen[name].value or 0.0)
        if np.isnan(end).any():
            missing = self.axes[int(np.flatnonzero(np.isnan(end))[0])].rstrip("=")
            self.fail(first, f"the first move leaves {missing} open; name all {len(end)} coordinates")
        return end

    def moves_origin(self, end: Array) -> bool:
        """Whether X, Y or Z moves on the way to coordinates, shape (k,) as written; from unknown ones they do."""
        moves = np.isnan(self.pose) | (np.abs(end - self.pose) > STILL)
        return bool(np.any(moves & self.linear))

    def timing(self, seen: dict[str, Word], end: Array, first: Word) -> tuple[float | None, float | None]:
        """Duration [s] or feed of a straight move to coordinates, shape (k,) as written; neither of a rapid."""
        if self.active("G0"):
            return None, None
        if self.active("G93"):
            if "F" not in seen:
                self.fail(first, f"{self.straight_word} without F under G93; add {self.block_time}")
            value = float(seen["F"].value or math.nan)
            return MINUTE / value if self.inverse_time else value, None
        if not self.active("G94"):
            self.fail(first, "a feed before G93 or G94; what it means is not known, add G94")
        if self.feed is None:
            self.fail(first, f"{self.straight_word} without a feed; add F")
        linear = self.moves_origin(end)
        if self.own_axes and self.feed_group and np.isnan(self.pose).any():
            if set(self.feed_axes or ()) != set(self.axes):
                group = self.feed_group.format(",".join(self.axes))
                self.fail(first, f"the first move comes from anywhere; write {group} and F, so that F counts all axes")
        else:
            self._require_counted(first, linear)
        return None, self.feed * (MM if linear else DEG) / MINUTE

    def _require_counted(self, first: Word, linear: bool) -> None:
        axes = tuple(a for a in self.axes if a in ("X", "Y", "Z")) if linear else self.angles
        if self.feed_group and self.feed_axes != axes:
            command = self.feed_group.format(",".join(axes))
            self.fail(first, f"F counts {', '.join(axes)} in this move only after {command}; add it before")

    def straight(self, end: Array, duration: float | None, feed: float | None, exact: bool) -> None:
        """Adds a straight move to coordinates, shape (k,) as written, and sets them as the pose."""
        linear = self.moves_origin(end)
        counted = tuple(map(int, np.flatnonzero(self.linear if linear else ~self.linear)))
        self.pose = end
        if duration is not None:
            self.motions.block((self.line, duration, end * self.scale, None), exact)
            return
        self.motions.move(self.line, end * self.scale, feed, linear, exact, law=(counted, None))

    def arc(self, seen: dict[str, Word], first: Word, exact: bool) -> None:
        """Adds an arc at a feed; centre words are relative to its start. Without end words it is a full circle."""
        if np.isnan(self.pose).any():
            self.fail(first, "an arc starts from an unknown pose; first move home at a feed (G94)")
        plane = next((plane for name, plane in PLANES.items() if self.active(name)), None)
        if plane is None:
            self.fail(first, "an arc before a plane was chosen; write G17, G18 or G19")
        if self.feed is None or not self.active("G94"):
            self.fail(first, "an arc needs a feed per minute; write G94 and F")
        self._require_counted(first, linear=True)
        end = self.end_of(seen, first)
        centres = {name: float(seen[name].value or 0.0) for name in "IJK" if name in seen}
        axis, other, normal = plane.axes
        if (name := "IJK"[normal]) in centres:
            self.fail(seen[name], f"{name} is not a centre in this plane; remove it, or choose another plane")
        if not centres:
            self.fail(first, f"an arc without a centre; add {'IJK'[axis]} and {'IJK'[other]}")
        if abs(end[normal] - self.pose[normal]) > STILL:
            self.fail(seen["XYZ"[normal]], "helices are not used here; write an arc in its plane")
        offset = np.array([centres.get("IJK"[k], 0.0) for k in (axis, other)])
        centre = self.pose[[axis, other]] + offset
        target = end[[axis, other]] - centre
        radius, end_radius = float(np.hypot(*offset)), float(np.hypot(*target))
        if radius <= 0.0:
            self.fail(first, "the arc has no radius; correct its centre")
        if abs(end_radius - radius) > ROUND:
            problem = f"radius {radius:g} mm at the start and {end_radius:g} mm at the end of the arc"
            self.fail(first, f"{problem}; correct its centre")
        angle, positive = 2 * np.pi, self.active("G3")  # counter-clockwise, seen from the positive end of the normal
        if float(np.hypot(*(target + offset))) > STILL:
            turned = float(np.arctan2(offset[1] * target[0] - offset[0] * target[1], -offset @ target)) % (2 * np.pi)
            angle = turned if positive else 2 * np.pi - turned
        angle = angle if positive else -angle
        self.pose = end
        arc = plane, centre * MM, angle
        self.motions.move(self.line, end * self.scale, self.feed * MM / MINUTE, True, exact, arc)
