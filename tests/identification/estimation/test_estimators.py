"""Methods: each combination that makes sense gives the right parameters, every other one says why not."""

import numpy as np
import pytest

from cases.base.errors import IdentificationError
from identification.estimation.estimators import EACH, Method
from identification.estimation.fit import Regression
from identification.estimation.priors import Prior
from tests.helpers import one_line
from tests.identification.moving_run import MODEL, NAMES, A, U, forces


@pytest.mark.parametrize("pooled", [True, False])
def test_it_finds_the_parameters_within_their_errors(pooled: bool) -> None:
    fit = Method().estimate(Regression(A, forces(0), NAMES, alike=None if pooled else EACH), MODEL)
    assert np.abs((fit.values - U) / np.sqrt(np.diag(fit.covariance))).max() < 4.0
    assert fit.white_noise == pytest.approx(1.0, abs=0.1)


def test_a_known_mass_makes_the_rest_more_certain_and_keeps_its_value() -> None:
    known = {"m": float(U[0])}
    free, fixed = (Method(k).estimate(Regression(A, forces(1), NAMES), MODEL) for k in ({}, known))
    assert fixed.values[0] == pytest.approx(U[0], rel=1e-12)
    assert fixed.covariance[0, 0] == pytest.approx(0.0, abs=1e-20)
    k2 = NAMES.index("k2")  # the factor that a static mass hides behind
    assert fixed.covariance[k2, k2] < 0.6 * free.covariance[k2, k2]


def test_a_prior_that_disagrees_is_told() -> None:
    quiet = Method(priors=(Prior("m", float(U[0]), 1.0),)).estimate(Regression(A, forces(4), NAMES), MODEL)
    loud = Method(priors=(Prior("m", float(U[0]) + 10.0, 1.0),)).estimate(Regression(A, forces(4), NAMES), MODEL)
    assert quiet.findings == ()
    assert "prior m disagrees" in loud.findings[0].sentence


REFUSED = {
    "unknown weights": (lambda: Method(weights="best"), "weights 'best' are unknown; choose equal"),
    "priors beside known values": (
        lambda: Method({"m": 1.0}, priors=(Prior("k3", 1.0, 1.0),)),
        "priors go with all parameters free",
    ),
    "an unknown name": (
        lambda: Method({"k9": 1.0}).estimate(Regression(A, forces(0), NAMES), MODEL),
        "'k9' is not a parameter",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_defined_is_refused(what: str) -> None:
    call, says = REFUSED[what]
    with pytest.raises(IdentificationError, match=says) as caught:
        call()
    one_line(caught.value)
