"""Writes programs for SINUMERIK 840D sl / ONE: straight moves as G1 with exact stop, paths as POLY or compressed G1.

The transformation, the words of the angles and the trigger's output are those of the case. Feeds: G94 in mm/min along
X, Y, Z, or in degrees/min along the angles where only they move (FGROUP says which); G93 is one over minutes.
"""

import numpy as np

from cases.controller import Sinumerik
from cases.errors import CaseError
from cases.machine import MotionLimits
from cases.schema import Case
from cases.units import DEG, MINUTE, MM
from identification.motion import TimedPoints, Trajectory
from postprocessors.blocks import (
    Arc,
    Array,
    Block,
    Comment,
    Dwell,
    ExactStopMove,
    NeutralProgram,
    Pieces,
    SplinePath,
    TimedPath,
    ToHome,
    TooCoarse,
    Trigger,
    even_deviation,
    path_speed_deviation,
    pieces,
)
from postprocessors.proving.guarantees import Guarantees, sinumerik_guarantees
from postprocessors.reading import Reading
from postprocessors.wording import (
    FEED_DECIMALS,
    PLANE_WORDS,
    arc_words,
    comments,
    coordinates,
    feed,
    feed_of,
    number,
    written_feed,
)
from postprocessors.writing import moves_as_polynomials, timed_path

POLY_LENGTH_DECIMALS = 7  # of a coefficient: rates must pass from piece to piece
POLY_ANGLE_DECIMALS = 8
AXES_OF_A_POSE = 6


class _SinumerikWriter:
    """Keeps what holds from block to block: which axes the feed counts."""

    def __init__(self, case: Case, settings: Sinumerik, limits: MotionLimits, guarantees: Guarantees) -> None:
        self.case = case
        self.settings = settings
        self.limits = limits
        self.guarantees = guarantees
        self.block = case.need_controller("a SINUMERIK program").block
        self.linear = True
        self.words = ["X", "Y", "Z", *(w + "=" if w[-1].isdigit() else w for w in settings.orientation_words)]

    def pose(self, pose: Array) -> str:
        return " ".join(word + value for word, value in zip(self.words, coordinates(pose), strict=True))

    def group(self, linear: bool) -> list[str]:
        """FGROUP where the feed has to count other axes than before."""
        if linear == self.linear:
            return []
        self.linear = linear
        return [f"FGROUP({','.join(('X', 'Y', 'Z') if linear else self.settings.orientation_axes)})"]

    def lines(self, block: Block) -> list[str]:
        match block:
            case Comment():
                return comments(block.text)
            case ToHome():
                return [
                    *comments("to home"),
                    *self.group(True),
                    f"G1 {self.pose(block.pose)} F{feed(block.feed, True)}",
                ]
            case ExactStopMove():
                linear, value = written_feed(block, self.limits, self.guarantees)
                return [*self.group(linear), f"G1 {self.pose(block.move.end)} F{value}"]
            case Arc():
                return [*self.group(True), f"{PLANE_WORDS[block.move.plane]} {self.arc(block)}", "G17"]
            case Dwell():
                return [f"G4 F{number(block.duration, 6)}"]
            case Trigger():
                return [f"DO $A_OUT[{self.settings.trigger_output}]={int(block.on)}"]
            case TimedPath():
                motion = TimedPoints.through(block.times, block.poses) if block.source is None else block.source
                return self.path(block.name, motion, block)
            case SplinePath():
                return self.path(block.name, block.motion, timed_path(block.name, block.motion, self.block, 1.0))

    def arc(self, block: Arc) -> str:
        words = arc_words(block.move, self.words, coordinates(block.move.end))
        value = feed(feed_of(block, self.limits, self.guarantees), True)
        return f"{'G3' if block.move.angle > 0.0 else 'G2'} {words} F{value}"

    def path(self, name: str, motion: Trajectory, points: TimedPath) -> list[str]:
        if self.settings.path == "lines":
            return self.compressed(name, points)
        s = self.settings
        if s.poly_axes < AXES_OF_A_POSE:
            raise self.wrong("poly_axes", f"{s.poly_axes} cannot carry six coordinates; set path = 'lines'")
        try:
            spline = pieces(motion, s.poly_degree, s.poly_block, s.poly_tolerance)
        except TooCoarse as error:
            raise self.wrong(
                "poly_tolerance_mm", f"is not reached: {error}; loosen it or set path = 'lines'"
            ) from error
        return [*self.stated(name, spline, motion), "G64 G93", *self.poly(spline), "G94 G60 G1"]

    def wrong(self, key: str, problem: str) -> CaseError:
        return CaseError(f"case {self.case.name}", f"controller.sinumerik.{key}", problem)

    def stated(self, name: str, found: Pieces, motion: Trajectory) -> list[str]:
        """How far the path is from the plan: its law of time is the controller's own."""
        lines = [f"{name}: {len(found.coefficients)} POLY blocks of degree {found.coefficients.shape[1] - 1}, "]
        lines[0] += f"{found.times[-1]:.6f} s"
        for law, off in (
            ("the polynomials' parameter passes evenly in time", even_deviation(found, motion)),
            ("the path speed stays the same within each block", path_speed_deviation(found, motion)),
        ):
            lines.append(f"off the plan by {off.position / MM:.2g} mm, {off.angle / DEG:.2g} deg at most if {law}")
        return [c for line in lines for c in comments(line)]

    def poly(self, found: Pieces) -> list[str]:
        """Finely rounded, lest rates step between pieces; the last ends as a pose does, where the next move starts."""
        axes = ("X", "Y", "Z", *self.settings.orientation_axes)
        decimals = (POLY_LENGTH_DECIMALS,) * 3 + (POLY_ANGLE_DECIMALS,) * 3
        units = (MM,) * 3 + (DEG,) * 3
        lines = []
        steps = np.diff(found.times)
        for count, (coefficients, step) in enumerate(zip(found.coefficients, steps, strict=True), start=1):
            end = coefficients.sum(axis=0)
            ends = coordinates(end) if count == len(steps) else None
            words = []
            for k, axis in enumerate(axes):
                items = [number(v[k] / units[k], decimals[k]) for v in (end, *coefficients[2:])]
                items[:1] = [ends[k]] if ends is not None else items[:1]
                while len(items) > 1 and items[-1] == "0":
                    items.pop()  # the last zero coefficients are omitted
                words.append(f"PO[{axis}]=({','.join(items)})")
            lines.append(f"POLY {' '.join(words)} PL=1 F{number(MINUTE / step, FEED_DECIMALS)}")
        return lines

    def compressed(self, name: str, path: TimedPath) -> list[str]:
        """The compressor takes nothing but G1, coordinates and F."""
        s = self.settings
        comment = f"{name}: {len(path.times) - 1} blocks, {path.times[-1]:.6f} s"
        tolerances = f"CTOL={s.contour_tolerance_mm:g} OTOL={s.orientation_tolerance_deg:g}"
        lines = [*comments(comment), f"G642 G93 COMPCAD {tolerances}"]
        for pose, step in zip(path.poses[1:], np.diff(path.times), strict=True):
            lines.append(f"G1 {self.pose(pose)} F{number(MINUTE / step, FEED_DECIMALS)}")
        return [*lines, "COMPOF", "G94 G60"]


def prepare_sinumerik(program: NeutralProgram, case: Case) -> NeutralProgram:
    """Point-to-point moves as the case wants them: at a feed, or as polynomials."""
    if case.chain is not None:
        return program
    settings = case.need_controller("a SINUMERIK program").need_sinumerik(case.name)
    return moves_as_polynomials(program) if settings.moves == "poly" else program


def write_sinumerik(program: NeutralProgram, case: Case) -> bytes:
    """The program's text, plain ASCII.

    Args:
        case: gives the controller's settings, and limits for which feeds are chosen.

    Raises:
        CaseError: the case lacks the machine or the settings of this dialect, or they cannot carry the motion.
    """
    limits = case.need_machine("a program")[2].motion
    settings = case.need_controller("a SINUMERIK program").need_sinumerik(case.name)
    writer = _SinumerikWriter(case, settings, limits, sinumerik_guarantees(Reading("", (), 0), case))
    rpy = "ORIWKS ORIRPY" if settings.orientation_words[0][-1].isdigit() else "ORIWKS"
    lines = [f"%_N_{settings.program_name}_MPF", ";$PATH=/_N_MPF_DIR"]
    lines += [c for line in program.header for c in comments(line)]
    lines += ["G17 G90 G94 G710 G40 G500", settings.transformation, rpy, "ORIAXES", "SOFT FFWON DYNNORM"]
    lines += ["FGROUP(X,Y,Z)", "COMPOF G60"]
    for block in program.blocks:
        lines += writer.lines(block)
    return ("\n".join([*lines, settings.transformation_off, "M30"]) + "\n").encode("ascii")
