"""The built-in virtual controller: executes a program's text; it times moves by ruckig and paths by toppra."""

import math
from dataclasses import replace

import numpy as np

from cases.base.errors import Code, HexciteError
from identification.machines.executed import Execution
from identification.machines.of_case import machine_of
from identification.machines.path_timing import keeps_pace, retime
from identification.motion.motion import Array, Joined, Standstill, TimedPoints, Trajectory
from identification.motion.moves import Profile, UntimedMotion, ruckig_profile
from postprocessors.controllers.executed_run import ExecutedRun
from postprocessors.proof.guarantees import Guarantees, Law, limits_jerk
from postprocessors.proof.homing import motions
from postprocessors.reading import Reading, Still

NAME = "virtual controller (exact on timed paths, built in)"
REST = 0.2  # [s] recorded standstill before and after: filters need it, and users see it in the plot
BLOCK = 100_000  # number of set points that are computed at once


def run_virtual(reading: Reading, guarantees: Guarantees) -> ExecutedRun:
    """Executes a program that was read, starting from home; errors as `commanded`.

    Drives get a set point each cycle (`cycle_ms` of the case), and interpolate between them as those of LinuxCNC
    do: phases of the commanded motion that end within a cycle are spread over it, for encoders and sensors alike.
    """
    motion, trigger = commanded(reading, guarantees)
    machine, cycle = machine_of(guarantees.case), guarantees.case.need_controller("a run").cycle
    t = np.minimum(np.arange(1 + np.ceil(motion.duration / cycle - 1e-9)) * cycle, motion.duration)
    blocks = np.array_split(t, 1 + len(t) // BLOCK)
    drives = np.vstack([machine.drives(motion.at(block).coordinates) for block in blocks])
    return ExecutedRun(NAME, Execution.of_set_points(machine, cycle, drives), trigger, real=False)


def commanded(reading: Reading, guarantees: Guarantees) -> tuple[Joined, Array]:
    """The motion that the controller commands, and start and end of each time the trigger is on, shape (k, 2) [s].

    Timed paths follow the curve through their points at their times; where that would exceed a limit of rates or
    accelerations, later, by toppra. Moves at a feed or in rapid are timed by ruckig within the motion limits and that
    feed; with a jerk limit where the controller of the program has one.

    Raises:
        ProgramError: the motion is not defined.
        HexciteError: no pace of a path keeps the limits.
    """
    case = guarantees.case
    home, _ = case.need_motion("a run")
    ruckig_guarantees = replace(guarantees, law=by_ruckig(guarantees.law))
    parts: list[Trajectory] = [Standstill(home, REST)]
    trigger: list[tuple[float, float]] = []
    clock, on, at_poses = REST, False, reading.measures_at_poses
    for stretch, motion in motions(reading, ruckig_guarantees):
        part = motion
        if isinstance(motion, TimedPoints) and not keeps_pace(motion, case):
            try:
                part = retime(motion, case)
            except UntimedMotion as error:
                raise HexciteError(
                    place=reading.file, problem=str(error), remedy="look at hexcite check", code=Code.NOT_PROVEN
                ) from error
        on = on and stretch.trigger
        if at_poses and stretch.trigger:
            trigger.append((clock, clock + part.duration))
        elif stretch.trigger and not isinstance(stretch, Still):
            # From the first movement to the last: pauses between them count, those before and after do not.
            start = trigger.pop()[0] if on else clock
            trigger.append((start, clock + part.duration))
            on = True
        parts.append(part)
        clock += part.duration
    parts.append(Standstill(parts[-1].at([parts[-1].duration]).coordinates[0], REST))
    return Joined(tuple(parts)), np.array(trigger).reshape(-1, 2)


def by_ruckig(law: Law) -> Law:
    """A law of the same kind, with a jerk limit or without, computed by ruckig within the limits as they are given."""

    def timed(velocity: float, acceleration: float, jerk: float) -> Profile:
        try:
            return ruckig_profile(velocity, acceleration, jerk if limits_jerk(law) else math.inf)
        except UntimedMotion as error:
            raise HexciteError(
                problem=f"ruckig cannot time a move ({error})",
                remedy="slow it down or make it longer",
                code=Code.RUN_FAILED,
            ) from error

    return timed
