"""Algorithm 1 removes what an exhaustive search removes, ends at full rank, and keeps what the paper says is kept."""

import numpy as np
import pytest
from numpy.typing import NDArray

from identification.estimation.criteria import Criterion, total_information
from planner.poses.removal import full_rank, reduce_best
from tests.planner.poses.conftest import Setting

LETTERS = tuple(Criterion)


def by_definition(letter: str, matrix: NDArray[np.float64]) -> float:
    """Table 4 from the singular values of the stacked regressor."""
    mu = np.linalg.svd(matrix.reshape(-1, matrix.shape[2]), compute_uv=False)
    return {
        "A": -float(np.sum(mu**-2)), "D": 2 * float(np.log(mu).sum()),
        "K": -float(mu[0] / mu[-1]), "N": float(mu[-1] ** 2 / mu[0]),
    }[letter]  # fmt: skip


def exhaustive(regressors: NDArray[np.float64], letter: str, count: int) -> list[int]:
    """Algorithm 1 word by word, with the sign corrected."""
    left = list(range(len(regressors)))
    while len(left) > count:
        values = [by_definition(letter, regressors[[k for k in left if k != j]]) for j in left]
        left.pop(int(np.argmax(values)))
    return left


@pytest.mark.first(2)
@pytest.mark.parametrize("letter", LETTERS)
def test_the_fast_algorithm_keeps_the_poses_of_the_slow_one(sample: Setting, letter: str) -> None:
    some = sample.regressors[:100]
    kept, removed = reduce_best(some, letter, 20)
    assert kept.tolist() == exhaustive(some, letter, 20)
    assert sorted([*removed, *kept]) == list(range(100))


@pytest.mark.slow
def test_the_fast_algorithm_keeps_its_word_where_bounds_must_be_renewed(grid: Setting) -> None:
    """Against exact values of every removal, step by step, on the symmetric grid, where many are equally good."""
    for criterion in Criterion:
        left = np.arange(480)
        for pose in reduce_best(grid.regressors, criterion, 400)[1]:
            information = total_information(grid.regressors[left])
            products = grid.regressors[left].transpose(0, 2, 1) @ grid.regressors[left]
            left = left[left != pose]
            value = criterion.of(total_information(grid.regressors[left]))
            assert value == pytest.approx(criterion.of(information - products).max(), rel=1e-9)


@pytest.mark.parametrize("letter", LETTERS)
def test_values_after_a_removal_are_those_of_the_smaller_set(sample: Setting, letter: Criterion) -> None:
    criterion, information = letter, total_information(sample.regressors[:40])
    quick = criterion.after_removal(information, sample.regressors[:40])
    slow = [by_definition(letter, np.delete(sample.regressors[:40], k, axis=0)) for k in range(40)]
    np.testing.assert_allclose(quick, slow, rtol=1e-9)


@pytest.mark.first(1)
@pytest.mark.parametrize("letter", LETTERS)
def test_14_parameters_need_3_poses_of_6_sensors_and_the_algorithm_gets_there(grid: Setting, letter: str) -> None:
    """The paper's row "Min. poses" has 3 (A, N) and 4 (D, K); the theoretical minimum is 14 / 6, rounded up."""
    kept, _ = reduce_best(grid.regressors, letter, 1)
    assert len(kept) == 3
    assert full_rank(grid.regressors[kept])
    for pose in kept:
        assert not full_rank(grid.regressors[kept[kept != pose]])


def test_earlier_stages_of_a_reduction_are_kept(grid: Setting) -> None:
    (few, most), (halfway, removed) = (reduce_best(grid.regressors, Criterion("D"), n) for n in (1, 30))
    later = np.setdiff1d(most, removed)
    np.testing.assert_array_equal(np.sort(np.r_[few, later]), halfway)
    np.testing.assert_array_equal(most[: len(removed)], removed)


@pytest.mark.repeats
def test_both_readings_of_k_reduce_and_differ(grid: Setting) -> None:
    best, _ = reduce_best(grid.regressors, Criterion("K"), 30)
    change, removed = reduce_best(grid.regressors, Criterion("K"), 30, smallest_change=True)
    assert set(best) != set(change)
    by_best, by_change = (by_definition("K", grid.regressors[kept]) for kept in (best, change))
    assert by_best > by_change  # what looks for the best condition finds the better one
    start = -np.linalg.cond(grid.regressors.reshape(-1, 14))
    assert abs(by_definition("K", np.delete(grid.regressors, removed[0], axis=0)) - start) <= np.min(
        np.abs([by_definition("K", np.delete(grid.regressors, k, axis=0)) - start for k in range(0, 480, 37)])
    ) * (1 + 1e-9)  # fmt: skip


def test_poses_far_out_and_strongly_tilted_are_preferred(grid: Setting) -> None:
    """Section 6: high absolute positions and large inclinations are preferred (Figure 4)."""
    kept = reduce_best(grid.regressors, Criterion("D"), 30)[0]
    radius = np.hypot(grid.poses[:, 0], grid.poses[:, 1])
    tilt = np.cos(grid.poses[:, 3]) * np.cos(grid.poses[:, 4])
    assert radius[kept].mean() > 1.1 * radius.mean()
    assert np.mean(tilt[kept] < np.cos(np.deg2rad(15.0))) > 0.65
