"""Further estimators of one run: a symmetric platform, gross errors, channels that err together, and the form (18)."""

from dataclasses import replace

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from cases.schema import load_case
from identification.estimation.estimators import EACH, Method, huber, huber_of, symmetric_platform
from identification.estimation.fit import Regression, gauss_markov
from identification.estimation.priors import Prior
from identification.fitting import fitted_run
from identification.identify import identify
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.samples.samples import Fitted
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, one_line
from tests.identification.moving_run import NAMES, A, U, forces
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
RUN = simulate_recording(CASE, PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.0)), np.array([[0.15, 1.85]]), 0)


def fitted(method: Method) -> Fitted:
    return fitted_run(RUN, CASE, MODEL, method).fitted


def values(found: Fitted) -> np.ndarray:
    return found.fit.values[:20]


def deviations(found: Fitted) -> np.ndarray:
    return np.sqrt(np.diag(found.fit.covariance))[:20]


def test_a_symmetric_platform_has_five_parameters_fewer() -> None:
    known = symmetric_platform(MODEL)
    assert known == {"xC": 0.0, "yC": 0.0, "I12": 0.0, "I13": 0.0, "I23": 0.0}
    found = fitted(Method(known))
    assert found.fit.rank == 15
    named = dict(zip(MODEL.names, values(found), strict=True))
    assert [named[n] for n in ("mxC", "myC", "I12", "I13", "I23")] == [0.0] * 5
    assert symmetric_platform(identification_model(CASE, 5)) == {"xC": 0.0, "yC": 0.0}  # it has no inertia


@pytest.mark.parametrize("known", [{}, {"xC": 0.0}, {"m": 31.8, "k0": 24.0}])
def test_the_non_linear_form_ends_at_the_linear_estimate(known: dict[str, float]) -> None:
    """Its minimum is the same where all is free, and where what is known is linear."""
    linear, other = fitted(Method(known)), fitted(Method(known, nonlinear=True))
    std = np.maximum(deviations(linear), 1e-9)
    assert np.abs((values(other) - values(linear)) / std).max() < 1e-3
    np.testing.assert_allclose(deviations(other), deviations(linear), rtol=1e-3, atol=1e-9)


def test_the_non_linear_form_takes_central_inertia_as_known() -> None:
    result = identify(RUN, CASE, 9, how=Method({"IC33": 0.95, "IC12": 0.0}, nonlinear=True))
    assert result["IC33"].value == pytest.approx(0.95, rel=1e-9)
    assert result["IC33"].reported < 1e-6
    assert result["IC12"].value == pytest.approx(0.0, abs=1e-9)
    free = identify(RUN, CASE, 9)
    assert result.record.rank == free.record.rank - 2
    assert 0.0 < result["IC11"].std <= 1.1 * free["IC11"].std
    assert any("(18)" in note and "Gauss-Newton steps" in note for note in result.notes)


def test_the_non_linear_form_is_least_squares_along_what_is_known() -> None:
    """Residuals are at right angles to the local Jacobian, and not to the column of what is known."""
    found = fitted(Method({"IC33": 0.95}, nonlinear=True))
    residuals = found.regression.residuals(found.fit.values).ravel()
    jacobian = (found.regression.regressors[:, :, :20] @ found.method.selection(MODEL).basis).reshape(
        len(residuals), -1
    )
    angles = residuals @ jacobian / np.linalg.norm(residuals) / np.linalg.norm(jacobian, axis=0)
    np.testing.assert_allclose(angles, 0.0, atol=1e-7)
    own = found.regression.regressors[:, :, MODEL.names.index("I33")].ravel()
    assert abs(residuals @ own) / np.linalg.norm(residuals) / np.linalg.norm(own) > 1e-3


def test_names_of_the_linear_form_are_refused_by_the_other_one() -> None:
    with pytest.raises(IdentificationError, match=r"I33.*IC33") as caught:
        fitted(Method({"I33": 0.9}, nonlinear=True))
    one_line(caught.value)
    with pytest.raises(IdentificationError, match="nonlinear") as caught:
        fitted(Method({"IC33": 0.9}))
    one_line(caught.value)


def test_gross_errors_count_less_by_hubers_weights() -> None:
    draw = np.random.default_rng(3)
    resisted, ruined = [], []
    for seed in range(6):
        clean = forces(seed)
        wrong = (draw.random(clean.shape) < 0.03) * draw.uniform(20.0, 200.0, clean.shape)
        regression = Regression(A, clean + wrong, NAMES, alike=EACH)
        resisted.append(np.abs(huber_of(regression).values - U).max())
        ruined.append(np.abs(gauss_markov(regression, np.ones(6)).values - U).max())
    assert np.mean(resisted) < 0.2 * np.mean(ruined)


def test_hubers_covariance_is_the_scatter_of_its_estimates() -> None:
    runs = [huber_of(Regression(A, forces(s), NAMES, alike=EACH)) for s in range(60)]
    z = np.array([(r.values - U) / np.sqrt(np.diag(r.covariance)) for r in runs])
    assert np.mean(z**2) == pytest.approx(1.0, abs=0.15)
    np.testing.assert_array_equal(runs[0].values, huber(Regression(A, forces(0), NAMES, alike=EACH)))


def test_full_weights_know_channels_that_err_together() -> None:
    """Noise that is alike in all six channels: W from all of them takes it out of what only some of them read."""
    assert RUN.t is not None
    common = 5.0 * np.random.default_rng(5).normal(size=(len(RUN.t), 1))
    run = replace(RUN, forces=RUN.forces + common)
    each, full = (fitted_run(run, CASE, MODEL, Method(weights=w)).fitted for w in ("per_channel", "full"))
    assert full.fit.white_noise == pytest.approx(1.0, rel=0.1)
    assert deviations(full)[0] < deviations(each)[0]
    true = CASE.need_simulation("the test").parameters.body.mass_kg
    assert abs(full.fit.values[0] - true) < 4.0 * deviations(full)[0]
    noise = np.linalg.inv(full.w)
    assert noise[0, 1] / np.sqrt(noise[0, 0] * noise[1, 1]) == pytest.approx(25.0 / 26.0, abs=0.03)


@pytest.mark.parametrize("how", [{"weights": "full"}, {"weights": "huber"}, {"nonlinear": True}])
def test_full_weights_huber_and_the_non_linear_form_do_not_go_with_priors(how: dict[str, object]) -> None:
    with pytest.raises(IdentificationError, match="priors go with") as caught:
        Method(priors=(Prior("m", 30.0, 1.0),), **how)
    one_line(caught.value)
