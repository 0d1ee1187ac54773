"""Refining poses, and the designs that bound what any of it can reach."""

import cvxpy as cp
import numpy as np
import pytest

from identification.estimation.criteria import Criterion, pose_regressors, total_information
from planner.poses.planned_poses import candidate_design
from planner.poses.removal import full_rank, reduce_best, refine
from planner.poses.space import valid_poses
from tests.helpers import few
from tests.planner.poses.conftest import Setting


def value(letter: str, regressors: np.ndarray) -> float:
    return float(Criterion(letter).of(total_information(regressors)))


def test_the_approximate_design_is_that_of_a_convex_solver(sample: Setting) -> None:
    some = sample.regressors[:60]
    design = candidate_design(some)
    products = some.transpose(0, 2, 1) @ some
    weights = cp.Variable(60, nonneg=True)
    information = sum(weights[k] * products[k] for k in range(60))
    problem = cp.Problem(cp.Maximize(cp.log_det(information)), [cp.sum(weights) == 1])  # type: ignore[attr-defined]
    problem.solve(solver=cp.CLARABEL)
    best = float(problem.value)
    assert design.logdet <= best + 1e-6
    assert design.bound(14) == pytest.approx(best, abs=14 * 1.1e-3)
    assert design.bound(14) >= best - 1e-6
    assert design.weights.sum() == pytest.approx(1.0)


def test_no_set_of_candidates_passes_the_bound(sample: Setting) -> None:
    bound, draw = candidate_design(sample.regressors).bound(14), np.random.default_rng(4)
    for _ in range(100):
        subset = draw.choice(200, size=int(draw.integers(5, 100)), replace=True)
        assert value("D", sample.regressors[subset]) - 14 * np.log(len(subset)) <= bound


def test_30_of_480_poses_by_algorithm_1_carry_nearly_all_that_any_30_could(grid: Setting) -> None:
    bound = candidate_design(grid.regressors).bound(14)
    kept = reduce_best(grid.regressors, Criterion("D"), 30)[0]
    mean = value("D", grid.regressors[kept]) - 14 * np.log(30)
    assert 0.99 < np.exp((mean - bound) / 14) <= 1.0


@pytest.mark.first(1)
@pytest.mark.parametrize("letter", few(*"DNAK", kept=2))
def test_refinement_finds_better_poses_that_are_all_valid(sample: Setting, letter: str) -> None:
    start = reduce_best(sample.regressors, Criterion(letter), 10)[0]
    found, _ = refine(sample.case, sample.model, sample.scaling, Criterion(letter), sample.poses[start])
    exact = value(letter, pose_regressors(sample.model, found) * sample.scaling)
    assert exact > value(letter, sample.regressors[start])
    assert valid_poses(sample.case, found).all()


def exact(found: np.ndarray, sample: Setting, known: np.ndarray | float) -> float:
    """Determinant's logarithm of poses and of what is known, from the regressor itself."""
    regressors = pose_regressors(sample.model, found) * sample.scaling
    return float(np.linalg.slogdet(total_information(regressors) + known)[1])


def test_poses_beside_what_is_known_measure_what_is_missing(sample: Setting) -> None:
    """Known are ten poses that all lean to one side, measured twenty times: what leans to the other adds most."""
    criterion = Criterion.D
    alone = reduce_best(sample.regressors, criterion, 10)[0]
    known = 20.0 * total_information(sample.regressors[np.argsort(sample.poses[:, 3])[-10:]])
    beside = reduce_best(sample.regressors, criterion, 10, known=known)[0]
    assert full_rank(sample.regressors[beside])
    joint, single = ([exact(sample.poses[kept], sample, more) for kept in (alone, beside)] for more in (known, 0.0))
    assert joint[1] > joint[0] + 1.0
    assert single[1] < single[0] - 1.0
    found, _ = refine(sample.case, sample.model, sample.scaling, criterion, sample.poses[beside], known)
    assert exact(found, sample, known) > joint[1] + 0.05
    assert valid_poses(sample.case, found).all()


def test_poses_keep_their_rank_where_all_is_known(sample: Setting) -> None:
    """Results that tell everything leave nothing to choose by, yet a run is evaluated by itself."""
    known = 1e12 * np.eye(14)
    kept, _ = reduce_best(sample.regressors[:40], Criterion.D, 1, known=known)
    assert full_rank(sample.regressors[kept])
    assert all(not full_rank(sample.regressors[np.delete(kept, k)]) for k in range(len(kept)))
