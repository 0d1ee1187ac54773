"""The largest box of poses, or of joints, inside `[limits.motion]` that a machine reaches as a whole."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.chain import JointLimit
from cases.errors import CaseError
from cases.machine import POSE
from cases.schema import Case
from identification.limit import TOLERANCE
from identification.motion import Array
from planner.reach import StaticLimits, corners_and_middles

MARGIN = 1e-3  # unused share of a limit, or half of that at home: sampling cannot find every pose
STARTS = 4  # boxes from which the search begins: it ends at the next local optimum
ROUNDS = 12  # rounds: each adds the worst poses of the box and searches on
PROVEN = 20_000  # random poses of the proof, half of the coordinates at an end of the box
SAMPLED = 2_000  # random poses in each round
NARROWEST = 1e-3  # share of the stated way from home to a side
WHOLE = 1.0 - 1e-5  # share from which a stated side counts as whole: the rest is rounding of the search
SHRINKING, SHRINKS = 0.98, 40  # factor by which the box shrinks where the proof fails, and how often at most
STEP = 1e-7  # step of differences, share of the stated box


@dataclass(frozen=True, slots=True)
class MotionBox:
    """A reachable box, to be written into a case file."""

    # key of `[limits.motion]`, or joint -> lower and upper limit relative to home [mm, deg], rounded inwards
    sides: dict[str, tuple[float, float]]
    share: float  # its volume over that of the stated box
    poses: int  # number of its poses at which `identification.limit_proof` proved the limits
    worst: float  # the largest share of a limit at these
    worst_limit: str  # name of that limit
    starts: int  # number of boxes from which the search began
    joints: tuple[JointLimit, ...] = ()  # limits of a chain with these sides; empty of a hexapod

    def toml(self) -> str:
        """The lines that replace those of `[limits.motion]`."""
        if self.joints:
            rows = [limit.model_dump(mode="json", exclude_none=True) for limit in self.joints]
            tables = [", ".join(f"{key} = {json.dumps(value)}" for key, value in row.items()) for row in rows]
            return "\n".join(["joints = [", *(f"    {{ {table} }}," for table in tables), "]"])
        return "\n".join(f"{key} = [{low!r}, {high!r}]" for key, (low, high) in self.sides.items())

    def to_json(self) -> dict[str, Any]:
        """Sides by the keys of `[limits.motion]`, and the other figures of the box."""
        return {
            "limits_motion": {key: list(side) for key, side in self.sides.items()},
            "share": self.share,
            "poses": self.poses,
            "worst": {"limit": self.worst_limit, "ratio": self.worst},
            "starts": self.starts,
            "toml": self.toml(),
        }


def largest_box(case: Case, seed: int = 0) -> MotionBox:
    """The largest box around home, inside `[limits.motion]`, all of whose poses satisfy the limits at rest.

    "Largest" means the largest product of the widths, each relative to that of the stated box. The sides are found
    by sequential quadratic programming (SLSQP) from several starts, under the limits at the worst poses of the boxes
    before. So the box is a local optimum; home may lie near one of its sides. It is verified at many poses (corners,
    edges, inside, and where a search from these ends), not everywhere.

    Raises:
        CaseError: the case has no machine or no limits, or home is out of reach.
    """
    search = _Search(case, seed)
    sides = search.best()
    for _ in range(SHRINKS):
        box = _rounded(search.limits, sides)
        worst, limit, poses = _proof(search.limits, box, seed)
        if worst <= 1.0 + TOLERANCE:
            units = search.limits.units
            share = float(np.prod(np.ptp(box * units, axis=0) / np.ptp(search.limits.box, axis=0)))
            keys = POSE if case.chain is None else case.chain.names
            ranges = dict(zip(keys, map(tuple, box.T.tolist()), strict=True))
            return MotionBox(ranges, share, poses, worst, limit, STARTS, _joints(case, box))
        sides = sides * SHRINKING
    raise search.at_the_end_of_reach()


class _Search:
    """Shares of the sides, (lower.., upper..) over those of the stated box, under limits at poses of the box.

    A pose is given by fractions of the sides, so that it moves with them: the limits there are smooth in the sides, and
    necessary for every box.
    """

    def __init__(self, case: Case, seed: int) -> None:
        self.limits = StaticLimits(case)
        self.count = self.limits.box.shape[1]
        self.draw = np.random.default_rng(seed)
        self.case, self.at_home = case, self.limits.shares(self.limits.home[None])[0]
        if self.at_home.max() > 1.0 - TOLERANCE:
            raise self.at_the_end_of_reach()
        margin = np.clip((1.0 - self.at_home) / 2, 0.0, MARGIN)
        self.most, self.tolerated = 1.0 - margin, 1.0 - 0.9 * margin
        self.fractions = np.empty((0, self.count))
        self.columns = np.empty(0, dtype=int)

    def best(self) -> Array:
        """The sides of the largest box that was found, shape (2 n,)."""
        whole = np.ones(2 * self.count)
        if (self._add_worst(whole) <= 1.0 + TOLERANCE).all():
            return whole
        boxes = []
        for k in range(STARTS):  # from the stated shape, then from random ones
            shape = np.exp(self.draw.normal(0.0, 0.5, 2 * self.count)) if k else whole
            boxes.append(self._grown(self._shrunk(shape / shape.max())))
        return min(boxes, key=lambda sides: self._objective(sides)[0])

    def at_the_end_of_reach(self) -> CaseError:
        """The error of a home around which no box is reachable."""
        limit, share = self.limits.names[int(self.at_home.argmax())], float(self.at_home.max())
        return CaseError(
            f"case {self.case.name}",
            "machine.home" if self.case.chain is None else "machine.chain: home",
            f"uses {100 * share:.4g} % of the limit {limit}, so that no box around it is reachable; move home inwards",
        )

    def _shrunk(self, sides: Array) -> Array:
        """The largest box of the same shape that satisfies the limits at the poses known so far."""
        low, high = 0.0, 1.0
        for _ in range(12):
            middle = (low + high) / 2
            low, high = (middle, high) if (self._room(middle * sides) >= 0.0).all() else (low, middle)
        return np.maximum(low * sides, NARROWEST)

    def _grown(self, start: Array) -> Array:
        """The local optimum that is reached from a box; where the search fails, the larger of both after shrinking."""
        from scipy.optimize import minimize  # most of a second to import

        sides = start
        for _ in range(ROUNDS):
            answer = minimize(
                self._objective,
                sides,
                jac=True,
                method="SLSQP",
                bounds=[(NARROWEST, 1.0)] * len(sides),
                constraints={"type": "ineq", "fun": self._room, "jac": self._slope},
                options={"maxiter": 20, "ftol": 1e-4},
            )
            sides = np.asarray(np.clip(answer.x, NARROWEST, 1.0))
            if (self._add_worst(sides) <= self.tolerated).all():
                return sides
        boxes: list[Array] = [self._shrunk(sides), self._shrunk(start)]
        return min(boxes, key=lambda box: self._objective(box)[0])

    def _objective(self, sides: Array) -> tuple[float, Array]:
        """-log of the volume over that of the stated box, and its gradient."""
        low, high = self.limits.box
        width = (high - low) / (high * sides[self.count :] - low * sides[: self.count])
        return float(np.log(width).sum()), np.concatenate([low, -high]) * np.tile(width / (high - low), 2)

    def _poses(self, sides: Array) -> Array:
        return self.limits.poses(self.limits.box * sides.reshape(2, -1), self.fractions)

    def _room(self, sides: Array) -> Array:
        """Distances to the limits at the poses, shape (n,)."""
        shares = self.limits.shares(self._poses(sides))
        return np.asarray(self.most[self.columns] - shares[np.arange(len(shares)), self.columns])

    def _slope(self, sides: Array) -> Array:
        """Derivative of `_room` by the sides, shape (poses, 2 n)."""
        low, high = self.limits.box
        poses = self._poses(sides)[:, None] + STEP * np.vstack([np.zeros(self.count), np.diag(high - low)])
        shares = self.limits.shares(poses.reshape(-1, self.count)).reshape(len(poses), self.count + 1, -1)
        shares = shares[np.arange(len(poses)), :, self.columns]
        slope = (shares[:, :1] - shares[:, 1:]) / (STEP * (high - low))
        return np.hstack([slope * (1 - self.fractions) * low, slope * self.fractions * high])

    def _add_worst(self, sides: Array) -> Array:
        """Largest share of each limit in the box, shape (limits,); poses where one is above `tolerated` are added."""
        box = self.limits.box * sides.reshape(2, -1)
        starts = np.vstack([corners_and_middles(self.count), _drawn(self.draw, SAMPLED, self.count)])
        worst, shares = self.limits.worst_poses(box, starts)
        broken = np.flatnonzero(shares > self.tolerated)
        self.fractions = np.vstack([self.fractions, worst[broken]])
        self.columns = np.concatenate([self.columns, broken])
        return shares


def _drawn(draw: np.random.Generator, count: int, n: int) -> Array:
    """Fractions of the sides of a box, shape (count, n): half of them random, the others 0 or 1."""
    return np.where(draw.random((count, n)) < 0.5, draw.random((count, n)), draw.integers(0, 2, (count, n)))


def _joints(case: Case, box: Array) -> tuple[JointLimit, ...]:
    """Limits of a chain's joints with other positions, shape (2, n) [mm, deg]; none of a hexapod."""
    if case.chain is None:
        return ()
    stated = case.need_chain("the reach of the motion box")[1].joints
    return tuple(
        limit.model_copy(update={"position_deg" if limit.turns else "position_mm": tuple(side)})
        for limit, side in zip(stated, box.T.tolist(), strict=True)
    )


def _rounded(limits: StaticLimits, sides: Array) -> Array:
    """The box in the units of the case file, rounded inwards to a 500th of its widths, shape (2, n) [mm, deg]."""
    stated = np.round(limits.box / limits.units, 9)
    box = stated * sides.reshape(2, -1)
    finest = np.minimum(np.ptp(box, axis=0) / 500, np.abs(box).min(axis=0) / 10)
    scale = 10.0 ** np.maximum(np.ceil(-np.log10(finest)), 0.0)
    inwards = np.trunc(box * scale * (1 + 1e-12)) / scale
    return np.where(sides.reshape(2, -1) >= WHOLE, stated, inwards)


def _proof(limits: StaticLimits, box: Array, seed: int) -> tuple[float, str, int]:
    """The largest share of a limit at many poses of the box by `identification.limit_proof`, its name, and how many."""
    n = box.shape[1]
    starts = np.vstack([corners_and_middles(n), _drawn(np.random.default_rng(seed + 1), PROVEN, n)])
    worst, shares = limits.worst_poses(box * limits.units, starts)
    return float(shares.max()), limits.names[int(shares.argmax())], len(starts) + len(worst)
