"""Periodic Fourier-series excitation (34)-(36), from rest to rest.

x(t) = x0 + sum_l a_l/(l w) sin(l w t) - b_l/(l w) cos(l w t) for each coordinate. Rest at t = 0 (and so after every
period) is linear in the coefficients: sum a_l = 0 (rate) and sum l b_l = 0 (acceleration; a motion that starts out of a
standstill with bounded jerk starts without acceleration). The coefficients are therefore written as a basis of the null
space of these two rows, and the solver needs no constraint. Order 1 would have no unknowns then: it has all of its
coefficients, and a quintic leads from rest in the middle of its circle into it and back (`run_in`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, Self

import numpy as np

from cases.schema import Case
from cases.units import Array
from identification.trajectories.curves import FourierMotion
from planner.families import Family, Layout, Settings, linear_rows
from planner.families.states import linear_states

START_SHARE = 0.8  # random starts use this share of the tightest limit: significantly different from zero, inside
DENSITY = 24  # instants of the optimiser's grid in one period of the highest harmonic
FIRST = 2  # every second of them is constrained from the start, others where limits come close


def _null_space(matrix: Array) -> Array:
    """Orthonormal basis of the null space; SciPy is loaded here: every command that reads a plan loads this module."""
    from scipy.linalg import null_space

    return np.asarray(null_space(matrix))


def resting_basis(order: int) -> Array:
    """Basis of the coefficients (x0, a_1..a_N, b_1..b_N) that are at rest at t = 0, shape (2 N + 1, 2 N - 1)."""
    harmonics = np.arange(1, order + 1)
    rate_row = np.r_[0.0, np.ones(order), np.zeros(order)]
    acceleration_row = np.r_[0.0, np.zeros(order), harmonics]
    return _null_space(np.vstack([rate_row, acceleration_row]))


@dataclass(frozen=True, slots=True)
class FourierFamily(Family):
    """All Fourier motions of one order and period.

    Unknowns are `q = 2 N - 1` amplitudes of each coordinate in units of the pose limits; with a run-in 2 N + 1.
    """

    order: int  # N, from 1 to 7; order 1 needs a run-in
    period: float  # [s]
    repeats: int  # number of periods
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]
    centred: bool = False  # whether x0 is the middle of the box, as in the paper; else it is free
    run_in: float = 0.0  # time from rest into the series and again out of it [s]; 0: the series itself begins at rest
    duration: float = field(init=False)  # duration of the excitation [s]

    def __post_init__(self) -> None:
        object.__setattr__(self, "duration", self.period * self.repeats + 2.0 * self.run_in)

    @classmethod
    def lasting(
        cls, order: int, period: float, periods: int, middle: Array, half: Array, centred: bool = False
    ) -> "FourierFamily":
        """The family whose motions last a number of periods; of order 1 two halves of one are run-in and run-out."""
        lead = order == 1
        return cls(order, period, periods - lead, middle, half, centred, period / 2 if lead else 0.0)

    name: ClassVar[str] = "fourier"
    iterations: ClassVar[int] = 30
    mending: ClassVar[int] = 20

    @property
    def settings(self) -> Settings:
        """Order, period and number of periods."""
        own = {"order": self.order, "period_s": self.period, "repeats": self.repeats, "centred": self.centred}
        return own | ({"run_in_s": self.run_in} if self.run_in else {})

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits."""
        unknowns = draw.normal(size=self.unknowns * len(self.middle))
        return np.asarray(unknowns * START_SHARE / worst(unknowns))

    def like(self, table: Array) -> Array | None:
        """Unknowns of the same series, of the same order."""
        fits = table.shape == (self.unknowns, len(self.middle)) and not (self.run_in or self.centred)
        return table.ravel() if fits else None

    @property
    def once(self) -> Self:
        """The family of one period, with the same run-in."""
        return replace(self, repeats=1)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of each coordinate."""
        return 2 * self.order + (1 if self.run_in else -1) - self.centred

    @property
    def _basis(self) -> Array:
        """Basis of the coefficients at rest, or of all with a run-in; `centred` omits the column that is x0 alone."""
        basis = np.eye(2 * self.order + 1) if self.run_in else resting_basis(self.order)
        if not self.centred:
            return basis
        return np.asarray(basis @ _null_space(basis[:1]))  # its first row is x0

    @property
    def grid(self) -> Array:
        """Instants at which the optimiser constrains the limits, shape (K,) [s].

        They cover one period, and before and after it the run-in and the run-out. Between two of them a limit of the
        series is exceeded by at most 1 - cos(pi / 24), 0.9 %, which the final scaling corrects.
        """
        lead, series = self._led, self._period
        return np.concatenate([lead, self.run_in + series, self.run_in + self.period * self.repeats + lead])

    @property
    def _period(self) -> Array:
        count = DENSITY * max(self.order, 2)
        return np.arange(count) * self.period / count

    @property
    def _led(self) -> Array:
        """Instants of the run-in, and of the run-out after its start."""
        count = int(np.ceil(len(self._period) * self.run_in / self.period))
        return (np.arange(count) + 0.5) * self.run_in / max(count, 1)

    def growth(self) -> float:
        """The bound N w by Bernstein's inequality for trigonometric polynomials of degree N [1/s].

        A limit on a derivative that N w times the limit before it cannot reach needs no rows of its own. A constant
        part does not move, so the bound holds for the oscillation, and the half width of the box bounds that. A run-in
        has no such bound.
        """
        if self.run_in:
            return float("inf")
        return 2 * np.pi * self.order / self.period

    def motion(self, unknowns: Array) -> FourierMotion:
        """The motion of the unknowns, shape (q n,), row by row."""
        # Unknowns of the basis are a_l / w and so on in units of the box: all of order one.
        w, values = 2 * np.pi / self.period, self._basis @ unknowns.reshape(self.unknowns, -1) * self.half
        a, b = values[1 : self.order + 1] * w, values[self.order + 1 :] * w
        return FourierMotion(self.middle + values[0], a, b, self.period, self.repeats, self.run_in)

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion, with the information at every second instant: enough for means at twice the highest frequency.

        There is no margin for excess between two rows: the final scaling corrects it.
        """
        limits, first = self.limit_maps(), np.arange(len(self.grid)) % FIRST == 0
        lead = np.full(len(self._led), self.run_in / max(len(self._led), 1))
        series = np.full(len(self._period), self.period * self.repeats / len(self._period))
        shares = np.concatenate([lead, series, lead])[first]
        rows = [(matrix, first) for matrix in limits]
        free = np.full(self.unknowns * len(self.middle), np.inf)
        return Layout(
            linear_states([matrix[first] for matrix in limits], self.middle, self.half, shares / shares.sum()),
            linear_states(limits, self.middle, self.half, np.zeros(len(first))),
            (first[None],) * 3,
            (linear_rows(self, case, margin, rows, np.zeros((2, len(self.middle))), self.growth()),),
            -free,
            free,
        )

    def limit_maps(self) -> tuple[Array, Array, Array, Array]:
        """Linear maps, each (K, q): unknowns of a coordinate -> it and its derivatives on the grid, in half widths."""
        q = self.unknowns  # coordinates here, of which each has one unknown that is 1
        unit = replace(self, middle=np.zeros(q), half=np.ones(q)).motion(np.eye(q).ravel()).at(self.grid)
        return unit.pose, unit.rates, unit.accelerations, unit.jerks
