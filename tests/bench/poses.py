"""Figures of quasi-static measurement: Tables 3 and 5, times of the selection, efficiency and measuring time."""

import time
import tracemalloc

import numpy as np

from cases.schema import load_case
from identification.estimation.criteria import Criterion, candidate_scaling, pose_regressors
from identification.model.model import identification_model
from planner.poses.planned_poses import grid_candidates, poses_planned, sampled_candidates
from planner.poses.removal import reduce_best
from planner.request import PoseRequest
from tests.bench import table_3, table_5
from tests.bench.tables import print_table

MANY = 20_000


def pose_tables() -> None:
    """Prints Tables 3 and 5 side by side with the paper's."""
    case = load_case("hexapod")
    ours = table_5.table_5(case)
    print_table("Table 5, standard deviations: published / ours", table_5.COLUMNS, table_5.rows_of(ours))
    print_table(
        "Table 3 in simulation: 480 poses, k2 and k3 not zero, 1 N of noise on an averaged force",
        table_3.COLUMNS, table_3.rows_of(case, table_3.table_3(case)),
    )  # fmt: skip


def pose_figures() -> list[list[str]]:
    """Rows of the table of figures."""
    case = load_case("hexapod")
    model = identification_model(case, 5)
    grid = _scaled(model, grid_candidates(case))
    rows = []
    for letter in Criterion:
        began = time.perf_counter()
        reduce_best(grid, letter, 30)
        rows.append([f"480 -> 30 poses, {letter}", f"{time.perf_counter() - began:.2f} s", "3 s"])
    began = time.perf_counter()
    reduce_best(grid, Criterion("K"), 30, smallest_change=True)
    rows.append(["480 -> 30 poses, K by smallest change", f"{time.perf_counter() - began:.2f} s", "3 s"])
    many = _scaled(model, sampled_candidates(case, MANY, 0))
    began, worked = time.perf_counter(), time.process_time()
    reduce_best(many, Criterion("D"), 30)
    spent = f"{time.perf_counter() - began:.1f} s ({time.process_time() - worked:.1f} s of CPU)"
    rows.append([f"{MANY} -> 30 poses, D", spent, "30 s"])
    tracemalloc.start()
    reduce_best(many[:2000], Criterion("D"), 30)
    peak = tracemalloc.get_traced_memory()[1] / 1e9
    tracemalloc.stop()
    rows.append(["  memory of 20 000 (traced at 2000, times ten)", f"{10 * peak + many.nbytes / 1e9:.2f} GB", "2 GB"])
    for method in ("backward", "refine"):
        plan = poses_planned(PoseRequest(method=method), case)
        rows += [
            [f"30 poses by {method}: D-efficiency over the candidates", f"{plan.worth.efficiency:.4f}", "0.99"],
            ["  measured in, travel included", f"{plan.motion.duration:.1f} s", "81 s"],
        ]
    return rows


def _scaled(model: object, poses: np.ndarray) -> np.ndarray:
    regressors = pose_regressors(model, poses)
    return np.asarray(regressors * candidate_scaling(regressors))
