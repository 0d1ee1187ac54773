"""State of controllers with groups of modal words from block to block, whatever their language."""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple, NoReturn

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.units import DEG, MINUTE, MM
from identification.motion.motion import Array
from identification.motion.moves import Plane
from postprocessors.reading import Grouping, Reading, Untimed

ROUND = 2e-3  # [mm] largest difference of the radii at both ends, by rounding of words; LinuxCNC accepts 5e-3
STILL = 1e-7  # [mm] distance below which places are the same

LARGEST = 1e6  # mm, degrees, seconds: no machine has such numbers
LARGEST_FEED = 1e9  # per minute; 60 over a microsecond is 6e7
LEAST_FEED = 1e-3  # of mm or degrees per minute; below, a control rounds it to nothing
LOOSEST_CHECK = 0.1  # [mm, deg] within which a program may check that the machine stands at a place
_INK = re.compile(r"\S")
PLANES = {"G17": Plane.XY, "G18": Plane.ZX, "G19": Plane.YZ}


class Word(NamedTuple):
    """One word."""

    # address, keyword or command in capitals; of G and M with the number: G1, G162, M30. `%` is the program's name
    name: str
    column: int  # where it begins, counted from 1
    value: float | None = None  # number of the word
    arguments: tuple[str, ...] = ()  # texts in parentheses or brackets behind it

    @property
    def written(self) -> str:
        """The word as text: G1, X5, TRAORI(2)."""
        number = "" if self.value is None else f"{self.value:g}"
        return f"{self.name}{number}" + (f"({','.join(self.arguments)})" if self.arguments else "")


class ModalState(ABC):
    """State of a controller while a program is read; subclasses define the words of their language.

    Args:
        axes: words of the coordinates, in their order; those of lengths are X, Y and Z.
        own_axes: whether the coordinates are the machine's own axes; else they are the pose of a platform.
    """

    name: ClassVar[str]  # name of the language, for messages
    title: ClassVar[re.Pattern[str] | None] = None  # the first line, with the program's name
    number: ClassVar[re.Pattern[str]] = re.compile(r"\s*N\d+", re.IGNORECASE)  # number of a block, at its begin
    # a word, with the groups `comment`, of a comment, and `letter` and `number`, of a letter with a plain number
    word: ClassVar[re.Pattern[str]]
    groups: ClassVar[tuple[str, ...]]  # groups of words of which one is active, and one may be in a block
    reads: ClassVar[str]  # all that is read, for messages
    last: ClassVar[tuple[str, ...]]  # words that end a program, the usual one first
    stops: ClassVar[tuple[str, ...]] = ("M0", "M1")  # words at which the machine stands until its operator goes on
    block_time: ClassVar[str] = "F = 60 / seconds"  # F under G93, for messages
    exact_stop: ClassVar[str] = "G60"  # word of an exact stop, for messages
    switch_at_rest: ClassVar[str] = "a dwell after it"  # what switches the trigger without a motion, for messages
    fractions: ClassVar[bool] = False  # whether G and M functions may have decimals
    resolution: ClassVar[float] = 0.0  # to which the control rounds the ends of moves [mm, deg]; 0: not at all
    inverse_time: ClassVar[bool] = True  # whether that F is one over minutes; else seconds
    # lines, each without blanks at its end, that stop the program unless an axis stands at a place, with the groups
    # `axis`, `place` (minus the place, with its sign) and `within`; their number; and with what all statements begin
    home_check: ClassVar[re.Pattern[str]]
    home_check_lines: ClassVar[int]
    condition: ClassVar[str]
    asks_where: ClassVar[str] = ""  # command before it, without which it would not see the present place; empty: none
    feed_group: ClassVar[str] = ""  # command that names the axes whose path F counts, with {} for them; empty: none

    def __init__(self, file: str, axes: Sequence[str], own_axes: bool) -> None:
        self.file = file
        self.group_of = {name: k for k, group in enumerate(self.groups) for name in group.split()}
        self.axes = axes
        self.own_axes = own_axes
        self.line = 0
        self.motions = Grouping(file, self.exact_stop, self.switch_at_rest)
        self.linear = np.array([name in ("X", "Y", "Z") for name in axes])
        self.angles = tuple(name for name in axes if name not in ("X", "Y", "Z"))  # where F counts them
        self.scale = np.where(self.linear, MM, DEG)  # SI values of the coordinates' units [m or rad]
        self.said: set[str] = set()  # settings that were made, beside modal words
        # what a move needs before it, for messages -> modal words or settings of which any one is it
        self.needed: dict[str, tuple[str, ...]] = {}
        self.coordinates = np.full(len(axes), np.nan)  # as written; unknown until the first move has stated all
        # places that the program has checked, by axis, each with its tolerance; and the largest distance of each
        # coordinate from `pose` since then, until a move has stated it
        self.places: dict[str, tuple[float, float]] = {}
        self.unsure = np.zeros(len(axes))
        self.stated = np.zeros(len(axes), dtype=bool)  # coordinates that the block states
        self.modal: dict[int, str] = {}  # the active word of each group
        self.feed: float | None = None
        self.feed_axes: tuple[str, ...] | None = None
        self.transformed = self.ended = False
        self.enclosed = False  # whether marks around the program end it too
        self.flowing = False  # whether the machine need not stand at the end of the last block
        self.stopped: list[int] = []  # lines at which the machine waits for its operator

    @abstractmethod
    def read(self, block: dict[str, Word]) -> None:
        """Executes the words of one block, by their names; raises ProgramError for one that is not understood."""

    @classmethod
    def words(cls, text: str, line: int, file: str) -> list[Word]:
        """The words of a line without its comments; raises ProgramError for what is not a word of this language."""
        if line == 1 and cls.title is not None and cls.title.match(text):
            return [Word("%", 1)]
        number = cls.number.match(text)
        position, words = 0 if number is None else number.end(), []
        while position < len(text) and (ink := _INK.search(text, position)) is not None:
            match = cls.word.match(text, ink.start())
            if match is None:
                bad = text[ink.start() : ink.start() + 12].rstrip()
                raise ProgramError(
                    file=file,
                    line=line,
                    column=ink.start() + 1,
                    problem=f"cannot read {bad!r}",
                    remedy=f"remove or replace it: {cls.reads}",
                    code=Code.SYNTAX,
                )
            if not match["comment"]:
                words.append(cls.word_of(match, ink.start() + 1))
            elif refusal := cls.comment_problem(text, match):
                problem, remedy = refusal
                raise ProgramError(
                    file=file, line=line, column=ink.start() + 1, problem=problem, remedy=remedy, code=Code.SYNTAX
                )
            position = match.end()
        return words

    @classmethod
    def comment_problem(cls, text: str, match: re.Match[str]) -> tuple[str, str] | None:
        """What a comment of a line does that a comment must not, and the remedy; None where it does nothing."""
        return None

    @classmethod
    def word_of(cls, match: re.Match[str], column: int) -> Word:
        """The word of a match of `word`, here of a letter and its number."""
        letter, number = match["letter"].upper(), match["number"]
        if letter not in "GM":
            return Word(letter, column, float(number))
        # LinuxCNC knows G91.1; to the others only whole numbers are G and M functions
        plain = cls.fractions or number.isdigit()
        return Word(f"{letter}{float(number):.15g}" if plain else letter + number, column)

    def read_program(self, lines: Iterable[str]) -> Reading:
        """Reads all lines; errors as `Dialect.read`."""
        blocks, read_up_to, lines = 0, 0, [*lines]
        for number, text in enumerate(lines, start=1):
            if number <= read_up_to or not text or text.isspace():
                continue
            statement = self._without_number(text)
            if statement.startswith(self.condition) and (count := self.statement(lines, number)):
                blocks, read_up_to = blocks + count, number - 1 + count
            elif words := self.words(text, number, self.file):
                self.line = number
                if self.ended:
                    self.fail(words[0], "a word after the end of the program", f"{self.last[0]} must be last")
                self.execute(self._block(words))
                blocks += 1
        if not (self.ended or self.enclosed):
            raise ProgramError(
                file=self.file,
                problem=f"no {self.last[0]} at the end",
                remedy=f"the file is truncated or not a {self.name} program",
                code=Code.DAMAGED,
            )
        return replace(self.motions.reading(blocks), stops=tuple(self.stopped))

    def statement(self, lines: list[str], number: int) -> int:
        """Reads the statement of several lines that begins in a line, if there is one: here a check of a place.

        Returns the number of its lines, else 0.
        """
        if self.ended or not (np.isnan(self.coordinates).any() or self.unsure.all()):  # behind the first motion
            return 0
        texts = [self._without_number(text) for text in lines[number - 1 : number - 1 + self.home_check_lines]]
        match = self.home_check.fullmatch("\n".join(texts))
        if match is None:
            return 0
        self.line, word, axis = number, Word(match["axis"], 1), match["axis"].upper()
        self.require_said(word)
        if self.asks_where and self.asks_where.partition(" [")[0] not in self.said:
            self.fail(word, f"a check of a place before {self.asks_where}, which says where the machine is", "add it")
        names = self.axes_of_places()
        if self.confirms(match):
            if self.places.get(axis) != self._place(match):
                self.fail(
                    word, f"a second check of {axis}, of another place than the first one before it", "correct it"
                )
            return len(texts)
        if axis not in names or axis in self.places:
            self.fail(word, f"a second check of {axis}, or {axis} is not an axis here", "remove it")
        place, within = self._place(match)
        if not 0.0 < within <= LOOSEST_CHECK:
            self.fail(word, f"a check within {within:g} mm or degrees is none", f"check within {LOOSEST_CHECK:g}")
        self.places[axis] = place, within
        if len(self.places) == len(names):
            self.coordinates, self.unsure = np.array([self.places[name] for name in names]).T
            self.motions.stand_near(self.coordinates * self.scale, np.abs(self.unsure * self.scale))
        return len(texts)

    def _without_number(self, text: str) -> str:
        """A line of a statement without the number of its block, as a control adds it, and blanks at its end."""
        number = self.number.match(text)
        return (text if number is None else text[number.end() :].lstrip()).rstrip()

    @staticmethod
    def _place(match: re.Match[str]) -> tuple[float, float]:
        return -float(match["place"]), float(match["within"])

    def confirms(self, match: re.Match[str]) -> bool:
        """Whether a check is a second one of a place, by another variable of the control."""
        return False

    def axes_of_places(self) -> Sequence[str]:
        """Names of the axes in checks of their places, in the order of the coordinates."""
        return self.axes

    def require_home(self, word: Word) -> None:
        """Refuses a motion while the machine stands near a checked place, but not there for certain."""
        if self.unsure.any():
            which = " ".join(np.array([*self.axes])[self.unsure > 0.0]).replace("=", "")
            problem = f"the machine stands near the checked place, but not there for certain in {which}"
            self.fail(word, f"{problem}", "first write G1 to it at a feed, those that slide first, alone")

    def execute(self, block: dict[str, Word]) -> None:
        """Executes a block: here one in which the machine waits for its operator, which stands alone."""
        stop = next((word for name, word in block.items() if name in self.stops), None)
        if stop is None:
            self.read(block)
            return
        self.require_alone(stop, block)
        self.motions.pause(self.line, 0.0, switches=True)
        self.stopped.append(self.line)
        self.flowing = False

    def fail(self, word: Word, problem: str, remedy: str = "") -> NoReturn:
        """Raises ProgramError at a word."""
        raise ProgramError(
            file=self.file, line=self.line, column=word.column, problem=problem, remedy=remedy, code=Code.SYNTAX
        )

    def refuse(self, word: Word) -> NoReturn:
        """Refuses a word that has no meaning here."""
        self.fail(word, f"{word.written} is not read here", f"remove or replace it: {self.reads}")

    def _block(self, words: Iterable[Word]) -> dict[str, Word]:
        """The words of a block by their names, each of which may stand in it once, and one of each group."""
        first: dict[str | int, Word] = {}
        for word in words:
            before = first.setdefault(self.group_of.get(word.name, word.name), word)
            if before is not word:
                self.fail(word, f"{before.written} and {word.written} in one block exclude each other", "remove one")
            if word.value is not None and abs(word.value) > (LARGEST_FEED if word.name == "F" else LARGEST):
                self.fail(word, f"{word.written} is not a number of a machine's size", "correct it")
        return {word.name: word for word in words}

    def activate(self, name: str) -> None:
        """Makes a word the active one of its group."""
        self.modal[self.group_of[name]] = name
        if name in ("G93", "G94"):
            self.feed = None  # a feed of the other kind has no meaning any more

    def active(self, *names: str) -> bool:
        """Whether one of these words is active."""
        return any(name in self.modal.values() for name in names)

    def take_feed(self, block: dict[str, Word]) -> None:
        """Sets the feed of the block, if it has one."""
        if "F" in block:
            self.feed = block["F"].value
            if not self.feed or self.feed <= 0.0:
                self.fail(block["F"], f"feed F{self.feed:g} is not positive", "correct it")
            if self.active("G94") and self.feed < LEAST_FEED:
                problem = f"feed F{self.feed:.3g} is below {LEAST_FEED:g} per minute, which a control rounds to nothing"
                self.fail(block["F"], f"{problem}", "leave this move out, or make it faster")

    def require_said(self, word: Word) -> None:
        """Refuses a move before what it needs."""
        for text, words in self.needed.items():
            if self.said.isdisjoint(words) and not self.active(*words):
                self.fail(word, f"a move before {text}", f"what it means is not known, add {text}")

    def require_alone(self, word: Word, block: dict[str, Word], *others: str) -> None:
        """Refuses words beside one that needs its block for itself, but for others of some names."""
        if other := next((w for name, w in block.items() if name not in (word.name, *others)), None):
            self.fail(other, f"{word.name} stands in a block of its own", f"move {other.written}")

    def pause(self, word: Word, seconds: Word | None, usual: str, switches: bool = False) -> None:
        """Adds a dwell; `usual` is its form, for messages, `switches` as in `Grouping.pause`."""
        duration = None if seconds is None else seconds.value
        if duration is None or not 0.0 <= duration <= LARGEST:
            self.fail(word, f"{word.name} needs a duration of 0 to {LARGEST:g} s", f"write {usual}")
        self.motions.pause(self.line, duration, switches)
        self.flowing = False

    def target(self, block: dict[str, Word], first: Word) -> tuple[Array, float | None, float | None]:
        """End of a straight move, shape (k,) as written, and its duration [s] or feed; neither of a rapid."""
        if not self.active("G0", "G1") or not {"I", "J", "K"}.isdisjoint(block):
            self.fail(first, "coordinates need G0 or G1, and I, J or K need G2 or G3", "correct the block")
        end = self._end_of(block, first)
        if self.active("G0"):
            return end, None, None
        if self.active("G93"):
            if "F" not in block:
                self.fail(first, "G1 without F under G93", f"add {self.block_time}")
            value = float(block["F"].value or 0.0)
            return end, MINUTE / value if self.inverse_time else value, None
        if self.feed is None or not self.active("G94"):
            self.fail(first, "G1 without a feed", "write G94 and F")
        linear = self._moves_origin(end)
        self._require_counted(first, linear)
        return end, None, self.feed * (MM if linear else DEG) / MINUTE

    def end(self, word: Word, transformation_off: str = "") -> None:
        """Ends the program."""
        if self.transformed:
            self.fail(word, "the transformation is still on", f"write {transformation_off} before")
        self.ended = True

    def _end_of(self, block: dict[str, Word], first: Word) -> Array:
        """The coordinates in which a block ends, as written, shape (k,)."""
        written = np.array([block[name].value if name in block else None for name in self.axes], dtype=float)
        self.stated = ~np.isnan(written)
        end = np.where(np.isnan(written), self.coordinates, written)
        if np.isnan(end).any():
            missing = self.axes[int(np.flatnonzero(np.isnan(end))[0])].rstrip("=")
            self.fail(first, f"the first move leaves {missing} open", f"name all {len(end)} coordinates")
        return end

    def _moves_origin(self, end: Array) -> bool:
        """Whether X, Y or Z moves on the way to coordinates, shape (k,) as written; from unknown ones they do."""
        way = np.abs(self._as_rounded(end) - self._as_rounded(self.coordinates))
        moves = np.isnan(self.coordinates) | (way > STILL) | (self.stated & (self.unsure > 0.0))
        return bool(np.any(moves & self.linear))

    def _as_rounded(self, pose: Array) -> Array:
        """Coordinates as the control rounds them, shape (k,) as written."""
        return np.round(pose / self.resolution) * self.resolution if self.resolution > 0.0 else pose

    def _require_counted(self, first: Word, linear: bool) -> None:
        """Refuses a feed along other axes than F counts; the first move of own axes, from anywhere, may use any."""
        axes = tuple(a for a in self.axes if a in ("X", "Y", "Z")) if linear else self.angles
        if self.own_axes and np.isnan(self.coordinates).any():
            axes = tuple(self.axes)
        if self.feed_group and set(self.feed_axes or ()) != set(axes):
            command = self.feed_group.format(",".join(axes))
            self.fail(first, f"F counts {', '.join(axes)} in this move only after {command}", "add it before")

    def straight(self, end: Array, duration: float | None, feed: float | None, exact: bool) -> None:
        """Adds a straight move to coordinates, shape (k,) as written, and sets them as the pose."""
        linear = self._moves_origin(end)
        counted = tuple(map(int, np.flatnonzero(self.linear if linear else ~self.linear)))
        within = self._taken_home(end, feed, counted) if self.unsure.any() else None
        before, self.coordinates = self.coordinates, end
        if duration is not None:
            self.motions.block((self.line, duration, end * self.scale, None), exact)
            return
        start = None
        if within is None and not np.isnan(before).any():
            start, end = self._as_rounded(before) * self.scale, self._as_rounded(end)
        move = Untimed(self.line, start, end * self.scale, feed, linear, counted=counted, within=within)
        self.motions.move(move, exact)

    def _taken_home(self, end: Array, feed: float | None, counted: tuple[int, ...]) -> Array:
        """Largest way of each coordinate of a move to the checked place, shape (k,) [m, rad]; then it is there.

        Refuses another move: one elsewhere, in rapid, in a time, or in which coordinates move that the feed does not
        count.
        """
        moving = self.stated & (self.unsure > 0.0)
        away = np.abs(end - self.coordinates) > np.where(moving, self.unsure, 0.0) + STILL
        if feed is None or away.any() or not set(map(int, np.flatnonzero(moving))) <= set(counted):
            self.require_home(Word("", 1))
        within = np.where(moving, self.unsure, 0.0)
        self.unsure = self.unsure - within
        return np.asarray(np.abs(within * self.scale))

    def arc(self, block: dict[str, Word], first: Word, exact: bool) -> None:
        """Adds an arc at a feed; centre words are relative to its start. Without end words it is a full circle."""
        plane = next((plane for name, plane in PLANES.items() if self.active(name)), None)
        self.require_home(first)
        if np.isnan(self.coordinates).any() or plane is None or self.feed is None or not self.active("G94"):
            self.fail(first, "an arc needs a known start, a plane (G17, G18, G19), G94 and F", "add what is missing")
        self._require_counted(first, linear=True)
        axis, other, normal = plane.axes
        end = self._end_of(block, first)
        centre_words = "IJK"[axis], "IJK"[other]
        offset = np.array([float(block[name].value or 0.0) if name in block else 0.0 for name in centre_words])
        stray = "IJK"[normal] in block or abs(end[normal] - self.coordinates[normal]) > STILL
        target = end[[axis, other]] - self.coordinates[[axis, other]] - offset
        radius, end_radius = float(np.hypot(*offset)), float(np.hypot(*target))
        if stray or radius <= 0.0 or abs(end_radius - radius) > ROUND:
            problem = f"the arc has radius {radius:g} mm at its start and {end_radius:g} mm at its end"
            remedy = f"write it in its plane, its centre from its start with {' and '.join(centre_words)}"
            self.fail(first, f"{problem}", f"{remedy}")
        angle, positive = 2 * np.pi, self.active("G3")  # counter-clockwise, seen from the positive end of the normal
        if float(np.hypot(*(target + offset))) > STILL:
            sweep = float(np.arctan2(offset[1] * target[0] - offset[0] * target[1], -offset @ target)) % (2 * np.pi)
            angle = sweep if positive else 2 * np.pi - sweep
        centre = self.coordinates[[axis, other]] + offset
        self.coordinates = end
        arc = plane, centre * MM, angle if positive else -angle
        move = Untimed(self.line, None, end * self.scale, self.feed * MM / MINUTE, linear=True, arc=arc)
        self.motions.move(move, exact)
