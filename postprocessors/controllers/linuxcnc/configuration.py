"""The LinuxCNC configuration of a case: INI, HAL, tool table and variables, in LinuxCNC's units (mm, degrees, seconds).

The joints of a hexapod are its six struts (`genhexkins`); its axes X Y Z A B C are the pose, A B C turning about the
fixed axes x y z, which is R = Rz(yaw) Ry(pitch) Rx(roll). The axes of a chain are its joints (`trivkins`). There are no
motors: each joint follows its command exactly. `dwell.ngc` counts a dwell in the controller's own cycles; G4 follows
the wall clock, whatever the servo thread does.
"""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.base.units import DEG, MM
from cases.schema import Case
from identification.motion.motion import Array
from postprocessors.dialects.linuxcnc.promises import SERVO_PERIOD, path_jerk

if TYPE_CHECKING:
    from jinja2 import Environment

PURPOSE = "running a program on LinuxCNC"
HERE = Path(__file__).parent
INI_FILE = "machine.ini"
HAL_FILE = "machine.hal"
DISPLAY_FILE = "driver.py"

ROUNDING = 1e-6  # last digit of a program's numbers, by which pose limits are widened [mm, deg]
UNBOUND = 1e6  # limits of struts that LinuxCNC does not enforce on a path [mm/s, mm/s^2]
WIDEST = np.pi / 2  # angles of the axes where only the struts limit them [rad]
TURNS = 1e6  # position limits of a joint that turns without end [degrees]


class AxisLayout(NamedTuple):
    """Axes and joints of a machine."""

    axes: str  # letters of the coordinates
    turns: NDArray[np.bool_]  # which of them are angles, shape (k,)
    kinematics: str  # LinuxCNC's name for it, with its settings
    slides: NDArray[np.bool_]  # which joints are lengths, shape (k,)

    @classmethod
    def of(cls, case: Case) -> "AxisLayout":
        """The layout of a case with a machine and limits; of a chain its joints are the axes."""
        turns = case.need_motion(PURPOSE)[1].turns
        if case.chain is None:
            return cls("XYZABC", turns, "genhexkins", np.ones(6, dtype=bool))
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
        """Channels of the log of every cycle: type of the sampler (s integer, b bit, f float64) and pin."""
        return (
            ("s", "motion.program-line"),
            ("b", "motion.digital-out-00"),
            *(("f", f"{joint}.pos-cmd") for joint in self.joints),
            *(("f", f"axis.{axis.lower()}.pos-cmd") for axis in self.axes),
        )

    @property
    def sampler(self) -> str:
        """The types of the channels in the form of LinuxCNC's `sampler`."""
        return "".join(kind for kind, _ in self.channels)


def pose_range(case: Case, box: bool) -> Array:
    """Range of the axes relative to home, shape (2, k) [m or rad]; `box`: the narrower one of `[limits.motion]`.

    The workspace limits x, y and, where it is stated, z; the other axes are limited by the struts only, whose limits
    LinuxCNC satisfies too.
    A chain is limited by the ends of its joints.
    """
    home, limits = case.need_motion(PURPOSE)
    if box:
        return limits.coordinates
    if case.chain is not None:
        return np.clip(case.chain.position, -TURNS * DEG, TURNS * DEG) - home
    _, workspace, _ = case.need_machine(PURPOSE)
    room = workspace.room
    if room.shape[1] == 2:
        room = np.column_stack([room, workspace.strut_length[1] * np.array([-1.0, 1.0])])
    return np.column_stack([room, np.outer([-WIDEST, WIDEST], np.ones(3))])


@cache
def _templates() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # checks of programs do not need it

    templates = Environment(
        loader=FileSystemLoader(HERE), undefined=StrictUndefined, trim_blocks=True, keep_trailing_newline=True
    )
    templates.filters["number"] = lambda value: f"{value:.12f}"
    return templates


def ini_text(case: Case, headroom: float, box: bool = True) -> str:
    """The INI file, with acceleration limits of `headroom` times the case's and positions of `pose_range` with `box`.

    Limits of the path as a whole are the diagonals of those of the axes, so that they never bind before an axis does.
    """
    from identification.machines.of_case import machine_of  # CasADi, which writers and readers do not need

    (start, limits), layout = case.need_motion(PURPOSE), AxisLayout.of(case)
    home = start / layout.units
    low, high = home + pose_range(case, box) / layout.units + ROUNDING * np.array([[-1.0], [1.0]])
    velocity, acceleration = limits.rate / layout.units, headroom * limits.acceleration / layout.units
    axes = joints = np.column_stack([low, high, velocity, acceleration]).tolist()
    if case.chain is None:
        joints = [[*case.need_machine(PURPOSE)[1].strut_length / MM, UNBOUND, UNBOUND]] * len(axes)
    diagonals = [
        (kind, float(np.linalg.norm(velocity[of_kind])), float(np.linalg.norm(acceleration[of_kind])))
        for kind, of_kind in (("LINEAR", ~layout.turns), ("ANGULAR", layout.turns))
        if of_kind.any()
    ]
    values = {
        "name": case.name,
        "layout": layout,
        "period_ns": round(SERVO_PERIOD * 1e9),
        "home": home.tolist(),
        "path_jerk": path_jerk(case),
        "jerks": (limits.jerk / layout.units).tolist(),
    }
    home_joints = (machine_of(case).drives(start[None])[0] / layout.joint_units).tolist()
    template = _templates().get_template("machine.ini.jinja")
    return template.render(values, paths=diagonals, axes=axes, joints=joints, home_joints=home_joints)


def hal_text(case: Case) -> str:
    """The HAL file: kinematics of the machine, joints that follow their commands, and the log of every cycle."""
    template = _templates().get_template("machine.hal.jinja")
    return template.render(layout=AxisLayout.of(case), hexapod=case.hexapod, mm=MM)


def write_configuration(folder: Path, case: Case, headroom: float, box: bool = True) -> None:
    """Writes the files of LinuxCNC, but its program and display, into a folder of its own; the rest as `ini_text`."""
    for name, text in (
        (INI_FILE, ini_text(case, headroom, box)),
        (HAL_FILE, hal_text(case)),
        ("tool.tbl", "T1 P1 Z0 D1\n"),
        ("dwell.ngc", (HERE / "dwell.ngc").read_text(encoding="ascii")),
        ("machine.var", ""),  # no offsets of another program
    ):
        (folder / name).write_text(text, encoding="ascii")
