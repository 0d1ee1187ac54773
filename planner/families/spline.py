"""Free-form excitation: cubic B-splines from rest to rest, limited in jerk.

Coordinates are cubic splines over equal intervals h. Their jerk is constant and their acceleration linear in each, so
that limits of both hold for all t if they hold at the knots. Positions and rates are limited at four instants an
interval: between two of them they slip by at most a h^2/128 and j h^2/128 (a, j the limits of acceleration and jerk),
which the rows leave free. The motion is at rest at its ends: the first three coefficients of each coordinate are one
and the same, and so are the last three. It need not end where it begins.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from cases.base.units import Array
from cases.schema import Case
from identification.estimation.criteria import box_middle
from identification.motion.curves import PolynomialMotion
from planner.families.family import Family, Layout, linear_rows
from planner.families.plan_settings import SplineSettings
from planner.families.states import linear_states

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 3
FEWEST, MOST = 20, 150  # intervals
FINE = 4  # instants an interval at which positions, rates, struts and joints may be constrained
START_SHARE = 0.8
GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


@dataclass(frozen=True, slots=True)
class SplineFamily(Family):
    """Cubic splines from rest to rest over equal intervals."""

    intervals: int  # 20 to 150
    duration: float  # duration of the excitation [s]
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]
    slip: Array  # by how much positions and rates may exceed the limit between two rows, in half widths, shape (2, n)

    @classmethod
    def of(cls, case: Case, intervals: int, duration: float) -> "SplineFamily":
        """The family of a case; raises CaseError where it has no machine or limits."""
        middle, half = box_middle(case)
        box = case.need_motion("planning")[1]
        step = duration / intervals / FINE
        slip = np.array([4 * box.acceleration, box.jerk]) * step**2 / 8 / half
        return cls(intervals, duration, middle, half, slip)

    name: ClassVar[str] = "spline"
    iterations: ClassVar[int] = 28  # which rank starts as 50 do, in 0.6 of the time
    refining: ClassVar[int] = 200
    mending: ClassVar[int] = 40

    @property
    def settings(self) -> SplineSettings:
        """Number of intervals and duration."""
        return SplineSettings(knots=self.intervals, duration_s=self.duration)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of each coordinate."""
        return self.intervals + DEGREE - 4

    def _basis(self) -> "BSpline":
        """All basis functions, as one spline with matrix coefficients from unknowns."""
        from scipy.interpolate import BSpline  # every command that reads a plan loads this module

        step = self.duration / self.intervals
        inner = np.arange(self.intervals + 1) * step
        knots = np.r_[[0.0] * DEGREE, inner, [self.duration] * DEGREE]
        spread = np.zeros((self.intervals + DEGREE, self.unknowns))
        spread[:3, 0] = spread[-3:, -1] = 1.0
        spread[3:-3, 1:-1] = np.eye(self.unknowns - 2)
        return BSpline(knots, spread, DEGREE)

    def _at(self, shares: tuple[float, ...]) -> Array:
        """Instants at shares of each interval."""
        places = np.arange(self.intervals)[:, None] + np.array(shares)
        return np.asarray(places.ravel() * self.duration / self.intervals)

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion, with the information at two instants an interval, which integrate cubic polynomials exactly.

        Positions and rates are limited at four instants an interval, accelerations at the knots, jerks in the
        intervals. Non-linear limits of accelerations have their peaks at the knots, those of rates between them, those
        of poses anywhere, but slowly: these at every instant are of no use in an exploration, and double what the
        solver has to factorise.
        """
        basis, fine, inner = self._basis(), self._at(tuple(np.arange(FINE) / FINE)), self._at(GAUSS)
        knots, between = np.zeros((2, self.intervals, FINE), dtype=bool)
        knots[:, 0] = between[:, FINE // 2] = True
        every = np.ones(len(fine), dtype=bool)
        limits = (
            (basis(fine), (knots | between).ravel()),
            (basis(fine[1:], nu=1), every[1:]),  # at rest at the start: no row
            (basis(self._at((0.0,))[1:], nu=2), every[1 : self.intervals]),
            (basis(self._at((0.5,)), nu=3), every[: self.intervals]),
        )
        samples, critical = ([np.asarray(basis(t, nu=order)) for order in range(3)] for t in (inner, fine))
        shares, none = np.full(len(inner), 1.0 / len(inner)), np.zeros(len(fine))
        free = np.full(self.unknowns * len(self.middle), np.inf)
        return Layout(
            linear_states(samples, self.middle, self.half, shares, self.intervals),
            linear_states(critical, self.middle, self.half, none, self.intervals),
            (knots | between, between, knots),
            (linear_rows(self, case, margin, limits, self.slip),),
            -free,
            free,
        )

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits."""
        steps = draw.normal(size=(self.unknowns // 6 + 1, len(self.middle)))
        unknowns = np.repeat(steps, 6, axis=0)[: self.unknowns].ravel()
        return np.asarray(unknowns * START_SHARE / worst(unknowns))

    def motion(self, unknowns: Array) -> PolynomialMotion:
        """The motion of unknowns of shape (q n,), row by row."""
        basis, values = self._basis(), unknowns.reshape(self.unknowns, -1) * self.half
        step, begins = self.duration / self.intervals, self._at((0.0,))
        # Taylor's coefficients at the start of each interval; the third derivative is constant and jumps there.
        places = [begins] * DEGREE + [begins + step / 2]
        taylor = np.array([basis(t, nu=order) @ values / factorial(order) for order, t in enumerate(places)])
        taylor[0] += self.middle
        return PolynomialMotion(taylor, np.full(self.intervals, step))
