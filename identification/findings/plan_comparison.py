"""A run beside its plan: both as points at equal distances along the paths of the drives, which are aligned in order.

Paths are compared without regard to time, so that dwells, the law of a controller and the way from home and back do
not count. Points that have no partner are parts of the plan that the run left out or did otherwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from cases.base.errors import HexciteError
from cases.base.units import DEG, MM, Array, Flags, Indices
from cases.schema import Case
from identification.machines.of_case import machine_of
from identification.motion.motion import Trajectory
from identification.recording.recording import Recording

PLAN_RATE = 500.0  # [1/s] at which the plan is sampled
MOST_SAMPLES = 200_000  # of plan or recording
STEP = 0.01  # distance of the points along a path, as a share of the plan's range of lengths or of angles
MOST_POINTS = 1500  # of the plan's path
# below which the range of a drive is not what distances are compared with; also as a share of that of its like
LEAST_RANGE, LEAST_SHARE = (5.0 * MM, 0.5 * DEG), 0.2
NEAR = 1.5  # distances of points, within which a point of the run is the plan's
LEFT_OUT, ADDED, FAR = 1.0, 0.2, 2.0  # cost of a point of the plan, of the run, and of a pair that is too far apart
COARSE = 3  # points of which one is taken where a shift is first looked for
FEWEST = 4  # points in a row that are not a coincidence
WHOLE = 0.98  # share of the plan's path from which a run holds all of it: recorders begin and end a little late
ANOTHER = 0.3  # share of it below which the run is another motion


@runtime_checkable
class Planned(Protocol):
    """What a run is compared with; a `Plan` is one."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    @property
    def motion(self) -> Trajectory:
        """The motion, in the coordinates of the machine."""

    @property
    def poses(self) -> Array:
        """Poses at which it stands, shape (n, k) [m or rad]; empty for motions."""


class _Path(NamedTuple):
    """A motion as points at equal distances of its drives."""

    t: Array  # when each is reached, shape (n,) [s]
    drives: Array  # shape (n, k) [m or rad]


@dataclass(frozen=True, slots=True)
class PlanComparison:
    """A run beside its plan."""

    plan: Planned
    case: Case
    planned: _Path
    run: _Path
    raw: _Path  # the run as recorded
    scale: Array  # of the drives, shape (k,) [m or rad]: what distances are shares of
    shift: Array  # of the run's drives against the plan's, shape (k,) [m or rad]
    pairs: Indices  # points of plan and run that are one, in order, shape (p, 2)
    step: float  # distance of the points as a share of the scale

    @property
    def matched(self) -> Flags:
        """Which points of the plan are in the run, shape (n,)."""
        flags = np.zeros(len(self.planned.t), dtype=bool)
        flags[self.pairs[:, 0]] = True
        return flags

    @property
    def begins(self) -> float:
        """Time of the run at which the plan begins, the median of the pairs [s]."""
        return float(np.median(self.run.t[self.pairs[:, 1]] - self.planned.t[self.pairs[:, 0]]))

    @property
    def share(self) -> float:
        """Share of the plan's path that is in the run."""
        return float(self.matched.mean())


def compared(recording: Recording, case: Case, plan: Planned) -> PlanComparison | None:
    """A run beside a plan; None where the recording has no clock or no drives, or one of them does not move.

    Args:
        recording: a run on one clock.
        case: machine of both.
        plan: plan for this machine.
    """
    if recording.t is None or recording.drives is None:
        return None
    good = np.flatnonzero(~recording.bad)[:: max(1, recording.rows // MOST_SAMPLES)]
    if len(good) < FEWEST:
        return None
    machine, motion = machine_of(case), plan.motion
    count = int(min(MOST_SAMPLES, max(FEWEST, motion.duration * PLAN_RATE)))
    t = np.linspace(0.0, motion.duration, count)
    drives = machine.drives(motion.at(t).coordinates)
    if drives.shape[1] != recording.drives.shape[1]:
        return None
    scale = np.empty(drives.shape[1])
    for turns, least in zip((False, True), LEAST_RANGE, strict=True):
        of_kind = machine.turns == turns
        ranges = np.ptp(drives[:, of_kind], axis=0)
        scale[of_kind] = np.maximum(ranges, max(least, LEAST_SHARE * ranges.max(initial=0.0)))
    length = float(np.linalg.norm(np.diff(drives / scale, axis=0), axis=1).sum())
    step = max(STEP, length / MOST_POINTS)
    planned = _walked(t, drives, scale, step)
    struts = _without_glitches(recording.drives[good])
    run = _walked(recording.t[good], struts, scale, step)
    if min(len(planned.t), len(run.t)) < FEWEST:
        return None
    shift, pairs = _best(planned.drives / scale, run.drives / scale, step)
    return PlanComparison(plan, case, planned, run, _Path(recording.t[good], struts), scale, shift * scale, pairs, step)


def closest(recording: Recording, case: Case, plan: Planned | Sequence[Planned]) -> PlanComparison | None:
    """A run beside its plan, or beside that of some plans which is most alike; None where none can be compared.

    Args:
        recording: a run on one clock.
        case: machine of both.
        plan: plan of the run; or plans that lie beside it, of which one may be that of the run.
    """
    plans = [plan] if isinstance(plan, Planned) else list(plan)
    comparisons = [found for one in plans if (found := compared(recording, case, one)) is not None]
    return max(comparisons, key=lambda comparison: comparison.share, default=None)


def _walked(t: Array, drives: Array, scale: Array, step: float) -> _Path:
    """Points of a sampled motion, each at a distance from the one before it.

    Args:
        t: times, shape (n,) [s].
        drives: shape (n, k) [m or rad].
        scale: what distances are shares of, shape (k,) [m or rad].
        step: distance of the points.
    """
    places = drives / scale
    at, when = [places[0]], [float(t[0])]
    row, reach = 1, 64
    while row < len(places):
        part = places[row : row + reach]
        away = np.linalg.norm(part - at[-1], axis=1)
        beyond = np.flatnonzero(away >= step)
        if not len(beyond):
            row, reach = row + len(part), min(2 * reach, 4096)
            continue
        row, reach = row + int(beyond[0]), 64
        before = places[row - 1]
        share = _crossing(before - at[-1], places[row] - before, step)
        at.append(before + share * (places[row] - before))
        when.append(float(t[row - 1] + share * (t[row] - t[row - 1])))
    return _Path(np.array(when), np.array(at) * scale)


def _crossing(offset: Array, way: Array, step: float) -> float:
    """Where on a way, from 0 to 1, the distance from a point reaches a step.

    Args:
        offset: start of the way less the point, shape (k,).
        way: the way, shape (k,).
    """
    a, b, c = float(way @ way), float(offset @ way), float(offset @ offset) - step**2
    root = max(b * b - a * c, 0.0) ** 0.5
    return float(np.clip((root - b) / a, 0.0, 1.0)) if a > 0.0 else 1.0


def _without_glitches(drives: Array) -> Array:
    """Drives of which single readings that leave both neighbours are taken out, shape (n, k)."""
    if len(drives) < 3:
        return drives
    middle = np.median(np.stack([drives[:-2], drives[1:-1], drives[2:]]), axis=0)
    return np.vstack([drives[:1], middle, drives[-1:]])


def _best(planned: Array, run: Array, step: float) -> tuple[Array, Indices]:
    """The shift of a run, shape (k,), and its pairs with the plan: of several first guesses the one with most pairs."""
    none = np.zeros(planned.shape[1])
    best = none, _aligned(planned, run, NEAR * step)
    if len(best[1]) < WHOLE * len(planned):
        middles = [(path.max(axis=0) + path.min(axis=0)) / 2.0 for path in (planned, run)]
        for guess in (none, middles[1] - middles[0], run[0] - planned[0], run[-1] - planned[-1]):
            shift = guess
            for near, every in ((12.0, COARSE), (4.0, COARSE), (2.0, 1)):
                pairs = every * _aligned(planned[::every], run[::every] - shift, near * NEAR * step)
                if len(pairs) < FEWEST:
                    break
                shift = np.median(run[pairs[:, 1]] - planned[pairs[:, 0]], axis=0)
            pairs = _aligned(planned, run - shift, NEAR * step) if len(pairs) >= FEWEST else pairs
            if len(pairs) > 1.02 * len(best[1]) + FEWEST:
                best = shift, pairs
            if len(best[1]) >= WHOLE * len(planned):
                break
    shift, pairs = best
    if len(pairs):
        shift = np.median(run[pairs[:, 1]] - planned[pairs[:, 0]], axis=0)
    return shift, pairs


MATCH, DELETE, INSERT = range(3)


def _aligned(planned: Array, run: Array, near: float) -> Indices:
    """Pairs of points of plan and run that are within a distance, in the order of both, shape (p, 2).

    The alignment of least cost: points before the first pair and behind the last one cost nothing in the run.
    """
    rows, columns = len(planned), len(run)
    choice = np.empty((rows + 1, columns + 1), dtype=np.int8)
    steps = ADDED * np.arange(columns + 1)
    cost = np.zeros(columns + 1)
    choice[0] = INSERT
    for i in range(rows):
        far = ((run - planned[i]) ** 2).sum(axis=1) / near**2
        matched = np.concatenate([[np.inf], cost[:-1] + np.where(far > 1.0, FAR, far)])
        deleted = cost + LEFT_OUT
        least_cost = np.minimum(matched, deleted)
        least = np.minimum.accumulate(least_cost - steps) + steps
        choice[i + 1] = np.where(least < least_cost - 1e-12, INSERT, np.where(matched <= deleted, MATCH, DELETE))
        cost = least
    i, j = rows, int(np.argmin(cost))
    pairs = []
    while i > 0:
        if choice[i, j] == MATCH:
            i, j = i - 1, j - 1
            if ((run[j] - planned[i]) ** 2).sum() <= near**2:
                pairs.append((i, j))
        elif choice[i, j] == DELETE:
            i -= 1
        else:
            j -= 1
    matches: Indices = np.array(pairs[::-1], dtype=np.int64).reshape(-1, 2)
    if not len(matches):
        return matches
    groups = np.split(matches, 1 + np.flatnonzero(np.diff(matches[:, 0]) > 2))
    return np.concatenate([matches[:0], *(group for group in groups if len(group) >= FEWEST)])


def in_coordinates(comparison: PlanComparison, points: Indices) -> Array | None:
    """Coordinates of points of the run, shape (n, k) [m or rad]; None where no pose has such drives."""
    try:
        return np.asarray(machine_of(comparison.case).coordinates(comparison.run.drives[points]))
    except HexciteError:
        return None
