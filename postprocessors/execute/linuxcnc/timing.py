"""What depends on the wall clock although LinuxCNC counts motion in cycles: dwells, switches, the supply of blocks.

LinuxCNC times G4 on the wall, which a servo thread on a busy computer lags behind. A program is therefore run as a copy
that counts its dwells in cycles (`configuration.DWELL`), line for line; that each phase between two switches of the
trigger took its time is then checked in the log. Written programs hold dwells in one form only, `G4 P<seconds>` on a
line of its own; any other form is refused, since it could not be proven. That a dwell has ended, and that an output
is to switch at once (M64, M65), is seen some milliseconds late, on the wall: these cycles of waiting are cut out.

Blocks reach the motion controller one by one, some thousand a second on the wall. Where they come too slowly, which
heavy work of others on the computer's disk does, the motion stops between them: not what LinuxCNC does in real time.
The log shows it: no line is executed for a while between a line and the next.
"""

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases.errors import ExecutionError
from postprocessors.execute import ControllerLog

ATTEMPTS = 3
"""Sessions for a program, each at half the speed-up of the one before, where cycles were lost, blocks came too late or
dwells were not proven."""

BLOCK = 1e-3
"""Shortest block that a session is given [s on the wall]. Down to half of it motion is the same at every speed-up, also
with four other busy processes on two cores; at a quarter of it blocks run out now and then."""

FEWEST_CYCLES = 10
"""That a standstill keeps: switches take LinuxCNC some cycles in real time too."""

_COMMENT = re.compile(r"\([^)]*\)|;.*")
_SWITCH = re.compile(r"M(?P<code>6[45])P0+")
_DWELL = re.compile(r"G4 P(?P<seconds>[0-9]+(\.[0-9]+)?)\s*")
_ANY_DWELL = re.compile(r"G0*4(\.0*)?(?![0-9.])")
_FEED_MODE = re.compile(r"G(9[345])(?![0-9.])")
_FEED = re.compile(r"F([0-9]+\.?[0-9]*|\.[0-9]+)")


def words(line: str) -> str:
    """A line as the interpreter sees it: without comments and blanks, in capitals."""
    return re.sub(r"\s", "", _COMMENT.sub("", line)).upper()


def dwells(program: Path, lines: list[str]) -> dict[int, float]:
    """The dwells of a program: line number, counted from 1, and duration [s].

    Raises:
        ExecutionError: a dwell has another form than `G4 P<seconds>` on a line of its own.
    """
    durations: dict[int, float] = {}
    for number, line in enumerate(lines, start=1):
        if match := _DWELL.fullmatch(line):
            durations[number] = float(match["seconds"])
        elif _ANY_DWELL.search(words(line)):
            raise ExecutionError(
                f"{program}, line {number}",
                f"dwell {line.strip()!r} cannot be timed",
                "write it as G4 P<seconds> on a line of its own",
            )
    return durations


def with_dwells(lines: list[str], durations: dict[int, float]) -> list[str]:
    """The lines of a program for a controller that counts its dwells in servo cycles."""
    return [
        f"o<dwell> call [{durations[number]:.6f}]" if number in durations else line
        for number, line in enumerate(lines, start=1)
    ]


def switches(lines: list[str]) -> dict[int, bool]:
    """The lines that switch the trigger at once (M64, M65): their number, counted from 1, and whether on."""
    return {
        number: match["code"] == "64"
        for number, line in enumerate(lines, start=1)
        if (match := _SWITCH.fullmatch(words(line)))
    }


def is_inverse_time(line: str) -> bool:
    """Whether a line turns inverse time (G93) on."""
    return any(mode == "93" for mode in _FEED_MODE.findall(words(line)))


def fastest(lines: list[str]) -> float:
    """The largest speed-up at which blocks timed by G93 arrive in time; infinite for a program without them."""
    shortest, inverse_time = np.inf, False
    for line in lines:
        block = words(line)
        if mode := _FEED_MODE.search(block):
            inverse_time = mode[1] == "93"
        if inverse_time and (feed := _FEED.search(block)) and float(feed[1]) > 0.0:
            shortest = min(shortest, 60.0 / float(feed[1]))
    return float(shortest / BLOCK)


def check_order(program: Path, log: ControllerLog) -> None:
    """Checks that the lines were executed from top to bottom, without which dwells cannot be told apart.

    Raises:
        ExecutionError: they were not.
    """
    executed = log.lines[log.lines != 0]
    back = np.diff(executed, prepend=0) < 0
    if back.any():
        raise ExecutionError(
            f"{program}, line {executed[np.argmax(back)]}",
            "LinuxCNC jumped back to this line, so that dwells and switches cannot be timed",
            "write the program without loops",
        )


def supply_problem(log: ControllerLog) -> str | None:
    """What is wrong where the motion waited for a block that follows on the line before; None where it never did."""
    moving = np.flatnonzero(log.lines)
    executed, waits = log.lines[moving], np.diff(moving) - 1
    late = np.flatnonzero((waits > 0) & (np.diff(executed) <= 1))  # a dwell or a switch has a line of its own
    if not len(late):
        return None
    first = late[0]
    return (
        f"line {executed[first + 1]}: the motion waited {waits[first] * log.period:.3f} s for this block; the computer "
        "is too busy, run again"
    )


def dwell_problem(
    log: ControllerLog, durations: dict[int, float], switched: dict[int, bool], window: tuple[int, int]
) -> str | None:
    """Proves from the log that the dwells took their programmed time, each before and after its switch of the trigger.

    No line is executed while LinuxCNC dwells. Dwells without a motion or a switch between them are checked as a sum,
    for the log cannot tell them apart. Those before the first and after the last motion are checked within `window`.

    Args:
        log: what was executed, from top to bottom.
        durations: line number and duration [s] of each dwell.
        switched: line number of each switch, and whether it switches on.
        window: rows between which the program ran: first, and one past the last.

    Returns:
        None, or what is wrong, beginning with the line.
    """
    for numbers, rows in _standstills(log, durations.keys() | switched.keys(), window):
        phases = _phases(log, numbers, rows, durations, switched)
        if not phases:
            return f"line {numbers[0]}: the trigger did not switch here as the program asks; run again"
        for start, end, seconds in phases:
            taken = (end - start) * log.period
            if taken < seconds - log.period / 2:
                return (
                    f"line {numbers[0]}: LinuxCNC dwelt {taken:.3f} s instead of {seconds:.3f} s; the "
                    "computer is too busy, run again"
                )
    return None


def _standstills(
    log: ControllerLog, numbers: Iterable[int], window: tuple[int, int]
) -> Iterator[tuple[list[int], slice]]:
    """Dwells and switches without a motion between them: numbers of their lines, ascending, and rows of the log."""
    moving = np.flatnonzero(log.lines)
    executed = log.lines[moving]
    together: dict[int, list[int]] = {}  # those that the same motion follows
    for number in sorted(numbers):
        together.setdefault(int(np.searchsorted(executed, number)), []).append(number)
    for k, group in together.items():
        start = int(moving[k - 1]) + 1 if k > 0 else window[0]
        # The first cycle of a motion still shows the line before it.
        end = int(moving[k]) - 1 if k < len(moving) else window[1]
        yield group, slice(start, end)


def without_surplus(
    log: ControllerLog, durations: dict[int, float], switched: dict[int, bool], window: tuple[int, int]
) -> ControllerLog:
    """The log without the cycles by which it stood longer only because the wall clock timed dwells and switches.

    Left out are cycles in the middle of a standstill, during which nothing changed, so that each dwell is as long as
    programmed, and a switch without one takes `FEWEST_CYCLES`. Where the trigger switches between dwells, each is
    shortened by itself; where the log does not show the switches that the program asks for, nothing is left out.
    Arguments as `dwell_problem`.
    """
    mask = np.ones(len(log.lines), dtype=bool)
    for numbers, rows in _standstills(log, durations.keys() | switched.keys(), window):
        for start, end, seconds in _phases(log, numbers, rows, durations, switched):
            cycles = max(round(seconds / log.period), FEWEST_CYCLES)
            middle = start + cycles // 2
            surplus = slice(middle, middle + end - start - cycles)
            if surplus.stop <= middle:
                continue
            if not np.ptp(log.drives[middle - 1 : surplus.stop + 1], axis=0).any():
                mask[surplus] = False
    columns = {name: getattr(log, name)[mask] for name in ("drives", "poses", "trigger", "lines")}
    return replace(log, **columns, left_out=int(np.count_nonzero(~mask)))


def _phases(
    log: ControllerLog, numbers: list[int], rows: slice, durations: dict[int, float], switched: dict[int, bool]
) -> list[tuple[int, int, float]]:
    """First row, one past the last, and programmed time [s] of each part of a standstill without a switch.

    None where the log does not show the switches that the program asks for.
    """
    trigger = log.trigger[rows]
    edges = rows.start + 1 + np.flatnonzero(np.diff(trigger.astype(int)))
    planned = _between_switches(numbers, durations, switched, bool(trigger[0]))
    if len(planned) == len(edges) + 2 and planned[-1] == 0.0:
        planned.pop()  # the last switch comes with the motion
    if len(planned) != len(edges) + 1:
        return []
    bounds = [rows.start, *(int(edge) for edge in edges), rows.stop]
    return list(zip(bounds, bounds[1:], planned, strict=False))


def _between_switches(
    numbers: list[int], durations: dict[int, float], switched: dict[int, bool], on: bool
) -> list[float]:
    """Programmed time before, between and after the switches that change the trigger in a standstill [s]."""
    planned = [0.0]
    for number in numbers:
        if number in durations:
            planned[-1] += durations[number]
        elif switched[number] != on:
            on = switched[number]
            planned.append(0.0)
    return planned
