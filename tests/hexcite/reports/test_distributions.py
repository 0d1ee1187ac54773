"""Normal densities, residuals in order, and accelerations planned beside measured: what these figures draw."""

import numpy as np
import pytest

import hexcite as hx
from cases.schema import load_case
from hexcite.reports.drawing.accelerations import (
    acceleration_charts,
    measured_accelerations,
    planned_accelerations,
    summary,
)
from hexcite.reports.drawing.chart import Line
from hexcite.reports.drawing.densities import density, density_charts, normal_chart
from identification.estimation.fit import Value
from identification.machines.hexapod import Hexapod
from identification.signals import Residuals
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")


def test_a_density_has_the_area_one_and_the_deviation_of_its_parameter() -> None:
    x = np.linspace(-8.0, 8.0, 2001)
    y = density(x, 0.7)
    assert np.trapezoid(y, x) == pytest.approx(1.0, abs=1e-6)
    assert np.trapezoid(x**2 * y, x) == pytest.approx(0.49, rel=1e-5)


def test_parameters_of_one_unit_share_a_figure_in_the_unit_for_people() -> None:
    values = {
        "m": Value(30.0, 0.1, 0.2, "kg"), "xC": Value(0.0, 1e-4, 2e-4, "m"), "zC": Value(0.1, 4e-4, 1e-4, "m"),
        "yC": Value(0.0, 0.0, 0.0, "m"), "K1_1x": Value(1.0, 1.0, 1.0, "N/m"),
    }  # fmt: skip
    mass, centre = density_charts(values)
    assert [series.name for series in centre.series if isinstance(series, Line)] == ["xC", "zC"]  # yC is given
    assert "mm" in centre.x.title
    (line,) = (s for s in mass.series if isinstance(s, Line))
    assert line.y.max() == pytest.approx(1.0 / (0.2 * np.sqrt(2.0 * np.pi)), rel=1e-3)  # the larger deviation


def test_normal_residuals_lie_on_a_line_and_gross_errors_bend_its_ends() -> None:
    noise = 2.0 * np.random.default_rng(0).normal(size=(4000, 6))
    noise[::100, 3] += 30.0
    chart = normal_chart(Residuals(np.arange(4000.0), noise, np.zeros((4000, 6)), 1.0), CASE.sensor_frame.channels)
    *channels, _ = (s for s in chart.series if isinstance(s, Line))
    inner = np.abs(channels[0].x) < 2.0
    np.testing.assert_allclose(channels[0].y[inner], 2.0 * channels[0].x[inner], atol=0.3)
    assert channels[3].y[-1] > 25.0


def test_measured_accelerations_are_those_that_were_executed() -> None:
    """By the drives of a noise-free run of a harmonic motion, beside the motion itself."""
    motion = Harmonic(duration=2.5)
    run = simulate_recording(CASE, PoseExecution(Hexapod.of(CASE), motion), np.array([[0.15, 2.35]]), 0, "run.csv")
    result = hx.identify(run, CASE)
    assert result.estimate is not None
    measured, planned = measured_accelerations(result.estimate), planned_accelerations(CASE, motion)
    assert measured is not None
    expected = np.array([np.interp(measured[0] - result.estimate.at, planned[0], column) for column in planned[1].T]).T
    size = np.sqrt(np.mean(expected**2, axis=0))
    np.testing.assert_allclose(np.sqrt(np.mean((measured[1] - expected) ** 2, axis=0)) / size, 0.0, atol=0.1)
    assert "m/s² rms" in summary(measured, planned)
    translation, rotation = acceleration_charts(measured, planned)
    assert len(translation.series) == len(rotation.series) == 6
    assert {s.dash for s in translation.series if isinstance(s, Line)} == {"solid", "dash"}
