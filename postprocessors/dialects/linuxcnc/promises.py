"""What LinuxCNC guarantees beyond a program's text."""

import math
from dataclasses import replace
from functools import partial

from cases.base.errors import Code, HexciteError, ProgramError
from cases.base.phrases import phrase
from cases.base.units import DEG, MM
from cases.controller import ControllerName, LinuxCnc
from cases.schema import Case
from identification.limits.limit import LimitKind
from postprocessors.proof.guarantees import LONGEST_POINTS, SEVEN_SEGMENTS, Guarantees, trapezoid
from postprocessors.reading import Reading, Timed, Untimed

ACROSS_LINUXCNC = math.sqrt(0.75)  # of the acceleration limit, in an arc; along it what is left (measured on 2.9)


SERVO_PERIOD = 1e-3  # cycle of LinuxCNC's motion controller [s]: its usual one, and the rate of the recordings

_TRAPEZOIDAL = "run it with [TRAJ]PLANNER_TYPE = 0 (the HAL pin ini.traj_planner_type) and state planner = "
_TRAPEZOIDAL += '"trapezoidal" in controller.linuxcnc'


OVERRIDE = phrase(
    "override_linuxcnc", "write M50 P0 before the first move, or end the knob at 100 % (MAX_FEED_OVERRIDE = 1)"
)


def acceleration_headroom(case: Case, timed: bool) -> float:
    """Acceleration limits that LinuxCNC gets for a program with timed paths or without, as a multiple of the case's."""
    return case.need_settings(LinuxCnc, "running a program on LinuxCNC").acceleration_headroom if timed else 1.0


def path_jerk(case: Case) -> float | None:
    """`[TRAJ]MAX_LINEAR_JERK` of the planner with limited jerk [mm/s^3 or deg/s^3]; None of that with trapezoids."""
    settings = case.need_controller("a program for LinuxCNC").linuxcnc
    return None if settings is None or settings.planner == "trapezoidal" else settings.max_linear_jerk_mm_s3


def linuxcnc_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees of LinuxCNC for a program; a timed block is a trapezoid to it, not the assumed curve.

    Raises:
        ProgramError: the planner with limited jerk runs it, and a line is not a straight move: neither blends of blocks
            nor what an arc uses of the limits is known there.
    """
    if path_jerk(case) is not None:
        for part in reading.stretches:
            if isinstance(part, Timed) or (isinstance(part, Untimed) and part.arc is not None):
                what = "blocks in inverse time" if isinstance(part, Timed) else "an arc"
                raise ProgramError(
                    file=reading.file,
                    line=part.lines[0] if isinstance(part, Timed) else part.line,
                    problem=f"{what}: how the planner with limited jerk (s_curve) makes them is not known here",
                    remedy=f"plan straight moves (family ptp), or {_TRAPEZOIDAL}",
                    code=Code.NOT_SUPPORTED,
                )
    return guarantees_of_linuxcnc(case, any(isinstance(part, Timed) for part in reading.stretches))


def guarantees_of_linuxcnc(case: Case, timed: bool) -> Guarantees:
    """Guarantees of LinuxCNC for a program with timed paths or without.

    Of the planner with trapezoids the law in moves from rest to rest is that of programs that were run on LinuxCNC 2.9:
    their accelerations, and those of struts, were at their limits and not above. Of the planner with limited jerk it is
    that of its source: seven segments within the axes' limits and one of jerk along the way that the feed counts.

    Raises:
        HexciteError: a program with timed paths for the planner with limited jerk.
    """
    headroom, jerk = acceleration_headroom(case, timed), path_jerk(case)
    if jerk is not None and timed:
        raise HexciteError(
            place=f"case {case.name}, controller.linuxcnc.planner",
            problem="how the planner with limited jerk (s_curve) blends the blocks of a path is not known here",
            remedy=f"plan straight moves (family ptp), or {_TRAPEZOIDAL}",
            code=Code.NOT_SUPPORTED,
        )
    enforced = {LimitKind.VELOCITY, LimitKind.ACCELERATION} if headroom <= 1.0 else {LimitKind.VELOCITY}
    trapezoids = Guarantees(
        case,
        controller="LinuxCNC",
        plan_for=ControllerName.LINUXCNC,
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
        override_remedy=OVERRIDE,
    )
    if jerk is None:
        return trapezoids
    return replace(
        trapezoids,
        controller="LinuxCNC with limited jerk",
        enforced=frozenset({*enforced, LimitKind.JERK}),
        law=SEVEN_SEGMENTS,
        known_law=False,  # no program was run on it
        jerk_time=0.0,
        path_jerk=(jerk * MM, jerk * DEG),
        own_rules=(
            f"LinuxCNC limits jerk to {jerk:g} mm/s^3 along the path (MAX_LINEAR_JERK) and, by MAX_JERK of each "
            "[AXIS_a], to limits.motion: by the source of its version 2.10, on which no program was tried",
        ),
    )
