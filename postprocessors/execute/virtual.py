"""The built-in virtual controller: executes a program's text, moves that it times itself by ruckig, paths by toppra."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cases.errors import ExecutionError
from cases.schema import Case
from identification.limited import Box
from identification.machines import machine_of
from identification.motion import Joined, Standstill, TimedPoints, Trajectory
from identification.trajectories.executed import DriveExecution
from identification.trajectories.path_timing import RetimedMotion, UntimedPath, keeps_pace, retime
from postprocessors.execute.executed_run import ExecutedRun
from postprocessors.execute.ruckig_law import by_ruckig
from postprocessors.proving.guarantees import Guarantees
from postprocessors.proving.predicted import predicted
from postprocessors.proving.stretches import Still, Stretch, Timed, measures_at_poses, stretches
from postprocessors.reading.words import Reading

Array = NDArray[np.float64]

NAME = "virtual controller (exact on timed paths, built in)"
BLOCK_LIMITED = "virtual controller (without look-ahead on timed paths, built in)"
REST = 0.2  # [s] of standstill recorded before and after: filters need it, and so does a user who looks at the plot
BLOCK = 100_000  # set points that are computed at once


def run_virtual(reading: Reading, case: Case, guarantees: Guarantees) -> ExecutedRun:
    """Executes a program that was read, starting from home.

    Drives are given a set point each cycle (`cycle_ms` of the case), and interpolate between them as those of LinuxCNC
    do: phases of the commanded motion that end within a cycle are spread over it, for encoders and sensors alike.

    Args:
        guarantees: guarantees of the controller that the program is for.

    Raises:
        ProgramError: the motion is not defined.
        ExecutionError: no pace of a path keeps the limits.
        CaseError: the case has no machine.
    """
    settings = case.need_controller("a run")
    motion, trigger = commanded(reading, case, guarantees)
    machine, cycle = machine_of(case), settings.cycle
    t = np.minimum(np.arange(1 + np.ceil(motion.duration / cycle - 1e-9)) * cycle, motion.duration)
    blocks = np.array_split(t, 1 + len(t) // BLOCK)
    drives = np.vstack([machine.drives(motion.at(block).pose) for block in blocks])
    name = NAME if settings.virtual_look_ahead == "exact" else BLOCK_LIMITED
    return ExecutedRun(name, DriveExecution.of_set_points(machine, cycle, drives), trigger, real=False)


def commanded(reading: Reading, case: Case, guarantees: Guarantees) -> tuple[Joined, Array]:
    """The motion that the controller commands, and start and end of each time the trigger is on, shape (k, 2) [s].

    Timed paths follow the curve through their points at their times (`virtual_look_ahead` of the case is "exact"; where
    that would pass a limit of rates or accelerations, later, by toppra), or without look-ahead, with rounded corners
    and as slow as that makes them ("block_limited"; by toppra inside the limits). Moves at a feed or in rapid are timed
    by ruckig within the motion limits and that feed; with a jerk limit where the controller that the program is for has
    one, without where not.

    Args:
        guarantees: guarantees of the controller that the program is for.

    Raises:
        ProgramError: the motion is not defined.
        ExecutionError: no pace of a path keeps the limits.
        CaseError: the case has no machine.
    """
    home, limits = case.need_motion("a run")
    own = replace(guarantees, law=by_ruckig(guarantees.law))
    exact = case.need_controller("a run").virtual_look_ahead == "exact"
    parts: list[Trajectory] = [Standstill(home, REST)]
    trigger: list[tuple[float, float]] = []
    clock, pose, on = REST, home, False
    program = stretches(reading)
    at_poses = measures_at_poses(program)
    for stretch in program:
        part = _trajectory(stretch, pose, limits, own)
        if isinstance(part, TimedPoints):
            part = _followed(part, case, own, exact, reading.file)
        if part is None:
            continue
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
        pose = part.at([part.duration]).pose[0]
    parts.append(Standstill(pose, REST))
    return Joined(tuple(parts)), np.array(trigger).reshape(-1, 2)


def _followed(path: TimedPoints, case: Case, own: Guarantees, exact: bool, file: str) -> Trajectory:
    try:
        if not exact:
            return block_limited(path, case, own.rounding)
        return path if keeps_pace(path, case) else retime(path, case)
    except UntimedPath as error:
        raise ExecutionError(file, str(error), "look at hexcite check") from error


def _trajectory(stretch: Stretch, pose: np.ndarray, limits: Box, own: Guarantees) -> Trajectory | None:
    if isinstance(stretch, Timed):
        return stretch.points
    if isinstance(stretch, Still):
        return Standstill(pose, stretch.duration) if stretch.duration > 0.0 else None
    return predicted(replace(stretch, start=pose), limits, own)


ROUNDED = 1 / 8  # of the change of velocity times the block: how far from its corner a parabola passes
CUT = 1e-3  # [m] G64 P1, as programs of ours have it
NOTHING = 1e-9  # [m, rad] of a block's way


def block_durations(times: Array, poses: Array, acceleration: Array) -> Array:
    """How long straight blocks between poses take, from rest to rest, shape (k - 1,) [s].

    Args:
        times: times at which the poses are wanted, shape (k,) [s].
        poses: shape (k, 6) [m, rad].
        acceleration: limits of the coordinates, shape (6,).
    """
    steps, ways = np.diff(times), np.diff(poses, axis=0)
    linear, turning = (np.linalg.norm(ways[:, axes], axis=1) for axes in (slice(0, 3), slice(3, 6)))
    length = np.where(linear > NOTHING, linear, turning)
    standing = length <= NOTHING
    ways, length = np.where(standing[:, None], 1.0, ways), np.where(standing, 1.0, length)
    slope = 0.5 / (np.abs(ways) / length[:, None] / acceleration).max(axis=1)
    speed = np.minimum(length / steps, np.sqrt(slope * length))
    alone, ramp = length / speed, speed / slope
    room = np.minimum(alone[:-1], alone[1:])
    together = np.minimum(ramp[:-1], np.minimum(np.maximum(ramp[:-1], ramp[1:]), room))
    direction = ways[:, :3] / np.where(linear > NOTHING, linear, np.inf)[:, None]
    bend = np.sqrt(np.maximum(0.0, 1.0 - np.sum(direction[:-1] * direction[1:], axis=1)) / 2)
    bend = np.where(np.minimum(linear[:-1], linear[1:]) > NOTHING, bend, 0.0)
    corner = 2.0 * np.sqrt(np.divide(CUT, slope[:-1] * bend, out=np.full(len(bend), np.inf), where=bend > 0.0))
    together = np.where(standing[:-1] | standing[1:], 0.0, np.minimum(together, corner))
    return np.where(standing, steps, alone + ramp - np.append(together, 0.0))


def largest_cut(times: Array, poses: Array) -> float:
    """How far the origin passes from the corners between blocks, at most [m]; shapes (k,) [s] and (k, 6) [m, rad]."""
    steps = np.diff(times)
    turns = np.diff(np.diff(poses[:, :3], axis=0) / steps[:, None], axis=0)
    return float(np.max(ROUNDED * np.linalg.norm(turns, axis=1) * np.minimum(steps[:-1], steps[1:]), initial=0.0))


def rounded(points: TimedPoints, tolerance: tuple[float, float]) -> TimedPoints:
    """The path with its corners rounded: parabolas from the middle of each block to that of the next.

    Args:
        tolerance: how far corners may be cut, of the origin [m] and of the angles [rad].
    """
    steps = np.diff(points.times)[:, None]
    velocities = np.diff(points.poses, axis=0) / steps
    cut = ROUNDED * np.diff(velocities, axis=0) * np.minimum(steps[:-1], steps[1:])
    for axes, allowed in ((slice(0, 3), tolerance[0]), (slice(3, 6), tolerance[1])):
        far = np.linalg.norm(cut[:, axes], axis=1, keepdims=True)
        cut[:, axes] *= np.minimum(1.0, np.divide(allowed, far, out=np.ones_like(far), where=far > 0.0))
    poses = points.poses.copy()
    poses[1:-1] += cut
    return TimedPoints.through(points.times, poses)


def block_limited(points: TimedPoints, case: Case, tolerance: tuple[float, float]) -> RetimedMotion:
    """The rounded path, each block as long as written or as long as it needs, inside the limits of the case.

    Each block is a trapezoid at half the acceleration limit along it, so that no block of length L is faster than
    sqrt(a L / 2). While one slows down the next speeds up, for as long as each has room, and only below the speed at
    which the corner between them is cut by the tolerance of G64; the slowing down above that speed is time lost.
    Corners are rounded by parabolas. Durations agree with LinuxCNC within 1 % for blocks of 10 to 210 ms.

    Args:
        case: its limits of rates and accelerations, of coordinates and struts.
        tolerance: tolerance of corners [m], [rad].

    Raises:
        UntimedPath: no pace keeps the limits.
        CaseError: the case has no machine.
    """
    acceleration = case.need_machine("a run")[2].motion.acceleration
    steps = np.diff(points.times)
    needed = np.maximum(block_durations(points.times, points.poses, acceleration), steps)

    def slowed(times: Array) -> Array:
        block = np.clip(np.searchsorted(points.times, times, side="right") - 1, 0, len(steps) - 1)
        return np.asarray((steps / needed)[block])

    return retime(rounded(points, tolerance), case, slowed=slowed)
