"""Predicted stretch of a timed path by LinuxCNC, before it runs, and settings that avoid it.

It plans a turning path block by block, without look-ahead (tp.c), measured on 2.9. Each block is a trapezoid at half
the acceleration limit along it, so that no block of length L is faster than sqrt(a L / 2). While one slows down the
next speeds up, for as long as each has room, and only below the speed at which the corner between them is cut by the
tolerance of G64; the slowing down above that speed is time lost. Corners are rounded by parabolas. Durations agree
with LinuxCNC within 1 % for blocks of 10 to 210 ms that last whole cycles; what a block lasts beyond them is left out
(9.23 ms take 9, 12.5 ms take 12).
"""

import math
from bisect import bisect_left
from functools import partial

import numpy as np

from cases.controller import LinuxCnc
from cases.schema import Case
from identification.limit import LimitKind
from identification.motion import Array, TimedPoints
from identification.trajectories.moves import Profile, fastest_profile
from postprocessors.execute.linuxcnc.configuration import PURPOSE, SERVO_PERIOD
from postprocessors.proving.guarantees import AS_PLANNED, Forecast, Guarantees
from postprocessors.reading import Reading, Timed

ARC_ALONG, ARC_ACROSS = math.sqrt(0.75) / 2, 0.5
"""Shares of the acceleration limit that its planner uses along an arc (measured) and across it."""

LONGEST_BLOCK = 0.25
"""[s] A block is a trapezoid to LinuxCNC, not the smooth curve that the proof assumes; over tens of milliseconds the
two stay micrometres apart, over seconds they have nothing in common."""


def acceleration_headroom(reading: Reading, case: Case) -> float:
    """Acceleration limits that LinuxCNC gets for a program, as a multiple of the case's."""
    timed = any(isinstance(part, Timed) for part in reading.stretches)
    return case.need_settings(LinuxCnc, PURPOSE).acceleration_headroom if timed else 1.0


def linuxcnc_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees of LinuxCNC when it runs a program."""
    headroom = acceleration_headroom(reading, case)
    real = headroom <= 1.0
    return Guarantees(
        case,
        controller="LinuxCNC",
        shortest_block=SERVO_PERIOD,
        longest_block=LONGEST_BLOCK,
        enforced=frozenset({LimitKind.VELOCITY, LimitKind.ACCELERATION} if real else {LimitKind.VELOCITY}),
        law=partial(_trapezoid, headroom),
        jerk_time=SERVO_PERIOD,
        even_blocks=True,
        whole_cycles=True,
        arc_shares=(ARC_ALONG, ARC_ACROSS * headroom),
    )


def _trapezoid(headroom: float, velocity: float, acceleration: float, jerk: float) -> Profile:
    return fastest_profile(1.0, velocity, headroom * acceleration)


NOTICEABLE = 1.01
MOST_HEADROOM = 10**6


def triggered_paths(reading: Reading) -> list[TimedPoints]:
    """The timed paths that run with the trigger on."""
    timed = [s.points for s in reading.stretches if isinstance(s, Timed) and s.trigger]
    return [points for points in timed if isinstance(points, TimedPoints)]  # LinuxCNC has no other paths


def expected_duration(paths: list[TimedPoints], case: Case, headroom: float) -> float:
    """Duration that timed paths will take [s] at `headroom` times the case's limits of acceleration."""
    acceleration = headroom * case.need_motion(PURPOSE)[1].acceleration
    return sum(float(block_durations(p.times, p.poses, acceleration).sum()) for p in paths)


def predicted_stretch(paths: list[TimedPoints], case: Case, headroom: float) -> float:
    """Predicted duration of timed paths over the planned one, 1 where they are equal; arguments as above."""
    return max(1.0, expected_duration(paths, case, headroom) / sum(p.duration for p in paths))


def sufficient_headroom(paths: list[TimedPoints], case: Case, headroom: float) -> int:
    """The least whole multiple of the case's acceleration limits, above `headroom`, without a stretch of the paths."""
    candidates = range(math.floor(headroom) + 1, MOST_HEADROOM)
    enough = bisect_left(candidates, True, key=lambda high: predicted_stretch(paths, case, high) <= NOTICEABLE)
    return candidates.start + enough


def linuxcnc_forecast(reading: Reading, case: Case) -> Forecast:
    """Predicted stretch of a program by LinuxCNC, with its set-up and under the case's own acceleration limits."""
    headroom, paths = acceleration_headroom(reading, case), triggered_paths(reading)
    if not paths:
        return AS_PLANNED
    stretch, own = predicted_stretch(paths, case, headroom), predicted_stretch(paths, case, 1.0)
    planned = sum(p.duration for p in paths)
    remarks = []
    if stretch > NOTICEABLE:
        remarks.append(
            f"LinuxCNC will take {stretch:.2f} times as long for the timed path ({stretch * planned:.1f} s, not "
            f"{planned:.1f} s); what keeps its time: controller.linuxcnc.acceleration_headroom = "
            f"{sufficient_headroom(paths, case, headroom)}, or point-to-point moves (hexcite plan --family ptp)"
        )
    if own > NOTICEABLE and headroom > 1.0:
        remarks.append(
            f"under the case's own acceleration limits it would take {own:.2f} times as long "
            f"(acceleration_headroom is {headroom:g}); point-to-point moves keep their time and these limits"
        )
    return stretch, tuple(remarks)


TOLERANCE = 1e-3  # [m] G64 P1, as in programs of hexcite
NOTHING = 1e-9  # [m, rad] length below which a block does not move


def block_durations(times: Array, poses: Array, acceleration: Array) -> Array:
    """Durations of straight blocks between poses, from rest to rest, shape (k - 1,) [s].

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
    corner = 2.0 * np.sqrt(np.divide(TOLERANCE, slope[:-1] * bend, out=np.full(len(bend), np.inf), where=bend > 0.0))
    together = np.where(standing[:-1] | standing[1:], 0.0, np.minimum(together, corner))
    return np.where(standing, steps, alone + ramp - np.append(together, 0.0))
