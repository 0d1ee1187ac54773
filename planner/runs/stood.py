"""Runs of programs that measure standing still: the way they are expected to go, and how they went."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import ExecutionError
from cases.schema import Case
from identification.motion import Joined, Standstill, Trajectory
from postprocessors.execute.executed_run import ExecutedRun
from postprocessors.proving.guarantees import Guarantees
from postprocessors.proving.predicted import predicted
from postprocessors.proving.stretches import Stretch, Timed, Untimed

STANDS = 1e-4  # [m or rad] that a drive may move while the trigger is on: it settles for some cycles


class Stood(NamedTuple):
    """How a run went.

    Args:
        duration: duration from the first movement to the last [s].
        off: largest distance of a standstill from its pose of the program [m].
    """

    duration: float
    off: float


def way_of(parts: tuple[Stretch, ...], case: Case, guarantees: Guarantees) -> Trajectory:
    """The whole way of a program that measures standing still, from home on, as its controller is expected to go it."""
    home, limits = case.need_motion("a run")
    here, way = home, list[Trajectory]()
    for part in parts:
        motion: Trajectory | None
        if isinstance(part, Timed):
            motion = part.points
        elif isinstance(part, Untimed):
            motion = predicted(part, limits, guarantees)
        else:
            motion = Standstill(here, part.duration) if part.duration > 0.0 else None
        if motion is not None:
            way.append(motion)
            here = motion.at([motion.duration]).pose[0]
    return Joined(tuple(way))


def stood(run: ExecutedRun, poses: NDArray[np.float64], program: Path) -> Stood:
    """How long it took from home to home, and how far the machine stood from the program's poses, shape (n, k).

    Raises:
        ExecutionError: the trigger did not come on once at each pose, or the machine moved while it was on.
    """
    if len(run.trigger) != len(poses):
        raise ExecutionError(
            program,
            f"the trigger came on {len(run.trigger)} times for {len(poses)} poses on {run.controller}",
            "report this",
        )
    for k, (start, end) in enumerate(run.trigger, 1):
        within = run.execution.struts(np.arange(start, end, 1e-3))
        if (way := float(np.ptp(within, axis=0).max())) > STANDS:
            raise ExecutionError(
                program,
                f"at pose {k} a drive moved by {way * 1e3:.3g} mm or mrad with the trigger on, on {run.controller}",
                "run again",
            )
    there = run.execution.kinematics(run.trigger.mean(axis=1)).pose
    t = np.arange(0.0, run.execution.duration, 1e-3)
    moving = np.flatnonzero(np.abs(np.diff(run.execution.struts(t), axis=0)).max(axis=1) > 1e-9)
    off = float(np.linalg.norm(there[:, :3] - run.execution.machine.positions(poses), axis=1).max())
    return Stood(float(t[moving[-1] + 1] - t[moving[0]]), off)
