"""Predicted deviations go by the rate of recording that the case states; a recording of another rate says so."""

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.estimation.criteria import reference_scaling
from identification.model.model import identification_model
from planner.plans.figures import predictions_of
from planner.poses.planned_poses import noise_of_average
from tests.helpers import Harmonic


def at_rate(rate: float) -> Case:
    case = load_case("hexapod")
    return case.model_copy(update={"recording": case.recording.model_copy(update={"rate_Hz": rate})})


def test_half_the_rate_makes_deviations_the_root_of_two_times_as_large() -> None:
    whole = load_case("hexapod")
    model = identification_model(whole, 9)
    motion, scaling = Harmonic(duration=2.0), reference_scaling(whole, model)
    usual, half = (
        predictions_of(case, model, scaling, motion, [0])[0].std for case in (at_rate(1000.0), at_rate(500.0))
    )
    assert whole.recording.rate_Hz == 1000.0
    for name, std in usual.items():
        assert half[name] == pytest.approx(np.sqrt(2.0) * std)
    assert noise_of_average(at_rate(500.0)) == pytest.approx(np.sqrt(2.0) * noise_of_average(whole))
