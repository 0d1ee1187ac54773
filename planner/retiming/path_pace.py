"""A path re-timed inside every limit, jerk too, as a cubic spline: the form that plans, programs and controllers take.

The pace is that of `planner.retiming.pacing`; the spline is the nearest to the motion at that pace. Where the spline
exceeds a limit between the points at which the pace was constrained, the limits there are tightened and the pace is
sought again; the excess after some rounds is removed by one slower pace for all. The spline is not the path:
`off_path` says how far it strays.
"""

from collections.abc import Callable

import numpy as np

from cases.errors import InfeasiblePlan
from cases.schema import Case
from identification.limit import TOLERANCE, LimitKind
from identification.limit_proof import kinetic_shares, prove
from identification.motion import Array, TimedPoints, Trajectory
from identification.trajectories.curves import PolynomialMotion
from planner.families.spline import in_pieces
from planner.retiming.pacing import POINTS, PacedMotion, constrained_places, paced
from planner.search.feasibility import MARGIN, remedy

STEP = 0.04  # [s] of the spline: four blocks of 10 ms, from which readers recognise a cubic spline
ROUNDS = 4
WATCHED = 2000.0  # [1/s] rate at which a round checks where limits are exceeded
SETTLED = 1e-3  # share of the duration: a round that gains less is the last
FASTEST = 5.0  # times the planned pace, where as fast as possible is asked for
LONGEST = 120.0  # [s] of a path: beyond that the search takes minutes
SLOWER = 1.02  # steps in which a motion is stretched whose sensor forces are too large
STRETCHES = 40
_FORCES = (LimitKind.SENSOR_FORCE, LimitKind.SENSOR_MOMENT, LimitKind.JOINT_TORQUE, LimitKind.JOINT_FORCE)


def retimed_path(
    path: Trajectory, case: Case, fastest: bool, progress: Callable[[str], None] = lambda _: None
) -> tuple[Trajectory, tuple[float, float], str]:
    """The path at the fastest pace inside all limits.

    Args:
        fastest: up to `FASTEST` times the planned pace; otherwise never faster than planned.

    Returns:
        The motion, proven inside all limits with a margin, or the path itself where its own pace is as good as any
        found; its largest distance from the path, of the position [m] and of an angle [rad]; the solver's status.

    Raises:
        InfeasiblePlan: no pace satisfies all limits; the message names the one that is exceeded.
    """
    if path.duration > LONGEST:
        raise InfeasiblePlan(
            f"a path of {path.duration:.0f} s is longer than the {LONGEST:g} s that this search takes; cut it"
        )
    limits, ends = case.need_motion("re-timing")[1], path.at([0.0, path.duration])
    moving = np.abs(ends.rates) / limits.rate
    if not moving.max() <= 1e-6:
        end = "begins" if not moving[0].max() <= 1e-6 else "ends"
        raise InfeasiblePlan(f"the path {end} at {100 * moving.max():.3g} % of a rate limit; it must be at rest there")
    own = not isinstance(path, TimedPoints) and prove(path, case).worst_ratio <= 1.0 - MARGIN + TOLERANCE
    if own and not fastest:
        return path, (0.0, 0.0), "its own pace keeps all limits"
    best, spline, slower = _search(path, case, FASTEST if fastest else 1.0, progress)
    if own and spline.duration * slower >= path.duration:
        return path, (0.0, 0.0), "its own pace is the fastest that was found"
    motion = _inside(spline, slower, case)
    t = np.linspace(0.0, motion.duration, int(motion.duration * WATCHED) + 2)
    off = motion.at(t).pose - path.at(best.places(t / motion.duration * spline.duration)).pose
    position = float(np.linalg.norm(off[:, ~limits.turns], axis=1).max())
    return motion, (position, float(np.abs(off[:, limits.turns]).max(initial=0.0))), best.solver


def _search(
    path: Trajectory, case: Case, most: float, report: Callable[[str], None]
) -> tuple[PacedMotion, PolynomialMotion, float]:
    """The best motion of some rounds, its spline, and by how much that must be slower."""
    points = constrained_places(path.duration)
    factors = np.ones(len(points)), np.ones(len(points))
    best, least = None, np.inf
    for number in range(ROUNDS):
        motion = paced(path, case, MARGIN, most, factors)
        spline = fitted_spline(motion, STEP)
        t = np.linspace(0.0, spline.duration, int(spline.duration * WATCHED) + 2)
        shares = kinetic_shares(spline, case, t)
        roots = [float(s.max()) ** (1.0 / order) for order, s in enumerate(shares, start=1)]
        slower = max(1.0, *roots) / (1.0 - MARGIN) if max(roots) > 1.0 - MARGIN else 1.0
        duration = spline.duration * slower
        report(f"round {number + 1}: {duration:.3f} s")
        gained = duration < least * (1.0 - SETTLED)
        if duration < least:
            best, least = (motion, spline, slower), duration
        if not gained or slower == 1.0:
            break
        places = motion.places(t)
        factors = factors[0] / _excess(shares[1], places, points), factors[1] / _excess(shares[2], places, points)
    assert best is not None
    return best


def _excess(shares: Array, places: Array, points: Array) -> Array:
    """Share of the worst limit near each point of the path, at least 1."""
    from scipy.ndimage import maximum_filter1d

    nearest = np.clip(np.round(places / (points[1] - points[0]) - 0.5).astype(int), 0, len(points) - 1)
    over = np.ones(len(points))
    np.maximum.at(over, nearest, shares / (1.0 - MARGIN))
    return np.asarray(maximum_filter1d(over, 2 * POINTS + 1))


def _inside(spline: PolynomialMotion, slower: float, case: Case) -> PolynomialMotion:
    """The spline at the slower pace that the proof at 10 kHz and the sensors' forces need.

    Raises:
        InfeasiblePlan: a limit is exceeded that no pace helps against.
    """
    for _ in range(STRETCHES):
        motion = spline.slowed(1.0 / slower)
        report = prove(motion, case)
        if report.worst_ratio <= 1.0 - MARGIN + TOLERANCE:
            return motion
        worst = max(report.checks, key=lambda c: c.ratio)
        if not worst.kind.kinetic:
            if report.kept:  # inside, with less than the margin: the path itself has no more
                return motion
            break
        slower *= SLOWER if worst.kind in _FORCES else 1.0 + 2e-4
    raise InfeasiblePlan(f"no pace keeps this path inside all limits: {worst.sentence()}; {remedy(worst, case)}")


SAMPLES = 8  # poses of each interval to which the spline is fitted


def fitted_spline(motion: Trajectory, step: float) -> PolynomialMotion:
    """The cubic spline over equal intervals that is nearest to a motion in the mean square of its poses.

    It begins and ends at the motion's ends, with rates and accelerations zero there. Its jerk is constant in each
    interval.

    Args:
        step: largest length of an interval [s].
    """
    from scipy.interpolate import BSpline
    from scipy.sparse.linalg import spsolve

    count = max(8, int(np.ceil(motion.duration / step - 1e-9)))
    length = motion.duration / count
    begins: Array = np.asarray(np.arange(count) * length, dtype=np.float64)
    knots = np.concatenate([np.zeros(3), begins, np.full(4, motion.duration)])
    t = np.linspace(0.0, motion.duration, SAMPLES * count + 1)
    poses = motion.at(t).pose
    basis = BSpline.design_matrix(t, knots, 3).tocsc()
    fixed = np.repeat(poses[[0, -1]], 3, axis=0)  # three equal coefficients at an end: no rate, no acceleration
    inner, outer = basis[:, 3:-3], basis[:, [0, 1, 2, -3, -2, -1]]
    free = spsolve((inner.T @ inner).tocsc(), inner.T @ (poses - outer @ fixed))
    spline = BSpline(knots, np.concatenate([fixed[:3], free, fixed[3:]]), 3)
    return in_pieces(spline, begins, length)
