"""Which part of the box of `[limits.motion]` a machine reaches, pose by pose at rest, by the proof of limits.

Makers state strokes of single axes; all of them at once are often out of reach of struts and joints.
"""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from cases.schema import Case
from identification.limits.limit import TOLERANCE, LimitCheck
from identification.limits.proof import everything, prove_at, shares_at
from identification.motion.motion import Array, StandingPoses

POSES = 20_000  # random poses of the box: the standard error of its volume is at most 0.35 %
MOST_COORDINATES = 6  # largest number of coordinates whose corners and middles are all checked


@dataclass(frozen=True, slots=True)
class Reach:
    """The reachable part of the motion box."""

    share: float  # share of the box's volume that is reachable, from random poses
    share_std: float  # its standard error
    poses: int  # number of these poses
    worst: LimitCheck  # the limit that comes closest, or is exceeded most, at these, in the corners and middles
    exceeded: dict[str, float]  # limit -> share of the random poses that exceed it

    @property
    def whole(self) -> bool:
        """Whether no pose of the box was found out of reach."""
        return self.worst.ratio <= 1.0 + TOLERANCE

    def to_json(self) -> dict[str, Any]:
        """Shares and limits."""
        of = self.worst
        worst = {"limit": of.name, "ratio": of.ratio, "worst": of.worst, "allowed": of.limit, "unit": of.unit}
        worst |= {} if of.bounds is None else {"bounds": list(of.bounds)}
        shares = {"share": self.share, "share_std": self.share_std, "poses": self.poses, "whole": self.whole}
        return shares | {"worst": worst, "exceeded": self.exceeded}


def reach(case: Case, count: int = POSES) -> Reach:
    """The reachable part of the motion box of a case, by its limits at rest, whether or not a way leads there.

    Args:
        count: number of random poses, uniform in the box, for the share of its volume.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    home, limits = case.need_motion("the reach of the motion box")
    grid = corners_and_middles(len(home))
    fractions = np.vstack([grid, np.random.default_rng(0).random((count, len(home)))])
    poses = home + limits.coordinates[0] + fractions * np.ptp(limits.coordinates, axis=0)
    checks = prove_at(StandingPoses(poses), case, np.arange(float(len(poses))), in_box=False).checks
    worst = max(checks, key=lambda check: check.ratio)
    violations = standing_ratios(case, poses[len(grid) :]) > 1.0 + TOLERANCE
    shares = {str(check.of): float(share) for check, share in zip(checks, violations.mean(axis=0), strict=True)}
    inside = int(count - violations.any(axis=1).sum())
    estimate = (inside + 1) / (count + 2)  # so that the error of a share of 0 or 1 is not 0
    return Reach(
        share=inside / count,
        share_std=float(np.sqrt(estimate * (1 - estimate) / count)),
        poses=count,
        worst=worst,
        exceeded={name: share for name, share in shares.items() if share > 0.0},
    )


def standing_ratios(case: Case, poses: Array) -> Array:
    """Share of each limit that standing at each pose uses, above 1 out of reach, shape (n, limits)."""
    return shares_at(StandingPoses(poses), case, np.arange(float(len(poses))), False, everything)


def corners_and_middles(n: int) -> Array:
    """Corners and middles of a box, of more than six coordinates 729 of them: fractions of its sides, shape (k, n)."""
    if n > MOST_COORDINATES:
        return np.random.default_rng(0).choice((0.0, 0.5, 1.0), (3**MOST_COORDINATES, n))
    return np.array(list(product((0.0, 0.5, 1.0), repeat=n)))
