"""Which part of the box of `[limits.motion]` a machine reaches, pose by pose at rest.

Makers state strokes of single axes; all of them at once are often out of reach of struts and joints.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from cases.schema import Case
from cases.tables import own_units
from cases.units import DEG, MM
from identification.limit import TOLERANCE, Limit, LimitKind
from identification.limit_proof import CHUNK, limited_machine, of_mechanics
from identification.motion import Array, StandingPoses

POSES = 20_000  # random poses of the box: the standard error of its volume is at most 0.35 %
STEPS = 400  # steps along each coordinate from home to the end of the box: narrower gaps are not found
HALVINGS = 40  # halvings of such a step: far below any encoder's resolution
CLIMBS = 30  # steps of the search for the worst pose, halved where none of them is worse
NEAR = 0.8  # share of a limit at the worst of many poses, below which no pose next to it exceeds the limit
MOST_COORDINATES = 6  # largest number of coordinates whose corners and middles are all checked


@dataclass(frozen=True, slots=True)
class Reach:
    """The reachable part of the motion box."""

    share: float  # share of the box's volume that is reachable, from random poses
    share_std: float  # its standard error
    poses: int  # number of these poses
    worst: float  # largest share of a limit found in the box, also by search; above 1 out of reach
    worst_limit: str  # name of that limit
    exceeded: dict[str, float]  # limit -> share of the poses that exceed it
    stated: Array  # the box, lower and upper end relative to home, shape (2, n) [m or rad]
    reachable: Array  # how far each coordinate goes from home without a gap, the others at home, shape (2, n)
    # what limits each coordinate at its lower and upper end; None where that is the box itself
    limited_by: tuple[tuple[str | None, str | None], ...]
    keys: tuple[str, ...]

    @property
    def units(self) -> Array:
        """SI value of the unit of each coordinate, shape (n,)."""
        return own_units(self.keys)

    @property
    def whole(self) -> bool:
        """Whether no pose of the box was found out of reach."""
        return self.worst <= 1.0 + TOLERANCE

    def to_json(self) -> dict[str, Any]:
        """Shares, and the coordinates by the keys of `[limits.motion]` and in their units."""
        case_ranges, reachable = (np.round(box / self.units, 9).T.tolist() for box in (self.stated, self.reachable))
        return {
            "share": self.share,
            "share_std": self.share_std,
            "poses": self.poses,
            "whole": self.whole,
            "worst": {"limit": self.worst_limit, "ratio": self.worst},
            "coordinates": {
                key: {"stated": case_ranges[k], "reachable": reachable[k], "limited_by": list(self.limited_by[k])}
                for k, key in enumerate(self.keys)
            },
            "exceeded": self.exceeded,
        }


def reach(case: Case, count: int = POSES) -> Reach:
    """The reachable part of the motion box of a case, by limits of poses at rest.

    Of a hexapod these are strut lengths, joint angles, the way to a singularity, and boxes that platform, struts and
    tools must not enter; of a chain distances of its bodies, torques and sensor forces. A pose counts as reachable by
    itself, whether or not a way leads there from home.

    Args:
        count: number of random poses, uniform in the box, for the share of its volume.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    limits = StaticLimits(case)
    box = limits.box
    n = box.shape[1]
    samples = np.random.default_rng(0).random((count, n))
    grid = corners_and_middles(n)
    violations = limits.shares(limits.poses(box, samples)) > 1.0 + TOLERANCE
    inside = int(count - violations.any(axis=1).sum())
    exceeded = {
        str(limit): float(violations[:, [k == limit for k in limits.kinds]].any(axis=1).mean())
        for limit in dict.fromkeys(limits.kinds)
    }
    _, worst = limits.worst_poses(box, np.vstack([grid, samples[:2000]]))
    estimate = (inside + 1) / (count + 2)  # so that the error of a share of 0 or 1 is not 0
    reachable, limited_by = _coordinates(limits)
    return Reach(
        share=inside / count,
        share_std=float(np.sqrt(estimate * (1 - estimate) / count)),
        poses=count,
        worst=float(worst.max()),
        worst_limit=limits.names[int(worst.argmax())],
        exceeded={name: share for name, share in exceeded.items() if share > 0.0},
        stated=box,
        reachable=reachable,
        limited_by=limited_by,
        keys=case.need_motion("the reach of the motion box")[1].columns,
    )


def corners_and_middles(n: int) -> Array:
    """Corners and middles of a box, of more than six coordinates 729 of them: fractions of its sides, shape (k, n)."""
    if n > MOST_COORDINATES:
        return np.random.default_rng(0).choice((0.0, 0.5, 1.0), (3**MOST_COORDINATES, n))
    return np.array(list(product((0.0, 0.5, 1.0), repeat=n)))


def _coordinates(limits: "StaticLimits") -> tuple[Array, tuple[tuple[str | None, str | None], ...]]:
    """Ends of each coordinate's reach with the others at home, shape (2, n), and what limits them."""
    n = limits.box.shape[1]
    ends = np.vstack([np.diag(side) for side in limits.box])  # one row each end of each coordinate, relative to home

    def shares(lengths: Array) -> Array:
        return limits.shares((limits.home + lengths[..., None] * ends[:, None]).reshape(-1, n))

    along = np.linspace(0.0, 1.0, STEPS + 1)
    valid = (shares(np.tile(along, (2 * n, 1))).max(axis=1) <= 1.0 + TOLERANCE).reshape(2 * n, -1)
    last = np.where(valid.all(axis=1), STEPS, np.maximum(np.argmin(valid, axis=1) - 1, 0))
    inside, outside = along[last], along[np.minimum(last + 1, STEPS)]
    for _ in range(HALVINGS):
        middle = (inside + outside) / 2
        good = shares(middle[:, None]).max(axis=1) <= 1.0 + TOLERANCE
        inside, outside = np.where(good, middle, inside), np.where(good, outside, middle)
    whole = last == STEPS
    beyond = [limits.names[k] for k in shares(outside[:, None]).argmax(axis=1)]
    names = [None if all_of_it else name for all_of_it, name in zip(whole, beyond, strict=True)]
    reachable = np.where(whole, 1.0, inside).reshape(2, n) * limits.box
    return reachable, tuple(zip(names[:n], names[n:], strict=True))


class StaticLimits:
    """The limits of a case for poses at rest, over many poses at once, by the proof of limits.

    Raises:
        CaseError: the case has no machine or no limits.
    """

    def __init__(self, case: Case) -> None:
        self.case = case
        self.home, limits = case.need_motion("the reach of the motion box")
        self.box, self.units, self.of_pose = limits.pose, np.where(limits.turns, DEG, MM), limits.of_pose
        columns = [(limit, label) for limit, labels, _ in self._columns(self.home[None]) for label in labels]
        self.kinds = tuple(limit for limit, _ in columns)
        self.names = tuple(limit.at(label) for limit, label in columns)

    def poses(self, box: Array, fractions: Array) -> Array:
        """Poses at fractions from 0 to 1 of the sides of a box relative to home, shape (n, k) [m or rad]."""
        return np.asarray(self.home + box[0] + fractions * (box[1] - box[0]))

    def shares(self, poses: Array) -> Array:
        """Share of each limit that each pose uses, above 1 out of reach, shape (n, limits); poses of shape (n, k)."""
        parts = [poses[first : first + CHUNK] for first in range(0, len(poses), CHUNK)]
        with np.errstate(invalid="ignore"):  # what is not a number counts as out of reach
            rows = [np.hstack([shares for *_, shares in self._columns(part)]) for part in parts]
        return np.asarray(np.nan_to_num(np.vstack([np.zeros((0, len(self.names))), *rows]), nan=np.inf))

    def _columns(self, poses: Array) -> Iterator[tuple[Limit, tuple[str, ...], Array]]:
        """Each limit, the parts of the machine that it limits, and the shares, shape (n, columns)."""
        still = StandingPoses(poses).at(np.arange(float(len(poses))))
        machine = limited_machine(self.case)
        if self.of_pose:
            workspace = self.case.need_machine("the reach of the motion box")[1]
            for quantity in machine.mechanics(still)[1]:
                if quantity.of.kind is LimitKind.STRUT_LENGTH:
                    low, high = quantity.limits
                    longest = (quantity.values - (low + high) / 2) / ((high - low) / 2)
                    for end, shares in (("longest", longest), ("shortest", -longest)):
                        yield quantity.of, tuple(f"{strut}, {end}" for strut in quantity.labels), shares
                elif quantity.of.kind is LimitKind.DISTANCE_FROM_BOX:
                    box = next(b for b in workspace.keep_out if b.name == quantity.of.box)
                    yield quantity.of, quantity.labels, 1.0 - quantity.values / box.vicinity
                elif not quantity.of.kind.kinetic:
                    yield quantity.of, quantity.labels, quantity.ratio
            return
        yield Limit(LimitKind.TURNING), ("",), np.zeros((len(poses), 1))  # of a joint without ends
        for quantity in (*machine.ranges(still), *of_mechanics(still, self.case, False)):
            yield quantity.of, quantity.labels, quantity.ratio

    def worst_poses(self, box: Array, starts: Array) -> tuple[Array, Array]:
        """The pose of a box that uses most of each limit, as fractions of its sides, (limits, k), and these shares.

        The worst of given poses, then, where it uses more than `NEAR` of the limit, a search along single coordinates
        from there: poses that are worse still may exist, but not next to it.

        Args:
            box: lower and upper end relative to home, shape (2, k) [m or rad].
            starts: fractions of its sides, shape (n, k).
        """
        n, shares = box.shape[1], self.shares(self.poses(box, starts))
        fractions, largest = starts[shares.argmax(axis=0)], shares.max(axis=0)
        columns = np.flatnonzero(largest > NEAR)
        if not len(columns):  # no limit is near anywhere
            return fractions, largest
        best, most = fractions[columns], largest[columns]
        size, rows = np.full(len(columns), 0.25), np.arange(len(columns))
        for _ in range(CLIMBS):
            moves = np.vstack([np.eye(n), -np.eye(n)])
            candidates = np.clip(best[:, None] + size[:, None, None] * moves, 0.0, 1.0)
            values = self.shares(self.poses(box, candidates.reshape(-1, n))).reshape(len(columns), 2 * n, -1)
            values = values[rows, :, columns]  # of each limit at the moves of its own pose
            way = values.argmax(axis=1)
            higher = values[rows, way] > most
            best = np.where(higher[:, None], candidates[rows, way], best)
            most = np.where(higher, values[rows, way], most)
            size = np.where(higher, size, size / 2)
        fractions[columns], largest[columns] = best, most
        return fractions, largest
