"""Writes programs for TwinCAT CNC (TF5200) and other ISG kernels: G01 with exact stop, dense paths as spline or #HSC.

Kinematics, sign of B, M functions and the kind of curve are those of the case. Feeds: G94 in mm/min along X, Y, Z, or
in degrees/min along A, B, C where only they move (#FGROUP says which); G93 is the block's time in seconds.
"""

import numpy as np

from cases.controller import TwinCat
from cases.machine import MotionLimits
from cases.schema import Case
from postprocessors.blocks import (
    Arc,
    Array,
    Block,
    Comment,
    Dwell,
    ExactStopMove,
    NeutralProgram,
    SplinePath,
    TimedPath,
    ToHome,
    Trigger,
)
from postprocessors.proving.guarantees import Guarantees, twincat_guarantees
from postprocessors.reading import Reading
from postprocessors.wording import (
    PLANE_WORDS,
    arc_words,
    comments,
    coordinates,
    feed,
    feed_of,
    number,
    written_feed,
)
from postprocessors.writing import timed_path

TIME_DECIMALS = 9  # of a second


class _TwinCatWriter:
    """Keeps what holds from block to block: which axes the feed counts."""

    def __init__(self, settings: TwinCat, limits: MotionLimits, guarantees: Guarantees, block: float) -> None:
        self.settings = settings
        self.limits = limits
        self.guarantees = guarantees
        self.block = block
        self.linear = True

    def coordinates(self, pose: Array) -> list[str]:
        return coordinates(pose * [1, 1, 1, 1, self.settings.angle_sign_b, 1])

    def pose(self, pose: Array) -> str:
        return " ".join(letter + value for letter, value in zip("XYZABC", self.coordinates(pose), strict=True))

    def group(self, linear: bool) -> list[str]:
        """#FGROUP where the feed has to count other axes than before."""
        if linear == self.linear:
            return []
        self.linear = linear
        return ["#FGROUP [X,Y,Z]" if linear else "#FGROUP [A,B,C]"]

    def lines(self, block: Block) -> list[str]:
        match block:
            case Comment():
                return comments(block.text)
            case ToHome():
                move = f"G01 G60 {self.pose(block.pose)} F{feed(block.feed, True)}"
                return ['#MSG ["TO HOME: KEEP THE WAY CLEAR"]', *self.group(True), move]
            case ExactStopMove():
                linear, value = written_feed(block, self.limits, self.guarantees)
                return [*self.group(linear), f"G01 G60 {self.pose(block.move.end)} F{value}"]
            case Arc():
                return [*self.group(True), f"{PLANE_WORDS[block.move.plane]} {self.arc(block)}", "G17"]
            case Dwell():
                return [f"G04 {number(block.duration, 6)}"]
            case Trigger():
                return [f"M{self.settings.trigger_on_m if block.on else self.settings.trigger_off_m}"]
            case TimedPath():
                return self.path(block)
            case SplinePath():
                return self.path(timed_path(block.name, block.motion, self.block, 1.0))

    def arc(self, block: Arc) -> str:
        words = arc_words(block.move, "XYZABC", self.coordinates(block.move.end))
        value = feed(feed_of(block, self.limits, self.guarantees), True)
        return f"{'G03' if block.move.angle > 0.0 else 'G02'} G60 {words} F{value}"

    def path(self, path: TimedPath) -> list[str]:
        """The last point stops exactly; before it, every point belongs to the curve."""
        s = self.settings
        deviations = f"PATH_DEV={s.path_deviation_mm:g} TRACK_DEV={s.track_deviation_deg:g}"
        before, after = {
            "akima": (["#SPLINE TYPE AKIMA", "#SPLINE ON"], "#SPLINE OFF"),
            "hsc": ([f"#HSC ON [BSPLINE {deviations}]"], "#HSC OFF"),
            "contour": ([f"#CONTOUR MODE [DEV {deviations}]", "G261"], "G260"),
        }[s.path]
        lines = [*comments(f"{path.name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"), *before, "G93"]
        steps = np.diff(np.round(path.times, TIME_DECIMALS))  # rounding of many blocks does not add up
        for k, (pose, step) in enumerate(zip(path.poses[1:], steps, strict=True), start=1):
            stop = "G60 " if k == len(steps) else ""
            lines.append(f"G01 {stop}{self.pose(pose)} F{number(step, TIME_DECIMALS)}")
        return [*lines, after, "G94"]


def write_twincat(program: NeutralProgram, case: Case) -> bytes:
    """The program's text, plain ASCII.

    Args:
        case: gives the controller's settings, and limits for which feeds are chosen.

    Raises:
        CaseError: the case lacks the machine or the settings of this dialect.
    """
    limits = case.need_machine("a program")[2].motion
    controller = case.need_controller("a TwinCAT program")
    settings = controller.need_twincat(case.name)
    writer = _TwinCatWriter(settings, limits, twincat_guarantees(Reading("", (), 0), case), controller.block)
    lines = [f"%{settings.program_name}", *(c for line in program.header for c in comments(line))]
    lines += ["G71 G90 G17 G94 G162", f"#SLOPE [TYPE={settings.slope}]", f"#KIN ID[{settings.kinematic_id}]"]
    lines += ["#TRAFO ON", "#FGROUP [X,Y,Z]"]
    for block in program.blocks:
        lines += writer.lines(block)
    return ("\n".join([*lines, "#TRAFO OFF", "M30"]) + "\n").encode("ascii")
