"""The reading of a program: stretches of motion between standstills, for the proof and for controllers.

Readers report each block to a `Grouping`, which joins timed blocks to paths and refuses a motion that is not defined.
Their common functions for lines, words and axes are at the end.
"""

import math
import re
from dataclasses import dataclass, replace
from itertools import islice
from operator import itemgetter

import numpy as np

from cases.base.errors import Code, ProgramError, option
from cases.schema import Case
from identification.motion.curves import PolynomialMotion, Tabulated
from identification.motion.motion import Array, TimedPoints
from identification.motion.moves import Plane

STILL = 1e-9  # [m, rad] below the last decimal of any program


@dataclass(frozen=True, slots=True)
class Timed:
    """A path whose time the program states block by block."""

    lines: tuple[int, ...]  # line of the program that ends each block, shape (k - 1,)
    points: TimedPoints | PolynomialMotion | Tabulated  # the motion through the k poses, from rest to rest
    trigger: bool  # whether the trigger is on

    @property
    def line(self) -> int:
        """Line of the program that ends its first block."""
        return self.lines[0]

    def line_at(self, time: float) -> int:
        """Line of the program whose block runs at `time` after the start of the stretch [s]."""
        block = int(np.searchsorted(self.points.times, time, side="left")) - 1
        return self.lines[int(np.clip(block, 0, len(self.lines) - 1))]


Arc = tuple[Plane, Array, float]
"""A way of the origin on a circle; the other coordinates change in proportion.

The plane in which it lies; the centre along the plane's first and second axis, absolute in {B}, shape (2,) [m]; the
angle turned about the plane's normal, positive counter-clockwise, at most a full circle [rad].
"""


@dataclass(frozen=True, slots=True)
class Untimed:
    """A straight move or an arc from standstill to standstill whose time law is the controller's."""

    line: int  # line of the program
    start: Array | None  # shape (6,) [m, rad], or None where the program cannot know it
    end: Array  # shape (6,) [m, rad]
    feed: float | None  # along XYZ [m/s], or along ABC [rad/s] where XYZ stands still; None for a rapid
    linear: bool  # whether X, Y or Z moves by the controller's own measure: then the feed is one of lengths
    arc: Arc | None = None  # None for a straight move
    trigger: bool = False  # whether the trigger is on
    counted: tuple[int, ...] = ()  # indices of the coordinates whose way the feed counts; of an arc it counts the arc
    # acceleration of that way, where the text states it: its time law is then the text's [m/s^2 or rad/s^2]
    acceleration: float | None = None
    # largest distance of each coordinate from `start`, where the program has checked that the machine stands near it,
    # and of those that this move takes to its end, shape (k,) [m, rad]; None where it stands at `start`
    within: Array | None = None

    @property
    def length(self) -> float:
        """Way that the feed counts, from a known start [m], [rad] where only angles move."""
        assert self.start is not None
        if self.arc is not None:
            plane, centre, angle = self.arc
            first, second, _ = plane.axes
            arm = self.start[[first, second]] - centre
            return abs(angle) * float(np.hypot(arm[0], arm[1]))
        return float(np.linalg.norm((self.end - self.start)[list(self.counted)]))

    @property
    def moves(self) -> bool:
        """Whether it moves, or may move from an unknown start."""
        return self.arc is not None or self.start is None or bool(np.any(np.abs(self.end - self.start) > STILL))


@dataclass(frozen=True, slots=True)
class Still:
    """A dwell."""

    line: int  # line of the program
    duration: float  # [s]
    trigger: bool  # whether the trigger is on


Stretch = Timed | Untimed | Still


@dataclass(frozen=True, slots=True)
class Reading:
    """A program as read."""

    file: str  # name of the program, for messages
    stretches: tuple[Stretch, ...]  # stretches in order
    blocks: int  # number of lines that hold words
    start: Array | None = None  # where the machine must stand, of programs that do not bring it there, shape (6,)
    checked: tuple[Array, Array] | None = None  # pose near which the program checks that it stands, and how near, (k,)
    start_time: float = 0.0  # time in which the controller takes it there from where it stands; 0 where it does not [s]
    left_on: int = 0  # line that switches the trigger on for good; 0 where it is off in the end
    stops: tuple[int, ...] = ()  # lines at which the machine waits for its operator
    override_off: bool = False  # whether the program switches the feed override off before it moves, for all moves

    @property
    def measures_at_poses(self) -> bool:
        """Whether the trigger is on while the machine stands, and never while it moves."""
        on = [part for part in self.stretches if part.trigger]
        on = [part for part in on if not (isinstance(part, Still) and part.duration == 0.0)]
        return bool(on) and all(isinstance(part, Still) for part in on)

    @property
    def measured_poses(self) -> Array:
        """Poses at which the trigger is on, in order, shape (k, n) [m or rad]; of programs that measure standing."""
        last_pose: Array | None = None
        poses: list[Array] = []
        for part in self.stretches:
            if isinstance(part, Untimed):
                last_pose = part.end
            elif isinstance(part, Timed):
                last_pose = part.points.at([part.points.duration]).coordinates[0]
            elif part.trigger and part.duration > 0.0 and last_pose is not None:
                poses.append(last_pose)
        return np.array(poses)


TimedBlock = tuple[int, float, Array, Array | None]
"""A block whose time the program states: line, duration [s], pose at its end, shape (6,) [m, rad], and coefficients.

c_i of the polynomial sum_i c_i p^i, p from 0 to 1 at constant rate, which begins where the machine stands, shape
(d + 1, 6) [m, rad]; None for a straight line.
"""


class Grouping:
    """Takes the blocks of a program in their order and groups them into stretches that begin and end at rest.

    Its methods raise ProgramError where a motion is not defined: timed blocks from an unknown pose, blocks of the
    controller's own timing that run into each other, a trigger that waits for a motion which never comes.
    """

    def __init__(self, file: str, exact_stop: str = "", switch_at_rest: str = "") -> None:
        self.file = file
        self.exact_stop, self.switch_at_rest = exact_stop, switch_at_rest  # in the words of the language
        self.stretches: list[Stretch] = []
        self.start: Array | None = None
        self.coordinates: Array | None = None
        self.trigger = False
        self.switched = 0  # line that switched the trigger last
        self.waiting: tuple[int, bool] | None = None  # line of a switch with the next motion, and whether on
        self.timed: list[TimedBlock] = []  # blocks since the last standstill
        self.checked: tuple[Array, Array] | None = None  # as in `Reading`

    def error(self, line: int, problem: str, remedy: str = "") -> ProgramError:
        """An error at a line."""
        return ProgramError(file=self.file, line=line, problem=problem, remedy=remedy, code=Code.SYNTAX)

    def stand(self, pose: Array) -> None:
        """Sets the pose before the start, to which the program itself does not bring the machine."""
        self.start = self.coordinates = pose

    def stand_near(self, pose: Array, within: Array) -> None:
        """Sets the pose before the start, from which the machine is no further away than `within`, shape (k,)."""
        self.coordinates, self.checked = pose, (pose, within)

    def pause(self, line: int, duration: float, switches: bool = False) -> None:
        """Adds a standstill [s]; `switches`: whether the trigger waits for no longer than this."""
        self._finish_path()
        if switches:
            self._settle_trigger()
        self.stretches.append(Still(line, duration, self.trigger))

    def switch(self, line: int, on: bool, at_once: bool) -> None:
        """Switches the trigger: after all motion before (`at_once`), else with the start of the next move."""
        self.switched = line
        if at_once:
            self._finish_path()
            self.trigger = on
        else:
            self.waiting = line, on  # the controller need not stop

    def block(self, block: TimedBlock, exact: bool = False) -> None:
        """Adds a block whose time the program states; `exact`: whether the controller comes to rest at its end."""
        if self.timed and self.waiting is not None:
            raise self.error(self.waiting[0], "the trigger switches in the middle of a path", "switch at rest")
        self._settle_trigger()
        if self.coordinates is None:
            raise self.error(block[0], "a timed block starts from an unknown pose", "first move home at a feed (G94)")
        if exact:
            raise self.error(block[0], "a timed block under exact stop lasts longer", "write G64")
        self.timed.append(block)

    def move(self, move: Untimed, exact: bool) -> None:
        """Adds a move that the controller times itself; `exact`: whether the controller comes to rest at its end.

        It begins where the motion before ends, unless it states its start as the controller rounds it; the trigger is
        as it was switched.
        """
        self._finish_path()
        self._settle_trigger()
        if not exact:
            problem = "a move at a feed without exact stop is blended into the next, its path is not known"
            raise self.error(move.line, problem, f"write {self.exact_stop}")
        start = self.coordinates if move.start is None else move.start
        self.stretches.append(replace(move, start=start, trigger=self.trigger))
        self.coordinates = move.end

    def rows(self, line: int, cycle: float, poses: Array, rates: Array, accelerations: Array) -> None:
        """Adds a path row by row, from rest to rest, whose first row is at `line`; arguments as `Tabulated`."""
        self._finish_path()
        self.coordinates = poses[-1]
        times = np.asarray(np.arange(len(poses)) * cycle, dtype=float)
        lines = tuple(range(line + 1, line + len(times)))
        self.stretches.append(Timed(lines, Tabulated(times, poses, rates, accelerations), self.trigger))

    def reading(self, blocks: int) -> Reading:
        """The reading of the whole program, with its number of blocks."""
        self._finish_path()
        if self.waiting is not None:
            problem = "the trigger waits for a next motion that never comes"
            raise self.error(self.waiting[0], problem, f"write {self.switch_at_rest}")
        left_on = self.switched if self.trigger else 0
        return Reading(self.file, tuple(self.stretches), blocks, self.start, self.checked, left_on=left_on)

    def _settle_trigger(self) -> None:
        if self.waiting is not None:
            self.trigger, self.waiting = self.waiting[1], None

    def _finish_path(self) -> None:
        if self.timed:
            self.stretches.append(Timed(tuple(line for line, *_ in self.timed), self._path(), self.trigger))
            self.coordinates, self.timed = self.timed[-1][2], []

    def _path(self) -> TimedPoints | PolynomialMotion:
        lines, times, ends, polynomials = zip(*self.timed, strict=True)
        if not any(polynomial is not None for polynomial in polynomials):
            return TimedPoints.through(np.cumsum([0.0, *times]), np.vstack([np.array(self.coordinates), *ends]))
        pieces = []
        for line, time, polynomial in zip(lines, times, polynomials, strict=True):
            if polynomial is None:
                raise self.error(line, "a timed straight block among polynomials", "write a path in one form")
            pieces.append((polynomial / time ** np.arange(len(polynomial))[:, None], time))
        return PolynomialMotion.of_pieces(pieces)


NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
"""Pattern of a plain decimal number."""

PLAIN = r"\d+(?:\.\d+)?"
"""Pattern of a plain decimal number without a sign."""

FLOAT = rf"((?>{NUMBER})(?:[eE][+-]?\d+)?)"
"""Pattern of a number that may have an exponent, as one group."""


_ODD = re.compile(r"[^\t\n -~]")


def program_lines(content: bytes, file: str, longest: int, most: float = math.inf) -> list[str]:
    """The lines of a program; only line feeds end one.

    Args:
        content: the program; one character a byte, so that columns are right whatever the encoding really is.
        longest: largest number of characters in a line of the controller.
        most: largest number of lines with content in its memory.

    Raises:
        ProgramError: a character that is not plain ASCII, a line too long, too many lines; with line and column.
    """
    text = content.decode("latin-1").replace("\r\n", "\n")
    lines = text.split("\n")
    errors: list[tuple[int, int, str, str]] = []  # the first of each kind: line, column, problem, remedy
    if (odd := _ODD.search(text)) is not None:
        problem, remedy = f"character {odd[0]!r} is not plain ASCII", "remove or replace it"
        line, column = text.count("\n", 0, odd.start()) + 1, odd.start() - text.rfind("\n", 0, odd.start())
        errors.append((line, column, problem, remedy))
    if max(map(len, lines)) > longest:
        line, size = next((k, len(line)) for k, line in enumerate(lines, start=1) if len(line) > longest)
        errors.append((line, 0, f"{size} characters, the controller takes {longest}", "split it"))
    if len(lines) > most:
        filled = (k for k, line in enumerate(lines, start=1) if line and not line.isspace())
        if line := next(islice(filled, int(most), None), 0):
            problem = f"more than {most} blocks, which is what the controller's memory holds (most_blocks)"
            errors.append((line, 0, problem, "make the program shorter"))
    if errors:
        line, column, problem, remedy = min(errors, key=itemgetter(0))
        raise ProgramError(file=file, line=line, column=column, problem=problem, remedy=remedy, code=Code.SYNTAX)
    return lines


def axis_letters(case: Case, controller: str, file: str, endless: bool = True) -> str:
    """Letters of the axes of a machine: those of a pose, or the names of its own axes.

    Raises ProgramError for a joint whose name is not an axis of its kind, or that turns without end where the
    controller does not count turns (not `endless`).
    """
    if case.need_motion("a program")[1].of_pose:
        return "XYZABC"
    chain, _ = case.need_chain("a program")
    for joint in chain.joints:
        endless_here = joint.kind == "continuous" and not endless  # a modulo axis would not count its turns
        if joint.name not in tuple("ABC" if joint.turns else "XYZ") or endless_here:
            how = "turns without end" if endless_here else "turns" if joint.turns else "slides"
            problem = f"joint {joint.name} {how} and is not an axis of {controller}"
            remedy = (
                'name those that slide X, Y, Z and those that turn A, B, C, with kind = "revolute" and position_deg, '
                f"or write with {option('dialect')} urscript, ros2 or setpoints"
            )
            raise ProgramError(file=file, problem=problem, remedy=remedy, code=Code.SYNTAX)
    return "".join(chain.names)
