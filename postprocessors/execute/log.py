"""What a controller did while it ran a program, whichever controller it was."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from postprocessors.proving.stretches import Timed, stretches
from postprocessors.reading.words import Reading

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ControllerLog:
    """What a controller did, one row a cycle. Arrays are copied and read-only.

    Args:
        controller: name and version of the controller, as it gave them itself.
        period: duration of a cycle [s].
        drives: commanded positions of struts or joints, shape (n, k) [m or rad].
        poses: commanded coordinates, shape (n, k) [m or rad].
        trigger: the recording output, shape (n,).
        lines: the program line being executed, counted from 1; 0 while nothing moves; a cycle late where the
            controller reports it so (LinuxCNC), shape (n,).
        left_out: cycles of standstill that are not in it, because only the computer's clock made them.

    Raises:
        ValueError: a shape is wrong, a value is not finite, or the log is empty.
    """

    controller: str
    period: float
    drives: Array
    poses: Array
    trigger: NDArray[np.bool_]
    lines: NDArray[np.int64]
    left_out: int = 0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.period) and self.period > 0.0):
            raise ValueError(f"controller log: period is {self.period} s, must be positive")
        count = len(self.lines)
        if count == 0:
            raise ValueError("controller log: holds no cycle")
        for name in ("drives", "poses"):
            values = np.array(getattr(self, name), dtype=np.float64)
            self._freeze(name, values, (count, *np.shape(self.poses)[1:]))
        self._freeze("trigger", np.array(self.trigger, dtype=np.bool_), (count,))
        self._freeze("lines", np.array(self.lines, dtype=np.int64), (count,))

    def _freeze(self, name: str, values: NDArray[np.generic], shape: tuple[int, ...]) -> None:
        if values.shape != shape:
            raise ValueError(f"controller log: {name} has shape {values.shape}, expected {shape}")
        if not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values).reshape(len(values), -1).all(axis=1)))
            raise ValueError(f"controller log: {name} is not finite in row {row + 1}")
        values.setflags(write=False)
        object.__setattr__(self, name, values)

    @property
    def time(self) -> Array:
        """Time since the first row, shape (n,) [s]."""
        return np.arange(len(self.lines), dtype=np.float64) * np.float64(self.period)


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
