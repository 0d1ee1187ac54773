"""A run of a program on a controller, whichever it was: what moved, and when the trigger was on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.trajectories.executed import DriveExecution

Array = NDArray[np.float64]

STILL = 1e-9  # [m] a cycle: 1 um/s


@dataclass(frozen=True, slots=True)
class ExecutedRun:
    """A run.

    Args:
        controller: name and version.
        execution: the motion, continuous in time.
        trigger: start and end of each time the trigger was on, shape (k, 2) [s].
        real: whether a real controller ran it (the machine is simulated in any case).
        remark: what to know about this run; empty where there is nothing.
    """

    controller: str
    execution: DriveExecution
    trigger: Array
    real: bool
    remark: str = ""

    @property
    def excitation(self) -> float:
        """Time with the trigger on [s]."""
        return float(np.sum(self.trigger[:, 1] - self.trigger[:, 0]))


def windows(on: NDArray[np.bool_], period: float) -> Array:
    """Start and end of each run of ones, shape (k, 2) [s]."""
    edges = np.diff(np.r_[False, on, False].astype(int))
    return np.asarray(np.column_stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)]) * period, dtype=float)


def moving_windows(on: NDArray[np.bool_], struts: Array, period: float) -> Array:
    """Windows of the trigger from the first movement in them to the last, shape (k, 2) [s].

    Before and after a movement the trigger waits for the controller's program, and with it for the computer's load. A
    window without movement stays as it is; of a program that measures standing still `windows` are wanted.

    Args:
        on: the trigger, shape (n,).
        struts: lengths, shape (n, 6) [m].
        period: of both [s].
    """
    moves = np.append(np.any(np.abs(np.diff(struts, axis=0)) > STILL, axis=1), False)
    trimmed = []
    for start, end in windows(on, period):
        rows = slice(round(start / period), round(end / period))
        moving = np.flatnonzero(moves[rows])
        first = rows.start
        trimmed.append((first + moving[0], first + moving[-1] + 1) if len(moving) else (rows.start, rows.stop))
    return np.array(trimmed, dtype=float).reshape(-1, 2) * period
