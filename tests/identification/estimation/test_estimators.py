"""Estimators by name: each combination that makes sense gives the right parameters, every other one says why not."""

import numpy as np
import pytest

from cases.errors import IdentificationError
from identification.estimation.channel_weights import EACH
from identification.estimation.estimators import ESTIMATORS, method
from identification.estimation.fit import Regression
from identification.estimation.priors import Prior
from tests.helpers import one_line
from tests.identification.moving_run import MODEL, NAMES, SAMPLES, A, U, forces


@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.parametrize("pooled", [True, False])
def test_every_estimator_finds_the_parameters_within_their_errors(name: str, pooled: bool) -> None:
    fit = method(name).estimate(Regression(A, forces(0), NAMES, alike=None if pooled else EACH), MODEL)
    assert np.abs((fit.values - U) / np.sqrt(np.diag(fit.covariance))).max() < 4.0
    assert fit.s0 == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("name", ["gauss-markov", "robust", "full", "consistent"])
def test_a_known_mass_makes_the_rest_more_certain_and_keeps_its_value(name: str) -> None:
    known = {"m": float(U[0])}
    free, fixed = (method(name, k).estimate(Regression(A, forces(1), NAMES), MODEL) for k in ({}, known))
    assert fixed.values[0] == pytest.approx(U[0], rel=1e-12)
    assert fixed.covariance[0, 0] == pytest.approx(0.0, abs=1e-20)
    k2 = NAMES.index("k2")  # the factor that a static mass hides behind
    assert fixed.covariance[k2, k2] < 0.6 * free.covariance[k2, k2]


def test_the_robust_one_survives_gross_errors_and_says_how_many_samples_lost_weight() -> None:
    measured = forces(2)
    measured[np.random.default_rng(0).integers(0, SAMPLES, 20), 3] += 500.0
    errors = {}
    for name in ("gauss-markov", "robust"):
        fit = method(name).estimate(Regression(A, measured, NAMES), MODEL)
        errors[name] = np.abs(
            (fit.values - U) / np.sqrt(np.diag(method().estimate(Regression(A, forces(2), NAMES), MODEL).covariance))
        )
    assert errors["robust"].max() < 5.0 < errors["gauss-markov"].max()
    (found,) = fit.findings
    assert "count less" in found.sentence


def test_consistency_says_whether_it_bound() -> None:
    (free,) = method("consistent").estimate(Regression(A, forces(3), NAMES), MODEL).findings
    assert "did not bind" in free.sentence
    thin = U.copy()
    thin[NAMES.index("I33")] = 10.0  # larger than the sum of the others, as no body has it
    bound = method("consistent").estimate(Regression(A, forces(3, thin), NAMES), MODEL)
    told, doubt = bound.findings
    assert "the constraint bound" in told.sentence
    assert "no real body" in doubt.sentence
    assert doubt.severity == "warning"


def test_a_prior_that_disagrees_is_told() -> None:
    quiet = method(priors=[Prior("m", float(U[0]), 1.0)]).estimate(Regression(A, forces(4), NAMES), MODEL)
    loud = method(priors=[Prior("m", float(U[0]) + 10.0, 1.0)]).estimate(Regression(A, forces(4), NAMES), MODEL)
    (told,) = quiet.findings
    assert "moved the estimate by" in told.sentence
    assert "prior m disagrees" in loud.findings[1].sentence


REFUSED = {
    "an unknown estimator": (lambda: method("best"), "estimator 'best' is unknown; choose gauss-markov"),
    "priors with another estimator": (
        lambda: method("robust", priors=[Prior("m", 1.0, 1.0)]).estimate(Regression(A, forces(0), NAMES), MODEL),
        "priors go with the estimator gauss-markov",
    ),
    "priors beside known values": (
        lambda: method(known={"m": 1.0}, priors=[Prior("k3", 1.0, 1.0)]).estimate(
            Regression(A, forces(0), NAMES), MODEL
        ),
        "priors go with",
    ),
    "an unknown name": (
        lambda: method(known={"k9": 1.0}).estimate(Regression(A, forces(0), NAMES), MODEL),
        "'k9' is not a parameter",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_defined_is_refused(what: str) -> None:
    call, says = REFUSED[what]
    with pytest.raises(IdentificationError, match=says) as caught:
        call()
    one_line(caught.value)
