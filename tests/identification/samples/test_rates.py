"""Forces and struts of different rates: averages that neither delay nor flatten, noise that falls with the root."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import RecordingError
from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.recording.formats.table import Stream
from identification.recording.recording import Recording
from identification.samples.clocks import interval_means, on_one_clock
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, ideal, one_line, tells
from tests.simulated_machine import PoseExecution, true_forces

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
PHYSICAL = physical_form(MODEL).of(linear_parameters(MODEL, CASE.simulation.parameters), np.eye(20))[0]
EXECUTION = PoseExecution(Hexapod.of(CASE), Harmonic(duration=3.0))


def two_rates(ratio: float, noise: float = 0.0, step: float = 2e-3, late: float = 0.0, seed: int = 0) -> Recording:
    """Struts every `step`, forces `ratio` times as often, exact or with white noise."""
    t, fine = np.arange(0.0, 3.0, step), np.arange(0.0, 3.0 - step / 2, step / ratio)
    draw = np.random.default_rng(seed)
    forces = true_forces(CASE, EXECUTION, fine - late) + noise * draw.normal(size=(len(fine), 6))
    struts = Stream("struts.csv", t, EXECUTION.drives(t), None, None, (t > 0.2) & (t < 2.8))
    return Recording("forces.csv", fine, None, None, forces, None, others=(struts,))


@given(a=st.floats(-5, 5), b=st.floats(-5, 5), interval=st.floats(0.01, 0.3), seed=st.integers(0, 100))
def test_the_mean_of_a_straight_line_is_its_value_at_the_centre(a: float, b: float, interval: float, seed: int) -> None:
    """Whatever the rates and however the samples lie: no group delay."""
    t = np.sort(np.random.default_rng(seed).uniform(-0.2, 1.2, 60))
    t = np.unique(np.r_[-0.2, t, 1.2])
    centres = np.linspace(0.0, 1.0, 7)
    means = interval_means(t, (a + b * t)[:, None], centres, interval)[:, 0]
    np.testing.assert_allclose(means, a + b * centres, atol=1e-12)


def test_means_over_adjoining_intervals_add_up_to_the_whole() -> None:
    draw = np.random.default_rng(0)
    t, values = np.arange(1001) * 1e-3, draw.normal(size=(1001, 3))
    parts = interval_means(t, values, np.arange(0.05, 1.0, 0.1), 0.1)
    whole = interval_means(t, values, np.array([0.5]), 1.0)
    np.testing.assert_allclose(parts.mean(axis=0), whole[0], atol=1e-13)
    np.testing.assert_allclose(whole[0], np.trapezoid(values, t, axis=0), atol=1e-13)


@pytest.mark.parametrize("ratio", [2.0, 3.7, 10.0])
def test_averages_are_the_forces_of_the_instant(ratio: float) -> None:
    """Compensated to second order: with 5 Hz at 500 samples a second some 1e-6 of the force's range."""
    joined = on_one_clock(two_rates(ratio), CASE)
    truth = true_forces(CASE, EXECUTION, joined.t)
    np.testing.assert_allclose(joined.forces, truth, atol=2e-5 * np.ptp(truth))
    assert joined.averaged == pytest.approx(ratio, rel=1e-6)
    assert joined.trigger.sum() == pytest.approx(2.6 / 2e-3, abs=2)


def test_the_noise_of_averages_falls_with_the_root_of_their_number() -> None:
    """By as much in the pass band, where the parameters are; the compensation of the curvature adds a little above."""
    noisy, clean = (on_one_clock(two_rates(16.0, noise), CASE) for noise in (4.0, 0.0))
    left = noisy.forces - clean.forces
    slow = left[: len(left) // 20 * 20].reshape(-1, 20, 6).mean(axis=1)
    assert slow.std() * np.sqrt(20) == pytest.approx(1.0, rel=0.1)
    assert left.std() == pytest.approx(np.sqrt(1.0 + 4 / 24 + 6 / 24**2), rel=0.05)


@pytest.mark.repeats
def test_an_ideal_oversampled_run_gives_parameters_and_no_delay() -> None:
    estimate = estimate_parameters(on_one_clock(two_rates(10.0), CASE), CASE)
    values = np.array([v.value for v in estimate.physical.values()])
    np.testing.assert_allclose(values, PHYSICAL, rtol=2e-4, atol=2e-5)
    assert estimate.delay.value == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_errors_are_those_of_ten_times_the_samples() -> None:
    """s0 is told for the averages; the standard deviations are those of the information that all samples hold."""
    many = estimate_parameters(on_one_clock(two_rates(10.0, noise=3.0, late=0.003), CASE), CASE)
    values, std = (np.array([getattr(v, k) for v in many.physical.values()]) for k in ("value", "reported"))
    assert many.fit.white_noise == pytest.approx(3.0 / np.sqrt(10.0), rel=0.12)
    assert np.abs((values - PHYSICAL) / std).max() < 4.0
    assert many.delay.value == pytest.approx(0.003, abs=4 * many.delay.std)
    thinned = two_rates(1.0, noise=3.0)
    few = estimate_parameters(on_one_clock(thinned, CASE), CASE)
    ratio = [few.physical[n].std / v.std for n, v in many.physical.items()]
    assert np.exp(np.mean(np.log(ratio))) == pytest.approx(np.sqrt(10.0), rel=0.15)
    assert tells(many.notes[0], "10 samples averaged")
    assert many.quantities["averaged"]["ratio"] == pytest.approx(10.0, rel=1e-9)


def held(ratio: int) -> Recording:
    """One file: every row has forces, struts come every `ratio` rows and are held."""
    step = 1e-3
    t = np.arange(0.0, 3.0, step / ratio)
    new = np.maximum((np.arange(len(t)) - 3) // ratio * ratio + 3, 0)
    return Recording("run.csv", t, EXECUTION.drives(t[new]), None, true_forces(CASE, EXECUTION, t), t > 0.1)


@pytest.mark.first(1)
@pytest.mark.parametrize("ratio", [2, 5])
def test_held_struts_are_taken_when_they_are_new(ratio: int) -> None:
    recording = held(ratio)
    joined = on_one_clock(recording, CASE)
    assert joined.averaged == pytest.approx(ratio)
    np.testing.assert_allclose(joined.drives, EXECUTION.drives(joined.t), atol=1e-12)
    assert (
        joined.lines.place(7) == f"line {2 + 3 % ratio + ratio + 7 * ratio}"
    )  # the first average needs what is before it
    assert joined.t[7] == recording.t[3 % ratio + ratio + 7 * ratio]
    estimate = estimate_parameters(joined, CASE)
    assert estimate.delay.value == pytest.approx(0.0, abs=1e-6)
    assert estimate.physical["m"].value == pytest.approx(31.83, abs=3e-3)


def test_a_run_with_one_rate_is_left_alone() -> None:
    recording = simulate_recording(CASE, EXECUTION, np.array([[0.1, 2.9]]), 0)
    assert on_one_clock(recording, CASE) is recording
    coarse = ideal(CASE)
    stepped = replace(recording, drives=np.round(recording.drives, 4))  # encoder steps of 0.1 mm: no rhythm
    assert on_one_clock(stepped, coarse) is stepped


def test_struts_that_are_faster_than_the_forces_are_read_at_the_forces() -> None:
    t, fine = np.arange(0.0, 3.0, 3e-3), np.arange(0.0, 3.0, 1e-3)
    struts = Stream("struts.csv", fine, EXECUTION.drives(fine), None, None, None)
    joined = on_one_clock(
        Recording("forces.csv", t, None, None, true_forces(CASE, EXECUTION, t), None, others=(struts,)), CASE
    )
    np.testing.assert_allclose(joined.drives, EXECUTION.drives(t), atol=1e-9)
    assert joined.averaged == 1.0


@pytest.mark.repeats
def test_an_average_over_a_clipped_sample_counts_as_clipped() -> None:
    recording = two_rates(10.0)
    forces = recording.forces.copy()
    forces[7003, 1] = 5000.0
    joined = on_one_clock(replace(recording, forces=forces), CASE)
    (row,) = np.flatnonzero(np.abs(joined.forces[:, 1]) >= 4999.0)
    assert joined.t[row] == pytest.approx(recording.t[7003], abs=1.1e-3)
    assert any("end of its range" in w for w in estimate_parameters(joined, CASE).warnings)


def test_averages_over_missing_forces_are_marked() -> None:
    """4 ms of forces at 5 kHz are missing; averages over 2 ms that reach there, or whose neighbours do, are none."""
    recording = two_rates(10.0)
    keep = np.r_[0:5000, 5020 : len(recording.t)]
    broken = replace(recording, t=recording.t[keep], forces=recording.forces[keep])
    joined, sound = on_one_clock(broken, CASE), on_one_clock(recording, CASE)
    marked = joined.missing
    assert joined.t[marked].min() == pytest.approx(recording.t[5000] - 2.5e-3, abs=1e-3)
    assert joined.t[marked].max() == pytest.approx(recording.t[5020] + 2.5e-3, abs=1e-3)
    np.testing.assert_allclose(joined.forces[~marked], sound.forces[~marked], rtol=1e-6)
    assert np.abs(joined.forces[marked] - sound.forces[marked]).max() > 1e-3


def test_forces_where_struts_of_their_own_clock_are_missing_are_marked() -> None:
    t, fine = np.arange(0.0, 3.0, 3e-3), np.arange(0.0, 3.0, 1e-3)
    keep = (fine < 1.0) | (fine > 1.2)
    struts = Stream("struts.csv", fine[keep], EXECUTION.drives(fine[keep]), None, None, None)
    joined = on_one_clock(
        Recording("forces.csv", t, None, None, true_forces(CASE, EXECUTION, t), None, others=(struts,)), CASE
    )
    inside = (t[: len(joined.t)] > 1.0) & (t[: len(joined.t)] < 1.2)
    assert joined.missing[inside].all()
    assert joined.missing.sum() <= inside.sum() + 2
    np.testing.assert_allclose(joined.drives[~joined.missing], EXECUTION.drives(joined.t[~joined.missing]), atol=1e-8)


def test_held_struts_whose_rhythm_a_gap_breaks_are_refused() -> None:
    t = np.arange(0.0, 3.0, 1e-3)
    held = EXECUTION.drives(t[5 * (np.arange(len(t)) // 5)])
    run = Recording("run.csv", t, held, None, true_forces(CASE, EXECUTION, t), None)
    assert on_one_clock(run, CASE).step == pytest.approx(5e-3)
    keep = np.r_[0:1500, 1512 : len(t)]
    broken = replace(run, t=t[keep], drives=held[keep], forces=run.forces[keep])
    with pytest.raises(RecordingError, match=r"run\.csv, line 1502: .*drives.* 5 rows"):
        on_one_clock(broken, CASE)


@pytest.mark.parametrize("ratio", [10.0, 4.0])
@pytest.mark.parametrize("off", [-1e-8, 0.0, 1e-8])
def test_single_samples_that_are_missing_among_many_do_not_matter(ratio: float, off: float) -> None:
    """A clock of a host is a straight line through its stamps: steps differ from the usual one by what that leaves."""
    recording = two_rates(ratio)
    keep = np.arange(len(recording.t)) % 97 != 5
    t = recording.t[keep] + off * np.cumsum(np.diff(np.flatnonzero(keep), prepend=0) > 1)
    joined = on_one_clock(replace(recording, t=t, forces=recording.forces[keep]), CASE)
    assert joined.missing is None or not joined.missing.any()
    truth = true_forces(CASE, EXECUTION, joined.t)
    np.testing.assert_allclose(joined.forces, truth, atol=5e-5 * np.ptp(truth))


def test_forces_that_hardly_overlap_the_motion_are_refused() -> None:
    recording = two_rates(10.0)
    with pytest.raises(RecordingError, match=r"less than 3 samples") as caught:
        on_one_clock(replace(recording, t=recording.t + 2.996), CASE)
    one_line(caught.value)
