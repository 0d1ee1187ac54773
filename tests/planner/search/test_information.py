"""Information of a motion: log det in CasADi, the mean over a motion, and what scaling does to it."""

from dataclasses import replace

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import box_middle, uniform_states
from identification.machines.casadi_batch import over_samples
from identification.model.model import Model, identification_model
from planner.families.fourier import FourierFamily
from planner.noise import mean_information
from planner.search.nlp import regressor_kernel


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> FourierFamily:
    return FourierFamily(3, 3.0, 2, *box_middle(hexapod_case))


@pytest.mark.parametrize("number", [0, 6, 9])
def test_the_regressor_of_a_state_is_the_models_scaled(number: int, hexapod_case: Case):
    model = identification_model(hexapod_case, number)
    size = len(model.parameters)
    scaling = np.random.default_rng(1).uniform(0.1, 10.0, size)
    states = uniform_states(hexapod_case, 20, seed=2)
    expected = over_samples(model.coordinate_regressor, *states)[0] * scaling
    table = np.hstack([*states, np.zeros((20, 1))])
    assert regressor_kernel(model, scaling).values(table).reshape(20, 6, size) == pytest.approx(expected, abs=1e-10)


def test_the_mean_does_not_depend_on_how_often_a_motion_repeats(
    model: Model, scaling: np.ndarray, family: FourierFamily
):
    unknowns = 0.2 * np.random.default_rng(0).normal(size=family.unknowns * 6)
    one, two = (mean_information(model, scaling, replace(family, repeats=n).motion(unknowns)) for n in (1, 2))
    assert np.allclose(one, two, rtol=1e-9, atol=1e-12)


def test_another_scaling_adds_the_same_to_every_motion(model: Model, scaling: np.ndarray, family: FourierFamily):
    draw = np.random.default_rng(0)
    other = scaling * draw.uniform(0.1, 10.0, len(scaling))
    for _ in range(3):
        motion = family.motion(0.2 * draw.normal(size=family.unknowns * 6))
        a, b = (np.linalg.slogdet(mean_information(model, s, motion))[1] for s in (scaling, other))
        assert b - a == pytest.approx(2 * np.log(other / scaling).sum(), abs=1e-8)
