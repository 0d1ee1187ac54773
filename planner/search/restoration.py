"""The motion within every limit that is closest to one that exceeds some.

Shrinking a motion towards the middle of its box loses little where limits are proportional to distances. Where they
bind more in the middle (struts of a short stroke are faster there) an excess of a per mille takes half of all
distances. Here the motion itself is changed, as little as its limits ask for: what counts as little is the change of
the regressor along the motion, because information is made of it. This problem knows no criterion, which couples all
unknowns: its second derivatives are sparse, and an iteration costs a fraction of one of the search.
"""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cases.base.units import Array, Indices
from cases.schema import Case
from identification.limits.limit import UNUSED_SHARE, LimitReport
from identification.limits.proof import prove
from identification.machines.machine import VICINITY
from identification.motion.motion import Trajectory
from planner.families.family import Family
from planner.families.rows import PacedRows, StateRows
from planner.families.states import SHARE
from planner.search.nlp import NonlinearProgram
from planner.search.problem import CHECK_RATE, largest_shares
from planner.search.solvers import INSIDE, Barrier, solve

ROUNDS = 5  # of solving, with more rows or tighter ones where the motion still exceeds limits between instants
ITERATIONS = 30  # of each round: most end after 10 to 20
CONSTRAINED = 0.6  # share of a limit above which an instant has a row
LOWERED, SLIP = 3.0, 1e-4  # times what only the proof sees, and share more, by which all bounds are lowered then
APART = 2e-3  # [m] by which bodies are kept further apart where rows did not see how near they are
EASE = 1e-3  # share of the mean curvature that moving has where it does not change the regressor
_AT_HAND: Barrier = (1e-6, 0.2, 1.5)  # distances squared are small, and the start is close by


@dataclass(frozen=True)
class ClosestProgram(NonlinearProgram):
    """Minimise the change of the regressor since a motion, over unknowns within bounds and rows."""

    motion: Array | None = None  # unknowns of that motion, shape (n,)

    @classmethod
    def of(cls, program: NonlinearProgram, motion: Array) -> "ClosestProgram":
        """The program with the bounds and rows of another."""
        return cls(**{field.name: getattr(program, field.name) for field in fields(program)}, motion=motion)

    def _change(self, unknowns: Array) -> Array:
        assert self.motion is not None
        return np.asarray(unknowns - self.motion)

    @cached_property
    def _metric(self) -> Array:
        """Mean square change of the regressor by unknowns at the motion, shape (n, n)."""
        assert self.motion is not None
        states, size = self.states, self.unknowns
        at, ways = states.at(self.motion), states.slopes(self.motion)
        flat = np.concatenate(at)
        slopes = self.regressor.slopes(flat)[1]
        squares = (slopes @ slopes.transpose(0, 2, 1)) * np.abs(flat[:, SHARE, None, None])
        blocks = ways.transpose(0, 1, 3, 2) @ squares.reshape(*at.shape, at.shape[2]) @ ways
        places = states.index[:, :, None] * size + states.index[:, None, :]
        metric = np.bincount(places.ravel(), blocks.sum(axis=1).ravel(), size**2).reshape(size, size)
        return np.asarray(metric + np.eye(size) * EASE * np.trace(metric) / size) / self.size

    def value(self, unknowns: Array) -> float:
        """Half of the mean square change."""
        change = self._change(unknowns)
        return float(change @ self._metric @ change) / 2

    def gradient(self, unknowns: Array) -> Array:
        """Derivative of `value`, shape (n,)."""
        return np.asarray(self._metric @ self._change(unknowns))

    @cached_property
    def hessian_pattern(self) -> tuple[Indices, Indices]:
        """Row and column of each value of `hessian`: the upper triangle, of blocks that share unknowns."""
        used = self._metric != 0.0
        for part in self.rows:
            if isinstance(part, StateRows):
                used[part.states.index[:, :, None], part.states.index[:, None, :]] = True
            elif isinstance(part, PacedRows):
                used[:] = True
        row, column = np.nonzero(np.triu(used))
        return row, column

    def hessian(self, unknowns: Array, factor: float, multipliers: Array) -> Array:
        """Second derivative of factor times the change plus the rows times multipliers, as `hessian_pattern`."""
        total = factor * self._metric
        size = self.unknowns
        for index, matrices in self._curvatures_of_rows(unknowns, multipliers):
            places = (index[:, :, None] * size + index[:, None, :]).ravel()
            total = total + np.bincount(places, matrices.ravel(), total.size).reshape(total.shape)
        return np.asarray(total[self.hessian_pattern])


class Closest(NamedTuple):
    """A motion close by that satisfies every limit, or nearly where there is none so close."""

    unknowns: Array  # shape (n,)
    bounds: dict[str, float]  # bounds of shares of some non-linear limits, by name, that their rows need


def closest_inside(program: NonlinearProgram, case: Case, family: Family, unknowns: Array, bound: float) -> Closest:
    """The closest motion inside.

    Args:
        program: with all limits that can bind; rows are chosen here.
        family: that of the unknowns.
        unknowns: of the motion that exceeds limits, shape (n,).
        bound: share of each limit that rows allow at first.
    """
    program, start = program.with_rows_near(unknowns, CONSTRAINED, CONSTRAINED), unknowns
    bounds: dict[str, float] = {}
    for _ in range(ROUNDS):
        closest, _, _ = solve(ClosestProgram.of(program, start), unknowns, ITERATIONS, lambda _: False, _AT_HAND)
        if not np.isfinite(closest).all():
            break
        unknowns = np.clip(closest, program.lower, program.upper)
        motion = family.once.motion(unknowns)
        report = prove(motion, case, CHECK_RATE)
        over = report.worst_ratio - (1.0 - UNUSED_SHARE)
        if over <= 0.0 or not np.isfinite(over):
            break
        if nearer := _nearer_than_rows(program, motion, report):
            bounds |= nearer
            program = program.with_rows_above(unknowns, CONSTRAINED).bounded(nearer)
            continue
        shares = largest_shares(program, motion, case)
        between = program.worst(unknowns) <= bound + INSIDE
        program = program.with_rows_above(unknowns, CONSTRAINED)
        if max(shares) <= 1.0 - UNUSED_SHARE:  # the proof sees more: it measures angles of joints, rows their cosines
            program = program.tightened([bound + LOWERED * over + SLIP] * len(shares), bound)
        elif between:
            program = program.tightened(shares, bound)
    return Closest(unknowns, bounds)


def _nearer_than_rows(program: NonlinearProgram, motion: Trajectory, report: LimitReport) -> dict[str, float]:
    """Bounds of the shares of distances that the rows judge by capsules, where the proof finds bodies nearer.

    That of a pair of bodies alone is lowered, to what the rows see where these come closest, and by what is missing.
    """
    bounds = {}
    for kernel in program.limits:
        check = next((c for c in report.checks if c.name == kernel.name and c.ratio > 1.0 - UNUSED_SHARE), None)
        if check is None:
            continue
        at = motion.at(np.array([check.time]))
        state = np.hstack([at.coordinates, at.rates, at.accelerations, np.zeros((1, 1))])
        seen = float(np.abs(kernel.values(state)).max())
        bounds[kernel.name] = seen * float(np.exp((check.worst / check.kind.scale - APART) / VICINITY))
    return bounds
