"""Whether LinuxCNC kept the time of timed paths: it may stretch them, and so may a computer that is too busy."""

from typing import NamedTuple

import numpy as np

from postprocessors.execute.log import ControllerLog
from postprocessors.proving.stretches import Timed, stretches
from postprocessors.reading.words import Reading

TIME_TOLERANCE = 0.005
"""Share of a path's duration by which it may be late; measured on an idle computer 0.002 with 10 ms blocks."""

CYCLES = 30
"""And these many cycles, which starting and stopping cost: blending ends some blocks late."""


class Path(NamedTuple):
    """A timed path and how long it took.

    Args:
        line: of the program at which it ends.
        planned: duration in the program [s].
        taken: with the controller [s].
    """

    line: int
    planned: float
    taken: float

    def sentence(self) -> str:
        """One phrase for people."""
        return f"the timed path that ends in line {self.line} took {self.taken:.3f} s instead of {self.planned:.3f} s"


def slowest_path(reading: Reading, log: ControllerLog) -> Path | None:
    """The timed path that was most late, None where all were in time.

    Args:
        reading: the program that was run.
        log: of every cycle.
    """
    worst: Path | None = None
    for part in stretches(reading):
        if not isinstance(part, Timed):
            continue
        rows = (log.lines >= part.lines[0]) & (log.lines <= part.lines[-1])
        path = Path(part.lines[-1], part.points.duration, float(np.count_nonzero(rows)) * log.period)
        late = path.taken - path.planned
        if late > TIME_TOLERANCE * path.planned + CYCLES * log.period and (
            worst is None or late > worst.taken - worst.planned
        ):
            worst = path
    return worst
