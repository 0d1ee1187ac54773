"""A structural mode rings after moves: it is named, what it biases is counted, and nothing else is taken for one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identification.findings.left_out import LeftOut
from identification.findings.remains import free_basis, remainder_of
from identification.findings.structural_mode import Mode, biased_by, followed, mode_of, sharpened
from identification.fitting import fitted_run
from identification.identify import default_model, estimate_parameters
from identification.model.model import identification_model
from identification.samples.samples import GAUSS_MARKOV, Fitted
from tests.damaged.runs import SOUND, STATED, Change, Machine, Moves, Noise, machine, recorded
from tests.helpers import few

DAMPING = 0.02


def behind_a_mode(of: Machine, frequency: float) -> Change:
    """Forces of a load behind spring and damper: x'' = w^2 (y - x) + 2 d w (y' - x'), integrated step by step."""

    def shaken(accelerations: np.ndarray) -> np.ndarray:
        w, step = 2.0 * np.pi * frequency, 1.0 / of.rate
        at = step * np.arange(len(accelerations))

        def rates(t: float, state: np.ndarray) -> np.ndarray:  # of what the load lags behind the drives, and its rate
            a = accelerations[min(int(t / step), len(at) - 1)] * (1.0 - (t / step) % 1.0)
            a = a + accelerations[min(int(t / step) + 1, len(at) - 1)] * ((t / step) % 1.0)
            lag, rate = np.split(state, 2)
            return np.concatenate([rate, -a - w**2 * lag - 2.0 * DAMPING * w * rate])

        found = solve_ivp(rates, (0.0, at[-1]), np.zeros(6), t_eval=at, max_step=step, rtol=1e-5, atol=1e-9)
        lag, rate = found.y[:3].T, found.y[3:].T
        return -(w**2) * lag - 2.0 * DAMPING * w * rate

    def forces(now, own, draw):
        return of.plant.forces(replace(now, acceleration=shaken(now.acceleration), alpha=shaken(now.alpha)))

    return Change(forces=forces)


@cache
def fitted(name: str, frequency: float, hum: float = 0.0) -> Fitted:
    of = machine(name)
    change = behind_a_mode(of, frequency) if frequency else SOUND
    run = recorded(of, Moves(of, 3, 4.0), 1, replace(STATED, hum=hum), change)
    model = identification_model(of.case, default_model(run, of.case))
    return fitted_run(run, of.case, model, GAUSS_MARKOV).fitted


@pytest.mark.parametrize(("name", "frequency"), [("hexapod", 80.0), ("five_axis_table", 60.0)])
def test_a_mode_is_named_with_its_frequency_and_damping(name: str, frequency: float) -> None:
    mode = mode_of(fitted(name, frequency))
    assert mode is not None
    assert mode.frequency == pytest.approx(frequency, rel=0.02)
    assert 0.2 * DAMPING < mode.damping < 2.5 * DAMPING


@pytest.mark.parametrize("name", ["hexapod", "ur10_wrist", "five_axis_table"])
@pytest.mark.parametrize("hum", [0.0, 2.0])
def test_neither_a_sound_run_nor_the_mains_have_one(name: str, hum: float) -> None:
    assert mode_of(fitted(name, 0.0, hum)) is None


def test_a_run_whose_noise_remembers_has_none() -> None:
    of = machine("hexapod")
    run = recorded(of, Moves(of, 5, 4.0), 5, Noise(0.5, 0.05, 0.8))
    model = identification_model(of.case, default_model(run, of.case))
    assert mode_of(fitted_run(run, of.case, model, GAUSS_MARKOV).fitted) is None


@pytest.mark.parametrize(("rate", "seen"), [(500.0, True), (100.0, True), (40.0, False), (20.0, False)])
def test_a_mode_is_followed_where_there_are_lags_enough(rate: float, seen: bool) -> None:
    """At 40 samples a second the time in which a mode turns is one step, through which no line leads."""
    t = np.arange(0.0, 4.0, 1.0 / rate)
    slow = np.exp((-0.5 + 2j * np.pi * 0.7) * t)[:, None] * np.ones(6)
    mode = followed(12.0, slow, 1.0 / rate)
    assert (mode is not None) == seen
    assert mode is None or mode.frequency == pytest.approx(12.7, abs=0.02)


def test_an_estimate_is_off_by_what_the_mode_is_said_to_do() -> None:
    """The same noise with and without a mode whose smoothing the fit does not estimate."""
    of, sound, off = machine("ur10_wrist"), fitted("ur10_wrist", 0.0), fitted("ur10_wrist", 80.0)
    assert sound.regression.nuisance == off.regression.nuisance == 1
    left_out = LeftOut.of(off, off.samples.motion(off.at), of.case)
    rest = remainder_of(off, left_out.regressors(off.regression.names))
    column = left_out.weighted(sharpened(Mode(80.0, DAMPING), left_out)[:, :, None])
    said = biased_by(column, rest, free_basis(off))[:-1]
    found = (off.fit.values - sound.fit.values)[:-1]
    scale = np.sqrt(np.diag(off.fit.covariance))[:-1]
    assert np.abs(found / scale).max() > 0.5
    np.testing.assert_allclose(said / scale, found / scale, atol=0.25 * np.abs(found / scale).max())


def test_deviations_hold_with_a_mode() -> None:
    of = machine("hexapod")
    run = recorded(of, Moves(of, 3, 4.0), 2, STATED, behind_a_mode(of, 70.0))
    estimate = estimate_parameters(run, of.case)
    entry = estimate.quantities["structural_mode"]
    assert entry["frequency_Hz"] == pytest.approx(70.0, abs=3.0)
    assert any("rings at" in said for said in (*estimate.warnings, *estimate.notes))
    errors = [(p.value - of.truth[k]) / p.reported for k, p in estimate.physical.items() if k in of.truth]
    assert np.abs(errors).max() < 3.5


@pytest.mark.parametrize(("frequency", "wider"), few((55.0, 6.0), (45.0, 15.0), (80.0, 1.6)))
def test_forces_that_a_mode_sharpens_are_estimated_so(frequency: float, wider: float) -> None:
    """Neither is the mass off by the mode, nor is its deviation much larger for it, unless the mode is in the band."""
    of, seed = machine("hexapod"), 2
    sound, off = (
        estimate_parameters(recorded(of, Moves(of, 3, 4.0), seed, STATED, change), of.case)
        for change in (SOUND, behind_a_mode(of, frequency))
    )
    assert off.quantities["structural_mode"]["frequency_Hz"] == pytest.approx(frequency, abs=3.0)
    sharpening = (2.0 * np.pi * frequency) ** -2
    assert -2.0 * sharpening < off.quantities["smoothing_s2"]["value"] < -0.9 * sharpening
    for name, value in off.physical.items():
        assert abs(value.value - sound.physical[name].value) < 2.0 * value.reported, name
    assert off.physical["m"].reported < wider * sound.physical["m"].reported


def test_clear_sharpening_is_estimated_where_noise_hides_what_sampling_makes() -> None:
    """Noise of ten times the stated leaves less than a twelfth of a squared step unseen; a mode makes far more."""
    of = machine("hexapod")
    loud = replace(STATED, size=10.0)
    run = recorded(of, Moves(of, 3, 4.0), 4, loud, behind_a_mode(of, 45.0))
    entry = estimate_parameters(run, of.case).quantities["smoothing_s2"]
    assert entry["value"] < -5.0 * entry["std"]
