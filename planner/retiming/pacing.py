"""The fastest pace along a path inside every limit of rates, accelerations and jerks: a small control problem.

The path is the planned motion q(s) itself, s its own time. Wanted is the pace p(s) = ds/dt that minimises the
duration, the integral of ds / p. With primes for derivatives with respect to s,

    q_t = q' p,    q_tt = q'' p^2 + q' p p',    q_ttt = q''' p^3 + 3 q'' p^2 p' + q' p (p'^2 + p p''),

and the same for the struts. p is a cubic B-spline, so that jerks stay finite; toppra's answer to the problem without
the third equation has steps in p'.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from cases.schema import Case
from identification.model import machine_of
from identification.motion import Array, Motion, Trajectory
from planner.search import SolverStatus

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

KNOT_DISTANCE = 0.05  # [s] of the planned time: limits of jerk let accelerations change in about that
POINTS = 4  # between two knots, at which the limits are constraints
SLOWEST = 0.01  # of the planned pace
ITERATIONS = 300
INTEGRATED = 4000.0  # [1/s] steps of the planned time in which the pace is integrated


def _knots(duration: float) -> Array:
    return np.linspace(0.0, duration, max(20, int(np.ceil(duration / KNOT_DISTANCE))) + 1)


def constrained_places(duration: float) -> Array:
    """Places on a path at which its limits are constraints, in its own time, equally far apart, shape (n,) [s]."""
    knots = _knots(duration)
    return np.asarray((knots[:-1, None] + np.diff(knots)[:, None] * (np.arange(POINTS) + 0.5) / POINTS).ravel())


@dataclass(frozen=True)
class PacedMotion:
    """A motion along a path at another pace, with finite jerks; a `Trajectory`."""

    path: Trajectory
    pace: "BSpline"  # p over the planned time
    solver: str  # status of the optimiser

    @cached_property
    def _clock(self) -> tuple[Array, Array]:
        """Times and places on the path, both increasing."""
        s = np.linspace(0.0, self.path.duration, max(64, int(self.path.duration * INTEGRATED)) + 1)
        middle = 1.0 / self.pace((s[1:] + s[:-1]) / 2)
        ends = 1.0 / self.pace(s)
        steps = (ends[:-1] + 4.0 * middle + ends[1:]) * np.diff(s) / 6.0  # Simpson's rule
        return np.concatenate([[0.0], np.cumsum(steps)]), s

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return float(self._clock[0][-1])

    def places(self, t: ArrayLike) -> Array:
        """Places on the path at times t: planned times, shape (n,) [s]."""
        from scipy.interpolate import CubicHermiteSpline

        times, s = self._clock
        places = CubicHermiteSpline(times, s, self.pace(s))(np.clip(np.asarray(t, dtype=float), 0.0, times[-1]))
        return np.asarray(np.clip(places, 0.0, self.path.duration))

    def at(self, t: ArrayLike) -> Motion:
        """The motion at times t, shape (n,) [s]."""
        time = np.asarray(t, dtype=float)
        s = self.places(time)
        q = self.path.at(s)
        p, slope, bend = (self.pace(s, nu=order)[:, None] for order in range(3))
        change, third = p * slope, p * (slope**2 + p * bend)  # second and third time derivative of s
        return Motion(
            time,
            q.pose,
            q.rates * p,
            q.accelerations * p**2 + q.rates * change,
            q.jerks * p**3 + 3.0 * q.accelerations * p * change + q.rates * third,
        )


def paced(path: Trajectory, case: Case, margin: float, most: float, free: tuple[Array, Array]) -> PacedMotion:
    """The fastest motion along a path inside all kinetic limits, as IPOPT finds it from the largest constant pace.

    Args:
        path: path from rest to rest.
        margin: share of every limit that stays unused.
        most: largest pace, as a multiple of the planned one.
        free: shares of the limits of accelerations and of jerks that may be used at each of `constrained_places`, each
            of shape (n,), above 0 and at most 1.
    """
    from scipy.interpolate import BSpline

    limits, s = case.need_motion("re-timing")[1], constrained_places(path.duration)
    motion = path.at(s)
    struts, of_struts = machine_of(case).further_drives(case, motion.pose, motion.rates, motion.accelerations)
    # derivatives of coordinates and struts with respect to s, shapes (n, c + k); third ones of the coordinates alone
    first, second = np.hstack([motion.rates, struts[0]]), np.hstack([motion.accelerations, struts[1]])
    velocity = np.concatenate([limits.rate, of_struts[0]]) * (1.0 - margin)
    acceleration = np.concatenate([limits.acceleration, of_struts[1]]) * (1.0 - margin)
    jerk = limits.jerk * (1.0 - margin)
    pairs = (first, velocity), (second, acceleration), (motion.jerks, jerk)
    shares = [float((np.abs(values) / limit).max()) for values, limit in pairs]
    # the largest share of the planned pace, the same all along, that is inside all limits
    own_pace = 1.0 / max(1e-9, *(share ** (1.0 / order) for order, share in enumerate(shares, start=1)))
    knots = _knots(path.duration)
    basis = BSpline(np.concatenate([np.zeros(3), knots, np.full(3, path.duration)]), np.eye(len(knots) + 2), 3)
    at = [ca.sparsify(ca.DM(basis(s, nu=order))) for order in range(3)]
    x = ca.MX.sym("x", basis.c.shape[0])
    p, slope, bend = (ca.mtimes(matrix, x) for matrix in at)
    change, third = p * slope, p * (slope**2 + p * bend)
    with np.errstate(divide="ignore"):
        fastest = np.minimum(most, np.min(velocity / np.abs(first), axis=1))
    rows = [p / ca.DM(fastest)]
    for k, limit in enumerate(acceleration):
        one, two = (ca.DM(v[:, k] / (limit * free[0])) for v in (first, second))
        rows.append(two * p**2 + one * change)
    for k, limit in enumerate(jerk):
        one, two, three = (ca.DM(v[:, k] / (limit * free[1])) for v in (first, second, motion.jerks))
        rows.append(three * p**3 + 3.0 * two * p * change + one * third)
    count = len(s)
    problem = {"x": x, "f": ca.sum1(1.0 / p) / count, "g": ca.vertcat(*rows)}
    options = {"ipopt": {"print_level": 0, "sb": "yes", "max_iter": ITERATIONS, "tol": 1e-6}, "print_time": False}
    solver = ca.nlpsol("pace", "ipopt", problem, options)
    begin = min(most, own_pace * float(min(h.min() for h in free)))
    low = np.concatenate([np.zeros(count), -np.ones((len(rows) - 1) * count)])
    answer = solver(x0=np.full(x.shape[0], begin), lbx=SLOWEST * begin, ubx=most, lbg=low, ubg=1.0)
    stats = solver.stats()
    solution = answer["x"].full()[:, 0]
    status = SolverStatus(stats["return_status"]).words
    if not np.isfinite(solution).all():
        solution, status = np.full(len(solution), begin), f"{status}; one pace all along"
    return PacedMotion(path, BSpline(basis.t, solution, 3), f"ipopt: {status}, {int(stats['iter_count'])} iterations")
