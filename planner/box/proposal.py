"""A motion box that a machine reaches as a whole, inside the one that its case states."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.base.errors import CaseError, Code
from cases.base.phrases import phrase
from cases.machine import POSE
from cases.schema import Case
from cases.tables import own_units
from identification.limits.limit import TOLERANCE
from identification.motion.motion import Array
from planner.box.reach import corners_and_middles, standing_ratios

INSIDE = 1e-3  # share of every limit that stays unused: checked poses are not all there are
CHECKED = 4000  # random poses of a box, beside its corners and middles
BISECTIONS = 9
PASSES = 2  # times that every side is moved outwards on its own


@dataclass(frozen=True, slots=True)
class ProposedBox:
    """A box for `[limits.motion]`, around home."""

    # key of `[limits.motion]`, or joint -> lower and upper limit relative to home [mm, deg], rounded inwards
    sides: dict[str, tuple[float, float]]
    share: float  # its volume over that of the stated box
    poses: int  # number of its poses that were checked

    def to_json(self) -> dict[str, Any]:
        """Sides and figures."""
        sides = {key: list(side) for key, side in self.sides.items()}
        return {"limits_motion": sides, "share": self.share, "poses": self.poses}

    @property
    def lines(self) -> list[str]:
        """The lines of the sides as a case file has them."""
        return [f"{key} = {json.dumps(list(side))}" for key, side in self.sides.items()]


def proposed_box(case: Case, seed: int = 0) -> ProposedBox:
    """A box inside the stated one of whose poses none was found out of reach.

    All sides shrink towards home together until all checked poses are within reach, then each moves outwards on its own
    as far as it can, in turns. It is one that fits, not proven to be the largest; poses are checked at its corners and
    middles and at random ones.

    Raises:
        CaseError: the case has no machine or no limits, or the machine cannot stand at home.
    """
    home, limits = case.need_motion("a proposal of the motion box")
    grid = corners_and_middles(len(home))
    fractions = np.vstack([grid, np.random.default_rng(seed).random((CHECKED, len(home)))])

    def fits(box: Array) -> bool:
        poses = home + box[0] + fractions * (box[1] - box[0])
        return float(standing_ratios(case, poses).max()) <= 1.0 - INSIDE

    ranges = limits.coordinates
    if float(standing_ratios(case, home[None]).max()) > 1.0 + TOLERANCE or not fits(np.zeros_like(ranges)):
        raise CaseError(
            file=case.origin,
            key="limits.motion",
            problem=phrase("home_unreachable", "home is out of reach, or at its edge"),
            remedy=phrase("move_home", "move home"),
            code=Code.INFEASIBLE,
        )
    whole = fits(ranges)
    box = ranges if whole else ranges * _largest(lambda share: fits(ranges * share))
    for _ in range(0 if whole else PASSES):
        for place in np.ndindex(*ranges.shape):
            box = _widened(box, ranges, place, fits)
    units = own_units(POSE) if case.chain is None else case.chain.units
    rounded = np.where(box < 0.0, np.ceil(box / units * 10.0), np.floor(box / units * 10.0)) / 10.0
    keys = POSE if case.chain is None else case.chain.names
    share = float(np.prod(np.ptp(rounded * units, axis=0) / np.ptp(ranges, axis=0)))
    return ProposedBox(dict(zip(keys, map(tuple, rounded.T.tolist()), strict=True)), min(share, 1.0), len(fractions))


def _widened(box: Array, ranges: Array, place: tuple[int, ...], fits: Callable[[Array], bool]) -> Array:
    """The box with one of its sides moved outwards as far as it fits."""

    def moved(share: float) -> Array:
        wider = box.copy()
        wider[place] += share * (ranges[place] - box[place])
        return wider

    return moved(1.0 if fits(moved(1.0)) else _largest(lambda share: fits(moved(share))))


def _largest(fits: Callable[[float], bool]) -> float:
    """The largest share, 0 to 1, that fits, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
