"""Blocks, numbers, poses and comments in dialects with similar words."""

import re
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile
from math import floor, log10
from typing import ClassVar

import numpy as np

from cases.base.errors import Code, HexciteError, option
from cases.base.phrases import phrase
from cases.base.units import DEG, MINUTE, MM
from cases.chain import Box
from cases.schema import Case
from identification.motion.motion import Array, Standstill
from identification.motion.moves import CircularMove, Plane, Profile, StraightMove, limits_along
from postprocessors.blocks import Block, Blocks, TimedPath, ToHome, Trace, Trigger
from postprocessors.proof.guarantees import NO_SLOWER, Guarantees, speed_lasting

# of mm and degrees: over 10 ms blocks this rounding stays below 0.1 % of the jerk limits
LENGTH_DECIMALS, ANGLE_DECIMALS = 5, 6
FEED_DECIMALS, FEED_DIGITS = 6, 10
# [mm] where angles move and X, Y, Z less than this, these stay: a feed that counts so little is a crawl, too coarse for
# a control to turn the angles by it evenly
LEAST_WAY = 0.01
COMMENT_WIDTH = 120
# of mm and degrees, for the check that the machine stands at home: ten times the least step of a hand wheel, as far as
# axes at rest stand off their command, and far too little to matter to the way that follows
HOME_WITHIN = 0.01
PLANE_WORDS = {Plane.XY: "G17", Plane.ZX: "G18", Plane.YZ: "G19"}


def number(value: float, decimals: int) -> str:
    """Plain decimal notation, without exponent, trailing zeros or a negative zero."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "", "-") else text


def feed(speed: float, linear: bool) -> str:
    """F in mm/min, or in degrees/min where only angles move; ten digits, also where X, Y, Z hardly move."""
    return digits(speed * MINUTE / (MM if linear else DEG))


def digits(value: float) -> str:
    """A number that is not negative with ten digits, or six decimals where those are more."""
    places = FEED_DIGITS - 1 - floor(log10(value)) if value > 0.0 else 0
    return number(value, max(FEED_DECIMALS, places))


def header_of(program: Blocks) -> tuple[str, ...]:
    """The texts before the first other block."""
    return tuple(map(str, takewhile(lambda block: isinstance(block, str), program)))


def comment_lines(text: str) -> list[str]:
    """The text of a comment, plain ASCII, in lines that every controller accepts."""
    return textwrap.wrap(re.sub(r"[^ -~]", "?", text), COMMENT_WIDTH)


MOTION = (ToHome, StraightMove, CircularMove, TimedPath)
FULL = 1e-9  # [rad] tolerance of a full circle for rounding


def _is_full(move: CircularMove) -> bool:
    return abs(abs(move.angle) - 2 * np.pi) < FULL


class BlockWriter(ABC):
    """Blocks of LinuxCNC, SINUMERIK and TwinCAT; remembers from block to block which axes the feed counts.

    In a machine's own axes no transformation is active, and there are moves from rest to rest only: how these
    controllers execute paths where rotary axes turn is not known.

    Args:
        words: words of the coordinates.
        axes: names of the axes behind them, for the command that groups them.
        guarantees: the controller's time laws.
        case: case with the limits of the controller's set-up; coordinates that are not a pose are the machine's own
            axes.
    """

    name: ClassVar[str]  # name of the controller, for messages
    straight: ClassVar[str]  # words of a straight move with exact stop
    arcs: ClassVar[tuple[str, str]]  # words of an arc counter-clockwise and of one clockwise
    dwell: ClassVar[str]  # word before the seconds of a pause
    full_ends: ClassVar[bool] = True  # whether a full circle has its end in its plane; LinuxCNC would not move with it
    grouping: ClassVar[str] = ""  # command that names the axes whose way F counts, with {} for them; empty: none
    before_checks: ClassVar[tuple[str, ...]] = ()  # lines without which checks of places would not see the present one
    # reason why there are no paths in a machine's own axes
    no_paths: ClassVar[str] = "programs in the machine's own axes are made of moves from rest to rest"

    def __init__(self, words: Sequence[str], axes: Sequence[str], guarantees: Guarantees, case: Case) -> None:
        self.words, self.axes, self.guarantees = words, axes, guarantees
        self.limits: Box = case.need_motion("a program")[1]
        self.own_axes = not self.limits.of_pose
        self.counted: tuple[str, ...] = () if self.own_axes else ("X", "Y", "Z")
        self.standing: list[str] = []  # the coordinates in which the block before ends, as written

    def comments(self, text: str) -> list[str]:
        """Comment lines behind a semicolon, without what may mean something there: quotes, `$PATH=`, backslashes."""
        return [f"; {line}" for line in comment_lines(re.sub(r'["$\\]', "?", text))]

    def to_home(self, block: ToHome) -> list[str]:
        """The lines that stop the program unless the machine stands at home, and those that take out what is left.

        Those that slide go first, alone: what F counts is then known, however short the way.
        """
        words = self.coordinates(block.coordinates)
        home = " ".join(axis + value for axis, value in zip(self.axes, words, strict=True))
        lines = self.comments(f"stop unless the machine stands at home, within {HOME_WITHIN:g} mm and degrees")
        lines += self.before_checks
        for axis, value in zip(self.axes, words, strict=True):
            difference = f"-{value}" if not value.startswith("-") else f"+{value[1:]}"
            lines += self.stop_unless(axis, difference, home)
        lines += [*self.before_crawl(), *self.comments("what is left, at a crawl")]
        for turning in (False, True):
            axes = self.limits.turns == turning
            if axes.any():
                ends = " ".join(w + v for w, v, mine in zip(self.words, words, axes, strict=True) if mine)
                lines += [*self.group(turning), f"{self.straight} {ends} F{self.home_feed(block, turning)}"]
        self.standing = words
        return lines

    def before_crawl(self) -> list[str]:
        """Lines between the checks and the first move."""
        return []

    @abstractmethod
    def stop_unless(self, axis: str, difference: str, home: str) -> list[str]:
        """Lines that stop the program with a message unless an axis stands within `HOME_WITHIN` of its place.

        Args:
            axis: its name.
            difference: minus that place, with its sign.
            home: places of all axes, for the message.
        """

    @abstractmethod
    def trigger(self, on: bool, moves_next: bool) -> str:
        """The block that switches the trigger; `moves_next`: whether a motion follows at once."""

    def trace(self, on: bool) -> list[str]:
        """The blocks that start or stop the controller's own recorder; raises HexciteError where there is none."""
        raise HexciteError(
            problem=f"{self.name} programs start no recorder of the controller",
            remedy="leave it out",
            code=Code.NOT_SUPPORTED,
        )

    @abstractmethod
    def path(self, path: TimedPath) -> list[str]:
        """Blocks of a path of poses."""

    def dense(self, path: TimedPath, before: Sequence[str], after: Sequence[str]) -> list[str]:
        """A path as straight blocks in inverse time, with F on every line, between the lines that begin and end it."""
        lines = [*self.comments(f"{path.name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"), *before]
        for pose, feed in zip(path.poses[1:], MINUTE / np.diff(path.times), strict=True):
            lines.append(f"G1 {self.pose(pose)} F{number(feed, FEED_DECIMALS)}")
        return [*lines, *after]

    def home_feed(self, block: ToHome, turning: bool) -> str:
        """F of the last hundredths to home of the axes that slide or turn, which may reach it within a cycle."""
        axes = self.limits.turns == turning
        speed = float(self.guarantees.crawl[axes].min())
        if self.own_axes:
            speed = min(speed, block.feed * float(self.limits.rate[axes].min()))
        elif not turning:
            speed = min(speed, block.feed)
        per_minute = speed * MINUTE / (DEG if turning else MM)
        step = 10.0 ** (floor(log10(per_minute)) - 1)  # two digits
        return digits(floor(per_minute / step * (1.0 + NO_SLOWER)) * step)

    def move_feed(self, move: StraightMove, words: Sequence[str]) -> tuple[bool, str]:
        """Whether F counts X, Y, Z, and F, for the way as written: where these hardly move, rounding matters.

        `words` are the coordinates of its end as written.
        """
        turns = self.limits.turns
        start, end = (
            self._as_meant(self._as_rounded(np.array([float(word) for word in coordinates])))
            for coordinates in (self.standing or self.coordinates(move.start), words)
        )
        written = replace(move, start=start, end=end) if np.any(start != end) else move
        way = (written.end - written.start)[~turns]
        linear = bool(np.any(np.round(way / MM, LENGTH_DECIMALS) != 0.0))
        return linear, feed(self._feed_of(written, linear), linear)

    def _feed_of(self, move: StraightMove | CircularMove, linear: bool) -> float:
        """Feed of a move along X, Y, Z [m/s] (`linear`), or along the angles [rad/s].

        It is the largest feed that the move can reach where even this takes longer than planned.
        """
        limits, way = self.limits, np.abs(move.end - move.start)
        if isinstance(move, CircularMove):
            way[list(move.plane.axes[:2])] = move.length
        velocity, acceleration, jerk = limits_along(way, limits.rate, limits.acceleration, limits.jerk)

        def law(speed: float) -> Profile:
            if isinstance(move, CircularMove):
                return self.guarantees.arc_law(speed, velocity, acceleration, jerk, abs(move.angle))
            return self.guarantees.law(speed, acceleration, jerk)

        speed = speed_lasting(law, velocity, move.duration)
        if isinstance(move, CircularMove):
            return speed * move.length
        return speed * float(np.linalg.norm(way[limits.turns != linear]))

    def arc_words(self, move: CircularMove) -> str:
        """An arc's end and two of I, J, K: the centre relative to the start, as the block before wrote it."""
        axes, values = move.plane.axes[:2], self.arc_ends(move)
        in_plane = sorted(axes) if self.full_ends or not _is_full(move) else ()
        ends = [self.words[k] + values[k] for k in (*in_plane, 3, 4, 5)]
        start = [float(v) for v in self.standing or self.coordinates(move.start)]
        offsets = move.centre / MM - np.array([start[k] for k in axes])
        centre = ["IJK"[k] + number(offset, LENGTH_DECIMALS) for k, offset in sorted(zip(axes, offsets, strict=True))]
        return " ".join([*ends, *centre])

    def arc_ends(self, move: CircularMove) -> list[str]:
        """Coordinates of an arc's end as written; a full circle ends where it starts, to the last digit."""
        ends = self.coordinates(move.end)
        if _is_full(move) and self.standing:
            for k in move.plane.axes[:2]:
                ends[k] = self.standing[k]
        return ends

    def text(self, program: Blocks, title: Sequence[str], start: Sequence[str], end: Sequence[str]) -> bytes:
        """The whole program, plain ASCII: title, header, and the blocks between those that begin and end it."""
        header = header_of(program)
        lines = [*title, *(comment for line in header for comment in self.comments(line)), *start]
        for k, block in enumerate(program[len(header) :], start=len(header) + 1):
            lines += self.lines(block, next((b for b in program[k:] if not isinstance(b, str)), None))
        return ("\n".join([*lines, *end]) + "\n").encode("ascii")

    def coordinates(self, pose: Array) -> list[str]:
        """Coordinates [m, rad] in mm and degrees."""
        return [
            number(v / DEG, ANGLE_DECIMALS) if angle else number(v / MM, LENGTH_DECIMALS)
            for v, angle in zip(pose, self.limits.turns, strict=True)
        ]

    def pose(self, pose: Array) -> str:
        """Coordinates as words."""
        return self._joined(self.coordinates(pose))

    def _joined(self, coordinates: Sequence[str]) -> str:
        return " ".join(word + value for word, value in zip(self.words, coordinates, strict=True))

    def _to(self, pose: Array) -> list[str]:
        """Coordinates of the end of a move as written: as in the block before where they move by too little.

        They are rounded to what the control can tell apart, or a feed would count a way that it rounds otherwise.
        """
        ends = self.coordinates(pose)
        if self.guarantees.rounds:
            rounded = self._as_rounded(np.array([float(end) for end in ends]))
            ends = [number(value, LENGTH_DECIMALS) for value in rounded]
        if not self.standing:
            return ends
        ways = np.abs(np.array([float(a) - float(b) for a, b in zip(self.standing, ends, strict=True)]))
        stays = ways < self.guarantees.resolution
        slides = ~self.limits.turns
        if not stays[~slides].all() and np.linalg.norm(ways[slides]) < LEAST_WAY:
            stays |= slides
        return [before if stay else end for before, end, stay in zip(self.standing, ends, stays, strict=True)]

    def _as_rounded(self, written: Array) -> Array:
        """Written coordinates in mm and degrees as the control rounds them, shape (k,)."""
        step = self.guarantees.resolution
        return np.round(written / step) * step if self.guarantees.rounds else written

    def _as_meant(self, written: Array) -> Array:
        """Coordinates [m, rad] of written ones in mm and degrees, shape (k,)."""
        return written * np.where(self.limits.turns, DEG, MM)

    def group(self, *turning: bool) -> list[str]:
        """The command that makes F count axes that slide (False) or turn (True), where it does not yet."""
        names = tuple(a for a, turns in zip(self.axes, self.limits.turns, strict=True) if bool(turns) in turning)
        if names == self.counted or not self.grouping:
            return []
        self.counted = names
        return [self.grouping.format(",".join(names))]

    def lines(self, block: Block, following: Block | None) -> list[str]:
        """The lines of a block before another one; raises HexciteError for a path in a machine's own axes."""
        match block:
            case str():
                return self.comments(block)
            case ToHome():
                return self.to_home(block)
            case StraightMove():
                words = self._to(block.end)
                linear, value = self.move_feed(block, words)
                self.standing = words
                return [*self.group(not linear), f"{self.straight} {self._joined(words)} F{value}"]
            case Standstill():
                return [f"{self.dwell}{number(block.duration, 6)}"]
            case Trace():
                return self.trace(block.on)
            case Trigger():
                return [self.trigger(block.on, isinstance(following, MOTION))]
            case CircularMove() | TimedPath() if self.own_axes:
                raise HexciteError(
                    problem=phrase("no_paths", "{name} {why}", name=self.name, why=self.no_paths),
                    remedy=phrase(
                        "plan_moves", "plan with {family}", family=option("family PointToPoint", "family ptp")
                    ),
                    code=Code.NOT_SUPPORTED,
                )
            case CircularMove():
                arc = f"{self.arcs[0] if block.angle > 0.0 else self.arcs[1]} {self.arc_words(block)}"
                value = feed(self._feed_of(block, True), True)
                self.standing = self.arc_ends(block)
                return [*self.group(False), f"{PLANE_WORDS[block.plane]} {arc} F{value}", "G17"]
            case TimedPath():
                self.standing = self.coordinates(block.poses[-1])
                return self.path(block)
