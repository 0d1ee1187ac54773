"""A search that counts what is known finds what is missing, and says what its motion is worth alone."""

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.model.model import identification_model
from planner.noise import expected_noise, information_of_known, mean_information
from planner.plans.figures import noise_covariance
from planner.search.solving import Start, Task, run_start
from tests.planner.search.conftest import family_of

NUMBER = 6


def mean_of(case: Case, start: Start) -> np.ndarray:
    model = identification_model(case, NUMBER)
    return mean_information(model, reference_scaling(case, model), start.family.motion(start.unknowns))


@pytest.mark.parametrize("name", ["fourier", pytest.param("ptp", marks=pytest.mark.repeats)])
def test_the_motion_adds_most_to_an_earlier_run(name: str, hexapod_case: Case):
    """Known is the motion that is best alone: another one has less information, and both together more."""
    case, family = hexapod_case, family_of(hexapod_case, name)
    model = identification_model(case, NUMBER)
    scaling, noise = reference_scaling(case, model), expected_noise(case, model)
    alone = run_start(Task(case, NUMBER, family, "D", 1))
    information, duration = mean_of(case, alone), 0.5 * family.duration
    known = noise_covariance(case, scaling, information, duration, noise.sensors)
    samples = case.recording.rate_Hz * family.duration
    assert information_of_known(known, scaling, noise.sensors**2 / samples) == pytest.approx(0.5 * information)

    beside = run_start(Task(case, NUMBER, family, "D", 1, known=known))
    joint = [np.linalg.slogdet(mean_of(case, start) + 0.5 * information)[1] for start in (alone, beside)]
    assert beside.record.criterion_value == pytest.approx(joint[1], abs=1e-6)
    assert beside.record.logdet == pytest.approx(np.linalg.slogdet(mean_of(case, beside))[1], abs=1e-6)
    assert joint[1] > joint[0] + 0.1
    assert beside.record.logdet < alone.record.logdet
