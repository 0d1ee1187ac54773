"""Time laws as controllers compute them online: jerk-limited, in whole controller cycles, by ruckig.

Ruckig is called for one move from rest to rest at a time. Its other features stay closed: intermediate waypoints are
computed by a service in the network, and vectors of wrong length are read out of bounds; neither can be reached here.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.trajectories.profile import StraightMove, limits_along

Array = NDArray[np.float64]

SAME = 1e-9  # relative: how well the coordinates of a straight move keep step in ruckig's answer


class UntimedMove(ValueError):
    """A move that cannot be timed; the message says why."""


@dataclass(frozen=True, slots=True)
class OnlineProfile:
    """Phases of constant jerk over the share of the way covered, from rest to rest; a `TimeLaw`."""

    lengths: Array  # lengths of the phases, shape (k,) [s]
    jerks: Array  # shape (k,) [1/s^3]
    duration: float  # duration in whole cycles: after the last phase the move rests until its cycle is over [s]

    @property
    def peak_velocity(self) -> float:
        """Largest velocity [1/s]."""
        return float(np.abs(self._knots()[2]).max())

    def slowed(self, speed: float) -> "OnlineProfile":
        """The same way at a share of the speed."""
        return OnlineProfile(self.lengths / speed, self.jerks * speed**3, self.duration / speed)

    def _knots(self) -> tuple[Array, Array, Array, Array]:
        """Starts of the phases and share, velocity and acceleration there, with the end as a last entry."""
        share, velocity, acceleration = [0.0], [0.0], [0.0]
        for t, j in zip(self.lengths, self.jerks, strict=True):
            s, v, a = share[-1], velocity[-1], acceleration[-1]
            share.append(s + v * t + a * t**2 / 2 + j * t**3 / 6)
            velocity.append(v + a * t + j * t**2 / 2)
            acceleration.append(a + j * t)
        starts = np.concatenate([[0.0], np.cumsum(self.lengths)])
        return starts, np.array(share), np.array(velocity), np.array(acceleration)

    def at(self, t: ArrayLike) -> tuple[Array, Array, Array, Array]:
        """Distance covered, velocity, acceleration and jerk at times t, each of shape (n,)."""
        starts, share, velocity, acceleration = self._knots()
        time = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        phase = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, len(self.jerks) - 1)
        tau, j = time - starts[phase], self.jerks[phase]
        s0, v0, a0 = share[phase], velocity[phase], acceleration[phase]
        s = s0 + v0 * tau + a0 * tau**2 / 2 + j * tau**3 / 6
        v, a = v0 + a0 * tau + j * tau**2 / 2, a0 + j * tau
        rest = (time >= starts[-1]) | (time >= self.duration)
        return (
            np.where(rest, 1.0, s),
            np.where(rest, 0.0, v),
            np.where(rest, 0.0, a),
            np.where(rest, 0.0, j),
        )


def online_move(
    start: ArrayLike, end: ArrayLike, rate: ArrayLike, acceleration: ArrayLike, jerk: ArrayLike, cycle: float
) -> StraightMove:
    """The straight move that a jerk-limited controller makes, all coordinates in step.

    Args:
        start: shape (n,) [m, rad].
        end: shape (n,), different from start [m, rad].
        rate: limits of the coordinates, shape (n,), above 0; infinity where there is none.
        acceleration: likewise.
        jerk: likewise.
        cycle: cycle of the controller; moves last whole cycles [s].

    Raises:
        UntimedMove: an argument has the wrong length, is not a number or out of range, or ruckig finds no profile.
    """
    shape = np.shape(start)
    ends = [_vector(name, value, shape) for name, value in (("start", start), ("end", end))]
    limits = [_limit(n, v, shape) for n, v in (("rate", rate), ("acceleration", acceleration), ("jerk", jerk))]
    way = np.abs(ends[1] - ends[0])
    if not way.any():
        raise UntimedMove("a move needs two different poses")
    with np.errstate(over="ignore"):
        velocity, peak, change = limits_along(way, *limits)
    return StraightMove(ends[0], ends[1], online_profile(velocity, peak, change, cycle))


def online_profile(velocity: float, acceleration: float, jerk: float, cycle: float) -> OnlineProfile:
    """The fastest time law over a way of 1 within three limits, in whole cycles.

    Args:
        velocity: limit [1/s].
        acceleration: limit [1/s^2].
        jerk: limit [1/s^3].
        cycle: cycle of the controller [s].

    Raises:
        UntimedMove: a limit is not a finite number above 0, or ruckig finds no profile.
    """
    from ruckig import DurationDiscretization, InputParameter, Result, Ruckig, RuckigError, Trajectory

    for name, value in (("velocity", velocity), ("acceleration", acceleration), ("jerk", jerk), ("cycle", cycle)):
        if not (np.isfinite(value) and value > 0.0):
            raise UntimedMove(f"{name} {value:g} is not a finite number above 0")
    request, answer = InputParameter(1), Trajectory(1)
    request.current_position, request.target_position = [0.0], [1.0]
    request.max_velocity, request.max_acceleration, request.max_jerk = [velocity], [acceleration], [jerk]
    request.duration_discretization = DurationDiscretization.Discrete
    try:
        result = Ruckig(1, cycle).calculate(request, answer)
    except RuckigError as error:
        raise UntimedMove(f"no time law within these limits ({' '.join(str(error).split())})") from error
    if result != Result.Working:
        raise UntimedMove(f"no time law within these limits (ruckig: {result.name})")
    phases = answer.profiles[0][0]
    valid = np.array(phases.t) > 0.0
    profile = OnlineProfile(np.array(phases.t)[valid], np.array(phases.j)[valid], float(answer.duration))
    if abs(profile._knots()[1][-1] - 1.0) > SAME or profile.duration < profile.lengths.sum() * (1.0 - SAME):
        raise UntimedMove("ruckig's time law does not cover the way: change the limits or the cycle slightly")
    return profile


def _vector(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    vector = np.array(value, dtype=float)
    if vector.ndim != 1 or vector.shape != shape:
        raise UntimedMove(f"{name} has shape {vector.shape}, expected {shape if len(shape) == 1 else '(n,)'}")
    if not np.isfinite(vector).all():
        raise UntimedMove(f"{name} holds values that are not finite")
    return vector


def _limit(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    limit = np.array(value, dtype=float)
    if limit.shape != shape:
        raise UntimedMove(f"{name} has shape {limit.shape}, expected {shape}")
    if np.isnan(limit).any() or not np.all(limit > 0.0):
        raise UntimedMove(f"{name} must be above 0 for every coordinate")
    return limit
