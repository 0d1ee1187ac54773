"""The neutral program: what a controller shall do, block by block, before any dialect."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion import Trajectory
from identification.profile import StraightMove

Array = NDArray[np.float64]

APPROACH_SHARE = 0.3  # of the motion limits, between home and the start: nobody needs that move to be fast


@dataclass(frozen=True, slots=True)
class ToHome:
    """A straight move to home at a safe feed from wherever the machine stands.

    Args:
        pose: home, shape (6,) [m, rad].
        feed: along the path of the origin [m/s].
    """

    pose: Array
    feed: float


@dataclass(frozen=True, slots=True)
class TimedPath:
    """Poses to be passed at given times, from rest at the pose before to rest at the last.

    Args:
        name: what it is for.
        times: shape (k,), increasing, the first 0 [s].
        poses: shape (k, 6), the first is where the machine stands [m, rad].
    """

    name: str
    times: Array
    poses: Array


@dataclass(frozen=True, slots=True)
class Dwell:
    """Standing still.

    Args:
        duration: [s].
    """

    duration: float


@dataclass(frozen=True, slots=True)
class Trigger:
    """The recording's trigger, switched while the machine stands."""

    on: bool


Block = ToHome | TimedPath | Dwell | Trigger


@dataclass(frozen=True, slots=True)
class Program:
    """A program.

    Args:
        header: comment lines that say where it comes from and what it was proven against.
        blocks: in order.
    """

    header: tuple[str, ...]
    blocks: tuple[Block, ...]

    @property
    def paths(self) -> tuple[TimedPath, ...]:
        """Its timed paths."""
        return tuple(b for b in self.blocks if isinstance(b, TimedPath))


def timed_path(name: str, trajectory: Trajectory, block: float, speed: float) -> TimedPath:
    """A trajectory as equally timed poses.

    Args:
        name: what it is for.
        trajectory: from rest to rest.
        block: duration of a block at full speed, at most [s].
        speed: share of the planned speed; 0.1 takes ten times as long.
    """
    count = max(2, int(np.ceil(trajectory.duration / block - 1e-9)))
    times = np.linspace(0.0, trajectory.duration, count + 1)
    return TimedPath(name, times / speed, trajectory.at(times).pose)


def excitation_program(trajectory: Trajectory, case: Case, header: tuple[str, ...], speed: float = 1.0) -> Program:
    """Home, approach, settle, the excitation between trigger on and off, settle, back home.

    Args:
        trajectory: the excitation, from rest to rest.
        case: home, limits and controller settings.
        header: comment lines.
        speed: share of the planned speed.

    Raises:
        CaseError: the case has no machine or no controller.
    """
    machine, _, limits = case.need_machine("a program")
    controller = case.need_controller("a program")
    home = machine.home.vector
    first, last = trajectory.at([0.0, trajectory.duration]).pose
    blocks: list[Block] = [ToHome(home, controller.safe_feed * min(1.0, speed))]

    def straight(name: str, start: Array, end: Array) -> None:
        if np.array_equal(start, end):
            return
        box = limits.motion
        share = [APPROACH_SHARE * limit for limit in (box.rate, box.acceleration, box.jerk)]
        move = StraightMove.fastest(start, end, *share)
        blocks.append(timed_path(name, move, controller.block, speed))

    straight("approach", home, first)
    blocks += [Dwell(controller.settle_s), Trigger(True)]
    blocks.append(timed_path("excitation", trajectory, controller.block, speed))
    blocks += [Trigger(False), Dwell(controller.settle_s)]
    straight("return", last, home)
    return Program(header, tuple(blocks))
