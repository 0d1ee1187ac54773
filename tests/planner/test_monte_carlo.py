"""Predicted standard deviations against many simulated runs, whose forces come from Newton's law for point masses."""

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import box_middle
from identification.motion.curves import FourierMotion
from planner.families.fourier import FourierFamily
from planner.search.feasibility import keep_limits
from tests.planner.monte_carlo import monte_carlo

RUNS = 600


@pytest.fixture(scope="module")
def motion(hexapod_case: Case) -> FourierMotion:
    family = FourierFamily(5, 3.0, 1, *box_middle(hexapod_case))
    draw = np.random.default_rng(2).normal(size=family.unknowns * 6)
    return family.motion(keep_limits(hexapod_case, family, draw, 1000.0)[0])


def test_white_force_noise_spreads_the_estimates_as_predicted(motion: FourierMotion, hexapod_case: Case):
    """600 runs know a standard deviation to 2.9 %: 10 % is more than three of these."""
    spread = monte_carlo(hexapod_case, motion, RUNS, 1.0, 0.0)
    assert spread.found == pytest.approx(spread.predicted, rel=0.1)
    assert np.abs(spread.bias / spread.predicted).max() < 4.5 / np.sqrt(RUNS)


@pytest.mark.repeats
def test_noise_in_the_accelerations_draws_the_mass_down(motion: FourierMotion, hexapod_case: Case):
    """Noise in the regressor attenuates, which no predicted deviation contains: it is told apart as bias."""
    spread = monte_carlo(hexapod_case, motion, 8, 1.0, 1.0)
    mass = spread.names.index("m")
    assert spread.bias[mass] < -10 * spread.predicted[mass]
