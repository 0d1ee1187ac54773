"""Periodic Fourier-series excitation (34)-(36), from rest to rest.

x(t) = x0 + sum_l a_l/(l w) sin(l w t) - b_l/(l w) cos(l w t) for each coordinate. Rest at t = 0 (and so after every
period) is linear in the coefficients: sum a_l = 0 (rate) and sum l b_l = 0 (acceleration; a motion that starts out of a
standstill with bounded jerk starts without acceleration). The coefficients are therefore written as a basis of the null
space of these two rows, and no constraint is left to a solver.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import null_space

from cases.schema import Case
from identification.motion import Motion
from planner.families.family import Sampling
from planner.families.linear import linear_sampling

Array = NDArray[np.float64]

START_SHARE = 0.8  # random starts use this share of the tightest limit: significantly different from zero, inside
COARSE, FINE = 12, 16  # instants of the optimiser's grid in one period of the highest harmonic


@dataclass(frozen=True, slots=True)
class FourierMotion:
    """A Fourier-series motion, repeated a whole number of times.

    Args:
        centre: x0 of (34), shape (6,) [m, rad].
        a: sine coefficients of (34), shape (N, 6) [m/s, rad/s].
        b: cosine coefficients of (34), shape (N, 6) [m/s, rad/s].
        period: 2 pi / w [s].
        repeats: number of periods.
    """

    centre: Array
    a: Array
    b: Array
    period: float
    repeats: int

    @property
    def order(self) -> int:
        """N of (34)."""
        return len(self.a)

    @property
    def duration(self) -> float:
        """Duration of all periods [s]."""
        return self.period * self.repeats

    def at(self, t: ArrayLike) -> Motion:
        """(34), (35), (36) and the third derivative at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        w = 2 * np.pi / self.period * np.arange(1, self.order + 1)
        sine, cosine = np.sin(time[:, None] * w), np.cos(time[:, None] * w)
        pose = self.centre + sine @ (self.a / w[:, None]) - cosine @ (self.b / w[:, None])
        rates = cosine @ self.a + sine @ self.b
        accelerations = -sine @ (self.a * w[:, None]) + cosine @ (self.b * w[:, None])
        jerks = -cosine @ (self.a * w[:, None] ** 2) - sine @ (self.b * w[:, None] ** 2)
        return Motion(time, pose, rates, accelerations, jerks)


NEGLIGIBLE = 0.02  # of the largest amplitude; a harmonic below adds nothing that can be measured


def needless_harmonics(motion: FourierMotion) -> int:
    """Number of highest harmonics whose rates are negligible beside the largest, in every coordinate."""
    amplitude = np.hypot(motion.a, motion.b)
    share = (amplitude / np.maximum(amplitude.max(axis=0), 1e-300)).max(axis=1)
    return int(np.argmax(share[::-1] > NEGLIGIBLE))


def resting_basis(order: int) -> Array:
    """Basis of the coefficients (x0, a_1..a_N, b_1..b_N) that are at rest at t = 0, shape (2 N + 1, 2 N - 1)."""
    harmonics = np.arange(1, order + 1)
    rate_row = np.r_[0.0, np.ones(order), np.zeros(order)]
    acceleration_row = np.r_[0.0, np.zeros(order), harmonics]
    return np.asarray(null_space(np.vstack([rate_row, acceleration_row])))


@dataclass(frozen=True, slots=True)
class FourierFamily:
    """All Fourier motions of one order and period.

    Unknowns are `q = 2 N - 1` numbers for each coordinate: amplitudes in units of the pose limits.

    Args:
        order: N, from 2 (order 1 cannot rest) to 7.
        period: [s].
        repeats: number of periods.
        middle: middle of the box of poses, shape (6,) [m, rad].
        half: half of its width, shape (6,) [m, rad].
        density: instants of the optimiser's grid in one period of the highest harmonic.
        centred: whether x0 is the middle of the box, as in the paper; else it is free.
    """

    order: int
    period: float
    repeats: int
    middle: Array
    half: Array
    density: int
    centred: bool = False

    @property
    def name(self) -> str:
        """As the command line calls it."""
        return "fourier"

    @property
    def settings(self) -> dict[str, Any]:
        """Order, period and number of periods."""
        return {"order": self.order, "period_s": self.period, "repeats": self.repeats, "centred": self.centred}

    def sampling(self, case: Case) -> Sampling:
        """The motion as expressions."""
        return linear_sampling(case, self)

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits."""
        unknowns = draw.normal(size=self.unknowns * 6)
        return np.asarray(unknowns * START_SHARE / worst(unknowns))

    def shrunk(self, unknowns: Array, share: float) -> Array:
        """Smaller about the middle of the box."""
        return unknowns * share

    def refined(self, unknowns: Array) -> "FourierFamily":
        """On a finer grid."""
        return replace(self, density=FINE)

    @property
    def unknowns(self) -> int:
        """Unknowns of each coordinate."""
        return 2 * self.order - 1 - self.centred

    @property
    def _basis(self) -> Array:
        """Coefficients at rest; `centred` leaves out the one with nothing but x0."""
        basis = resting_basis(self.order)
        if not self.centred:
            return basis
        return np.asarray(basis @ null_space(basis[:1]))  # its first row is x0

    @property
    def grid(self) -> Array:
        """Instants at which the optimiser holds the limits, shape (K,) [s].

        Between two of them a limit slips by at most 1 - cos(pi / density), which the final scaling takes back.
        """
        count = self.density * self.order
        return np.arange(count) * self.period / count

    def struts(self) -> NDArray[np.bool_]:
        """Strut limits enter where they come close."""
        return np.zeros((2, len(self.grid)), dtype=bool)

    def critical_maps(self) -> tuple[Array, Array, Array]:
        """At the samples."""
        return self.maps()[:3]

    def slips(self) -> tuple[Array, Array]:
        """Nothing is left free: the final drawing back takes what slips."""
        return np.zeros(6), np.zeros(6)

    def growth(self) -> float:
        """N w: Bernstein's inequality for trigonometric polynomials of degree N [1/s].

        A limit on a derivative that N w times the limit before it cannot reach needs no rows of its own. A constant
        part does not move, so the bound holds for the oscillation, and the half width of the box bounds that.
        """
        return 2 * np.pi * self.order / self.period

    def _coefficients(self, unknowns: Array) -> tuple[Array, Array, Array]:
        w = 2 * np.pi / self.period * np.arange(1, self.order + 1)
        # Unknowns of the basis are a_l / w_1 and so on in units of the box: all of order one.
        values = self._basis @ unknowns.reshape(self.unknowns, 6) * self.half
        return values[0], values[1 : self.order + 1] * w[0], values[self.order + 1 :] * w[0]

    def motion(self, unknowns: Array) -> FourierMotion:
        """The motion of the unknowns, shape (q * 6,), row by row."""
        centre, a, b = self._coefficients(unknowns)
        return FourierMotion(self.middle + centre, a, b, self.period, self.repeats)

    def limit_maps(self) -> tuple[Array, Array, Array, Array]:
        """Limits are held on the grid; see `grid`."""
        return self.maps()

    def maps(self) -> tuple[Array, Array, Array, Array]:
        """Linear maps, each (K, q): unknowns of a coordinate -> it and its derivatives on the grid, in half widths."""
        basis, t = self._basis, self.grid
        w = 2 * np.pi / self.period * np.arange(1, self.order + 1)
        sine, cosine = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        one, zero = np.ones((len(t), 1)), np.zeros((len(t), 1))
        rows = (
            np.hstack([one, sine / w, -cosine / w]),
            np.hstack([zero, cosine, sine]),
            np.hstack([zero, -sine * w, cosine * w]),
            np.hstack([zero, -cosine * w**2, -sine * w**2]),
        )
        scale = np.r_[1.0, np.full(2 * self.order, w[0])]
        value, rate, acceleration, jerk = ((r * scale) @ basis for r in rows)
        return value, rate, acceleration, jerk
