"""A program that was read, as stretches of motion between standstills: what the proof judges and controllers run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import ProgramError
from identification.motion import TimedPoints
from identification.trajectories.curves import Piece, PolynomialMotion, Tabulated
from postprocessors.reading import Move, Pause, Polynomial, Reading, Stand, Switch, TableRows, Turn

Array = NDArray[np.float64]

STILL = 1e-9  # [m, rad] below the last decimal of any program


@dataclass(frozen=True, slots=True)
class Timed:
    """A path whose time the program states block by block."""

    lines: tuple[int, ...]  # line of the program that ends each block, shape (k - 1,)
    points: TimedPoints | PolynomialMotion | Tabulated  # the motion through the k poses, from rest to rest
    trigger: bool  # whether the trigger is on

    def line_at(self, time: float) -> int:
        """Line of the program whose block runs at `time` after the start of the stretch [s]."""
        block = int(np.searchsorted(self.points.times, time, side="left")) - 1
        return self.lines[int(np.clip(block, 0, len(self.lines) - 1))]


@dataclass(frozen=True, slots=True)
class Untimed:
    """A straight move or an arc from standstill to standstill whose time law is the controller's."""

    line: int  # line of the program
    start: Array | None  # shape (6,) [m, rad], or None where the program cannot know it
    end: Array  # shape (6,) [m, rad]
    feed: float | None  # along XYZ [m/s] or ABC [rad/s]; None for a rapid
    linear: bool  # whether the feed counts XYZ
    turn: Turn | None  # the arc; None for a straight move
    trigger: bool  # whether the trigger is on
    # indices of the coordinates of a chain whose way the feed counts; None as `linear` says
    counted: tuple[int, ...] | None = None
    # acceleration of that way, where the text states it: its time law is then the text's [m/s^2 or rad/s^2]
    acceleration: float | None = None

    @property
    def length(self) -> float:
        """Way that the feed counts, from a known start [m], [rad] where only angles move."""
        assert self.start is not None
        way = self.end - self.start
        if self.turn is not None:
            first, second, _ = self.turn.plane.axes
            arm = self.start[[first, second]] - self.turn.centre
            return abs(self.turn.angle) * float(np.hypot(arm[0], arm[1]))
        if self.counted is not None:
            return float(np.linalg.norm(way[list(self.counted)]))
        return float(np.linalg.norm(way[:3] if self.linear else way[3:]))

    @property
    def share_rate(self) -> float | None:
        """The feed as a share of the way, from a known start [1/s]; None for a rapid."""
        return None if self.feed is None else self.feed / self.length

    @property
    def moves(self) -> bool:
        """Whether it moves at all, as far as is known."""
        return self.turn is not None or self.start is None or bool(np.any(np.abs(self.end - self.start) > STILL))


@dataclass(frozen=True, slots=True)
class Still:
    """A dwell."""

    line: int  # line of the program
    duration: float  # [s]
    trigger: bool  # whether the trigger is on


Stretch = Timed | Untimed | Still


def stretches(reading: Reading) -> tuple[Stretch, ...]:
    """Groups moves into stretches that begin and end at rest.

    Raises:
        ProgramError: a program whose motion is not defined: timed blocks from an unknown pose, blocks of the
            controller's own timing that run into each other, a trigger that waits for a motion which never comes.
    """
    return tuple(_Grouping(reading).run())


class _Grouping:
    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self.pose: Array | None = None
        self.trigger = False
        self.waiting: Switch | None = None
        self.timed: list[Move | Polynomial] = []

    def error(self, line: int, problem: str) -> ProgramError:
        return ProgramError(self.reading.file, line, 0, problem)

    def run(self) -> Iterator[Stretch]:
        for event in self.reading.events:
            if isinstance(event, Polynomial) or (isinstance(event, Move) and event.duration is not None):
                if self.timed and self.waiting is not None:
                    raise self.error(self.waiting.line, "the trigger switches in the middle of a path; switch at rest")
                self._settle_trigger()
                self.timed.append(event)
                continue
            if isinstance(event, Switch) and not event.at_once:
                self.waiting = event  # no reason for the controller to stop
                continue
            yield from self._finish_timed()
            if isinstance(event, Move | Turn):
                self._settle_trigger()
                yield self._untimed(event)
            elif isinstance(event, Pause):
                yield Still(event.line, event.duration, self.trigger)
            elif isinstance(event, TableRows):
                yield self._rows(event)
            elif isinstance(event, Stand):
                self.pose = event.pose
            else:
                self.trigger = event.on
        yield from self._finish_timed()
        if self.waiting is not None:
            raise self.error(self.waiting.line, "the trigger waits for a next motion that never comes; use M64 or M65")

    def _rows(self, event: TableRows) -> Timed:
        self.pose = event.poses[-1]
        times = np.asarray(np.arange(len(event.poses)) * event.cycle, dtype=float)
        lines = tuple(range(event.line + 1, event.line + len(times)))
        points = Tabulated(times, event.poses, event.rates, event.accelerations)
        return Timed(lines, points, self.trigger)

    def _settle_trigger(self) -> None:
        if self.waiting is not None:
            self.trigger, self.waiting = self.waiting.on, None

    def _finish_timed(self) -> Iterator[Timed]:
        if not self.timed:
            return
        moves, self.timed = self.timed, []
        if self.pose is None:
            raise self.error(
                moves[0].line, "a timed block starts from an unknown pose; first move home at a feed (G94)"
            )
        stopping = next((m for m in moves if isinstance(m, Move) and m.exact_stop), None)
        if stopping is not None:
            raise self.error(
                stopping.line,
                "a timed block under G61: the controller stops at its end and does not keep the time; use G64",
            )
        yield Timed(tuple(m.line for m in moves), self._through(moves, self.pose), self.trigger)
        self.pose = moves[-1].end

    def _through(self, moves: list[Move | Polynomial], start: Array) -> TimedPoints | PolynomialMotion:
        points = [m for m in moves if isinstance(m, Move)]
        if len(points) == len(moves):
            times = np.concatenate([[0.0], np.cumsum([m.duration or 0.0 for m in points])])
            return TimedPoints.through(times, np.vstack([start, *(m.end for m in points)]))
        if points:
            raise self.error(points[0].line, "a timed straight block among polynomials; write a path in one form")
        pieces = []
        for move in moves:
            assert isinstance(move, Polynomial)
            powers = move.duration ** np.arange(len(move.coefficients))
            pieces.append(Piece(move.coefficients / powers[:, None], move.duration))
        return PolynomialMotion(tuple(pieces))

    def _untimed(self, move: Move | Turn) -> Untimed:
        if not move.exact_stop:
            raise self.error(
                move.line, "a move at a feed is blended into the next (G64), its path is not known; use G61"
            )
        start, self.pose = self.pose, move.end
        if isinstance(move, Turn):
            if start is None:
                raise self.error(move.line, "an arc starts from an unknown pose; first move home at a feed")
            return Untimed(move.line, start, move.end, move.feed, True, move, self.trigger)
        law = (move.counted, move.acceleration)
        return Untimed(move.line, start, move.end, move.feed, move.linear, None, self.trigger, *law)


def measures_at_poses(program: Sequence[Stretch]) -> bool:
    """Whether the trigger is on while the machine stands, and never while it moves."""
    on = [part for part in program if part.trigger and not (isinstance(part, Still) and part.duration == 0.0)]
    return bool(on) and all(isinstance(part, Still) for part in on)


def measured_poses(program: Sequence[Stretch]) -> Array:
    """Poses at which the trigger is on, in order, shape (k, n) [m or rad]; of programs that measure standing still."""
    last_pose: Array | None = None
    poses: list[Array] = []
    for part in program:
        if isinstance(part, Untimed):
            last_pose = part.end
        elif isinstance(part, Timed):
            last_pose = part.points.at([part.points.duration]).pose[0]
        elif part.trigger and part.duration > 0.0 and last_pose is not None:
            poses.append(last_pose)
    return np.array(poses)
