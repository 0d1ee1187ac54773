"""What LinuxCNC guarantees beyond a program's text."""

import math
from functools import partial

from cases.base.errors import CaseError, Code
from cases.controller import LinuxCnc
from cases.schema import Case
from identification.limits.limit import LimitKind
from postprocessors.proof.guarantees import LONGEST_POINTS, Guarantees, trapezoid
from postprocessors.reading import Reading, Timed

ACROSS_LINUXCNC = math.sqrt(0.75)  # of the acceleration limit, in an arc; along it what is left (measured on 2.9)


SERVO_PERIOD = 1e-3  # cycle of LinuxCNC's motion controller [s]: its usual one, and the rate of the recordings


def acceleration_headroom(case: Case, timed: bool) -> float:
    """Acceleration limits that LinuxCNC gets for a program with timed paths or without, as a multiple of the case's."""
    return case.need_settings(LinuxCnc, "running a program on LinuxCNC").acceleration_headroom if timed else 1.0


def linuxcnc_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees of LinuxCNC, which has no jerk limit; a timed block is a trapezoid to it, not the assumed curve.

    Its law in moves from rest to rest is that of programs that were run on LinuxCNC 2.9: their accelerations, and those
    of struts, were at their limits and not above.
    """
    return guarantees_of_linuxcnc(case, any(isinstance(part, Timed) for part in reading.stretches))


def guarantees_of_linuxcnc(case: Case, timed: bool) -> Guarantees:
    """The same of a program with timed paths or without.

    Raises:
        CaseError: the machine runs the planner with limited jerk of LinuxCNC 2.10. It limits the jerk along the path,
            so that no move takes the time of the law, and limits of struts, proven by that law, are not its own.
    """
    settings = case.need_controller("a program for LinuxCNC").linuxcnc
    if settings is not None and settings.planner == "s_curve":
        raise CaseError(
            file=f"case {case.name}",
            key="controller.linuxcnc.planner",
            problem='"s_curve" is a planner whose time law is not known here: nothing could be proven',
            remedy="switch it off for the run, [TRAJ]PLANNER_TYPE = 0 or the HAL pin ini.traj_planner_type, and state "
            '"trapezoidal"',
            code=Code.NOT_SUPPORTED,
        )
    headroom = acceleration_headroom(case, timed)
    enforced = {LimitKind.VELOCITY, LimitKind.ACCELERATION} if headroom <= 1.0 else {LimitKind.VELOCITY}
    return Guarantees(
        case,
        controller="LinuxCNC",
        shortest_block=SERVO_PERIOD,
        longest_block=LONGEST_POINTS,
        enforced=frozenset(enforced),
        law=partial(trapezoid, headroom=headroom),
        known_law=headroom <= 1.0,
        jerk_time=SERVO_PERIOD,
        even_blocks=True,
        rounds=False,
        headroom=headroom,
        arc_across=ACROSS_LINUXCNC,
        arc_along=None,
        override_remedy="write M50 P0 before the first move, or end the knob at 100 % (MAX_FEED_OVERRIDE = 1)",
    )
