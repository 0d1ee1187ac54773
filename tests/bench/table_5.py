"""Table 5 of the paper side by side with ours: standard deviations from 480 poses, and from 30 by Algorithm 1.

Standard deviations are taken at the published s0 and, for the centre of gravity, at the published parameters.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.estimation.criteria import Criterion, candidate_scaling, pose_regressors
from identification.model.model import identification_model
from identification.model.parameters import physical_form
from planner.poses.planned_poses import grid_candidates
from planner.poses.removal import reduce_best

Array = NDArray[np.float64]

GROUPS = ("m", "xC, yC", "zC", "f_q0", "k0", "k1", "k2", "k3")
UNITS = ("kg", "mm", "mm", "N", "N/m", "N m/m", "N", "N m")
LEFT = 30


@dataclass(frozen=True)
class Column:
    """A column of Table 5.

    Args:
        s0: published.
        mass: published [kg].
        centre: published [mm].
        deviations: published standard deviations by group, xC and yC averaged, in the units of UNITS.
        fewest: published "Min. poses"; None for all 480.
    """

    s0: float
    mass: float
    centre: tuple[float, float, float]
    deviations: tuple[float, ...]
    fewest: int | None


PUBLISHED = {
    "Q5M": Column(1.28, 33.78, (0.46, 0.50, 108.93), (0.22, 0.19, 1.34, 0.49, 0.27, 0.05, 4.28, 0.86), None),
    "Q5A": Column(1.83, 33.02, (1.02, 0.49, 105.93), (0.94, 0.90, 5.14, 2.027, 1.19, 0.22, 17.70, 3.21), 3),
    "Q5D": Column(1.77, 33.66, (0.89, 0.29, 111.36), (0.90, 0.845, 4.87, 1.957, 1.14, 0.21, 17.08, 3.10), 4),
    "Q5K": Column(1.39, 33.69, (1.94, -0.25, 110.01), (1.00, 0.765, 5.38, 2.09, 1.19, 0.22, 18.93, 3.43), 4),
    "Q5N": Column(1.81, 32.96, (1.16, 0.38, 106.75), (0.92, 0.895, 5.08, 2.00, 1.22, 0.22, 17.45, 3.16), 3),
}


def group_deviations(regressors: Array, case: Case, column: Column) -> Array:
    """Standard deviations by group of model 5 from unscaled regressors, shape (n, 6, 14) -> (8,)."""
    model = identification_model(case, 5)
    rows = regressors.reshape(-1, 14)
    covariance = column.s0**2 * np.linalg.inv(rows.T @ rows)
    linear = np.r_[column.mass, column.mass * np.array(column.centre) * 1e-3, np.zeros(10)]
    form = physical_form(model)
    std = dict(zip([p.name for p in form.parameters], np.sqrt(np.diag(form.of(linear, covariance)[1])), strict=True))
    return np.array([
        std["m"], 1e3 * (std["xC"] + std["yC"]) / 2, 1e3 * std["zC"],
        np.mean([std[f"f_q0_{k}"] for k in range(1, 7)]), std["k0"], std["k1"], std["k2"], std["k3"],
    ])  # fmt: skip


@dataclass(frozen=True)
class Table5:
    """Ours.

    Args:
        deviations: by column, Q5K in its two readings Q5K and Q5K', each of shape (8,).
        fewest: poses that Algorithm 1 ends at.
    """

    deviations: dict[str, Array]
    fewest: dict[str, int]


def table_5(case: Case) -> Table5:
    """Computes all columns for the frame and the poses of a case."""
    model = identification_model(case, 5)
    unscaled = pose_regressors(model, grid_candidates(case))
    scaled = unscaled * candidate_scaling(unscaled)
    reductions = {f"Q5{c}": reduce_best(scaled, Criterion(c), 1) for c in "ADKN"}
    reductions["Q5K'"] = reduce_best(scaled, Criterion("K"), 1, smallest_change=True)
    deviations = {"Q5M": group_deviations(unscaled, case, PUBLISHED["Q5M"])}
    for name, (_, removed) in reductions.items():
        left = np.setdiff1d(np.arange(len(unscaled)), removed[: len(unscaled) - LEFT])
        deviations[name] = group_deviations(unscaled[left], case, PUBLISHED[name.rstrip("'")])
    return Table5(deviations, {name: len(kept) for name, (kept, _) in reductions.items()})


def rows_of(table: Table5) -> list[list[str]]:
    """Rows for printing: each column published, ours, and the deviation."""
    names = ("Q5M", "Q5A", "Q5D", "Q5K", "Q5K'", "Q5N")
    rows = []
    for k, group in enumerate(GROUPS):
        row = [f"{group} in {UNITS[k]}"]
        for name in names:
            published, ours = PUBLISHED[name.rstrip("'")].deviations[k], table.deviations[name][k]
            row.append(f"{published:.3g} / {ours:.3g} {100 * (ours / published - 1):+.0f} %")
        rows.append(row)
    fewest = [f"{PUBLISHED[n.rstrip(chr(39))].fewest or '-'} / {table.fewest.get(n, '-')}" for n in names]
    return [*rows, ["Min. poses", *fewest]]


COLUMNS = ("published / ours", "Q5M", "Q5A", "Q5D", "Q5K best", "Q5K change", "Q5N")
