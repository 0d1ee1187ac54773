"""The largest sensor forces of a motion of which only the way and the controller's limits are known.

No controller limits sensor forces. But where it limits velocities and accelerations, no time law of its own can
exceed these: f = b (p'' - g) + d alpha + omega Q omega, with b, d and Q constant in the axes of the platform.
"""

from itertools import combinations

import numpy as np

from cases.chain import Box
from identification.limit import Limit, LimitCheck, LimitKind, Status
from identification.limit_proof import limited_machine
from identification.motion import Array, Motion, Trajectory
from identification.overload import Loads
from identification.trajectories.moves import CircularMove, StraightMove, limits_along

SAMPLES = 64  # samples of a move: forces change with the pose alone, by less than a hundredth between two of them
PATH_SAMPLES = 1000  # samples of a timed path


def steady(move: StraightMove | CircularMove, speed: float) -> Motion:
    """The way of a move at one speed from end to end [1/s], which no law below it exceeds anywhere, at 65 instants."""
    t = np.linspace(0.0, 1.0 / speed, SAMPLES + 1)
    none = np.zeros_like(t)
    return move.along(t, (t * speed, none + speed, none, none))


def forces_anywhere(loads: Loads, share: float = 1.0) -> tuple[LimitCheck, ...]:
    """Bounds for any pose, with a share of the limits; empty for struts, whose forces depend on the pose."""
    if loads.case.sensor_frame.struts is not None:
        return ()
    machine, limits = limited_machine(loads.case), _limits(loads)
    linear, angular, spin = np.split(loads.coefficients, (3, 6), axis=1)
    omega, alpha, pull = machine.fastest(share * limits.rate, share * limits.acceleration)
    pull += float(np.linalg.norm(loads.case.gravity))
    most = np.linalg.norm(linear, axis=1) * pull + np.linalg.norm(angular, axis=1) * alpha
    products = spin.reshape(-1, 3, 3)
    most += np.abs(np.linalg.eigvalsh(products + products.transpose(0, 2, 1))).max(axis=1) / 2 * omega**2
    return _checks(loads, most[None], np.zeros(1))


def forces_on(loads: Loads, path: Trajectory) -> tuple[LimitCheck, ...]:
    """Bounds at the poses of a path, whatever the motion along it or beside it.

    Forces are linear in accelerations and products of rates, whose coefficients unit ones show.
    """
    limits, times = _limits(loads), np.linspace(0.0, path.duration, PATH_SAMPLES)
    pose = path.at(times).pose
    axes, none = np.eye(6), np.zeros_like(pose)

    def at(rates: Array, accelerations: Array = none) -> Array:
        rate, acceleration = (np.array(np.broadcast_to(v, pose.shape)) for v in (rates, accelerations))
        return _forces(loads, Motion(times, pose.copy(), rate, acceleration, none.copy()))

    still = at(none)
    most = np.abs(still)
    squares, odd = np.zeros((2, 6, *still.shape))
    for k, (rate, acceleration) in enumerate(zip(limits.rate, limits.acceleration, strict=True)):
        forth, back = at(axes[k]), at(-axes[k])
        squares[k], odd[k] = (forth + back) / 2.0 - still, (forth - back) / 2.0
        most += np.abs(at(none, axes[k]) - still) * acceleration + np.abs(squares[k]) * rate**2
        most += np.abs(odd[k]) * rate
    for i, j in combinations(range(6), 2):
        both = at(axes[i] + axes[j]) - odd[i] - odd[j] - squares[i] - squares[j] - still
        most += np.abs(both) * limits.rate[i] * limits.rate[j]
    return _checks(loads, most, times)


def forces_along(loads: Loads, move: StraightMove | CircularMove, feed: float | None) -> tuple[LimitCheck, ...]:
    """Bounds for a move at any speed and acceleration along its way: forces are affine in s'^2 and s''.

    Friction forces in struts change sign with s', and are at most those at s' = 1 or in proportion to s'. `feed` is
    the largest speed of the share of the way, besides the limits [1/s].
    """
    way = steady(move, 1.0)
    none = np.zeros_like(way.pose)
    pose, tangent, bend = way.pose.copy(), way.rates.copy(), way.accelerations.copy()
    standing, forth, back, starting = (
        _forces(loads, Motion(way.t, pose, *values, none))
        for values in ((none, none), (tangent, bend), (-tangent, bend), (none, tangent))
    )
    speed, acceleration = _fastest(move, tangent, bend, _limits(loads))
    fastest = min(speed, np.inf if feed is None else feed)
    turning = (forth + back) / 2.0 - standing
    most = np.maximum(np.abs(standing), np.abs(standing + fastest**2 * turning))
    most += np.abs(forth - back) / 2.0 * max(fastest, 1.0)
    return _checks(loads, most + acceleration * np.abs(starting - standing), way.t * move.duration)


def _limits(loads: Loads) -> Box:
    """Limits of rates and accelerations, which the controller enforces."""
    return loads.case.need_motion("the check of a program")[1]


def _forces(loads: Loads, motion: Motion) -> Array:
    return loads.forces(motion, *limited_machine(loads.case).mechanics(motion)[0])


def _checks(loads: Loads, most: Array, times: Array) -> tuple[LimitCheck, ...]:
    """The worst force, and the worst moment where moments have a range."""
    checks = []
    for own, kind in ((~loads.moments, LimitKind.SENSOR_FORCE), (loads.moments, LimitKind.SENSOR_MOMENT)):
        if own.any():
            shares = np.where(own, most / loads.limit, 0.0)
            row, k = np.unravel_index(int(np.argmax(shares)), shares.shape)
            worst, limit, ratio = float(most[row, k]), float(loads.limit[k]), float(shares[row, k])
            place, time = f"{loads.labels[k]}, at most", float(times[row])
            checks.append(LimitCheck(Limit(kind), place, worst, limit, kind.unit, ratio, time, Status.PROVEN))
    return tuple(checks)


def _fastest(move: StraightMove | CircularMove, tangent: Array, bend: Array, limits: Box) -> tuple[float, float]:
    """Largest speed and acceleration of the share of the way under the limits of each coordinate [1/s, 1/s^2]."""
    way = np.abs(tangent).max(axis=0)
    rates, accelerations = limits.rate.copy(), limits.acceleration.copy()
    if isinstance(move, CircularMove):
        plane = list(move.plane.axes[:2])
        for values in (rates, accelerations):
            values[plane] = float(np.hypot(*values[plane]))  # either axis may carry all of it
    speed, acceleration = limits_along(way, rates, accelerations)
    bends = np.abs(bend).max(axis=0)
    turning = float(np.min(np.append(accelerations[bends > 0.0] / bends[bends > 0.0], np.inf)))
    return min(speed, float(np.sqrt(turning))), acceleration
