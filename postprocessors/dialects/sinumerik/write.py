"""Writes programs for SINUMERIK 840D sl / ONE: straight moves as G1 with exact stop, paths as POLY or compressed G1.

The transformation, the words of the angles and the trigger's output are those of the case. Feeds: G94 in mm/min along
X, Y, Z, or in degrees/min along the angles where only they move (FGROUP says which); G93 is one over minutes. In a
machine's own axes no transformation is active, and FGREF states that a degree counts like 1 mm.
"""

import numpy as np

from cases.base.errors import CaseError, Code
from cases.base.units import DEG, MINUTE, MM, MS
from cases.controller import Sinumerik, SinumerikAxes
from cases.schema import Case
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Trajectory
from postprocessors.blocks import (
    Blocks,
    TimedPath,
    even_deviation,
    path_speed_deviation,
    pieces,
    traced,
)
from postprocessors.dialects.block_writer import FEED_DECIMALS, HOME_WITHIN, BlockWriter, number
from postprocessors.dialects.sinumerik.promises import sinumerik_guarantees
from postprocessors.reading import Reading, axis_letters

MM_A_DEGREE = 180.0 / np.pi  # [mm] radius at which a degree is a way of 1 mm: FGREF
POLY_LENGTH_DECIMALS = 7  # decimals of a coefficient: rates must agree from piece to piece
POLY_ANGLE_DECIMALS = 8
AXES_OF_A_POSE = 6
ALARM = 65000  # a user's cycle alarm


class _SinumerikWriter(BlockWriter):
    name, straight, arcs, dwell, grouping = "SINUMERIK", "G1", ("G3", "G2"), "G4 F", "FGROUP({})"

    def __init__(self, case: Case) -> None:
        self.settings = case.need_settings(SinumerikAxes, "a SINUMERIK program")
        if isinstance(self.settings, Sinumerik):
            words = ["X", "Y", "Z", *(w + "=" if w[-1].isdigit() else w for w in self.settings.orientation_words)]
            axes = ["X", "Y", "Z", *self.settings.orientation_axes]
        else:
            words = axes = list(axis_letters(case, self.name, self.settings.program_name, endless=False))
        super().__init__(words, axes, sinumerik_guarantees(Reading("", (), 0), case), case)
        self.place = f"case {case.name}"

    def written(self, program: Blocks) -> bytes:
        # No tool, no programmed shift, turn, scale or mirror of an operator. Shifts of the base and from the PLC, which
        # a program cannot switch off, are checked with home.
        s, start = self.settings, ["G17 G90 G94 G710 G40 G500", "D0", "TRANS"]
        title = [f"%_N_{s.program_name}_MPF", ";$PATH=/_N_MPF_DIR"]
        if isinstance(s, Sinumerik):
            rpy = "ORIWKS ORIRPY" if s.orientation_words[0][-1].isdigit() else "ORIWKS"
            start += [s.transformation, rpy, "ORIAXES", "SOFT FFWON DYNNORM", "FGROUP(X,Y,Z)", "COMPOF G60"]
            return self.text(program, title, start, [s.transformation_off, "M30"])
        turning = (a for a, turns in zip(self.axes, self.limits.turns, strict=True) if turns)
        start += ["TRAFOOF", "SOFT FFWON DYNNORM", "COMPOF G60"]
        start += [f"FGREF[{a}]={number(MM_A_DEGREE, 6)}" for a in turning]
        return self.text(program, title, start, ["M30"])

    before_checks = ("STOPRE",)  # for what follows is computed while the machine still moves

    def stop_unless(self, axis: str, difference: str, home: str) -> list[str]:
        within = f"{difference})>{HOME_WITHIN:g}"
        off = f"ABS($AA_IW[{axis}]{within}"
        if self.own_axes or axis in ("X", "Y", "Z"):  # in the basic system too, which has no shifts
            off = f"({off}) OR (ABS($AA_IB[{axis}]{within})"
        return [
            f"IF {off}",
            f'MSG("NOT AT HOME: GO TO {home} FIRST, THEN START AGAIN")',
            f'SETAL({ALARM},"{axis}: NOT AT HOME")',
            "M30",
            "ENDIF",
        ]

    def trigger(self, on: bool, moves_next: bool) -> str:
        return f"DO $A_OUT[{self.settings.trigger_output}]={int(on)}"

    def trace(self, on: bool) -> list[str]:
        return ["STOPRE", f"$AN_SLTRACE={1 if on else 2}"]

    def path(self, path: TimedPath) -> list[str]:
        s, motion = self.settings, path.motion
        assert isinstance(s, Sinumerik)  # of a hexapod: paths in a machine's own axes are refused before
        if s.path == "lines":
            # for the compressor, which accepts only G1, coordinates and F
            tolerances = f"CTOL={s.contour_tolerance_mm:g} OTOL={s.orientation_tolerance_deg:g}"
            return self.dense(path, [f"G642 G93 COMPCAD {tolerances}"], ["COMPOF", "G94 G60"])
        if s.poly_axes < AXES_OF_A_POSE:
            raise self.wrong("poly_axes", f"{s.poly_axes} cannot carry six coordinates", "set path = 'lines'")
        try:
            spline = pieces(motion, s.poly_degree, s.poly_block_ms * MS, s.poly_tolerance)
        except ValueError as error:
            raise self.wrong(
                "poly_tolerance_mm", f"is not reached: {error}", "loosen it or set path = 'lines'"
            ) from error
        return [*self.stated(path.name, spline, motion), "G64 G93", *self.poly(spline), "G94 G60 G1"]

    def wrong(self, key: str, problem: str, remedy: str) -> CaseError:
        place = f"controller.sinumerik.{key}"
        return CaseError(file=self.place, key=place, problem=problem, remedy=remedy, code=Code.OUT_OF_RANGE)

    def stated(self, name: str, spline: PolynomialMotion, motion: Trajectory) -> list[str]:
        """Comment lines with the distance of the path from the plan: its time law is the controller's own."""
        lines = [
            f"{name}: {len(spline.durations)} POLY blocks of degree {len(spline.table) - 1}, {spline.duration:.6f} s"
        ]
        for law, (position, angle) in (
            ("the polynomials' parameter passes evenly in time", even_deviation(spline, motion)),
            ("the path speed stays the same within each block", path_speed_deviation(spline, motion)),
        ):
            lines.append(f"off the plan by {position / MM:.2g} mm, {angle / DEG:.2g} deg at most if {law}")
        return [c for line in lines for c in self.comments(line)]

    def poly(self, spline: PolynomialMotion) -> list[str]:
        """POLY blocks, finely rounded against steps of rates; the last ends at words of a pose, for the next move."""
        decimals = (POLY_LENGTH_DECIMALS,) * 3 + (POLY_ANGLE_DECIMALS,) * 3
        units = (MM,) * 3 + (DEG,) * 3
        lines = []
        powers = np.arange(len(spline.table))[:, None]
        for row, duration in enumerate(spline.durations):
            coefficients = spline.table[:, row] * duration**powers
            end = coefficients.sum(axis=0)
            ends = self.coordinates(end) if row == len(spline.durations) - 1 else None
            words = []
            for k, axis in enumerate(self.axes):
                items = [number(v[k] / units[k], decimals[k]) for v in (end, *coefficients[2:])]
                items[:1] = [ends[k]] if ends is not None else items[:1]
                while len(items) > 1 and items[-1] == "0":
                    items.pop()  # the last zero coefficients are omitted
                words.append(f"PO[{axis}]=({','.join(items)})")
            lines.append(f"POLY {' '.join(words)} PL=1 F{number(MINUTE / duration, FEED_DECIMALS)}")
        return lines


def prepare_sinumerik(program: Blocks, case: Case) -> Blocks:
    """The program, with the start and the stop of the control's trace where the case wants them."""
    return traced(program) if case.need_settings(SinumerikAxes, "a SINUMERIK program").trace else program


def write_sinumerik(program: Blocks, case: Case) -> bytes:
    """The program's text, plain ASCII; see `Dialect.write`."""
    return _SinumerikWriter(case).written(program)
