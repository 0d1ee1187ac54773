"""Parts of a run that depend on the wall clock, although LinuxCNC counts motion in cycles: dwells, switches, blocks.

LinuxCNC times G4 by the wall clock, behind which a busy servo thread lags. A program is therefore run as a copy that
counts its dwells in cycles (`dwell.ngc`); that each phase between two switches of the trigger took its time is checked
in the log. The end of a dwell, and an output that switches at once (M64, M65), are noticed some milliseconds of
wall-clock time late: these cycles are removed.

Where blocks reach the motion controller too slowly, the motion stops between them, which LinuxCNC does not do in real
time. The log shows it: no line is executed for a while between a line and the next.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases.base.errors import Code, HexciteError
from postprocessors.controllers.executed_run import ControllerLog
from postprocessors.reading import NUMBER, Reading, Still, Timed

ATTEMPTS = 3  # sessions for a program, each at half the speed-up of the one before
BLOCK = 1e-3  # shortest block of a session [s of wall-clock time]; at a quarter of it blocks are sometimes late

FEWEST_CYCLES = 10  # cycles that a standstill has at least: switches take LinuxCNC some cycles in real time too

_COMMENT = re.compile(r"\([^()]*\)|;.*")
_DWELL = re.compile(rf"\s*(?:N\s*[0-9.]+)?\s*(?:G\s*0*4\s*P\s*{NUMBER}|M\s*[0-9]+)\s*", re.IGNORECASE)


def with_dwells(program: Path, lines: list[str], reading: Reading) -> list[str]:
    """The lines of a program with dwells in servo cycles, and without the stops at which an operator would go on.

    Raises HexciteError for a dwell that is not `G4 P<seconds>` alone.
    """
    copy = list(lines)
    for part in reading.stretches:
        if isinstance(part, Still):
            line = lines[part.line - 1]
            if not _DWELL.fullmatch(_COMMENT.sub("", line)):
                place, remedy = f"{program}, line {part.line}", "write it as G4 P<seconds> on a line of its own"
                raise HexciteError(
                    place=place,
                    problem=f"dwell {line.strip()!r} cannot be timed",
                    remedy=remedy,
                    code=Code.NOT_SUPPORTED,
                )
            copy[part.line - 1] = f"o<dwell> call [{part.duration:.6f}]"
    return copy


def fastest(reading: Reading) -> float:
    """The largest speed-up at which blocks with a time of their own arrive in time; infinite without them."""
    steps = [np.diff(part.points.times).min() for part in reading.stretches if isinstance(part, Timed)]
    return float(min(steps, default=np.inf) / BLOCK)


def supply_problem(log: ControllerLog) -> str | None:
    """The problem where the motion waited for a block that follows on the line before; None where it never did."""
    moving = np.flatnonzero(log.lines)
    executed, waits = log.lines[moving], np.diff(moving) - 1
    steps = np.flatnonzero((waits > 0) & (np.diff(executed) <= 1))  # a dwell or a switch has a line of its own
    if not len(steps):
        return None
    first = steps[0]
    return (
        f"line {executed[first + 1]}: the motion waited {waits[first] * log.period:.3f} s for this block; the computer "
        "is too busy, run again"
    )


def dwell_problem(log: ControllerLog, reading: Reading, window: tuple[int, int]) -> str | None:
    """Proves from the log that the dwells took their programmed time; returns None, or the problem from its line on.

    No line is executed while LinuxCNC dwells. Dwells without a motion or a switch between them are checked as a sum,
    for the log does not separate them. Those before the first and after the last motion are checked within `window`,
    the rows between which the program ran: first, and one past the last.
    """
    for line, phases in _standstills(log, reading, window):
        if not phases:
            return f"line {line}: the trigger did not switch here as the program asks; run again"
        for start, end, seconds in phases:
            dwell_time = (end - start) * log.period
            if dwell_time < seconds - log.period / 2:
                return (
                    f"line {line}: LinuxCNC dwelt {dwell_time:.3f} s instead of {seconds:.3f} s; "
                    "the computer is too busy, run again"
                )
    return None


def without_surplus(log: ControllerLog, reading: Reading, window: tuple[int, int]) -> ControllerLog:
    """The log without the cycles by which it stood longer only because the wall clock timed dwells and switches.

    It removes cycles in the middle of a standstill, during which nothing changed, so that each dwell is as long as
    programmed, and a switch without one takes `FEWEST_CYCLES`. Where the trigger switches between dwells, each is
    shortened by itself; where the log does not show the switches of the program, nothing is removed.
    Arguments as `dwell_problem`.
    """
    mask = np.ones(len(log.lines), dtype=bool)
    for _, phases in _standstills(log, reading, window):
        for start, end, seconds in phases:
            cycles = max(round(seconds / log.period), FEWEST_CYCLES)
            middle = start + cycles // 2
            surplus = slice(middle, middle + end - start - cycles)
            if surplus.stop <= middle:
                continue
            if not np.ptp(log.drives[middle - 1 : surplus.stop + 1], axis=0).any():
                mask[surplus] = False
    columns = {name: getattr(log, name)[mask] for name in ("drives", "poses", "trigger", "lines")}
    return replace(log, **columns, left_out=int(np.count_nonzero(~mask)))


def _standstills(
    log: ControllerLog, reading: Reading, window: tuple[int, int]
) -> Iterator[tuple[int, list[tuple[int, int, float]]]]:
    """Dwells and switches without a motion between them: one of their lines, and the parts without a switch.

    Each part has the first row, one past the last, and the programmed time [s]; there are no parts where the log does
    not show the switches of the program.
    """
    moving = np.flatnonzero(log.lines)
    executed = log.lines[moving]
    for line, following, planned in _planned_standstills(reading, set(executed.tolist())):
        k = len(moving) if following is None else int(np.searchsorted(executed, following))
        first = int(moving[k - 1]) + 1 if k > 0 else window[0]
        # The first cycle of a motion still shows the line before it.
        last = int(moving[k]) - 1 if k < len(moving) else window[1]
        if first >= last and not any(planned):
            continue  # a switch with the motion
        edges = first + 1 + np.flatnonzero(np.diff(log.trigger[first:last].astype(int)))
        for end in (-1, 0):  # a switch may come with the motion after it, or with the end of the one before
            if len(planned) > len(edges) + 1 and planned[end] == 0.0:
                planned.pop(end)
        bounds = [first, *map(int, edges), last]
        complete = len(planned) == len(edges) + 1
        yield line, list(zip(bounds, bounds[1:], planned, strict=False)) if complete else []


def _planned_standstills(reading: Reading, executed: set[int]) -> Iterator[tuple[int, int | None, list[float]]]:
    """A line of each standstill, that of the motion after it, and the time before, between and after switches [s].

    `executed` are the lines in which something moved.
    """
    on, line, planned = False, 0, [0.0]
    for part in (*reading.stretches, None):
        trigger = bool(reading.left_on) if part is None else part.trigger
        if trigger != on:
            planned.append(0.0)
        on = trigger
        if isinstance(part, Still):
            line = line or part.line
            planned[-1] += part.duration
        elif part is None:
            if line or len(planned) > 1:
                yield line or reading.stretches[-1].line, None, planned
        elif moved := sorted(executed.intersection(part.lines if isinstance(part, Timed) else (part.line,))):
            if line or len(planned) > 1:
                yield line or part.line, moved[0], planned
            line, planned = 0, [0.0]
