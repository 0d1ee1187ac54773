"""What depends on the wall clock although LinuxCNC counts motion in servo cycles: dwells and the supply of blocks.

LinuxCNC times G4 on the wall. A program is therefore run as a copy whose dwells are divided by the speed-up, line for
line; what was executed is then checked in the log, in cycles. Written programs hold dwells in one form only, `G4
P<seconds>` on a line of its own; any other form is refused, since it could not be proven.

Blocks reach the motion controller one by one, some thousand a second on the wall. Where they come too slowly the motion
stops between them, and the log is true but not what LinuxCNC does in real time.
"""

import re
from pathlib import Path

import numpy as np

from cases.errors import ExecutionError
from postprocessors.execute.linuxcnc.syntax import words
from postprocessors.execute.log import ControllerLog

RESERVES = (0.002, 0.008, 0.032)
"""Added to each dwell [s on the wall], for a servo thread that lags more behind its clock at the dwell's end than at
its start. A run whose dwells are not proven is repeated with the next one."""

LATENCY = 0.2
"""How much longer than that a dwell may take [s on the wall]; about 0.003 on an idle computer, 0.06 on a busy one."""

BLOCK = 1e-3
"""Shortest block that a session is given [s on the wall]. Down to half of it motion is the same at every speed-up, also
with four other busy processes on two cores; at a quarter of it blocks run out now and then."""

_DWELL = re.compile(r"G4 P(?P<seconds>[0-9]+(\.[0-9]+)?)\s*")
_ANY_DWELL = re.compile(r"G0*4(\.0*)?(?![0-9.])")
_FEED_MODE = re.compile(r"G(9[345])(?![0-9.])")
_FEED = re.compile(r"F([0-9]+\.?[0-9]*|\.[0-9]+)")


def dwells(program: Path, lines: list[str]) -> dict[int, float]:
    """The dwells of a program: line number, counted from 1, and duration [s].

    Args:
        program: the program, for messages.
        lines: its lines.

    Raises:
        ExecutionError: a dwell has another form than `G4 P<seconds>` on a line of its own.
    """
    found: dict[int, float] = {}
    for number, line in enumerate(lines, start=1):
        if match := _DWELL.fullmatch(line):
            found[number] = float(match["seconds"])
        elif _ANY_DWELL.search(words(line)):
            raise ExecutionError(
                f"{program}, line {number}: dwell {line.strip()!r} cannot be timed; write it as G4 P<seconds> on a "
                "line of its own"
            )
    return found


def with_dwells(lines: list[str], durations: dict[int, float], speedup: float, reserve: float) -> list[str]:
    """The lines of a program for a controller whose clock runs `speedup` times as fast as the wall's."""
    return [
        f"G4 P{durations[number] / speedup + reserve:.6f}" if number in durations else line
        for number, line in enumerate(lines, start=1)
    ]


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
            f"{program}, line {executed[np.argmax(back)]}: LinuxCNC jumped back to this line, so that dwells cannot be "
            "timed; write the program without loops"
        )


def dwell_problem(
    log: ControllerLog, durations: dict[int, float], speedup: float, reserve: float, window: tuple[int, int]
) -> str | None:
    """Proves from the log that each dwell took its programmed time, and at most `LATENCY` on the wall more.

    No line is executed while LinuxCNC dwells. Dwells without a motion between them are checked as a sum, for the log
    cannot tell them apart. Those before the first and after the last motion are checked within `window`, which is as
    exact as the driver's polling (some milliseconds on the wall).

    Args:
        log: what was executed, from top to bottom.
        durations: line number and duration [s] of each dwell.
        speedup: controller time per wall-clock time.
        reserve: what was added to each dwell [s on the wall].
        window: rows between which the program ran: first, and one past the last.

    Returns:
        None, or what is wrong, beginning with the line.
    """
    moving = np.flatnonzero(log.lines)
    executed = log.lines[moving]
    standstills: dict[int, list[int]] = {}  # dwells that the same motion follows
    for number in durations:
        standstills.setdefault(int(np.searchsorted(executed, number)), []).append(number)
    for following, numbers in standstills.items():
        start = window[0] if following == 0 else int(moving[following - 1]) + 1
        # The first cycle of a motion still shows the line before it.
        end = window[1] if following == len(moving) else int(moving[following]) - 1
        taken = (end - start) * log.period
        planned = sum(durations[number] for number in numbers)
        allowed = planned + len(numbers) * (reserve + LATENCY) * speedup
        if not planned <= taken <= allowed:
            return (
                f"line {numbers[0]}: LinuxCNC dwelt {taken:.3f} s, must be {planned:.3f} to {allowed:.3f} s; the "
                f"computer is too busy, run again with a speed-up below {speedup:g}"
            )
    return None
