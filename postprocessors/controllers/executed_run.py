"""A run of a program on any controller: its motion, and when the trigger was on."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cases.base.errors import Code, HexciteError
from identification.motion.motion import Array
from identification.stretches import windows

if TYPE_CHECKING:  # it imports SciPy, which the check of a program does not need
    from identification.machines.executed import Execution

STILL = 1e-9  # [m] a cycle: 1 um/s


@dataclass(frozen=True, slots=True)
class ExecutedRun:
    """A run."""

    controller: str  # name and version
    execution: "Execution"  # the motion, continuous in time
    trigger: Array  # start and end of each time the trigger was on, shape (k, 2) [s]
    real: bool  # whether a real controller ran it (the machine is simulated in any case)
    remark: str = ""  # remark on this run for people, or empty

    @property
    def excitation(self) -> float:
        """Time with the trigger on [s]."""
        return float(np.sum(self.trigger[:, 1] - self.trigger[:, 0]))


def moving_windows(on: NDArray[np.bool_], struts: Array, period: float) -> Array:
    """Windows of the trigger from the first movement in them to the last, shape (k, 2) [s].

    Before and after a movement the trigger waits for the controller's program, and with it for the computer's load. A
    window without movement stays as it is; for a program that measures standing still use `windows`.

    Args:
        on: the trigger, shape (n,).
        struts: strut lengths, shape (n, 6) [m].
        period: period of both [s].
    """
    moves = np.append(np.any(np.abs(np.diff(struts, axis=0)) > STILL, axis=1), False)
    trimmed = []
    for start, end in windows(on, period):
        rows = slice(round(start / period), round(end / period))
        moving = np.flatnonzero(moves[rows])
        first = rows.start
        trimmed.append((first + moving[0], first + moving[-1] + 1) if len(moving) else (rows.start, rows.stop))
    return np.array(trimmed, dtype=float).reshape(-1, 2) * period


@dataclass(frozen=True, slots=True)
class ControllerLog:
    """Log of a controller, one row a cycle."""

    controller: str  # name and version of the controller, as it reported them
    period: float  # duration of a cycle [s]
    drives: Array  # commanded positions of struts or joints, shape (n, k) [m or rad]
    poses: Array  # commanded coordinates, shape (n, k) [m or rad]
    trigger: NDArray[np.bool_]  # the recording output, shape (n,)
    lines: NDArray[np.int64]  # program line being executed, a cycle late; 0 while nothing moves, shape (n,)
    left_out: int = 0  # removed cycles of standstill, which only the computer's clock caused


STANDS = 1e-4  # [m or rad] largest motion of a drive while the trigger is on: it settles for some cycles


def stood(run: ExecutedRun, poses: NDArray[np.float64], program: Path) -> tuple[float, float]:
    """How long it took from home to home [s], and how far the machine stood from the program's poses at most [m].

    `poses` are those of the program, shape (n, k) [m or rad].

    Raises HexciteError where the trigger did not come on once at each pose, or the machine moved while it was on.
    """
    if len(run.trigger) != len(poses):
        problem = f"the trigger came on {len(run.trigger)} times for {len(poses)} poses on {run.controller}"
        raise HexciteError(place=program, problem=problem, remedy="report this", code=Code.INTERNAL)
    for k, (start, end) in enumerate(run.trigger, 1):
        within = run.execution.drives(np.arange(start, end, 1e-3))
        if (way := float(np.ptp(within, axis=0).max())) > STANDS:
            problem = f"at pose {k} a drive moved by {way * 1e3:.3g} mm or mrad with the trigger on"
            raise HexciteError(
                place=program, problem=f"{problem}, on {run.controller}", remedy="run again", code=Code.RUN_FAILED
            )
    actual = run.execution.kinematics(run.trigger.mean(axis=1)).pose
    t = np.arange(0.0, run.execution.duration, 1e-3)
    moving = np.flatnonzero(np.abs(np.diff(run.execution.drives(t), axis=0)).max(axis=1) > 1e-9)
    off = float(np.linalg.norm(actual[:, :3] - run.execution.machine.positions(poses), axis=1).max())
    return float(t[moving[-1] + 1] - t[moving[0]]), off
