"""The built-in virtual controller: follows timed paths exactly and times other moves itself, jerk-limited."""

import numpy as np

from cases.schema import Case
from identification.executed import PoseExecution
from identification.hexapod import Hexapod
from identification.motion import Joined, Standstill, Trajectory
from identification.profile import StraightMove
from postprocessors.execute.executed_run import ExecutedRun
from postprocessors.reading.words import Reading
from postprocessors.stretches import STILL, Still, Stretch, Timed, Untimed, stretches

NAME = "virtual controller (exact on timed paths, built in)"
REST = 0.2  # [s] of standstill recorded before and after: filters need it, and so does a user who looks at the plot


def run_virtual(reading: Reading, case: Case) -> ExecutedRun:
    """Executes a program that was read, starting from home.

    Timed paths follow the quintic spline through their points; moves at a feed or in rapid follow the seven-segment
    profile within the motion limits and that feed.

    Raises:
        ProgramError: the motion is not defined.
        CaseError: the case has no machine.
    """
    home = case.need_machine("a run")[0].home.vector
    parts: list[Trajectory] = [Standstill(home, REST)]
    trigger: list[tuple[float, float]] = []
    clock, pose = REST, home
    for stretch in stretches(reading, case):
        part = _trajectory(stretch, pose, case)
        if part is None:
            continue
        if stretch.trigger and not isinstance(stretch, Still):
            trigger.append((clock, clock + part.duration))
        parts.append(part)
        clock += part.duration
        pose = part.at([part.duration]).pose[0]
    parts.append(Standstill(pose, REST))
    execution = PoseExecution(Hexapod.of(case), Joined(tuple(parts)))
    return ExecutedRun(NAME, execution, np.array(trigger).reshape(-1, 2), real=False)


def _trajectory(stretch: Stretch, pose: np.ndarray, case: Case) -> Trajectory | None:
    if isinstance(stretch, Timed):
        return stretch.points
    if isinstance(stretch, Still):
        return Standstill(pose, stretch.duration) if stretch.duration > 0.0 else None
    return _untimed(stretch, pose, case)


def _untimed(stretch: Untimed, pose: np.ndarray, case: Case) -> Trajectory | None:
    way = np.abs(stretch.end - pose)
    if not np.any(way > STILL):
        return None
    limits = case.need_machine("a run")[2].motion
    rate = limits.rate
    if stretch.feed is not None:
        linear, angular = float(np.linalg.norm(way[:3])), float(np.linalg.norm(way[3:]))
        duration = (linear if linear > STILL else angular) / stretch.feed
        rate = np.minimum(rate, np.where(way > 0.0, way / duration, np.inf))
    return StraightMove.fastest(pose, stretch.end, rate, limits.acceleration, limits.jerk)
