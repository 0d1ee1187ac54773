"""The LinuxCNC configuration of a case: INI, HAL, tool table and variables, in LinuxCNC's units (mm, degrees, seconds).

The joints of a hexapod are its six struts (`genhexkins`); its axes X Y Z A B C are the pose, A B C turning about the
fixed axes x y z, which is R = Rz(yaw) Ry(pitch) Rx(roll). The axes of a chain are its joints (`trivkins`). There are no
motors: each joint follows its command exactly.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from cases.units import DEG, MM
from identification.motion import Array

PURPOSE = "running a program on LinuxCNC"
INI_FILE = "machine.ini"
HAL_FILE = "machine.hal"
TOOL_FILE = "tool.tbl"
VARIABLE_FILE = "machine.var"
DWELL_FILE = "dwell.ngc"
DISPLAY_FILE = "driver.py"

SERVO_PERIOD = 1e-3
"""Cycle of the motion controller [s]: LinuxCNC's usual one, and the rate of the recordings."""

ROUNDING = 1e-6
"""Pose limits are widened by the last digit of a program's numbers [mm, deg], so that the limit itself is allowed."""

UNBOUND = 1e6
"""LinuxCNC does not enforce strut velocity and acceleration on a path; any number beyond use will do [mm/s, mm/s^2]."""

WIDEST = np.pi / 2
"""Angles of the axes where only the struts limit them [rad]."""

FOLLOWING_ERROR = 50.0
"""Struts "follow" one cycle late, 1 mm at 1 m/s: far below this, so that only a broken kinematics trips it [mm]."""

QUEUE = 100_000
"""Cycles that the log can hold until the driver fetches them: 5 s at 20 times real time."""

TURNS = 1e6
"""Position limits of a joint that turns without end [degrees]."""

AXES = "XYZABC"
DWELL_OUTPUT = 3
"""Digital output that starts a dwell, digital input that ends it, and analog output that holds its seconds."""

DWELL = f"""o<dwell> sub
(- #1 seconds of servo cycles in position; written for HAL's timedelay)
M68 E{DWELL_OUTPUT} Q#1
M64 P{DWELL_OUTPUT}
M66 P{DWELL_OUTPUT} L3 Q1000000
M65 P{DWELL_OUTPUT}
M66 P{DWELL_OUTPUT} L4 Q1000000
o<dwell> endsub
M2
"""
"""A dwell that is counted in the controller's own cycles; G4 is timed on the wall, whatever the servo thread does."""


class AxisLayout(NamedTuple):
    """Axes and joints of a machine."""

    axes: str  # letters of the coordinates
    turns: NDArray[np.bool_]  # which of them are angles, shape (k,)
    kinematics: str  # LinuxCNC's name for it, with its settings
    slides: NDArray[np.bool_]  # which joints are lengths, shape (k,)

    @classmethod
    def of(cls, case: Case) -> "AxisLayout":
        """The layout of a case with a machine; of a chain its joints are the axes.

        Raises:
            CaseError: the case has no machine or no limits.
        """
        turns = case.need_motion(PURPOSE)[1].turns
        if case.chain is None:
            return cls(AXES, turns, "genhexkins", np.ones(6, dtype=bool))
        letters = "".join(case.chain.names)
        return cls(letters, turns, f"trivkins coordinates={letters}", ~turns)

    @property
    def units(self) -> Array:
        """LinuxCNC's unit of each axis in SI, shape (k,)."""
        return np.where(self.turns, DEG, MM)

    @property
    def joint_units(self) -> Array:
        """LinuxCNC's unit of each joint in SI, shape (k,)."""
        return np.where(self.slides, MM, DEG)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints as HAL names them."""
        return tuple(f"joint.{k}" for k in range(len(self.axes)))

    @property
    def channels(self) -> tuple[tuple[str, str], ...]:
        """What is logged every cycle: type of the sampler (s integer, b bit, f float64) and pin."""
        return (
            ("s", "motion.program-line"),
            ("b", "motion.digital-out-00"),
            *(("f", f"{joint}.pos-cmd") for joint in self.joints),
            *(("f", f"axis.{axis.lower()}.pos-cmd") for axis in self.axes),
        )

    @property
    def sampler(self) -> str:
        """The types of the channels as LinuxCNC's `sampler` wants them."""
        return "".join(kind for kind, _ in self.channels)


def pose_range(case: Case, box: bool) -> Array:
    """Range of the axes relative to home, shape (2, k) [m or rad].

    The workspace limits x and y; whatever else its struts allow, whose limits LinuxCNC keeps too, the axes may do. Of a
    chain the ends of its joints do.

    Args:
        box: whether the narrower box of `[limits.motion]` holds.
    """
    home, limits = case.need_motion(PURPOSE)
    if box:
        return limits.pose
    if case.chain is not None:
        return np.clip(case.chain.position, -TURNS * DEG, TURNS * DEG) - home
    _, workspace, _ = case.need_machine(PURPOSE)
    reach = workspace.strut_length[1]
    low, high = workspace.plane
    return np.array([[*low, -reach, *[-WIDEST] * 3], [*high, reach, *[WIDEST] * 3]])


def ini_text(case: Case, home_joints: Array, headroom: float, box: bool = True) -> str:
    """The INI file.

    Position limits of the axes are `pose_range`, those of struts `[workspace]`. Velocity limits of
    the axes are `[limits.motion]`, acceleration limits its multiple by `headroom`. The limits of the path
    as a whole are the diagonals of these boxes, so that they never bind before an axis does.

    Args:
        case: a case with machine, limits and controller.
        home_joints: joints at home, shape (k,) [m or rad].
        headroom: acceleration limits as a multiple of the case's.
        box: whether the axes keep the box of `[limits.motion]`, else `[workspace]`; see `pose_range`.

    Raises:
        CaseError: the case lacks one of these parts.
    """
    (start, limits), layout = case.need_motion(PURPOSE), AxisLayout.of(case)
    home = start / layout.units
    low, high = home + pose_range(case, box) / layout.units + ROUNDING * np.array([[-1.0], [1.0]])
    velocity = limits.rate / layout.units
    acceleration = headroom * limits.acceleration / layout.units
    linear, angular = ~layout.turns, layout.turns
    lines = [
        "[EMC]",
        "VERSION = 1.1",
        f"MACHINE = {case.name}",
        "[HEXCITE]",
        f"SAMPLER = {layout.sampler}",
        "[DISPLAY]",
        f"DISPLAY = ./{DISPLAY_FILE}",
        "[RS274NGC]",
        f"PARAMETER_FILE = {VARIABLE_FILE}",
        "SUBROUTINE_PATH = .",
        "RS274NGC_STARTUP_CODE = G17 G21 G40 G49 G54 G80 G90 G94",
        "[EMCMOT]",
        "EMCMOT = motmod",
        "COMM_TIMEOUT = 4.0",
        f"SERVO_PERIOD = {round(SERVO_PERIOD * 1e9)}",
        "[TASK]",
        "TASK = milltask",
        "CYCLE_TIME = 0.001",
        "[HAL]",
        f"HALFILE = {HAL_FILE}",
        "[TRAJ]",
        f"COORDINATES = {' '.join(layout.axes)}",
        f"HOME = {' '.join(_number(value) for value in home)}",
        "LINEAR_UNITS = mm",
        "ANGULAR_UNITS = degree",
        *_path_limits("LINEAR", velocity[linear], acceleration[linear]),
        *_path_limits("ANGULAR", velocity[angular], acceleration[angular]),
        "[EMCIO]",
        "EMCIO = io",
        "CYCLE_TIME = 0.1",
        f"TOOL_TABLE = {TOOL_FILE}",
        "[KINS]",
        f"KINEMATICS = {layout.kinematics}",
        f"JOINTS = {len(layout.axes)}",
    ]
    axes = [(*_range(low[k], high[k]), *_dynamics(velocity[k], acceleration[k])) for k in range(len(home))]
    for axis, own in zip(layout.axes, axes, strict=True):
        lines += [f"[AXIS_{axis}]", *own]
    joints = axes
    if case.chain is None:
        shortest, longest = case.need_machine(PURPOSE)[1].strut_length / MM
        joints = [(*_range(shortest, longest), *_dynamics(UNBOUND, UNBOUND))] * len(axes)
    for k, value in enumerate(np.asarray(home_joints) / layout.joint_units):
        kind = "LINEAR" if layout.slides[k] else "ANGULAR"
        lines += [f"[JOINT_{k}]", f"TYPE = {kind}", *joints[k]]
        lines += [f"HOME = {_number(value)}", f"HOME_OFFSET = {_number(value)}", "HOME_SEQUENCE = 0"]
        lines += ["HOME_SEARCH_VEL = 0", "HOME_LATCH_VEL = 0"]
        lines += [f"{limit} = {_number(FOLLOWING_ERROR)}" for limit in ("FERROR", "MIN_FERROR")]
    return "\n".join(lines) + "\n"


def hal_text(case: Case) -> str:
    """The HAL file: kinematics of the machine, joints that follow their commands, and the log of every cycle.

    Raises:
        CaseError: the case has none.
    """
    layout = AxisLayout.of(case)
    lines = [
        "loadrt [KINS]KINEMATICS",
        "loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS num_dio=4 num_aio=4",
        "loadrt and2",
        "loadrt timedelay",
        f"loadrt sampler depth={QUEUE} cfg={layout.sampler}",
        "addf motion-command-handler servo-thread",
        "addf motion-controller servo-thread",
        "addf and2.0 servo-thread",
        "addf timedelay.0 servo-thread",
        "addf sampler.0 servo-thread",
        "setp sampler.0.enable 0",
        "setp timedelay.0.off-delay 0",
        f"net dwell-asked motion.digital-out-0{DWELL_OUTPUT} => and2.0.in0",
        "net standing motion.in-position => and2.0.in1",
        "net dwelling and2.0.out => timedelay.0.in",
        f"net dwell-seconds motion.analog-out-0{DWELL_OUTPUT} => timedelay.0.on-delay",
        f"net dwelt timedelay.0.out => motion.digital-in-0{DWELL_OUTPUT}",
        "net emergency-stop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in",
        "net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared",
        "net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed",
    ]
    lines += _kinematics(case)
    lines += [f"net {joint.replace('.', '-')} {joint}.motor-pos-cmd => {joint}.motor-pos-fb" for joint in layout.joints]
    lines += [f"net log-{k} {pin} => sampler.0.pin.{k}" for k, (_, pin) in enumerate(layout.channels)]
    return "\n".join(lines) + "\n"


def _kinematics(case: Case) -> Iterator[str]:
    """Settings of the kinematics: the points of a hexapod, none of a chain."""
    if case.chain is not None:
        return
    machine, _, _ = case.need_machine(PURPOSE)
    yield "net tool-length motion.tooloffset.z => genhexkins.tool-offset"
    for ring, points in (("base", machine.base.points), ("platform", machine.platform.points)):
        for k, point in enumerate(points / MM):
            yield from (f"setp genhexkins.{ring}.{k}.{c} {_number(v)}" for c, v in zip("xyz", point, strict=True))


def write_configuration(folder: Path, case: Case, home_joints: Array, headroom: float, box: bool = True) -> None:
    """Writes all that LinuxCNC reads, but its program and display, into a folder of its own; the rest as `ini_text`."""
    for name, text in (
        (INI_FILE, ini_text(case, home_joints, headroom, box)),
        (HAL_FILE, hal_text(case)),
        (TOOL_FILE, "T1 P1 Z0 D1\n"),
        (DWELL_FILE, DWELL),
        (VARIABLE_FILE, ""),  # no offsets left over from another program
    ):
        (folder / name).write_text(text, encoding="ascii")


def _path_limits(kind: str, velocity: Array, acceleration: Array) -> list[str]:
    if not len(velocity):
        return []
    largest, strongest = float(np.linalg.norm(velocity)), float(np.linalg.norm(acceleration))
    return [
        f"{start}_{kind}_{quantity} = {_number(value)}"
        for quantity, value in (("VELOCITY", largest), ("ACCELERATION", strongest))
        for start in ("DEFAULT", "MAX")
    ]


def _range(low: float, high: float) -> list[str]:
    return [f"MIN_LIMIT = {_number(low)}", f"MAX_LIMIT = {_number(high)}"]


def _dynamics(velocity: float, acceleration: float) -> list[str]:
    return [f"MAX_VELOCITY = {_number(velocity)}", f"MAX_ACCELERATION = {_number(acceleration)}"]


def _number(value: float) -> str:
    return f"{value:.12f}"
