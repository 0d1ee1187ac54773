"""The figure of residuals: the distribution of Gaussian ones lies on the normal density, also behind a filter."""

import numpy as np
import pytest
from scipy.signal import welch

from cases.schema import Case
from identification.hexapod import Hexapod
from identification.identify import estimate_parameters
from identification.signals import Residuals
from identification.simulate import simulate_recording
from planner.reports.identify import distribution_chart
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution


def test_gaussian_residuals_lie_on_the_density_whatever_the_forces_are() -> None:
    drawn = np.random.default_rng(0).normal(size=(3000, 6)) * [1.0, 2.0, 3.0, 0.1, 0.2, 0.01]
    bars, normal = distribution_chart(Residuals(np.arange(3000) * 1e-3, drawn, np.zeros_like(drawn), 1e-3)).data
    assert bars["y"].max() == pytest.approx(normal["y"].max(), rel=0.15)


def test_residuals_behind_the_filter_are_those_of_the_estimate(hexapod_case: Case) -> None:
    execution = PoseExecution(Hexapod.of(hexapod_case), Harmonic(seed=1, duration=2.0))
    recording = simulate_recording(hexapod_case, execution, np.array([[0.1, 1.9]]), 0)
    estimate = estimate_parameters(recording, hexapod_case)
    found = estimate.evaluated.series(estimate.at, estimate.fit.values)
    rms = np.sqrt(np.mean(found.evaluated**2, axis=0))
    np.testing.assert_allclose(rms, np.sqrt(np.mean(estimate.fit.residuals**2, axis=0)), rtol=0.05)
    assert (rms < 0.5 * np.sqrt(np.mean(found.values**2, axis=0))).all()  # white noise: most lies above the pass band


@pytest.mark.parametrize("samples", [7, 1000, 1024, 5001])
def test_the_spectrum_is_welchs(samples: int) -> None:
    forces = 3.0 + np.random.default_rng(0).normal(size=(samples, 6))
    found = Residuals(np.arange(samples) * 1e-3, forces, np.zeros_like(forces), 1e-3)
    frequency, power = welch(forces, 1000.0, nperseg=min(1024, samples), axis=0)
    np.testing.assert_allclose(found.spectrum()[0], frequency)
    np.testing.assert_allclose(found.spectrum()[1], np.sqrt(power), atol=1e-12)
