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
from planner.precision import SolverStatus

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

KNOT_DISTANCE = 0.05  # [s] of the planned time: limits of jerk let accelerations change in about that
POINTS = 4  # between two knots, at which the limits are constraints
SLOWEST = 0.01  # of the planned pace
ITERATIONS = 300
INTEGRATED = 4000.0  # [1/s] steps of the planned time in which the pace is integrated


@dataclass(frozen=True, slots=True)
class PathConstraints:
    """A path and the terms of its limits, at the points at which they are constraints."""

    s: Array  # places on the path, its own time, shape (n,) [s]
    first: Array  # derivatives of the c coordinates and the lengths of k struts with respect to s, shape (n, c + k)
    second: Array  # shape (n, c + k)
    third: Array  # third derivatives of the coordinates, shape (n, c)
    velocity: Array  # limits, shape (c + k,)
    acceleration: Array  # shape (c + k,)
    jerk: Array  # shape (c,)

    @classmethod
    def of(cls, path: Trajectory, case: Case, margin: float) -> "PathConstraints":
        """The constraints along a path.

        Args:
            path: path from rest to rest.
            margin: share of every limit that stays unused.
        """
        limits = case.need_motion("re-timing")[1]
        knots = _knots(path.duration)
        s = (knots[:-1, None] + np.diff(knots)[:, None] * (np.arange(POINTS) + 0.5) / POINTS).ravel()
        motion = path.at(s)
        struts, most = machine_of(case).further_drives(case, motion.pose, motion.rates, motion.accelerations)
        return cls(
            s,
            np.hstack([motion.rates, struts[0]]),
            np.hstack([motion.accelerations, struts[1]]),
            motion.jerks,
            np.concatenate([limits.rate, most[0]]) * (1.0 - margin),
            np.concatenate([limits.acceleration, most[1]]) * (1.0 - margin),
            limits.jerk * (1.0 - margin),
        )

    @property
    def own_pace(self) -> float:
        """The largest share of the path's own pace, the same all along, that satisfies all limits."""
        shares = [
            float((np.abs(values) / limit).max()) ** (1.0 / (order + 1))
            for order, (values, limit) in enumerate(
                ((self.first, self.velocity), (self.second, self.acceleration), (self.third, self.jerk))
            )
        ]
        return float(1.0 / max(*shares, 1e-9))


def _knots(duration: float) -> Array:
    return np.linspace(0.0, duration, max(20, int(np.ceil(duration / KNOT_DISTANCE))) + 1)


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


def paced(path: Trajectory, limits: PathConstraints, most: float, free: tuple[Array, Array]) -> PacedMotion:
    """The fastest motion along a path inside all kinetic limits, as IPOPT finds it from the largest constant pace.

    Args:
        most: largest pace, as a multiple of the planned one.
        free: shares of the limits of accelerations and of jerks that may be used at each point of the path, each of
            shape (n,), above 0 and at most 1.
    """
    from scipy.interpolate import BSpline

    knots = _knots(path.duration)
    basis = BSpline(np.concatenate([np.zeros(3), knots, np.full(3, path.duration)]), np.eye(len(knots) + 2), 3)
    at = [ca.sparsify(ca.DM(basis(limits.s, nu=order))) for order in range(3)]
    x = ca.MX.sym("x", basis.c.shape[0])
    p, slope, bend = (ca.mtimes(matrix, x) for matrix in at)
    change, third = p * slope, p * (slope**2 + p * bend)
    with np.errstate(divide="ignore"):
        fastest = np.minimum(most, np.min(limits.velocity / np.abs(limits.first), axis=1))
    rows = [p / ca.DM(fastest)]
    for k, limit in enumerate(limits.acceleration):
        one, two = (ca.DM(v[:, k] / (limit * free[0])) for v in (limits.first, limits.second))
        rows.append(two * p**2 + one * change)
    for k, limit in enumerate(limits.jerk):
        one, two, three = (ca.DM(v[:, k] / (limit * free[1])) for v in (limits.first, limits.second, limits.third))
        rows.append(three * p**3 + 3.0 * two * p * change + one * third)
    weights = np.full(len(limits.s), path.duration / len(limits.s))
    problem = {"x": x, "f": ca.dot(ca.DM(weights), 1.0 / p) / path.duration, "g": ca.vertcat(*rows)}
    options = {"ipopt": {"print_level": 0, "sb": "yes", "max_iter": ITERATIONS, "tol": 1e-6}, "print_time": False}
    solver = ca.nlpsol("pace", "ipopt", problem, options)
    begin = min(most, limits.own_pace * float(min(h.min() for h in free)))
    count = len(limits.s)
    low = np.concatenate([np.zeros(count), -np.ones((len(rows) - 1) * count)])
    answer = solver(x0=np.full(x.shape[0], begin), lbx=SLOWEST * begin, ubx=most, lbg=low, ubg=1.0)
    stats = solver.stats()
    solution = answer["x"].full()[:, 0]
    status = SolverStatus(stats["return_status"]).words
    if not np.isfinite(solution).all():
        solution, status = np.full(len(solution), begin), f"{status}; one pace all along"
    return PacedMotion(path, BSpline(basis.t, solution, 3), f"ipopt: {status}, {int(stats['iter_count'])} iterations")
