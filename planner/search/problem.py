"""The optimal excitation problem of a family: its program with every limit that can bind."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.limited_quantities import Box
from identification.model import Model
from identification.motion import Trajectory
from planner.families.family import Family, Layout, box_middle
from planner.noise import PoseErrors
from planner.search.objective import FieldByStates
from planner.search.program import NonlinearProgram, regressor_kernel
from planner.search.rows import LinearRows, Rows, StateRows
from planner.search.state_limits import BINDS, LimitGroup, near_limits
from planner.search.states import Peak

Array = NDArray[np.float64]

SLIP_RATE = 1000.0  # [1/s] at which a motion is looked at between the constrained instants


@dataclass(frozen=True)
class Problem:
    """Minimise a criterion of the mean information subject to the limits."""

    layout: Layout  # the family's motion as functions of the unknowns
    program: NonlinearProgram  # program with all rows
    limits: tuple[LimitGroup, ...]  # non-linear limits that can bind, one for each of the program's last rows
    box: Box  # limits of the coordinates
    middle: Array  # middle of the box, shape (n,) [m or rad]
    half: Array  # half of its width, shape (n,) [m or rad]

    def worst(self, unknowns: Array) -> float:
        """The largest share of any limit that unknowns use, at all critical states, those without rows as well."""
        return max(float(np.abs(part.all_values(unknowns)).max()) for part in self.program.rows if not _equation(part))

    def with_rows_above(self, unknowns: Array, share: float) -> "Problem":
        """The same with rows for all that use more than a share of a limit, besides those that it has."""
        rows: list[Rows] = []
        for part in self.program.rows:
            if isinstance(part, StateRows) or (isinstance(part, LinearRows) and part.equal is None):
                part = replace(part, chosen=part.chosen | (np.abs(part.all_values(unknowns)) > share))
            rows.append(part)
        return replace(self, program=replace(self.program, rows=tuple(rows)))

    def within(self, layout: Layout) -> "Problem":
        """The same within the bounds of unknowns of another layout of the same family."""
        return replace(self, program=replace(self.program, lower=layout.lower, upper=layout.upper))

    def outside(self, unknowns: Array) -> float:
        """By how much unknowns are outside their bounds."""
        program = self.program
        return float(max((program.lower - unknowns).max(), (unknowns - program.upper).max(), 0.0))

    def slips(self, motion: Trajectory) -> tuple[float, ...]:
        """The largest share of each limit along the whole motion: rows constrain it at some instants only.

        One number for each order of the coordinates (pose, rates, accelerations, jerks), then one for each of `limits`.
        """
        box, samples = self.box, motion.at(np.linspace(0.0, motion.duration, max(2, int(motion.duration * SLIP_RATE))))
        pose = (samples.pose - self.middle) / self.half
        shares = [pose, samples.rates / box.rate, samples.accelerations / box.acceleration, samples.jerks / box.jerk]
        states = np.hstack([samples.pose, samples.rates, samples.accelerations, np.zeros((len(pose), 1))])
        shares += [group.kernel.values(states) for group in self.limits]
        return tuple(float(np.abs(share).max()) for share in shares)

    def tightened(self, slips: Sequence[float], bound: float) -> "Problem":
        """The same with bounds lowered by what `slips` exceed one that all should satisfy."""
        factors = [bound / max(bound, slip) for slip in slips]  # a jerk that nothing limits slips by 0
        before = len(self.program.rows) - len(self.limits)
        rows: list[Rows] = []
        for k, part in enumerate(self.program.rows):
            if isinstance(part, LinearRows) and part.equal is None:
                part = replace(part, bound=part.bound * np.array(factors)[part.order])
            elif isinstance(part, StateRows) and k >= before:
                part = replace(part, bound=part.bound * factors[4 + k - before])
            rows.append(part)
        return replace(self, program=replace(self.program, rows=tuple(rows)))


def _equation(part: Rows) -> bool:
    return isinstance(part, LinearRows) and part.equal is not None


def build_problem(
    case: Case, model: Model, family: Family, scaling: Array, margin: float, errors: PoseErrors | None = None
) -> Problem:
    """Builds the program of criterion D.

    Args:
        scaling: reference scaling, shape (u,).
        margin: share of each limit that is left free.
        errors: errors of the pose, which the information counts.
    """
    layout, limits = family.layout(case, margin), near_limits(case)
    rows = tuple(
        StateRows(
            layout.critical,
            group.kernel,
            np.repeat(layout.peaks[group.peak][:, :, None], group.kernel.size, axis=2) & (group.most > BINDS),
            1.0 - margin,
        )
        for group in limits
    )
    first: tuple[Rows, ...] = ()
    if (standing := layout.standing) is not None:
        shape = standing.index.shape[0], standing.at(np.zeros(len(layout.lower))).shape[1]
        first = tuple(
            StateRows(standing, group.kernel, np.ones((*shape, group.kernel.size), dtype=bool), 1.0 - margin)
            for group in limits
            if group.peak is Peak.POSE
        )
    program = NonlinearProgram(
        layout.states,
        regressor_kernel(model, scaling),
        (*layout.rows, *first, *rows),
        layout.lower,
        layout.upper,
        errors=None if errors is None else FieldByStates(errors, family.duration),
    )
    return Problem(layout, program, limits, case.need_motion("planning")[1], *box_middle(case))
