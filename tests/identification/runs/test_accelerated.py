"""Selection of accelerated sections: which samples, unbiased parameters, and a comparison that can go either way."""

from dataclasses import replace

import numpy as np
import pytest

from cases.errors import RecordingError
from cases.loading import load_case
from identification.hexapod import Hexapod
from identification.identify import identifiability, identify
from identification.model import identification_model
from identification.parameters import linear_parameters, physical_form
from identification.recording import Recording
from identification.result import Estimate
from identification.runs.accelerated import accelerated
from identification.runs.conditioning import Accelerated, Conditioning
from identification.runs.preparation import moving_run
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, ideal, one_line
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
PHYSICAL = physical_form(MODEL).of(linear_parameters(MODEL, CASE.simulation.parameters), np.eye(20))[0]
EXECUTION = PoseExecution(Hexapod.of(CASE), Harmonic(duration=3.0))


def recorded(exact: bool = False) -> Recording:
    return simulate_recording(ideal(CASE) if exact else CASE, EXECUTION, np.array([[0.2, 2.8]]), 0, "run.csv")


def values(estimate: Estimate, what: str = "value") -> np.ndarray:
    return np.array([getattr(v, what) for v in estimate.physical.values()])


@pytest.mark.parametrize("wish", [Accelerated(share=0.25), Accelerated(least=1.2)])
def test_the_samples_kept_are_those_of_the_largest_strut_accelerations(wish: Accelerated) -> None:
    run = moving_run(recorded(exact=True), CASE, MODEL)
    section = accelerated(run, wish)
    true = np.abs(EXECUTION.struts(run.t, 2)).max(axis=1)
    kept = np.isin(run.rows, section.run.rows)
    assert true[kept].min() > true[~kept].max() - 0.01
    assert section.kept == kept.sum() == len(section.run.rows)
    if wish.least is None:
        assert kept.mean() == pytest.approx(wish.share, abs=2 / len(kept))
    else:
        assert true[kept].min() == pytest.approx(wish.least, abs=0.1)


def test_without_noise_a_selection_gives_the_parameters_of_the_whole() -> None:
    """The filter has seen the whole run: sections have no ends."""
    estimate = identify(recorded(exact=True), CASE, conditioning=Conditioning(accelerated=Accelerated(0.3)))
    np.testing.assert_allclose(values(estimate), PHYSICAL, rtol=2e-4, atol=2e-5)


def test_all_samples_selected_are_all_samples() -> None:
    whole = identify(recorded(), CASE)
    chosen = identify(recorded(), CASE, conditioning=Conditioning(accelerated=Accelerated(1.0)))
    np.testing.assert_allclose(values(chosen), values(whole), rtol=1e-7, atol=1e-9)
    assert chosen.told["accelerated"]["std_ratio"] == pytest.approx(1.0, abs=1e-6)
    assert chosen.told["accelerated"]["favours"] == "neither"


def test_fewer_samples_of_like_noise_are_less_certain() -> None:
    """As the paper found: selection does not improve the results."""
    chosen = identify(recorded(), CASE, conditioning=Conditioning(accelerated=Accelerated(0.3)))
    assert np.abs((values(chosen) - PHYSICAL) / values(chosen, "reported")).max() < 4.5
    found = chosen.told["accelerated"]
    assert found["std_ratio"] > 1.3
    assert found["favours"] == "all samples"
    assert chosen.samples == pytest.approx(0.3 * found["samples_of_all"], rel=0.01)


def test_where_slow_sections_are_noisy_the_selection_is_favoured() -> None:
    run = recorded(exact=True)
    slow = np.abs(EXECUTION.struts(run.t, 2)).max(axis=1) < 1.0
    draw = np.random.default_rng(0)
    noise = np.where(slow, 1.0, 0.4)[:, None] * draw.normal(size=run.forces.shape)
    noisy = replace(run, forces=run.forces + noise)
    chosen = identify(noisy, CASE, conditioning=Conditioning(accelerated=Accelerated(least=1.1)))
    assert chosen.told["accelerated"]["favours"] == "the selection"
    assert "favours the selection" in chosen.notes[-1]


def test_identifiability_is_that_of_the_selection() -> None:
    run, wish = recorded(), Conditioning(accelerated=Accelerated(0.2))
    chosen, whole = identify(run, CASE, conditioning=wish), identify(run, CASE)
    some, every = (identifiability(run, CASE, e) for e in (chosen, whole))
    assert np.abs(some.correlation - every.correlation).max() > 0.02


def test_more_than_any_strut_is_accelerated_is_refused() -> None:
    with pytest.raises(
        RecordingError, match=r"accelerated so much, at most \d\.\d+ m/s\^2 behind the filter"
    ) as caught:
        identify(recorded(), CASE, conditioning=Conditioning(accelerated=Accelerated(least=50.0)))
    assert "run.csv" in one_line(caught.value)
