"""Programs from motions: which block each part of a motion becomes, and what surrounds an excitation."""

from dataclasses import replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.motion import Joined, Measurement, Slowed, Standstill, Trajectory
from identification.trajectories.circle import CircularMove
from identification.trajectories.polynomial import PolynomialMotion, polynomials_of
from identification.trajectories.profile import StraightMove
from postprocessors.program import (
    Arc,
    Block,
    Comment,
    Dwell,
    NeutralProgram,
    PointToPoint,
    SplinePath,
    TimedPath,
    ToHome,
    Trigger,
)

Array = NDArray[np.float64]

SAME = 1e-8  # [m, rad] two poses are one, below the last decimal of any program
APPROACH_SHARE = 0.3  # of the motion limits, between home and the start: nobody needs that move to be fast


def moves_as_polynomials(program: NeutralProgram) -> NeutralProgram:
    """The program with each run of point-to-point moves as one spline: the same path and time law, in cubic pieces."""
    blocks: list[Block] = []
    for together, group in groupby(program.blocks, lambda b: isinstance(b, PointToPoint)):
        found = list(group)
        if together:
            moves = [b.move for b in found if isinstance(b, PointToPoint)]
            found = [SplinePath("moves", polynomials_of(moves))]
        blocks += found
    return replace(program, blocks=tuple(blocks))


def _block_ends(trajectory: Trajectory, block: float) -> Array:
    knots = trajectory.times if isinstance(trajectory, PolynomialMotion) else np.array([0.0, trajectory.duration])
    counts = np.ceil(np.diff(knots) / block - 1e-9).astype(int).clip(1 if len(knots) > 2 else 2)
    steps = zip(knots, knots[1:], counts, strict=False)
    return np.append(np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in steps]), knots[-1])


def timed_path(name: str, trajectory: Trajectory, block: float, speed: float) -> TimedPath:
    """A trajectory as equally timed poses; of a spline the ends of its pieces are among them.

    Args:
        name: what it is for.
        block: duration of a block at full speed, at most [s].
        speed: share of the planned speed; 0.1 takes ten times as long.
    """
    times = _block_ends(trajectory, block)
    source = trajectory if speed == 1.0 else Slowed(trajectory, speed)
    return TimedPath(name, times / speed, trajectory.at(times).pose, source)


def motion_blocks(name: str, trajectory: Trajectory, block: float, speed: float) -> tuple[Block, ...]:
    """What a motion is to a controller.

    Straight and circular moves stay what they are, joined motions become their parts in order, standstills dwells,
    polynomials splines, measurements dwells with the trigger on in the second; whatever else becomes a timed path.

    Args:
        name: what it is for.
        block: duration of a block of a timed path at full speed, at most [s].
        speed: share of the planned speed.
    """
    if isinstance(trajectory, Joined):
        return tuple(b for part in trajectory.parts for b in motion_blocks(name, part, block, speed))
    if isinstance(trajectory, StraightMove):
        return (PointToPoint(replace(trajectory, profile=trajectory.profile.slowed(speed))),)
    if isinstance(trajectory, CircularMove):
        return (Arc(replace(trajectory, profile=trajectory.profile.slowed(speed))),)
    if isinstance(trajectory, Standstill):
        return (Dwell(trajectory.duration),)  # as long at any speed
    if isinstance(trajectory, Measurement):
        settle = (Dwell(trajectory.settle),) if trajectory.settle > 0.0 else ()
        return (*settle, Trigger(True), Dwell(trajectory.average), Trigger(False))
    if isinstance(trajectory, PolynomialMotion):
        return (SplinePath(name, trajectory.slowed(speed)),)
    return (timed_path(name, trajectory, block, speed),)


def excitation_program(
    trajectory: Trajectory, case: Case, header: tuple[str, ...], speed: float = 1.0
) -> NeutralProgram:
    """Home, approach, settle, the excitation between trigger on and off, settle, back home.

    Where the motion contains measurements, the trigger is on in these alone: moves between them only take the machine
    to a place.

    Approach and return are point-to-point moves where the excitation consists of such moves, else timed paths: a
    controller that is set up to follow dense paths may accelerate as hard as it can in a move that it times itself.

    Args:
        trajectory: the excitation, from rest to rest.
        case: home, limits and controller settings.
        header: comment lines.
        speed: share of the planned speed.

    Raises:
        CaseError: the case has no machine or no controller.
    """
    home, box = case.need_motion("a program")
    controller = case.need_controller("a program")
    safe = controller.safe_share if case.chain is not None else controller.safe_feed
    first, last = trajectory.at([0.0, trajectory.duration]).pose
    blocks: list[Block] = [ToHome(home, safe * min(1.0, speed))]
    excitation = motion_blocks("excitation", trajectory, controller.block, speed)
    own_time = not any(isinstance(b, TimedPath | SplinePath) for b in excitation)

    def straight(name: str, start: Array, end: Array) -> None:
        if np.max(np.abs(end - start)) < SAME:
            return
        share = [APPROACH_SHARE * limit for limit in (box.rate, box.acceleration, box.jerk)]
        move = StraightMove.fastest(start, end, *share)
        if own_time:
            blocks.extend([Comment(name), *motion_blocks(name, move, controller.block, speed)])
        else:
            blocks.append(timed_path(name, move, controller.block, speed))

    straight("approach", home, first)
    if any(isinstance(b, Trigger) for b in excitation):
        blocks += excitation
    else:
        blocks += [Dwell(controller.settle_s), Trigger(True), *excitation, Trigger(False), Dwell(controller.settle_s)]
    straight("return", last, home)
    return NeutralProgram(header, tuple(blocks))
