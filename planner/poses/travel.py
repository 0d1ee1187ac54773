"""Travel times between poses: straight moves from rest to rest.

Moves satisfy every limit of `[limits.motion]` that concerns velocity, acceleration and jerk; where a strut would be too
fast or a sensor overloaded, the whole move is slowed. On the way the machine must be able to stand at every place.
"""

from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from cases.base.errors import Code, InfeasiblePlan
from cases.schema import Case
from identification.limits.limit import UNUSED_SHARE
from identification.limits.proof import slowed_for_forces
from identification.machines.of_case import machine_of
from identification.motion.motion import Array
from identification.motion.moves import Profile, StraightMove, fastest_profile
from planner.poses.space import valid_poses

INSTANTS = 161  # instants of a move at which its struts are checked
COARSE = 17  # the same where the pairs of poses are so many that only their order matters
MANY_PAIRS = 5000
LIKE = 9  # decimals to which limits over the way agree [1/s, 1/s^2, 1/s^3] where moves have one time law
CHUNK = 10_000  # pairs at once: limits the memory


def fastest_move(case: Case, start: Array, end: Array) -> StraightMove:
    """The fastest straight move between two poses, shapes (n,), within all limits, those of forces included."""
    limits = case.need_motion("moves between poses")[1]
    box = (limit * (1.0 - UNUSED_SHARE) for limit in (limits.rate, limits.acceleration, limits.jerk))
    move = StraightMove.fastest(start, end, *box)
    slowness = float(_slowness(case, start[None], end[None], _laws([move.profile], INSTANTS))[0])
    profile = move.profile.slowed(min(1.0, 1.0 / max(slowness, 1e-9)))
    return slowed_for_forces(StraightMove(start, end, profile), case)


def travel_times(case: Case, poses: Array) -> Array:
    """Duration of the fastest move between each two poses, infinite without a valid way, shape (n, n) [s].

    For more than a hundred poses, shape (n, k), struts are checked in few places: enough for an order, not for a proof.
    """
    limits = case.need_motion("moves between poses")[1]
    pairs = np.array(list(combinations(range(len(poses)), 2)), dtype=int).reshape(-1, 2)
    start, end = poses[pairs[:, 0]], poses[pairs[:, 1]]
    way = np.maximum(np.abs(end - start), 1e-12)
    box = (limit * (1.0 - UNUSED_SHARE) for limit in (limits.rate, limits.acceleration, limits.jerk))
    rows = np.column_stack([(limit / way).min(axis=1) for limit in box])
    # Poses of a grid are the same ways apart: 115 440 pairs of the paper's 480 need 91 time laws.
    _, indices, law = np.unique(rows.round(LIKE), axis=0, return_index=True, return_inverse=True)
    profiles = [fastest_profile(1.0, *map(float, row)) for row in rows[indices]]
    durations = np.array([profile.duration for profile in profiles])[law]
    instants = INSTANTS if len(pairs) <= MANY_PAIRS else COARSE
    laws = _laws(profiles, instants)
    for first in range(0, len(pairs), CHUNK):
        block = slice(first, first + CHUNK)
        durations[block] *= np.maximum(_slowness(case, start[block], end[block], laws[law[block]]), 1.0)
        share = np.linspace(0.0, 1.0, instants)[:, None]
        places = start[block][:, None, :] + share * (end - start)[block][:, None, :]
        valid = valid_poses(case, places.reshape(-1, start.shape[1])).reshape(len(places), -1)
        durations[block][~valid.all(axis=1)] = np.inf
    times = np.zeros((len(poses), len(poses)))
    times[pairs[:, 0], pairs[:, 1]] = times[pairs[:, 1], pairs[:, 0]] = durations
    return times


def require_ways(times: Array, order: NDArray[np.int64]) -> None:
    """Raises InfeasiblePlan, naming the poses, where a way does not exist: infinite in times, shape (n, n) [s]."""
    for a, b in pairwise(order):
        if not np.isfinite(times[a, b]):
            raise InfeasiblePlan(
                problem=f"there is no straight way from pose {a} to pose {b} inside the workspace (0 is home)",
                remedy="choose other poses or widen the workspace",
                code=Code.INFEASIBLE,
            )


def _laws(profiles: list[Profile], instants: int) -> Array:
    """Share of the way, its rate and acceleration, shape (n, 3, instants + 6) [1, 1/s, 1/s^2].

    At equal steps, and at the corners of each profile, where velocity and acceleration peak.
    """
    laws = []
    for profile in profiles:
        steps, corners = np.linspace(0.0, profile.duration, instants), np.cumsum(profile.lengths[:-1])
        laws.append(profile.at(np.sort(np.r_[steps, corners]))[:3])
    return np.array(laws)


def _slowness(case: Case, start: Array, end: Array, laws: Array) -> Array:
    """Factor by which each move, with its law of `_laws`, must be slowed for the struts, else below 1, shape (n,)."""
    way = (end - start)[:, None, :]
    pose = start[:, None, :] + laws[:, 0, :, None] * way
    rates, accelerations = (laws[:, k, :, None] * way for k in (1, 2))
    struts, most = machine_of(case).further_drives(
        case, *(np.ascontiguousarray(v.reshape(-1, way.shape[2])) for v in (pose, rates, accelerations))
    )
    fast, hard = (
        (np.abs(values) / limit).reshape(len(start), -1).max(axis=1, initial=0.0)
        for values, limit in zip(struts, most, strict=True)
    )
    return np.asarray(np.maximum(fast, np.sqrt(hard)) / (1.0 - UNUSED_SHARE))


STARTS = 12  # first poses that are tried
GAIN = 1e-9  # [s] smallest gain: below it rounding would reverse stretches without end


def shortest_order(times: Array) -> NDArray[np.int64]:
    """Order of visit, starting and ending with 0 (home), shape (n + 1,): tours of nearest neighbours, made 2-optimal.

    Of times, symmetric, shape (n, n), n >= 2 [s]; infinite without a valid way.
    """
    finite = np.where(np.isfinite(times), times, 1e6)
    count = len(times)
    firsts = np.argsort(finite[0, 1:])[:: max(1, (count - 1) // STARTS)][:STARTS] + 1
    tours = [_improved(_nearest(finite, int(first)), finite) for first in firsts]
    return min(tours, key=lambda tour: (duration(tour, finite), tuple(tour)))


def duration(order: NDArray[np.int64], times: Array) -> float:
    """Time of travel in an order [s], from the times between places, shape (n, n) [s]."""
    return float(times[order[:-1], order[1:]].sum())


def _nearest(times: Array, first: int) -> NDArray[np.int64]:
    tour, rest = [0, first], set(range(1, len(times))) - {first}
    while rest:
        following = min(rest, key=lambda k: (times[tour[-1], k], k))
        tour.append(following)
        rest.remove(following)
    return np.array([*tour, 0])


def _improved(tour: NDArray[np.int64], times: Array) -> NDArray[np.int64]:
    """The tour after reversals of a stretch i+1 .. j, the best one first, until none makes it shorter."""
    while True:
        a, b = tour[:-1], tour[1:]
        along = times[a, b]
        gain = np.triu(along[:, None] + along[None, :] - times[np.ix_(a, a)] - times[np.ix_(b, b)], 2)
        i, j = np.unravel_index(int(np.argmax(gain)), gain.shape)
        if gain[i, j] <= GAIN:
            return tour
        tour = np.concatenate([tour[: i + 1], tour[i + 1 : j + 1][::-1], tour[j + 1 :]])
