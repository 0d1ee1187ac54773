"""Periodic Fourier-series excitation (34)-(36), from rest to rest.

x(t) = x0 + sum_l a_l/(l w) sin(l w t) - b_l/(l w) cos(l w t) for each coordinate. Rest at t = 0 (and so after every
period) is linear in the coefficients: sum a_l = 0 (rate) and sum l b_l = 0 (acceleration; a motion that starts out of a
standstill with bounded jerk starts without acceleration). The coefficients are therefore written as a basis of the null
space of these two rows, and the solver needs no constraint. Order 1 has no unknowns then: it has all of its
coefficients, and a quintic leads from rest in the middle of its ellipse into it and back (`run_in`).

Where w is free it is one more unknown. At the same phase of the period the pose does not depend on w; rates,
accelerations and jerks are in proportion to w, w^2 and w^3.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, NamedTuple, Self

import numpy as np

from cases.base.units import Array
from cases.schema import Case
from identification.motion.curves import FourierMotion
from planner.families.family import Family, Layout, linear_rows
from planner.families.plan_settings import FourierSettings
from planner.families.rows import PacedRows
from planner.families.states import PacedStates, linear_states

START_SHARE = 0.8  # random starts use this share of the tightest limit: significantly different from zero, inside
START_PACES = 1.25  # random starts have a base frequency that differs by this factor at most from that of their family
DENSITY = 24  # instants of the optimiser's grid in one period of the highest harmonic
FIRST = 2  # every second of them is constrained from the start, others where limits come close
ROUNDING = 1e-9  # of a number of periods


def _null_space(matrix: Array) -> Array:
    """Orthonormal basis of the null space of a matrix whose rows are independent."""
    return np.asarray(np.linalg.svd(matrix)[2][len(matrix) :].T)


def resting_basis(order: int) -> Array:
    """Basis of the coefficients (x0, a_1..a_N, b_1..b_N) that are at rest at t = 0, shape (2 N + 1, 2 N - 1)."""
    harmonics = np.arange(1, order + 1)
    rate_row = np.r_[0.0, np.ones(order), np.zeros(order)]
    acceleration_row = np.r_[0.0, np.zeros(order), harmonics]
    return _null_space(np.vstack([rate_row, acceleration_row]))


class FreePeriod(NamedTuple):
    """What a period may be that the optimiser chooses."""

    shortest: float  # [s]
    longest: float  # [s]
    duration: float  # most that all periods may take together [s]


@dataclass(frozen=True, slots=True)
class FourierFamily(Family):
    """All Fourier motions of one order, and of one period or of a free one.

    Unknowns are `q = 2 N - 1` amplitudes of each coordinate in units of the pose limits (one more of order 1, which has
    a run-in, one less with x0 fixed), and behind them w in units of its first value, where it is free.
    """

    order: int  # N, from 1 to 7; order 1 needs a run-in
    period: float  # [s]; where it is free, the first value
    repeats: int  # number of periods; where the period is free, at its first value
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]
    centred: bool = False  # whether x0 is the middle of the box, as in the paper; else it is free
    run_in: float = 0.0  # time from rest into the series and again out of it [s]; 0: the series itself begins at rest
    free: FreePeriod | None = None  # None where the period is fixed
    equal_start: bool = False  # whether the coefficients of every start are alike; else they are random
    duration: float = field(init=False)  # duration of the excitation [s]

    def __post_init__(self) -> None:
        object.__setattr__(self, "duration", self.period * self.repeats + 2.0 * self.run_in)

    @classmethod
    def lasting(
        cls,
        order: int,
        period: float,
        periods: int,
        middle: Array,
        half: Array,
        centred: bool = False,
        free: FreePeriod | None = None,
    ) -> "FourierFamily":
        """The family whose motions last a number of periods; of order 1 two halves of one are run-in and run-out."""
        lead = order == 1
        return cls(order, period, periods - lead, middle, half, centred, period / 2 if lead else 0.0, free)

    name: ClassVar[str] = "fourier"
    iterations: ClassVar[int] = 30
    refining: ClassVar[int] = 200
    mending: ClassVar[int] = 60

    @property
    def settings(self) -> FourierSettings:
        """Order, first period and number of periods."""
        return FourierSettings(
            order=self.order, period_s=self.period, repeats=self.repeats, run_in_s=self.run_in, centred=self.centred
        )

    def found(self, unknowns: Array) -> FourierSettings:
        """The same with the period that was found, where it was free."""
        if self.free is None:
            return self.settings
        motion = self.motion(unknowns)
        period_settings = {"period_s": motion.period, "repeats": motion.repeats, "run_in_s": motion.run_in}
        return self.settings.model_copy(update=period_settings)

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits, or those with all coefficients alike, in half widths."""
        count = len(self.middle)
        unknowns = draw.normal(size=self.unknowns * count)
        if self.equal_start:
            alike = np.concatenate([[0.0], np.ones(2 * self.order)])  # x0 stays in the middle
            unknowns = np.repeat(self._basis.T @ alike, count)
        if self.free is not None:
            pace = START_PACES ** draw.uniform(-1.0, 1.0)
            unknowns = np.append(unknowns, np.clip(pace, *self.paces))
        return self.shrunk(unknowns, START_SHARE / worst(unknowns))

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """The same with all distances times share, at the same period."""
        if self.free is None:
            return np.asarray(unknowns * share)
        return np.append(unknowns[:-1] * share, unknowns[-1])

    @property
    def once(self) -> Self:
        """The family of one period, with the same run-in."""
        return replace(self, repeats=1, free=None if self.free is None else self.free._replace(duration=0.0))

    @property
    def unknowns(self) -> int:
        """Number of amplitudes of each coordinate."""
        return 2 * self.order + (1 if self.run_in else -1) - self.centred

    @property
    def paces(self) -> tuple[float, float]:
        """Smallest and largest w in units of its first value."""
        return (1.0, 1.0) if self.free is None else (self.period / self.free.longest, self.period / self.free.shortest)

    @property
    def grid(self) -> Array:
        """Instants at which the optimiser constrains the limits at the first period, shape (K,) [s].

        They cover one period, and before and after it the run-in and the run-out. Between two of them a limit of the
        series is exceeded by at most 1 - cos(pi / 24), 0.9 %, which the final scaling corrects.
        """
        lead, series = self._lead, self._series
        return np.concatenate([lead, self.run_in + series, self.run_in + self.period * self.repeats + lead])

    @property
    def _series(self) -> Array:
        count = DENSITY * max(self.order, 2)
        return np.arange(count) * self.period / count

    @property
    def _lead(self) -> Array:
        """Instants of the run-in, and of the run-out after its start."""
        count = int(np.ceil(len(self._series) * self.run_in / self.period))
        return (np.arange(count) + 0.5) * self.run_in / max(count, 1)

    @property
    def _basis(self) -> Array:
        """Basis of the coefficients at rest, or of all with a run-in; `centred` leaves out those that move x0."""
        basis = np.eye(2 * self.order + 1) if self.run_in else resting_basis(self.order)
        return np.asarray(basis @ _null_space(basis[:1])) if self.centred else basis  # its first row is x0

    def motion(self, unknowns: Array) -> FourierMotion:
        """The motion of the unknowns: amplitudes row by row, shape (q n,), and w where it is free.

        Of a free period it lasts the largest whole number that fits into the duration.
        """
        period, run_in, repeats = self.period, self.run_in, self.repeats
        if self.free is not None:
            period, run_in = period / float(unknowns[-1]), run_in / float(unknowns[-1])
            repeats = max(1, int((self.free.duration - 2.0 * run_in) / period + ROUNDING))
            unknowns = unknowns[:-1]
        # Unknowns of the basis are a_l / w and so on in units of the box: all of order one.
        w, values = 2 * np.pi / period, self._basis @ unknowns.reshape(self.unknowns, -1) * self.half
        a, b = values[1 : self.order + 1] * w, values[self.order + 1 :] * w
        return FourierMotion(self.middle + values[0], a, b, period, repeats, run_in)

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion, with the information at every second instant: enough for means at twice the highest frequency.

        There is no margin for excess between two rows: the final scaling corrects it.
        """
        limits, first = self.limit_maps(), np.arange(len(self.grid)) % FIRST == 0
        lead = np.full(len(self._lead), self.run_in / max(len(self._lead), 1))
        series = np.full(len(self._series), self.period * self.repeats / len(self._series))
        shares = np.concatenate([lead, series, lead])[first]
        averaged = linear_states([matrix[first] for matrix in limits], self.middle, self.half, shares / shares.sum())
        critical = linear_states(limits, self.middle, self.half, np.zeros(len(first)))
        rows = [(matrix, first) for matrix in limits]
        box = linear_rows(self, case, margin, rows, np.zeros((2, len(self.middle))))
        bounds = np.full(self.unknowns * len(self.middle), np.inf)
        if self.free is None:
            return Layout(averaged, critical, (first[None],) * 3, (box,), -bounds, bounds)
        slowest, fastest = self.paces
        return Layout(
            PacedStates(averaged, len(self.middle)),
            PacedStates(critical, len(self.middle)),
            (first[None],) * 3,
            (PacedRows(box),),
            np.append(-bounds, slowest),
            np.append(bounds, fastest),
        )

    def limit_maps(self) -> tuple[Array, Array, Array, Array]:
        """Linear maps, each (K, q): amplitudes of a coordinate -> it and its derivatives on the grid, in half widths.

        Of a free period those at its first value.
        """
        q = self.unknowns  # coordinates here, of which each has one unknown that is 1
        unit = replace(self, middle=np.zeros(q), half=np.ones(q), free=None).motion(np.eye(q).ravel()).at(self.grid)
        return unit.coordinates, unit.rates, unit.accelerations, unit.jerks


def of_lower_order(motion: FourierMotion, order: int, middle: Array, half: Array) -> tuple[FourierFamily, Array]:
    """The resting series of a lower order, 2 or more, that is nearest to a motion, with one period: family, unknowns.

    Args:
        middle: middle of the box, shape (n,) [m or rad].
        half: half of its width, shape (n,) [m or rad].
    """
    w = 2 * np.pi / motion.period
    coefficients = np.vstack([motion.centre - middle, motion.a[:order] / w, motion.b[:order] / w]) / half
    return FourierFamily(order, motion.period, 1, middle, half), (resting_basis(order).T @ coefficients).ravel()
