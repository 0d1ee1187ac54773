"""A part of a long run stands for it where the number of samples only costs time: results are of the whole run."""

from dataclasses import replace

import numpy as np
import pytest

from cases.schema import load_case
from identification import signals
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.recording.recording import Recording
from identification.results.estimate import Estimate
from identification.signals import STRETCHES, fair_part
from identification.simulate import simulate_recording
from tests.helpers import Harmonic
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
RUN = simulate_recording(
    CASE, PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=12.0)), np.array([[0.2, 5.7], [6.0, 11.8]]), 0
)
FEW = 400  # of some 1400 evaluated samples


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signals, "FAIR_PART", FEW)


@pytest.mark.parametrize("count", [1, 399, 400, 401, 5000, 100_003])
def test_a_fair_part_is_all_of_few_and_even_stretches_of_many(count: int, few: None) -> None:
    part = fair_part(count)
    assert len(part) == min(count, FEW)
    assert np.all(np.diff(part) > 0)
    assert part[-1] == count - 1
    if count > 2 * FEW:
        assert np.sum(np.diff(part) > 1) == STRETCHES - 1


def estimates(recording: Recording, monkeypatch: pytest.MonkeyPatch) -> tuple[Estimate, Estimate]:
    """Of the whole run at once, and begun from a part."""
    whole = estimate_parameters(recording, CASE)
    monkeypatch.setattr(signals, "FAIR_PART", FEW)
    return whole, estimate_parameters(recording, CASE)


def test_parameters_and_delay_are_those_of_the_whole_run(monkeypatch: pytest.MonkeyPatch) -> None:
    whole, begun = estimates(RUN, monkeypatch)
    std = np.sqrt(np.diag(whole.fit.covariance))
    assert np.abs((begun.fit.values - whole.fit.values) / std).max() < 0.01
    # how much of the noise is of encoders, a part of the run shows
    np.testing.assert_allclose(np.sqrt(np.diag(begun.fit.covariance)), std, rtol=0.15)
    assert whole.delay is not None
    assert begun.delay is not None
    assert abs(begun.delay.value - whole.delay.value) < 0.01 * whole.delay.std
    assert (begun.samples.recorded_count, begun.fit.freedom) == (
        whole.samples.recorded_count,
        whole.fit.freedom,
    )
    assert begun.s0_N == pytest.approx(whole.s0_N, rel=1e-6)


@pytest.mark.repeats
def test_white_noise_is_seen_to_be_white_from_a_part(monkeypatch: pytest.MonkeyPatch) -> None:
    _, begun = estimates(RUN, monkeypatch)
    ratio = np.sqrt(np.diag(begun.fit.covariance_robust) / np.diag(begun.fit.covariance))
    assert 0.7 < np.median(ratio) < 1.6


@pytest.mark.slow
def test_errors_that_depend_on_the_pose_are_seen_from_a_part_and_do_not_average_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert RUN.drives is not None
    phase = 2.0 * np.pi * RUN.drives[:, [0, 2, 4, 1, 3, 5]] / 0.02
    waving = replace(RUN, forces=RUN.forces + 3.0 * np.sin(phase))
    whole, begun = estimates(waving, monkeypatch)
    for estimate in (whole, begun):
        assert any("depend on the pose" in n for n in estimate.notes)
    ratio = np.sqrt(np.diag(begun.fit.covariance_robust) / np.diag(whole.fit.covariance_robust))
    assert 0.4 < np.median(ratio) < 2.5


@pytest.mark.slow
@pytest.mark.parametrize("start", [1.0, 8.5])
def test_a_contact_is_found_wherever_it_is(start: float, monkeypatch: pytest.MonkeyPatch) -> None:
    extra = np.linalg.solve(CASE.sensor_frame.structure, [12.0, 0.0, 16.0, 0.0, 0.0, 0.0])
    assert RUN.t is not None
    on = (RUN.t >= start) & (RUN.t < start + 0.2)
    whole, begun = estimates(replace(RUN, forces=RUN.forces - on[:, None] * extra), monkeypatch)
    places = [[w.split(", up to")[0] for w in e.warnings if "external contact" in w] for e in (whole, begun)]
    assert places[0] == places[1]
    assert f"from {start:.1f}" in places[1][0]
    assert begun.samples.recorded_count == whole.samples.recorded_count
