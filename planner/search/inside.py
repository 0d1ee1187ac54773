"""What a motion is worth, and the motion drawn back inside every limit: computed anew, whatever a solver says."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError, InfeasiblePlan
from cases.schema import Case
from identification.criteria import CRITERIA, singular_values
from identification.limit import TOLERANCE, LimitReport
from identification.limit_proof import prove
from identification.model import Model
from planner.families.family import Family
from planner.infeasible import remedy
from planner.noise import PoseErrors, information_of

Array = NDArray[np.float64]

MARGIN = 1e-3  # of every limit, left for the rounding of program words and for the encoders' view of the motion
CLOSE_ENOUGH = 3e-4  # gap of the bisection that draws a motion back
SMALLEST = 1e-6  # share of all ways below which nothing moves


class Rating(NamedTuple):
    """What a motion is worth in reference scaling: log det of its information, and the criterion to be maximised."""

    logdet: float
    score: float


def rate(
    model: Model, scaling: Array, family: Family, unknowns: Array, criterion: str, errors: PoseErrors | None = None
) -> Rating:
    """Rates a motion from its samples at 1 kHz; minus infinity where it does not determine all parameters."""
    information = information_of(model, scaling, family.motion(unknowns), errors)
    try:
        mu = singular_values(information, model.names)
    except IdentificationError:
        return Rating(-np.inf, -np.inf)
    return Rating(CRITERIA["D"].of(mu), CRITERIA[criterion].of(mu))


class Inside(NamedTuple):
    """A motion that satisfies every limit."""

    unknowns: Array  # unknowns of the motion
    report: LimitReport  # report of its limits
    share: float  # share of all ways that are left


def keep_limits(case: Case, family: Family, unknowns: Array, rate: float) -> Inside:
    """Draws a motion towards the middle of the box until it satisfies every limit, less a margin, on a grid of `rate`.

    From small steps to large ones: lengths of struts need not fall on the way, so that a smaller motion is not always
    further inside.

    Raises:
        InfeasiblePlan: it exceeds a limit even where all but nothing moves; the message names the limit.
    """

    def attempt(share: float) -> tuple[Inside | None, LimitReport]:
        trial = family.shrunk(unknowns, share)
        report = prove(family.motion(trial), case, rate)
        good = report.worst_ratio <= 1.0 - MARGIN + TOLERANCE
        return Inside(trial, report, share) if good else None, report

    best, report = attempt(1.0)
    share, failed, step = 1.0, 1.0, CLOSE_ENOUGH
    while best is None and share > SMALLEST:
        failed, share = share, share - step if step < share / 2 else share / 2
        best, report = attempt(share)
        step *= 2
    if best is None:
        worst = max(report.checks, key=lambda c: c.ratio)
        raise InfeasiblePlan(f"no feasible motion: {worst.sentence()}; {remedy(worst, case)} or move home")
    while failed - best.share > CLOSE_ENOUGH:
        between = (failed + best.share) / 2
        better, _ = attempt(between)
        if better is None:
            failed = between
        else:
            best = better
    return best
