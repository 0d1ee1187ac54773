"""What a controller did while it ran a program, whichever controller it was."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ControllerLog:
    """What a controller did, one row a cycle. Arrays are copied and read-only.

    Args:
        controller: name and version of the controller, as it gave them itself.
        period: duration of a cycle [s].
        strut_lengths: commanded strut lengths, shape (n, 6) [m].
        poses: commanded pose (x, y, z, roll, pitch, yaw), shape (n, 6) [m, rad].
        trigger: the recording output, shape (n,).
        lines: the program line being executed, counted from 1; 0 while nothing moves; a cycle late where the
            controller reports it so (LinuxCNC), shape (n,).
        left_out: cycles of standstill that are not in it, because only the computer's clock made them.

    Raises:
        ValueError: a shape is wrong, a value is not finite, or the log is empty.
    """

    controller: str
    period: float
    strut_lengths: Array
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
        self._freeze("strut_lengths", np.array(self.strut_lengths, dtype=np.float64), (count, 6))
        self._freeze("poses", np.array(self.poses, dtype=np.float64), (count, 6))
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
