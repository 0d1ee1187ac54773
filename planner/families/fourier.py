"""Periodic Fourier-series excitation (34)-(36), from rest to rest.

x(t) = x0 + sum_l a_l/(l w) sin(l w t) - b_l/(l w) cos(l w t) for each coordinate. Rest at t = 0 (and so after every
period) is linear in the coefficients: sum a_l = 0 (rate) and sum l b_l = 0 (acceleration; a motion that starts out of a
standstill with bounded jerk starts without acceleration). The coefficients are therefore written as a basis of the null
space of these two rows, and the solver needs no constraint. Order 1 would stand still.
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


def resting_basis(order: int) -> Array:
    """Basis of the coefficients (x0, a_1..a_N, b_1..b_N) that are at rest at t = 0, shape (2 N + 1, 2 N - 1)."""
    from scipy.linalg import null_space  # every command that reads a plan loads this module

    harmonics = np.arange(1, order + 1)
    rate_row = np.r_[0.0, np.ones(order), np.zeros(order)]
    acceleration_row = np.r_[0.0, np.zeros(order), harmonics]
    return np.asarray(null_space(np.vstack([rate_row, acceleration_row])))


@dataclass(frozen=True, slots=True)
class FourierFamily(Family):
    """All Fourier motions of one order and period.

    Unknowns are `q = 2 N - 1` amplitudes of each coordinate in units of the pose limits.
    """

    order: int  # N, from 2 to 7
    period: float  # [s]
    repeats: int  # number of periods
    middle: Array  # middle of the box of coordinates, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]
    duration: float = field(init=False)  # duration of the excitation [s]

    def __post_init__(self) -> None:
        object.__setattr__(self, "duration", self.period * self.repeats)

    name: ClassVar[str] = "fourier"
    iterations: ClassVar[int] = 30
    mending: ClassVar[int] = 20

    @property
    def settings(self) -> Settings:
        """Order, period and number of periods."""
        return {"order": self.order, "period_s": self.period, "repeats": self.repeats}

    def start(self, draw: np.random.Generator, worst: Callable[[Array], float]) -> Array:
        """Random unknowns well inside the limits."""
        unknowns = draw.normal(size=self.unknowns * len(self.middle))
        return np.asarray(unknowns * START_SHARE / worst(unknowns))

    @property
    def once(self) -> Self:
        """The family of one period."""
        return replace(self, repeats=1)

    @property
    def unknowns(self) -> int:
        """Number of unknowns of each coordinate."""
        return 2 * self.order - 1

    @property
    def grid(self) -> Array:
        """Instants at which the optimiser constrains the limits, shape (K,) [s].

        They cover one period. Between two of them a limit is exceeded by at most 1 - cos(pi / 24), 0.9 %, which the
        final scaling corrects.
        """
        count = DENSITY * self.order
        return np.arange(count) * self.period / count

    def motion(self, unknowns: Array) -> FourierMotion:
        """The motion of the unknowns, shape (q n,), row by row."""
        # Unknowns of the basis are a_l / w and so on in units of the box: all of order one.
        w, values = 2 * np.pi / self.period, resting_basis(self.order) @ unknowns.reshape(self.unknowns, -1) * self.half
        a, b = values[1 : self.order + 1] * w, values[self.order + 1 :] * w
        return FourierMotion(self.middle + values[0], a, b, self.period, self.repeats)

    def layout(self, case: Case, margin: float) -> Layout:
        """The motion, with the information at every second instant: enough for means at twice the highest frequency.

        There is no margin for excess between two rows: the final scaling corrects it.
        """
        limits, first = self.limit_maps(), np.arange(len(self.grid)) % FIRST == 0
        shares = np.full(first.sum(), 1.0 / first.sum())
        rows = [(matrix, first) for matrix in limits]
        free = np.full(self.unknowns * len(self.middle), np.inf)
        return Layout(
            linear_states([matrix[first] for matrix in limits], self.middle, self.half, shares),
            linear_states(limits, self.middle, self.half, np.zeros(len(first))),
            (first[None],) * 3,
            (linear_rows(self, case, margin, rows, np.zeros((2, len(self.middle)))),),
            -free,
            free,
        )

    def limit_maps(self) -> tuple[Array, Array, Array, Array]:
        """Linear maps, each (K, q): unknowns of a coordinate -> it and its derivatives on the grid, in half widths."""
        q = self.unknowns  # coordinates here, of which each has one unknown that is 1
        unit = replace(self, middle=np.zeros(q), half=np.ones(q)).motion(np.eye(q).ravel()).at(self.grid)
        return unit.pose, unit.rates, unit.accelerations, unit.jerks
