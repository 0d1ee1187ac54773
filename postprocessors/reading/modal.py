"""What controllers with groups of modal words keep from block to block, whatever their language."""

from typing import NamedTuple, NoReturn

import numpy as np

from cases.errors import ProgramError
from cases.units import MINUTE, MM
from identification.trajectories.circle import Plane
from postprocessors.reading.arcs import Arc, PlaneProblem, arc_through
from postprocessors.reading.words import Array, Event, Turn

LARGEST = 1e6  # mm, degrees, seconds: no machine has such numbers
LARGEST_FEED = 1e9  # per minute
STILL = 1e-7  # [mm, deg] a coordinate moves if it changes by more
PLANES = {"G17": Plane.XY, "G18": Plane.ZX, "G19": Plane.YZ}


class Word(NamedTuple):
    """One word.

    Args:
        name: address, keyword or command in capitals; of G and M with the number: G1, G162, M30. `%` is the program's
            name, `N` a block number.
        column: where it begins, counted from 1.
        value: its number.
        arguments: what stands in parentheses or brackets behind it.
        selector: what stands in brackets before its value; of a synchronised action, its condition.
    """

    name: str
    column: int
    value: float | None = None
    arguments: tuple[str, ...] | None = None
    selector: str | None = None


class ModalState:
    """State of a controller while a program is read.

    Args:
        file: name of the program, for messages.
        groups: words of which one is active at a time, and one may stand in a block.
        axes: words of the six coordinates, in the order of a pose.
        scale: what they count, shape (6,) [m, rad].
    """

    def __init__(self, file: str, groups: tuple[tuple[str, ...], ...], axes: list[str], scale: Array) -> None:
        self.file = file
        self.groups = groups
        self.axes = axes
        self.scale = scale
        self.line = 0
        self.events: list[Event] = []
        self.pose = np.full(6, np.nan)  # as written; unknown until the first move has named all six
        self.modal: dict[int, str] = {}  # the active word of each group
        self.feed: float | None = None
        self.transformed = self.ended = False
        self.flowing = False  # whether the machine need not stand at the end of the last block

    def fail(self, word: Word | None, problem: str) -> NoReturn:
        """Refuses the program, at a word or the line as a whole.

        Raises:
            ProgramError: always.
        """
        raise ProgramError(self.file, self.line, word.column if word else 0, problem)

    def activate(self, name: str) -> None:
        """Makes a word the active one of its group."""
        self.modal[next(k for k, group in enumerate(self.groups) if name in group)] = name

    def active(self, *names: str) -> bool:
        """Whether one of these words is active."""
        return not set(names).isdisjoint(self.modal.values())

    def require_one_of_each_group(self, seen: dict[str, Word]) -> None:
        """Two words of one group in a block are an error to the controller."""
        for group in self.groups:
            members = [seen[name] for name in group if name in seen]
            if len(members) > 1:
                names = " and ".join(w.name for w in members)
                self.fail(max(members, key=lambda w: w.column), f"{names} in one block exclude each other; remove one")

    def take_feed(self, seen: dict[str, Word]) -> None:
        """Keeps the block's feed, if it has one."""
        if "F" in seen:
            value = seen["F"].value
            if value is None or not value > 0.0:
                self.fail(seen["F"], f"feed F{value:g} is not positive; correct it")
            self.feed = value

    def end_of(self, seen: dict[str, Word], first: Word) -> Array:
        """The pose in which a block ends, as written, shape (6,)."""
        end = self.pose.copy()
        for k, name in enumerate(self.axes):
            if name in seen:
                end[k] = float(seen[name].value or 0.0)
        if np.isnan(end).any():
            missing = self.axes[int(np.flatnonzero(np.isnan(end))[0])].rstrip("=")
            self.fail(first, f"the first move leaves {missing} open; name all six coordinates")
        return end

    def moves_origin(self, end: Array) -> bool:
        """Whether X, Y or Z moves; from an unknown pose they are taken to."""
        return bool(np.isnan(self.pose).any() or np.any(np.abs(end - self.pose)[:3] > STILL))

    def plane(self) -> Plane | None:
        """The plane of arcs, if one was chosen."""
        return next((plane for name, plane in PLANES.items() if self.active(name)), None)

    def turn(self, seen: dict[str, Word], first: Word, plane: Plane, feed: float) -> Turn:
        """An arc at a feed [mm/min] that stops exactly; centre words are relative to its start."""
        end = self.end_of(seen, first)
        centres = {name: float(seen[name].value or 0.0) for name in "IJK" if name in seen}
        try:
            centre, angle = arc_through(Arc(plane, self.active("G3"), self.pose, end, centres))
        except PlaneProblem as problem:
            self.fail(seen.get(problem.word, first), str(problem))
        self.pose = end
        return Turn(self.line, end * self.scale, plane, centre * MM, angle, feed * MM / MINUTE, True)
