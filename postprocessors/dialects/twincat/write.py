"""Writes programs for TwinCAT CNC (TF5200) and other ISG kernels: G01 with exact stop, dense paths as spline or #HSC.

Kinematics, sign of B, M functions and the kind of curve are those of the case. Feeds: G94 in mm/min along X, Y, Z, or
in degrees/min along A, B, C where only they move (#FGROUP says which); G93 is the block's time in seconds. In a
machine's own axes no transformation is active.
"""

import numpy as np

from cases.controller import TwinCat, TwinCatAxes
from cases.schema import Case
from identification.motion.motion import Array
from postprocessors.blocks import Blocks, TimedPath
from postprocessors.dialects.block_writer import HOME_WITHIN, BlockWriter, number
from postprocessors.dialects.twincat.promises import twincat_guarantees
from postprocessors.reading import Reading, axis_letters

TIME_DECIMALS = 9  # decimals of a second
ERROR = 900  # number of a user's error message


class _TwinCatWriter(BlockWriter):
    name, straight, arcs, dwell, grouping = "TwinCAT", "G01 G60", ("G03 G60", "G02 G60"), "G04 ", "#FGROUP [{}]"

    def __init__(self, case: Case) -> None:
        self.settings = case.need_settings(TwinCatAxes, "a TwinCAT program")
        letters = "XYZABC"
        if not isinstance(self.settings, TwinCat):
            letters = axis_letters(case, self.name, self.settings.program_name, endless=False)
        super().__init__(letters, letters, twincat_guarantees(Reading("", (), 0), case), case)

    def written(self, program: Blocks) -> bytes:
        s = self.settings
        title, slope = [f"%{s.program_name}"], f"#SLOPE [TYPE={s.slope}]"
        none = "G53 G40 G20"  # no zero offset, no tool radius, no mirror, whatever the defaults of the channel
        if not isinstance(s, TwinCat):
            return self.text(program, title, ["G71 G90 G17 G94", none, slope, "#TRAFO OFF"], ["M30"])
        start = ["G71 G90 G17 G94 G162", none, slope, f"#KIN ID[{s.kinematic_id}]", "#TRAFO ON", "#FGROUP [X,Y,Z]"]
        return self.text(program, title, start, ["#TRAFO OFF", "M30"])

    def coordinates(self, pose: Array) -> list[str]:
        if isinstance(self.settings, TwinCat):
            pose = pose * [1, 1, 1, 1, self.settings.angle_sign_b, 1]
        return super().coordinates(pose)

    def _as_meant(self, written: Array) -> Array:
        state = super()._as_meant(written)
        return state * [1, 1, 1, 1, self.settings.angle_sign_b, 1] if isinstance(self.settings, TwinCat) else state

    before_checks = ("#CHANNEL INIT [CMDPOS]",)  # V.A.ABS then is the present place

    def stop_unless(self, axis: str, difference: str, home: str) -> list[str]:
        # with the offsets that are active, and without any
        return [
            line
            for variable in ("ABS", "ACT_POS")
            for line in (
                f"$IF ABS[V.A.{variable}.{axis}{difference}] > {HOME_WITHIN:g}",
                f'#MSG ["{axis} IS NOT AT HOME: GO TO {home} FIRST, THEN START AGAIN"]',
                f"#ERROR [ID={ERROR} RC=2]",
                "$ENDIF",
            )
        ]

    def trigger(self, on: bool, moves_next: bool) -> str:
        return f"M{self.settings.trigger_on_m if on else self.settings.trigger_off_m}"

    def path(self, path: TimedPath) -> list[str]:
        """Blocks of a path: the last point stops exactly; every point before it belongs to the curve."""
        s = self.settings
        assert isinstance(s, TwinCat)  # of a hexapod: paths in a machine's own axes are refused before
        deviations = f"PATH_DEV={s.path_deviation_mm:g} TRACK_DEV={s.track_deviation_deg:g}"
        before, after = {
            "akima": (["#SPLINE TYPE AKIMA", "#SPLINE ON"], "#SPLINE OFF"),
            "hsc": ([f"#HSC ON [BSPLINE {deviations}]"], "#HSC OFF"),
            "contour": ([f"#CONTOUR MODE [DEV {deviations}]", "G261"], "G260"),
        }[s.path]
        lines = [*self.comments(f"{path.name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"), *before, "G93"]
        steps = np.diff(np.round(path.times, TIME_DECIMALS))  # rounding of many blocks does not add up
        for k, (pose, step) in enumerate(zip(path.poses[1:], steps, strict=True), start=1):
            stop = "G60 " if k == len(steps) else ""
            lines.append(f"G01 {stop}{self.pose(pose)} F{number(step, TIME_DECIMALS)}")
        return [*lines, after, "G94"]


def write_twincat(program: Blocks, case: Case) -> bytes:
    """The program's text, plain ASCII; see `Dialect.write`."""
    return _TwinCatWriter(case).written(program)
