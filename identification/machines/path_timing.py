"""A path re-timed under limits of coordinates and struts, by toppra (time-optimal path parameterisation).

The planned motion q(t) itself is the path, with s = t / duration in [0, 1] as its parameter. At rest dq/ds is zero, so
that any pace satisfies the limits there: the motion begins and ends at the planned pace, s' = 1 / duration, so that it
is smooth at its ends. Where the limits allow, the pace stays the planned one.

This method has no jerk limit: accelerations step where the pace changes from one extreme to the other.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import Code, HexciteError
from cases.base.units import Array
from cases.schema import Case
from identification.limits.limit import UNUSED_SHARE
from identification.machines.of_case import machine_of
from identification.motion.motion import Motion, Trajectory
from identification.motion.moves import UntimedMotion

STEPS_PER_SECOND = 400.0  # gridpoints of the path
FEWEST_STEPS = 2000
CHECK_RATE = 20_000.0  # [1/s] at which that is checked
ROUNDER = 5e-4  # a motion that must be stretched is stretched by this much more: peaks lie between instants too
AT_REST = 1e-6  # share of the rate limits

_NO_PACE = (
    "the path cannot be re-timed: no pace keeps all limits somewhere on it: it bends too sharply or leaves the "
    "machine's reach there"
)


@dataclass(frozen=True, slots=True)
class RetimedMotion:
    """A motion along a planned path at another pace; a `Trajectory`."""

    path: Trajectory
    shares: Array  # gridpoints of s = t / duration, shape (k,), from 0 to 1
    times: Array  # when the gridpoints are passed, shape (k,) [s]
    paces: Array  # s' there, shape (k,) [1/s]

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self.times[-1])

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]; s'' is constant between gridpoints.

        Jerks contain s''' as the slope between the middles of the steps of s'': where s'' really jumps, the jerk is
        larger, without bound.
        """
        time = np.asarray(t, dtype=float)
        step = np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.times) - 2)
        lengths = np.diff(self.times)
        slope = np.diff(self.paces) / lengths
        tau = time - self.times[step]
        pace, change = self.paces[step] + slope[step] * tau, slope[step]
        share = np.clip(self.shares[step] + self.paces[step] * tau + change * tau**2 / 2, 0.0, 1.0)
        middles = (self.times[:-1] + self.times[1:]) / 2
        rises = np.diff(slope) / np.diff(middles) if len(slope) > 1 else np.zeros(1)
        third = rises[np.clip(np.searchsorted(middles, time) - 1, 0, len(rises) - 1)]
        q = self.path.at(share * self.path.duration)
        first, second, last = (
            q.rates * self.path.duration,
            q.accelerations * self.path.duration**2,
            q.jerks * self.path.duration**3,
        )
        p, c, j = pace[:, None], change[:, None], third[:, None]
        return Motion(
            time, q.coordinates, first * p, second * p**2 + first * c, last * p**3 + 3.0 * second * p * c + first * j
        )


Shares = Callable[[Array, Array, Array], Array]
"""Pose, rates and accelerations, each (k, n) -> shares of further limits between -1 and 1, (k, r).

They are sums of a part of the pose, one that is quadratic in the rates and one that is linear in the accelerations, as
torques and forces are.
"""


def retime(path: Trajectory, case: Case, hurry: float = 1.0, forces: Shares | None = None) -> RetimedMotion:
    """The motion along a path inside the limits of rates and accelerations of coordinates and struts.

    Its pace, not its shape, is changed. A path that does not rest at an end gets its rest from the pace. Raises
    UntimedMotion where the path is not finite, or no pace satisfies the limits.

    Args:
        hurry: how many times its own pace the motion may have; at 1 it is never faster.
        forces: shares of limits of torques and forces.
    """
    try:
        from toppra.algorithm import TOPPRA  # takes 0.7 s to import
    except ImportError as error:
        raise HexciteError(
            problem="toppra, which times this path, is not installed",
            remedy="install it (pip install toppra; without a wheel for this computer it wants a compiler), or plan "
            "moves",
            code=Code.NOT_INSTALLED,
        ) from error

    steps = max(FEWEST_STEPS, int(np.ceil(path.duration * STEPS_PER_SECOND)))
    shares = np.linspace(0.0, 1.0, steps + 1)
    constraint, geometry = _constraint(path, case, shares, hurry, forces)
    solver = TOPPRA([constraint], geometry, gridpoints=shares, solver_wrapper="seidel")
    limits, fastest = case.need_motion("re-timing")[1], hurry / path.duration
    starts_at_rest, ends_at_rest = np.abs(path.at([0.0, path.duration]).rates / limits.rate).max(axis=1) <= AT_REST
    end = min(fastest, _largest_pace(solver.compute_feasible_sets()[-1])) if ends_at_rest else 0.0
    start = min(fastest, _largest_pace(solver.compute_controllable_sets(end, end)[0])) if starts_at_rest else 0.0
    if (starts_at_rest and not start > 0.0) or (ends_at_rest and not end > 0.0):
        raise UntimedMotion(_NO_PACE)
    solver.compute_parameterization(start, end)
    code, paces = solver.problem_data.return_code, solver.problem_data.sd_vec
    lengths = np.full(steps, np.nan) if paces is None else 2.0 * np.diff(shares) / (paces[:-1] + paces[1:])
    if code.name != "Ok" or not np.isfinite(lengths).all():
        raise UntimedMotion(_NO_PACE)
    motion = RetimedMotion(path, shares, np.concatenate([[0.0], np.cumsum(lengths)]), paces)
    # A motion that is slower than planned passes as much of its path between two instants as at the planned pace.
    count = int(np.ceil(min(motion.duration, path.duration * hurry) * CHECK_RATE)) + 1
    worst = _worst(motion.at(np.linspace(0.0, motion.duration, count)), case)  # between gridpoints
    slower = worst * (1.0 + ROUNDER) if worst > 1.0 else 1.0
    return RetimedMotion(path, shares, motion.times * slower, paces / slower)


QUADRATURE = 20  # parts of a window, by Simpson's rule


def rounded(motion: Trajectory, window: float, step: float) -> list[tuple[Array, float]]:
    """The mean of a motion over a sliding window, as quintic polynomials of equal length.

    A motion whose accelerations step becomes one whose accelerations change within the window. Rates and accelerations
    are means of those before, so that they exceed no limit of a coordinate; the path is rounded by an eighth of the
    acceleration times the square of the window, at most. It begins and ends at rest half a window earlier and later.

    Args:
        window: its length [s].
        step: length of a polynomial, at most [s].

    Returns:
        Coefficients c_0 to c_5, shape (6, n), and duration [s] of each.
    """
    duration = motion.duration + window
    count = max(1, int(np.ceil(duration / step)))
    times, length = np.linspace(0.0, duration, count + 1), duration / count
    first, last = (np.clip(times + shift, 0.0, motion.duration) for shift in (-window, 0.0))
    before, after = motion.at(first), motion.at(last)
    v, a = (after.coordinates - before.coordinates) / window, (after.rates - before.rates) / window
    weights = np.ones(QUADRATURE + 1)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    q = (
        sum(
            weight * motion.at(np.clip(times - window * k / QUADRATURE, 0.0, motion.duration)).coordinates
            for k, weight in enumerate(weights)
        )
        / weights.sum()
    )
    v, a = v * length, a * length**2
    way, rate, change = q[1:] - q[:-1] - v[:-1] - a[:-1] / 2, v[1:] - v[:-1] - a[:-1], a[1:] - a[:-1]
    higher = 10 * way - 4 * rate + change / 2, -15 * way + 7 * rate - change, 6 * way - 3 * rate + change / 2
    unit = q[:-1], v[:-1], a[:-1] / 2, *higher
    table = np.stack([c / length**power for power, c in enumerate(unit)], axis=1)
    return [(coefficients, length) for coefficients in table]


def keeps_pace(path: Trajectory, case: Case) -> bool:
    """Whether a motion satisfies the limits of rates and accelerations of coordinates and struts at its own pace."""
    rows = max(FEWEST_STEPS, int(np.ceil(path.duration * STEPS_PER_SECOND)))
    return _worst(path.at(np.linspace(0.0, path.duration, rows + 1)), case) <= 1.0 + 1e-6


def _worst(m: Motion, case: Case) -> float:
    """Largest share of the pace that a limit allows: of rates as they are, of accelerations by its root."""
    limits = case.need_motion("re-timing")[1]
    struts, most = machine_of(case).further_drives(case, m.coordinates, m.rates, m.accelerations)
    velocity, acceleration = (
        max(np.max(np.abs(coordinates) / limit), np.max(np.abs(values) / others, initial=0.0))
        for coordinates, limit, values, others in zip(
            (m.rates, m.accelerations), (limits.rate, limits.acceleration), struts, most, strict=True
        )
    )
    return max(float(velocity), float(np.sqrt(acceleration)))


def _largest_pace(squares: Array) -> float:
    """Largest s' of an interval of its square; 0 where there is none. A little less, for rounding."""
    return float(np.sqrt(max(0.0, squares[1]))) * (1.0 - 1e-6) if np.isfinite(squares).all() else 0.0


def _constraint(path: Trajectory, case: Case, shares: Array, hurry: float, forces: Shares | None) -> tuple[Any, Any]:
    """Limits of coordinates, struts and forces in toppra's form, and the path.

    With q the coordinates and l the strut lengths as functions of s: l' = l_s s', l'' = l_s s'' + l_ss s'^2. Forces are
    a s'' + b s'^2 + c.
    """
    from toppra import SplineInterpolator
    from toppra.constraint import DiscretizationType, LinearConstraint
    from toppra.constraint.linear_constraint import canlinear_colloc_to_interpolate

    limits = case.need_motion("re-timing")[1]
    motion = path.at(shares * path.duration)
    if not all(np.isfinite(v).all() for v in (motion.coordinates, motion.rates, motion.accelerations)):
        raise UntimedMotion("the path holds values that are not finite")
    ends = np.abs(motion.rates[[0, -1]]) / limits.rate
    if hurry == 1.0 and ends.max() > AT_REST:
        raise UntimedMotion(f"the path has {100 * ends.max():.3g} % of a rate limit at an end; it must rest there")
    by_share = (motion.rates * path.duration, motion.accelerations * path.duration**2)
    struts, most = machine_of(case).further_drives(case, motion.coordinates, *by_share)
    first, second = (np.hstack([coordinates, values]) for coordinates, values in zip(by_share, struts, strict=True))
    velocity, acceleration = (
        np.concatenate([coordinates, limit]) * (1.0 - UNUSED_SHARE)
        for coordinates, limit in zip((limits.rate, limits.acceleration), most, strict=True)
    )
    with np.errstate(divide="ignore"):
        squares = np.min((velocity / np.abs(first)) ** 2, axis=1)
    squares = np.minimum(squares, (hurry / path.duration * (1.0 + 1e-6)) ** 2)
    constant = np.zeros_like(first)
    if forces is not None:
        still = np.zeros_like(motion.coordinates)
        at_rest = forces(motion.coordinates, still, still)
        by_change = forces(motion.coordinates, still, by_share[0]) - at_rest
        by_square = forces(motion.coordinates, by_share[0], by_share[1]) - at_rest
        first, second, constant = (
            np.hstack(pair) for pair in ((first, by_change), (second, by_square), (constant, at_rest))
        )
        acceleration = np.concatenate([acceleration, np.full(at_rest.shape[1], 1.0 - UNUSED_SHARE)])

    class AllLimits(LinearConstraint):  # type: ignore[misc]
        """All limits at once, computed for all gridpoints in one go."""

        def __init__(self) -> None:
            super().__init__()
            self.identical = True
            self.set_discretization_type(DiscretizationType.Interpolation)

        def compute_constraint_params(self, _path: Any, gridpoints: Array) -> Any:
            """Coefficients of s'', s'^2 and 1, and the limits."""
            twice = np.vstack([np.eye(len(acceleration)), -np.eye(len(acceleration))])
            bounds = np.column_stack([np.zeros(len(gridpoints)), squares])
            both = np.concatenate([acceleration, acceleration])
            # Named the other way round there, but read as bounds of s'' first, of s'^2 second.
            return canlinear_colloc_to_interpolate(
                first, second, constant, twice, both, None, bounds, gridpoints, identical=True
            )

    # Of the path the solver asks the number of coordinates and the interval of s alone: the coefficients are above.
    return AllLimits(), SplineInterpolator([0.0, 1.0], motion.coordinates[[0, -1]])
