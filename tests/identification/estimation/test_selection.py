"""Partial identification: what is known stays, what is left is the best that can be had beside it."""

from functools import partial

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from cases.schema import load_case
from identification.estimation.estimators import estimate_selected, per_channel
from identification.estimation.fit import Regression, gauss_markov
from identification.model.model import identification_model
from identification.model.parameters import physical_form, select
from tests.helpers import one_line
from tests.identification.moving_run import FORM, MODEL, NAMES, ONES, PHYSICAL, A, coverage, forces, truth_with

EQUAL = partial(gauss_markov, weights=ONES)
FREE = EQUAL(Regression(A, forces(0), NAMES))
KNOWN = {"m": 31.0, "xC": 0.002, "yC": -0.001, "zC": 0.1, "I11": 1.6, "k0": 20.0}


def physical(values: np.ndarray) -> dict[str, float]:
    return dict(zip(PHYSICAL, FORM.of(values, np.zeros((20, 20)))[0], strict=True))


def test_known_values_come_back_exactly_and_without_variance() -> None:
    fit = estimate_selected(Regression(A, forces(0), NAMES), select(MODEL, KNOWN), EQUAL)
    found = physical(fit.values) | dict(zip(NAMES, fit.values, strict=True))
    for name, value in KNOWN.items():
        assert found[name] == pytest.approx(value, rel=1e-10), name
    for covariance in (fit.covariance, fit.covariance_robust):
        std = np.sqrt(np.clip(np.diag(FORM.of(fit.values, covariance)[1]), 0.0, None))
        zero = {name for name, s in zip(PHYSICAL, std, strict=True) if s < 1e-9}
        assert zero == set(KNOWN) - {"I11"} | {"IC11"}
    np.testing.assert_array_equal(fit.covariance[[NAMES.index(n) for n in ("m", "mxC", "k0")]], 0.0)


def test_it_is_the_least_squares_estimate_under_constraints() -> None:
    """With Lagrange's multipliers for the same knowledge, written as rows C u = d."""
    known = {"xC": 0.002, "I12": 0.01, "k0": 20.0, "I33": 0.9}
    rows = {"xC": {"mxC": 1.0, "m": -0.002}, "I12": {"I12": 1.0}, "k0": {"k0": 1.0}, "I33": {"I33": 1.0}}
    c, d = np.zeros((4, 20)), [0.0, 0.01, 20.0, 0.9]
    for k, row in enumerate(rows.values()):
        for name, factor in row.items():
            c[k, NAMES.index(name)] = factor
    matrix, scale = A.reshape(-1, 20), np.linalg.norm(A.reshape(-1, 20), axis=0)
    information = matrix.T @ matrix / np.outer(scale, scale)
    system = np.block([[information, (c / scale).T], [c / scale, np.zeros((4, 4))]])
    right = np.r_[matrix.T @ forces(0).ravel() / scale, d]
    fit = estimate_selected(Regression(A, forces(0), NAMES), select(MODEL, known), EQUAL)
    np.testing.assert_allclose(fit.values, np.linalg.solve(system, right)[:20] / scale, rtol=1e-8, atol=1e-8)
    inverse = np.linalg.inv(system)[:20, :20] / np.outer(scale, scale)
    np.testing.assert_allclose(fit.covariance, fit.white_noise**2 * inverse, rtol=1e-6, atol=1e-12)
    assert fit.freedom == 1200 - 16


def test_knowing_what_the_data_say_anyway_changes_nothing_but_certainty() -> None:
    found = physical(FREE.values)
    known = {name: found[name] for name in ("m", "xC", "yC", "zC", "k3")}
    fit = estimate_selected(Regression(A, forces(0), NAMES), select(MODEL, known), EQUAL)
    np.testing.assert_allclose(fit.values, FREE.values, rtol=1e-8, atol=1e-9)
    assert np.all(np.diag(fit.covariance) <= np.diag(FREE.covariance) * (1.0 + 1e-3))


def test_dropped_columns_are_as_if_they_had_never_been_there() -> None:
    dropped = ("I12", "I13", "I23", "k1")
    keep = [k for k, name in enumerate(NAMES) if name not in dropped]
    expected = EQUAL(Regression(A[:, :, keep], forces(0), [NAMES[k] for k in keep]))
    fit = estimate_selected(Regression(A, forces(0), NAMES), select(MODEL, {}, dropped), EQUAL)
    np.testing.assert_allclose(fit.values[keep], expected.values)
    np.testing.assert_allclose(fit.covariance[np.ix_(keep, keep)], expected.covariance)
    np.testing.assert_array_equal(np.delete(fit.values, keep), 0.0)
    assert fit.rank == 16
    assert fit.condition == pytest.approx(expected.condition)


def test_a_tare_leaves_only_the_offsets() -> None:
    """What was identified before stays, by linear names; new offsets are the mean of what it leaves."""
    known = {name: float(v) for name, v in zip(NAMES, FREE.values, strict=True) if not name.startswith("f_q0")}
    offsets = [name.startswith("f_q0") for name in NAMES]
    fit = estimate_selected(Regression(A[:10], forces(1)[:10], NAMES), select(MODEL, known), EQUAL)
    rest = forces(1)[:10] - A[:10] @ np.where(offsets, 0.0, FREE.values)
    np.testing.assert_allclose(fit.values[offsets], rest.mean(axis=0))


@pytest.mark.parametrize(
    "estimator",
    [EQUAL, per_channel],
    ids=["W=1", "W"],
)
def test_every_estimator_serves_it_and_nuisances_stay_free(estimator) -> None:
    late = np.random.default_rng(2).normal(size=(200, 6, 1))
    late_too = Regression(np.dstack([A, late]), forces(0) + 3.0 * late[:, :, 0], [*NAMES, "delay"])
    fit = estimate_selected(late_too, select(MODEL, {"m": 31.83}), estimator)
    assert fit.values.shape == (21,)
    assert fit.values[0] == 31.83
    assert fit.values[-1] == pytest.approx(3.0, abs=4.0 * np.sqrt(fit.covariance[-1, -1]))


def test_intervals_of_the_rest_hold_the_truth_in_95_of_100() -> None:
    truth = truth_with(centre_of_gravity_mm=(0.0, 0.0, 105.05))
    selection = select(MODEL, dict.fromkeys(("xC", "yC", "I12", "I13", "I23"), 0.0) | {"m": 31.83})

    def fit(seed: int):
        return estimate_selected(Regression(A, forces(seed, truth), NAMES), selection, EQUAL)

    assert 0.92 <= coverage(fit, truth) <= 0.98


@pytest.mark.parametrize(
    ("known", "dropped", "message"),
    [
        ({"mC": 1.0}, (), "'mC' is not a parameter here; .*choose from m, mxC, .*k3, xC, .*IC33"),
        ({}, ("xC",), "'xC' is not a parameter here; .*choose from m, mxC, .*k3$"),
        ({"m": np.nan}, (), "m = nan cannot be a known value"),
        ({"m": 0.0}, (), "m = 0 cannot be a known value; .* a mass above 0"),
        ({"mxC": 0.0, "xC": 0.0}, (), "mxC is given twice"),
        ({"xC": 0.0}, ("mxC",), "mxC is given twice"),
        ({"k0": 0.0}, ("k0",), "k0 is given twice"),
        ({}, ("m",), "m cannot be left out: .*; keep it, or give its value"),
        ({"IC11": 1.2}, (), "IC11 .*cannot be fixed.*; fix I11, .*give it as a prior, or .*nonlinear"),
        ({}, tuple(NAMES), "all parameters are known; leave at least one"),
    ],
)
def test_what_cannot_be_selected_is_said_in_a_line(known, dropped, message: str) -> None:
    with pytest.raises(IdentificationError, match=message) as caught:
        select(MODEL, known, dropped)
    one_line(caught.value)


def test_a_wrist_sensor_is_served_too() -> None:
    model = identification_model(load_case("ft_wrist"), 6)
    names = [p.name for p in physical_form(model).parameters]
    selection = select(model, dict.fromkeys(("xC", "yC", "I12", "I13", "I23"), 0.0))
    assert len(selection.names) == len(names) - 5
    assert not {"mxC", "myC", "I12", "I13", "I23"} & set(selection.names)
