"""Paths of points of TwinCAT (splines, HSC, contour mode): what begins and ends them, what belongs to them."""

import re

import numpy as np

from cases.controller import TwinCat
from postprocessors.reading.modal import ModalState, Word

FEWEST_SPLINE_POINTS = 3  # of an AKIMA spline, its start included

_DEVIATION = re.compile(r"(?P<name>PATH_DEV|TRACK_DEV)=(?P<value>\d+\.?\d*|\.\d+)$")


class PointPath:
    """The path of points that is open, if one is.

    Args:
        state: of the controller.
        settings: of the case.
    """

    def __init__(self, state: ModalState, settings: TwinCat) -> None:
        self.state = state
        self.settings = settings
        self.kind = ""  # SPLINE, HSC or CONTOUR while one is open
        self.akima = self.contour = False  # whether what SPLINE and CONTOUR need was said
        self.points = 0
        self.stopped = False  # whether an exact stop has ended the points

    def open(self, kind: str, word: Word) -> None:
        """Begins a path where the machine stands.

        Raises:
            ProgramError: another one is open, it was not chosen, the pose is not known, or the machine moves on.
        """
        fail = self.state.fail
        if kind == "SPLINE" and not self.akima:
            fail(word, "#SPLINE ON before #SPLINE TYPE AKIMA; add it")
        if kind == "CONTOUR" and (not self.contour or self.kind):
            fail(word, "G261 needs #CONTOUR MODE before it, and no other curve; correct that")
        if self.kind:
            fail(word, f"{word.name} while another curve is open; end it first")
        if np.isnan(self.state.pose).any():
            fail(word, "a path of points starts from an unknown pose; first move home at a feed (G94)")
        if self.state.flowing:
            fail(word, "a path of points starts while the machine moves on; write G60 in the block before")
        self.kind, self.points, self.stopped = kind, 1, False

    def close(self, kind: str, word: Word) -> None:
        """Ends a path.

        Raises:
            ProgramError: none of this kind is open, or it has too few points.
        """
        if self.kind != kind:
            self.state.fail(word, f"{word.name} without its beginning; remove it")
        if kind == "SPLINE" and self.points < FEWEST_SPLINE_POINTS:
            self.state.fail(word, f"a spline needs {FEWEST_SPLINE_POINTS} points, its start included; add some")
        self.kind = ""

    def point(self, first: Word, exact: bool) -> None:
        """A timed block is a point of the path; the very first move of a program needs none.

        Raises:
            ProgramError: no path is open, or its points have ended.
        """
        if not self.kind:
            if not np.isnan(self.state.pose).any():
                problem = "a timed block (G93) is a corner without a curve; write #SPLINE ON before the points"
                self.state.fail(first, problem)
            return
        if self.stopped:
            self.state.fail(first, "a point after an exact stop within a path; write G60 in the last block alone")
        self.points += 1
        self.stopped = exact

    def require_deviations(self, word: Word, kind: str) -> None:
        """The curve may leave its points by what the case allows; both must be stated, the defaults are loose.

        Raises:
            ProgramError: they are not stated, or larger.
        """
        s, arguments = self.settings, word.arguments or ()
        limits = {"PATH_DEV": s.path_deviation_mm, "TRACK_DEV": s.track_deviation_deg}
        wanted = f"[{kind} PATH_DEV={s.path_deviation_mm:g} TRACK_DEV={s.track_deviation_deg:g}]"
        found = {m["name"]: float(m["value"]) for item in arguments[1:] if (m := _DEVIATION.match(item))}
        if arguments[:1] != (kind,) or len(arguments) != 3 or set(found) != set(limits):
            self.state.fail(word, f"{word.name} needs its deviations; write {word.name} {wanted}")
        for name, limit in limits.items():
            if not 0.0 < found[name] <= limit:
                problem = f"{name}={found[name]:g} is not above 0 and at most {limit:g}, the case's; correct it"
                self.state.fail(word, problem)
