"""A program that was read, as stretches of motion between standstills: what the proof judges and controllers run."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import ProgramError
from cases.schema import Case
from identification.motion import TimedPoints
from postprocessors.reading.words import Move, Pause, Reading, Switch, Timing

Array = NDArray[np.float64]

STILL = 1e-9  # [m, rad] below the last decimal of any program


@dataclass(frozen=True, slots=True)
class Timed:
    """A path whose time the program states block by block.

    Args:
        lines: line of the program that ends each block, shape (k - 1,).
        points: the motion through the k poses, from rest to rest.
        trigger: whether the trigger is on.
    """

    lines: tuple[int, ...]
    points: TimedPoints
    trigger: bool

    def line_at(self, time: float) -> int:
        """Line of the program whose block runs at `time` after the start of the stretch [s]."""
        block = int(np.searchsorted(self.points.times, time, side="left")) - 1
        return self.lines[int(np.clip(block, 0, len(self.lines) - 1))]


@dataclass(frozen=True, slots=True)
class Untimed:
    """A straight move from standstill to standstill whose time law is the controller's.

    Args:
        line: of the program.
        start: shape (6,) [m, rad], or None where the program cannot know it.
        end: shape (6,) [m, rad].
        duration: at constant feed; None where the start is not known [s].
        feed: along XYZ [m/s] or ABC [rad/s]; None for a rapid.
        trigger: whether the trigger is on.
    """

    line: int
    start: Array | None
    end: Array
    duration: float | None
    feed: float | None
    trigger: bool


@dataclass(frozen=True, slots=True)
class Still:
    """A dwell.

    Args:
        line: of the program.
        duration: [s].
        trigger: whether the trigger is on.
    """

    line: int
    duration: float
    trigger: bool


Stretch = Timed | Untimed | Still


def stretches(reading: Reading, case: Case) -> tuple[Stretch, ...]:
    """Groups moves into stretches that begin and end at rest.

    Args:
        reading: the program.
        case: gives the speed of rapids.

    Raises:
        ProgramError: a program whose motion is not defined: timed blocks from an unknown pose, blocks of the
        controller's
            own timing that run into each other, a trigger that waits for a motion which never comes.
    """
    return tuple(_Grouping(reading, case).run())


class _Grouping:
    def __init__(self, reading: Reading, case: Case) -> None:
        self.reading = reading
        self.rate = case.need_machine("the check of a program")[2].motion.rate
        self.pose: Array | None = None
        self.trigger = False
        self.waiting: Switch | None = None
        self.timed: list[Move] = []

    def error(self, line: int, problem: str) -> ProgramError:
        return ProgramError(self.reading.file, line, 0, problem)

    def run(self) -> Iterator[Stretch]:
        for event in self.reading.events:
            if isinstance(event, Move) and event.timing is Timing.DURATION:
                if self.timed and self.waiting is not None:
                    raise self.error(self.waiting.line, "the trigger switches in the middle of a path; switch at rest")
                self._settle_trigger()
                self.timed.append(event)
                continue
            if isinstance(event, Switch) and not event.at_once:
                self.waiting = event  # no reason for the controller to stop
                continue
            yield from self._finish_timed()
            if isinstance(event, Move):
                self._settle_trigger()
                yield self._untimed(event)
            elif isinstance(event, Pause):
                yield Still(event.line, event.duration, self.trigger)
            else:
                self.trigger = event.on
        yield from self._finish_timed()
        if self.waiting is not None:
            raise self.error(self.waiting.line, "the trigger waits for a next motion that never comes; use M64 or M65")

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
        stopping = next((m for m in moves if m.exact_stop), None)
        if stopping is not None:
            raise self.error(
                stopping.line,
                "a timed block under G61: the controller stops at its end and does not keep the time; use G64",
            )
        times = np.concatenate([[0.0], np.cumsum([m.value for m in moves])])
        poses = np.vstack([self.pose, *(m.end for m in moves)])
        self.pose = moves[-1].end
        yield Timed(tuple(m.line for m in moves), TimedPoints.through(times, poses), self.trigger)

    def _untimed(self, move: Move) -> Untimed:
        if not move.exact_stop:
            raise self.error(
                move.line, "a move at a feed is blended into the next (G64), its path is not known; use G61"
            )
        start, self.pose = self.pose, move.end
        rapid = move.timing is Timing.RAPID
        duration = None
        if start is not None:
            way = np.abs(move.end - start)
            linear, angular = float(np.linalg.norm(way[:3])), float(np.linalg.norm(way[3:]))
            length = linear if move.linear else angular
            duration = float(np.max(way / self.rate)) if rapid else length / move.value
        return Untimed(move.line, start, move.end, duration, None if rapid else move.value, self.trigger)
