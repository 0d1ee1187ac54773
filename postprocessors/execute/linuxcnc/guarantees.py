"""What LinuxCNC answers for: axis positions, velocities and accelerations, no jerk, no strut velocity or acceleration.

Measured on 2.9; see CONVENTIONS. Programs without timed blocks run with the case's own acceleration limits. A dense
timed path needs limits far above them (`acceleration_headroom`), or it is stretched; what its planner then does between
the blocks nobody limits.
"""

import math

from cases.schema import Case
from identification.trajectories.profile import Profile, TimeLaw, fastest_profile
from postprocessors.execute.linuxcnc.configuration import PURPOSE, SERVO_PERIOD
from postprocessors.proving.guarantees import Guarantees
from postprocessors.reading.words import Move, Reading, Timing

ARC_ALONG, ARC_ACROSS = math.sqrt(0.75) / 2, 0.5
"""Shares of the acceleration limit that its planner spends along an arc (measured) and on turning."""

LONGEST_BLOCK = 0.25
"""[s] A block is a trapezoid to LinuxCNC, not the smooth curve that the proof assumes; over tens of milliseconds the
two stay micrometres apart, over seconds they have nothing in common."""


def acceleration_headroom(reading: Reading, case: Case) -> float:
    """Acceleration limits that LinuxCNC gets for a program, as a multiple of the case's."""
    timed = any(isinstance(e, Move) and e.timing is Timing.DURATION for e in reading.events)
    return case.need_controller(PURPOSE).need_linuxcnc(case.name).acceleration_headroom if timed else 1.0


def linuxcnc_guarantees(reading: Reading, case: Case) -> Guarantees:
    """What LinuxCNC answers for when it runs a program."""
    headroom = acceleration_headroom(reading, case)
    real = headroom <= 1.0
    return Guarantees(
        controller="LinuxCNC",
        shortest_block=SERVO_PERIOD,
        longest_block=LONGEST_BLOCK,
        follows_paths=False,
        even_blocks=True,
        enforced=frozenset({"velocity", "acceleration"} if real else {"velocity"}),
        law=_Line(headroom),
        arc_law=_Arc(headroom),
        jerk_time=SERVO_PERIOD,
        rounding=(math.inf, math.inf),  # whatever G64 P says, measured: blocks blend over their halves
    )


class _Line:
    def __init__(self, headroom: float) -> None:
        self.headroom = headroom

    def __call__(self, velocity: float, acceleration: float, jerk: float) -> Profile:
        return fastest_profile(1.0, velocity, self.headroom * acceleration)


class _Arc:
    def __init__(self, headroom: float) -> None:
        self.headroom = headroom

    def __call__(self, velocity: float, acceleration: float, jerk: float, angle: float) -> TimeLaw:
        allowed = self.headroom * acceleration
        turning = math.sqrt(ARC_ACROSS * allowed / angle)  # v^2 / r over the length r angle
        return fastest_profile(1.0, min(velocity, turning), ARC_ALONG * allowed)
