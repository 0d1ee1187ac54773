"""What s0 of a periodic run consists of, and what noise of its accelerations does to the parameters."""

from dataclasses import replace

import numpy as np
import pytest

from cases.schema import load_case
from identification.identify import estimate_parameters
from identification.recording import Recording
from identification.samples import Conditioning
from tests.helpers import ideal, simulated
from tests.identification.repeating import Repeating, recorded
from tests.identification.runs.test_noise_sources import noisy, stated

CASE = ideal(load_case("hexapod"))
WISH = Conditioning(True, harmonics=40)
EXACT = recorded(CASE, Repeating(periods=3))


def forces_of(recording: Recording, seed: int, std: float) -> Recording:
    drawn = np.random.default_rng(100 + seed).normal(0.0, std, recording.forces.shape)
    return replace(recording, forces=recording.forces + drawn)


def squares(recording: Recording) -> float:
    return estimate_parameters(recording, CASE, conditioning=WISH).fit.s0 ** 2


@pytest.mark.slow
def test_shares_are_those_that_each_noise_alone_leaves() -> None:
    """Averaging takes noise of forces and struts alike; the struts' grows with the square of the frequency."""
    case, seeds = stated(CASE, force_noise_N=0.5, strut_noise_um=5.0), range(4)
    said = [estimate_parameters(noisy(forces_of(EXACT, k, 0.5), k, 5.0), case, conditioning=WISH).noise for k in seeds]
    total = np.mean([squares(noisy(forces_of(EXACT, k, 0.5), k, 5.0)) for k in seeds])
    forces = np.mean([squares(forces_of(EXACT, k, 0.5)) for k in seeds]) / total
    struts = np.mean([squares(noisy(EXACT, k, 5.0)) for k in seeds]) / total
    assert min(forces, struts) > 0.1  # the test sees both
    assert np.mean([s.force_sensors for s in said]) == pytest.approx(forces, rel=0.15)
    assert np.mean([s.accelerations for s in said]) == pytest.approx(struts, rel=0.15)
    assert np.mean([s.explained for s in said]) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(("period", "repeats"), [(2.0, True), (2.0003, False)])
def test_steps_of_encoders_that_repeat_are_not_averaged_away(period: float, repeats: bool) -> None:
    case = simulated(CASE, encoder_resolution_um=20.0)
    run = forces_of(recorded(case, Repeating(period, 3)), 0, 0.5)
    found = estimate_parameters(
        run, stated(CASE, force_noise_N=0.5, encoder_resolution_um=20.0), conditioning=WISH
    ).noise
    assert found.explained == pytest.approx(1.0, abs=0.25)
    above = 15  # harmonics of the struts beside those of the forces
    orders = np.arange(1, 40 + above + 1) * 2 * np.pi / period
    variance = (20e-6**2 / 12) * 2 * np.sum(orders**4) / (3 * 1000 * period)
    assert found.acceleration_std**2 == pytest.approx(variance * (3 if repeats else 1), rel=0.01)


@pytest.mark.slow
def test_attenuation_is_the_mean_bias_by_noise_of_the_struts() -> None:
    seeds, std = range(5), 100.0
    case = stated(CASE, strut_noise_um=std)
    true = estimate_parameters(EXACT, CASE, conditioning=WISH)
    found = [estimate_parameters(noisy(EXACT, k, std), case, conditioning=WISH) for k in seeds]
    names = ("m", "IC11", "IC22", "IC33")
    off = np.array([[e.physical[n].value - true.physical[n].value for n in names] for e in found])
    said = np.mean([[e.attenuation[n]["bias"] for n in names] for e in found], axis=0)
    error = off.std(axis=0, ddof=1) / np.sqrt(len(seeds))
    assert (np.abs(said) > 6 * error).all()  # there is something to compare
    np.testing.assert_allclose(off.mean(axis=0), said, rtol=0.3)
