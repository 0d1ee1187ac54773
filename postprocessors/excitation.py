"""The neutral program of a motion: from home, the excitation between trigger on and off, and back."""

from dataclasses import replace

import numpy as np

from cases.schema import Case
from identification.limits.limit import UNUSED_SHARE, LimitKind
from identification.limits.proof import FORCE_RATE, mechanical_pace, slowed_for_forces
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Array, Joined, Standstill, Trajectory
from identification.motion.moves import CircularMove, StraightMove
from postprocessors.blocks import Block, Blocks, TimedPath, ToHome, Trigger, timed_path
from postprocessors.proof.guarantees import Guarantees

SAME = 1e-8  # [m, rad] distance of equal poses, below the last decimal of any program
APPROACH_SHARE = 0.3  # share of the motion limits between home and the start: that move need not be fast


def motion_blocks(name: str, trajectory: Trajectory, block: float, speed: float) -> tuple[Block, ...]:
    """Blocks of a motion for a controller.

    Straight and circular moves and standstills stay as they are, joined motions become their parts in order,
    polynomials splines, measured standstills two with the trigger on in the second; all others become a timed path.

    Args:
        block: duration of a block of a timed path at full speed, at most [s].
        speed: share of the planned speed.
    """
    if isinstance(trajectory, Joined):
        return tuple(b for part in trajectory.parts for b in motion_blocks(name, part, block, speed))
    if isinstance(trajectory, StraightMove | CircularMove):
        return (replace(trajectory, profile=trajectory.profile.slowed(speed)),)
    if isinstance(trajectory, Standstill) and not trajectory.average:
        return (trajectory,)  # the same duration at any speed
    if isinstance(trajectory, Standstill):
        settle = (Standstill(trajectory.coordinates, trajectory.settle),) if trajectory.settle > 0.0 else ()
        return (*settle, Trigger(True), Standstill(trajectory.coordinates, trajectory.average), Trigger(False))
    if isinstance(trajectory, PolynomialMotion):
        return (timed_path(name, trajectory.slowed(speed), block, 1.0),)
    return (timed_path(name, trajectory, block, speed),)


SLOWER, ATTEMPTS = 0.8, 20  # share of the speed of an approach that is too hard by its controller's law, and tries


def _gentle(move: StraightMove, by: Guarantees) -> StraightMove:
    """A move that struts, sensors and joints bear as its controller makes it; itself where slowness does not help.

    A controller accelerates as hard as its set-up allows, however low the feed: with limited jerk it then comes less
    far.
    """
    slower = move
    for _ in range(ATTEMPTS):
        if mechanical_pace(by.lasting(slower), by.case, FORCE_RATE) <= 1.0 - UNUSED_SHARE:
            return slower
        slower = replace(slower, profile=slower.profile.slowed(SLOWER))
    return move


def excitation_program(trajectory: Trajectory, case: Case, speed: float = 1.0, by: Guarantees | None = None) -> Blocks:
    """The program: home, approach, settle, the excitation between trigger on and off, settle, back home.

    Where the motion contains measurements, the trigger is on in these alone: moves between them only take the machine
    to a place.

    Approach and return are point-to-point moves where the excitation consists of such moves, else timed paths: a
    controller that is set up to follow dense paths may accelerate as hard as it can in a move that it times itself.

    Args:
        speed: share of the planned speed.
        by: what the controller guarantees, by whose law approach and return then satisfy limits too.
    """
    home, box = case.need_motion("a program")
    controller = case.need_controller("a program")
    safe = controller.safe_feed if box.of_pose else controller.safe_share
    first, last = trajectory.at([0.0, trajectory.duration]).coordinates
    blocks: list[Block] = [ToHome(home, safe * min(1.0, speed))]
    excitation = motion_blocks("excitation", trajectory, controller.block, speed)
    own_time = not any(isinstance(b, TimedPath) for b in excitation)

    def straight(name: str, start: Array, end: Array) -> None:
        if np.max(np.abs(end - start)) < SAME:
            return
        share = [APPROACH_SHARE * limit for limit in (box.rate, box.acceleration, box.jerk)]
        move = slowed_for_forces(StraightMove.fastest(start, end, *share), case)
        if own_time:
            if by is not None and LimitKind.ACCELERATION in by.enforced:
                move = _gentle(move, by)
            blocks.extend([name, *motion_blocks(name, move, controller.block, speed)])
        else:
            blocks.append(timed_path(name, move, controller.block, speed))

    straight("approach", home, first)
    if any(isinstance(b, Trigger) for b in excitation):
        blocks += excitation
    else:
        before, after = (Standstill(pose, controller.settle_s) for pose in (first, last))
        blocks += [before, Trigger(True), *excitation, Trigger(False), after]
    straight("return", last, home)
    if isinstance(blocks[-1], Trigger):  # the last pose is home: some controllers switch with what follows
        blocks.append(Standstill(last, controller.settle_s))
    return tuple(blocks)
