"""A moving sensor whose orientations and accelerations are recorded: its delay, and what its residuals follow."""

import numpy as np
import pytest

from identification.identify import estimate_parameters
from tests.damaged.runs import truth_of
from tests.helpers import seeds
from tests.wrist_runs import DELAY, case_of_wrist, wrist_machine, wrist_recording

CASE = case_of_wrist()
BODY = 6  # the model with the inertia of the load


@seeds(40)
@pytest.mark.parametrize("memory", [None, 0.3])
def test_sound_runs_are_not_accused_and_are_right(seed: int, memory: float | None) -> None:
    """Noise of 0.006 deg in the orientations is no motion, so that it does not move the delay."""
    estimate = estimate_parameters(wrist_recording(seed, memory=memory), CASE, BODY)
    assert estimate.warnings == ()
    assert estimate.delay is not None
    assert abs(estimate.delay.value - DELAY) < 4.0 * estimate.delay.std < 2e-3
    truth = truth_of(wrist_machine().plant)
    errors = [(p.value - truth[k]) / p.reported for k, p in estimate.physical.items() if k in truth]
    assert np.abs(errors).max() < 5.0


@pytest.mark.usefixtures("causes_aside")
def test_inertia_that_a_model_leaves_out_is_said_with_the_model_to_choose() -> None:
    estimate = estimate_parameters(wrist_recording(0), CASE, 0)
    (said,) = [w for w in estimate.warnings if "choose model 6" in w]
    assert "I11" in said


def test_an_accelerometer_beside_the_sensor_is_said_or_its_deviations_hold() -> None:
    estimate = estimate_parameters(wrist_recording(2, arm=(0.05, 0.0, 0.0)), CASE, BODY)
    assert any("follow" in w for w in estimate.warnings)
