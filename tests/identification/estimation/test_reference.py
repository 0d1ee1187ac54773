"""The reference scaling belongs to case and model, not to a motion."""

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.schema import Case, load_case
from identification.estimation.criteria import information, reference_scaling, uniform_states
from identification.model.model import identification_model

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)


def test_scaled_columns_have_a_mean_square_of_one_a_sample_over_the_box() -> None:
    """Seen with other states than those it was made of, 20 000 of them: within 3 %."""
    scaling = reference_scaling(CASE, MODEL)
    mean_square = np.diag(information(MODEL, scaling, uniform_states(CASE, 20_000, seed=7)))
    np.testing.assert_allclose(mean_square, 1.0, rtol=0.03)


def test_it_is_the_same_every_time() -> None:
    np.testing.assert_array_equal(reference_scaling(CASE, MODEL), reference_scaling(CASE, MODEL))


def test_offsets_are_scaled_by_one() -> None:
    """Each offset acts on one of the six sensors with 1, so its column has a mean square of 1 a sample."""
    scaling = dict(zip(MODEL.names, reference_scaling(CASE, MODEL), strict=True))
    assert {scaling[f"f_q0_{k}"] for k in range(1, 7)} == {1.0}


def test_uniform_states_fill_the_box_and_stay_inside() -> None:
    (poses, rates, accelerations), box = uniform_states(CASE, 5000, seed=0), CASE.limits.motion
    relative = poses - CASE.machine.home.vector
    for values, low, high in (
        (relative, *box.coordinates),
        (rates, -box.rate, box.rate),
        (accelerations, -box.acceleration, box.acceleration),
    ):
        assert np.all((values >= low) & (values <= high))
        np.testing.assert_allclose(np.ptp(values, axis=0), high - low, rtol=0.01)
        np.testing.assert_allclose(values.var(axis=0), (high - low) ** 2 / 12, rtol=0.06)


def test_information_is_the_mean_over_states_so_that_twice_the_time_is_worth_the_same() -> None:
    states, scaling = uniform_states(CASE, 300, seed=1), np.ones(20)
    twice = tuple(np.vstack([a, a]) for a in states)
    once = information(MODEL, scaling, states)
    np.testing.assert_allclose(information(MODEL, scaling, twice), once, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(once, once.T)
    assert np.linalg.eigvalsh(once).min() > 0.0


def test_a_case_without_machine_has_no_box(wrist_case: Case) -> None:
    with pytest.raises(CaseError, match=r"machine: .*missing.*reference scaling"):
        reference_scaling(wrist_case, identification_model(wrist_case, 6))
