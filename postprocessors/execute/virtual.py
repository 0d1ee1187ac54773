"""The built-in virtual controller: follows timed paths exactly and times other moves itself, jerk-limited."""

from dataclasses import replace

import numpy as np

from cases.machine import MotionLimits
from cases.schema import Case
from identification.executed import PoseExecution
from identification.hexapod import Hexapod
from identification.motion import Joined, Standstill, Trajectory
from identification.profile import TimeLaw, fastest_profile
from postprocessors.execute.executed_run import ExecutedRun
from postprocessors.guarantees import Guarantees
from postprocessors.predicted import predicted
from postprocessors.reading.words import Reading
from postprocessors.stretches import Still, Stretch, Timed, stretches


def _arc_law(velocity: float, acceleration: float, jerk: float, angle: float) -> TimeLaw:
    """Half of the acceleration limit turns, the rest drives; a jerk limit that turning cannot pass either."""
    turning = min(np.sqrt(acceleration / 2 / angle), np.cbrt(jerk / 2 / angle**2))
    return fastest_profile(1.0, min(velocity, float(turning)), acceleration / 2, jerk / 4)


GUARANTEES = Guarantees(
    controller="the virtual controller",
    shortest_block=1e-6,
    longest_block=np.inf,
    follows_paths=True,
    enforced=frozenset({"velocity", "acceleration", "jerk"}),
    law=lambda velocity, acceleration, jerk: fastest_profile(1.0, velocity, acceleration, jerk),
    arc_law=_arc_law,
    jerk_time=0.0,
)
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
    machine, _, limits = case.need_machine("a run")
    home = machine.home.vector
    parts: list[Trajectory] = [Standstill(home, REST)]
    trigger: list[tuple[float, float]] = []
    clock, pose = REST, home
    for stretch in stretches(reading):
        part = _trajectory(stretch, pose, limits.motion)
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


def _trajectory(stretch: Stretch, pose: np.ndarray, limits: MotionLimits) -> Trajectory | None:
    if isinstance(stretch, Timed):
        return stretch.points
    if isinstance(stretch, Still):
        return Standstill(pose, stretch.duration) if stretch.duration > 0.0 else None
    return predicted(replace(stretch, start=pose), limits, GUARANTEES)
