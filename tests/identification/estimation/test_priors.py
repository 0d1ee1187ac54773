"""Priors help where data are silent, step back where data speak, and tell where they disagree."""

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from identification.estimation import priors as solver
from identification.estimation.estimators import EACH, Method, per_channel
from identification.estimation.fit import Filtered, Fit, Regression, gauss_markov
from identification.estimation.priors import Prior, as_measurements, conflict_of, with_priors
from tests.helpers import few, one_line, paper_poses, taylor_slope
from tests.identification.moving_run import FORM, MODEL, NAMES, ONES, PHYSICAL, SAMPLES, A, U, coverage, forces

Array = np.ndarray
STILL = np.zeros((480, 6))
STATIC = MODEL.matrices(*paper_poses(), STILL, STILL)
CAD = [  # Table 3: mass, centre of gravity, inertia as designed
    Prior("m", 33.0, 1.0), Prior("xC", 0.0, 0.02), Prior("yC", 0.0, 0.02), Prior("zC", 0.128, 0.02),
    Prior("IC11", 1.65, 0.5), Prior("IC12", 0.0, 0.5), Prior("IC13", 0.0, 0.5), Prior("IC22", 1.65, 0.5),
    Prior("IC23", 0.0, 0.5), Prior("IC33", 1.51, 0.5),
]  # fmt: skip
LINEAR = [Prior("m", 31.0, 0.03), Prior("myC", -0.02, 0.01), Prior("I23", 0.01, 0.005), Prior("k1", -9.0, 0.3)]
BODY = PHYSICAL[:10]
STD = dict(zip(BODY, [0.05, 5e-4, 5e-4, 5e-4, 0.01, 0.005, 0.005, 0.01, 0.005, 0.01], strict=True))


def estimated(seed: int, priors: list[Prior]) -> tuple[Fit, list[float]]:
    """The fit, and the conflict of each prior with it."""
    fit = with_priors(Regression(A, forces(seed), NAMES), MODEL, ONES, priors)
    return fit, conflicts_of(fit, priors)


def conflicts_of(fit: Fit, priors: list[Prior]) -> list[float]:
    values, rows = as_measurements(priors, MODEL)(fit.values)
    variances = np.einsum("ij,jk,ik->i", rows, fit.covariance, rows)
    return [conflict_of(*one) for one in zip(priors, values, variances, strict=True)]


def test_linear_priors_give_the_mean_of_data_and_prior_weighted_by_their_information() -> None:
    """The normal equations of both: (F / s0^2 + P) u = A^T f / s0^2 + P value."""
    free = gauss_markov(Regression(A, forces(0), NAMES), ONES)
    rows, values = np.zeros((4, 20)), np.array([p.value / p.std for p in LINEAR])
    for k, prior in enumerate(LINEAR):
        rows[k, NAMES.index(prior.name)] = 1.0 / prior.std
    information = np.linalg.inv(free.covariance)
    covariance = np.linalg.inv(information + rows.T @ rows)
    found, _ = estimated(0, LINEAR)
    np.testing.assert_allclose(
        found.values, covariance @ (information @ free.values + rows.T @ values), rtol=1e-7, atol=1e-9
    )
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-7, atol=1e-12)
    assert (found.white_noise, found.freedom) == (pytest.approx(free.white_noise), free.freedom)


def test_a_prior_that_says_nothing_changes_nothing() -> None:
    free = gauss_markov(Regression(A, forces(0), NAMES), ONES)
    found, _ = estimated(0, [Prior("m", 0.0, 1e9), Prior("zC", 0.0, 1e9)])
    np.testing.assert_allclose(found.values, free.values, rtol=1e-8)
    np.testing.assert_allclose(found.covariance, free.covariance, rtol=1e-8, atol=1e-14)


def test_a_prior_that_is_nearly_certain_fixes_its_parameter() -> None:
    found, _ = estimated(0, [Prior("zC", 0.1, 1e-8), Prior("IC11", 1.3, 1e-7)])
    values, covariance = FORM.of(found.values, found.covariance)
    for name, value, std in (("zC", 0.1, 1e-8), ("IC11", 1.3, 1e-7)):
        assert values[PHYSICAL.index(name)] == pytest.approx(value, abs=5 * std)
        assert covariance[PHYSICAL.index(name), PHYSICAL.index(name)] == pytest.approx(std**2, rel=1e-3)


def test_the_search_ends_at_the_most_probable_parameters() -> None:
    """Priors on centre and central inertia are not linear in u: the gradient of both parts vanishes together."""
    found, _ = estimated(0, CAD)
    values, rows = as_measurements(CAD, MODEL)(found.values)
    stated, std_of_priors = (np.array([p[k] for p in CAD]) for k in (1, 2))
    of_data = A.reshape(-1, 20).T @ found.residuals.ravel() / found.white_noise**2
    of_priors = rows.T @ ((stated - values) / std_of_priors**2)
    std = np.sqrt(np.diag(found.covariance))
    np.testing.assert_allclose((of_data + of_priors) * std, 0.0, atol=1e-6)


def test_priors_as_rows_have_the_right_derivative() -> None:
    at, direction = as_measurements((*CAD, *LINEAR[1:]), MODEL), np.random.default_rng(0).normal(size=20)
    slope = taylor_slope(lambda h: at(U + h * direction)[0], 0.0, at(U)[1] @ direction, 0.1)
    assert slope == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("taken", range(4))
def test_a_conflict_is_that_with_an_estimate_without_the_prior(taken: int) -> None:
    prior, rest = LINEAR[taken], [p for k, p in enumerate(LINEAR) if k != taken]
    (_, conflicts), without = estimated(0, LINEAR), estimated(0, rest)[0]
    k = NAMES.index(prior.name)
    std = np.sqrt(without.covariance[k, k])
    expected = (prior.value - without.values[k]) / np.hypot(std, prior.std)
    assert conflicts[taken] == pytest.approx(expected, rel=1e-5)


def with_drawn_priors(seed: int) -> tuple[Fit, list[float]]:
    """Designs scatter about the truth as their standard deviations say."""
    draw, truth = np.random.default_rng(5000 + seed), FORM.of(U, np.eye(20))[0]
    return estimated(
        seed, [Prior(n, v + STD[n] * draw.normal(), STD[n]) for n, v in zip(BODY, truth[:10], strict=True)]
    )


@pytest.mark.parametrize("robust", few(True, False))
def test_intervals_hold_the_truth_in_95_of_100_if_the_priors_do(robust: bool) -> None:
    def fit(seed: int) -> Fit:
        return with_drawn_priors(seed)[0]

    assert 0.92 <= coverage(fit, U, robust=robust) <= 0.98


def test_honest_priors_conflict_as_a_standard_normal_and_wrong_ones_stand_out() -> None:
    conflicts = [with_drawn_priors(s)[1] for s in range(60)]
    assert np.std(conflicts) == pytest.approx(1.0, abs=0.1)
    assert np.mean(conflicts) == pytest.approx(0.0, abs=0.15)
    wrong, (conflict,) = estimated(0, [Prior("m", 33.0, 0.05)])
    assert conflict > 10.0
    free = gauss_markov(Regression(A, forces(0), NAMES), ONES)
    assert wrong.white_noise == pytest.approx(free.white_noise)  # it does not hide in the noise


def test_inertia_that_a_standstill_cannot_show_comes_from_the_design_alone() -> None:
    measured = STATIC @ U + np.random.default_rng(0).normal(size=(480, 6))
    found, names = with_priors(Regression(STATIC, measured, NAMES), MODEL, ONES, CAD), [p.name for p in CAD]
    conflicts = conflicts_of(found, CAD)
    estimates, rows = as_measurements(CAD, MODEL)(found.values)
    std = np.sqrt(np.einsum("ij,jk,ik->i", rows, found.covariance, rows))
    for name, nominal in (("IC11", 1.65), ("IC12", 0.0), ("IC33", 1.51)):
        k = names.index(name)
        assert conflicts[k] == pytest.approx(0.0, abs=1e-3)
        assert (estimates[k], std[k]) == (pytest.approx(nominal, abs=1e-9), pytest.approx(0.5))
    static = gauss_markov(Regression(STATIC[:, :, [0, 1, 2, 3, *range(10, 20)]], measured, [""] * 14), ONES)
    assert (found.white_noise, found.freedom) == (pytest.approx(static.white_noise), static.freedom)


def test_what_neither_data_nor_priors_determine_is_named() -> None:
    with pytest.raises(IdentificationError, match=r"rank 19 of 20: I23\b") as caught:
        with_priors(Regression(STATIC, STATIC @ U, NAMES), MODEL, ONES, [p for p in CAD if p.name != "IC23"])
    one_line(caught.value)


def test_a_filter_and_nuisances_are_treated_as_in_the_linear_estimate() -> None:
    late, filtered = np.random.default_rng(2).normal(size=(SAMPLES, 6, 1)), Filtered(0.1, 5)
    wide = np.dstack([A, late])
    regression = Regression(wide, forces(0), [*NAMES, "delay"], 1, filtered)
    expected = gauss_markov(regression, ONES)
    found = with_priors(regression, MODEL, ONES, [Prior("m", 0.0, 1e9)])
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-7)
    np.testing.assert_allclose(found.covariance, expected.covariance, rtol=1e-7, atol=1e-13)
    assert (found.white_noise, found.freedom) == (pytest.approx(expected.white_noise), pytest.approx(expected.freedom))


def test_data_without_noise_overrule_every_prior() -> None:
    found = with_priors(Regression(A, A @ U, NAMES), MODEL, ONES, CAD)
    np.testing.assert_allclose(found.values, U, rtol=1e-7, atol=1e-8)


def test_without_priors_it_is_gauss_markov() -> None:
    np.testing.assert_allclose(
        estimated(0, [])[0].values, gauss_markov(Regression(A, forces(0), NAMES), ONES).values, rtol=1e-8
    )


def test_a_search_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solver, "EVALUATIONS", 1)
    with pytest.raises(IdentificationError, match="no minimum was found with these priors"):
        with_priors(Regression(A, forces(0), NAMES), MODEL, ONES, CAD)


@pytest.mark.parametrize(
    ("priors", "message"),
    [
        ([Prior("mass", 33.0, 1.0)], "'mass' is not a parameter here; choose from m, mxC, .*k3, xC, .*IC33"),
        ([Prior("m", 33.0, 1.0), Prior("m", 34.0, 1.0)], "two priors on m; combine them into one"),
        (
            [Prior("m", 33.0, 0.0)],
            r"prior m = 33 \+- 0 needs .* a standard deviation above 0; .* known value",
        ),
        ([Prior("m", np.nan, 1.0)], "prior m = nan"),
        ([Prior("m", 33.0, np.inf)], r"prior m = 33 \+- inf"),
    ],
)
def test_priors_that_cannot_be_used_are_said_in_a_line(priors: list[Prior], message: str) -> None:
    with pytest.raises(IdentificationError, match=message) as caught:
        with_priors(Regression(A, forces(0), NAMES), MODEL, ONES, priors)
    one_line(caught.value)


def test_channels_are_weighed_where_only_priors_determine_all_parameters() -> None:
    """A run that stands determines no inertia: weights follow from its residuals, the inertia from the priors."""
    noise = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 20.0])
    measured = STATIC @ U + np.random.default_rng(3).normal(size=(len(STATIC), 6)) * noise
    regression = Regression(STATIC, measured, NAMES, alike=EACH)
    with pytest.raises(IdentificationError):
        per_channel(regression)
    fit = Method(priors=tuple(CAD)).estimate(regression, MODEL)
    ratios = fit.weights[5] / fit.weights[:5]
    assert np.all((ratios > 0.25 / 400.0) & (ratios < 4.0 / 400.0))
    spanned = regression.within_span()
    assert spanned.regressors.shape[2] < STATIC.shape[2]
    exact = np.linalg.lstsq(STATIC.reshape(-1, STATIC.shape[2]), measured.ravel(), rcond=1e-12)[0]
    left = np.linalg.lstsq(spanned.regressors.reshape(-1, spanned.regressors.shape[2]), measured.ravel())[0]
    np.testing.assert_allclose(spanned.residuals(left), regression.residuals(exact), atol=1e-6)


def test_weights_of_a_run_that_determines_all_are_as_without_priors() -> None:
    regression = Regression(A, forces(0), NAMES, alike=EACH)
    assert regression.within_span() is regression
