"""What s0 consists of, and what noise of the accelerations does to the parameters, where a case states its noise."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.estimation.estimators import method
from identification.hexapod import Hexapod
from identification.identify import estimate_parameters
from identification.model import identification_model, regressors
from identification.motion import Motion
from identification.recording import Recording
from identification.runs.noise_sources import regressor_squares
from identification.runs.preparation import moving_run
from identification.signals import Filter
from identification.simulate import simulate_recording
from identification.symbolic import over_samples
from tests.helpers import Harmonic, ideal, simulated
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
Array = np.ndarray


@dataclass(frozen=True)
class Later:
    """A motion that began some time ago: the same path, met by the encoders at other instants."""

    motion: Harmonic
    start: float

    @property
    def duration(self) -> float:
        return self.motion.duration

    def at(self, t: Array) -> Motion:
        return self.motion.at(np.asarray(t) + self.start)


def stated(case: Case, **noise: float) -> Case:
    return case.model_copy(update={"sensors": case.sensors.model_copy(update=noise)})


def run(case: Case, seed: int = 0, size: float = 1.0) -> Recording:
    """The whole motion but a tenth of a second at each end, its encoders read at instants that the seed shifts."""
    motion = Later(Harmonic(size=size), np.random.default_rng(seed).uniform(0.0, 1e-3))
    window = np.array([[0.1, motion.duration - 0.1]])
    return simulate_recording(case, PoseExecution(Hexapod.of(case), motion), window, seed, "run.csv")


def squares(case: Case, seed: int) -> float:
    return estimate_parameters(run(case, seed), case).fit.s0 ** 2


def test_gain_of_the_second_derivative_is_what_the_filter_makes_of_white_noise() -> None:
    low_pass = Filter(40.0, 1e-3)
    noise = np.random.default_rng(1).normal(size=(200_000, 1))
    assert low_pass.apply(noise, 2).var() == pytest.approx(low_pass.acceleration_noise_gain, rel=0.03)


@pytest.mark.slow
def test_shares_are_those_that_each_noise_alone_leaves() -> None:
    """s0^2 with force noise alone, and with encoder steps alone, over s0^2 with both."""
    sources = {"force_noise_N": 2.0, "encoder_resolution_um": 10.0}
    both = simulated(ideal(CASE), **sources)
    alone = [simulated(ideal(CASE), **{name: value}) for name, value in sources.items()]
    seeds = range(3)
    total = np.mean([squares(both, k) for k in seeds])
    shares = [np.mean([squares(case, k) for k in seeds]) / total for case in alone]
    assert min(shares) > 0.2  # the test sees both
    said = [estimate_parameters(run(both, k), stated(both, **sources)).noise for k in seeds]
    assert np.mean([s.force_sensors for s in said]) == pytest.approx(shares[0], rel=0.15)
    assert np.mean([s.accelerations for s in said]) == pytest.approx(shares[1], rel=0.15)
    assert np.mean([s.explained for s in said]) == pytest.approx(1.0, abs=0.1)


def test_what_is_not_stated_is_left_unexplained() -> None:
    case = simulated(CASE, force_noise_N=2.0)
    found = estimate_parameters(run(case), stated(case, force_noise_N=1.0))
    assert found.noise.to_json()["unexplained"] == pytest.approx(0.75, abs=0.08)
    assert found.noise.accelerations is None
    assert found.attenuation is None


def test_steps_and_noise_of_the_struts_add_as_variances() -> None:
    steps, noise, both = (
        stated(CASE, **k).sensors.strut_variance
        for k in ({"encoder_resolution_um": 6.0}, {"strut_noise_um": 2.0},
                  {"encoder_resolution_um": 6.0, "strut_noise_um": 2.0})
    )  # fmt: skip
    assert steps == pytest.approx(3e-12)
    assert noise == pytest.approx(4e-12)
    assert both == pytest.approx(7e-12)


def test_effect_of_the_accelerations_is_that_of_changed_struts() -> None:
    """Another strut acceleration, through the whole kinematics, changes A by just this."""
    case = ideal(CASE)
    made = moving_run(run(case), case, identification_model(case, 9))
    struts = [made.filter.apply(made.recording.struts, k)[made.rows] for k in range(3)]
    change, motion = np.random.default_rng(0).normal(size=struts[2].shape), made.kinematics(0.0)
    other = regressors(made.model, made.machine.kinematics(struts[0], struts[1], struts[2] + change))
    to_twist_rate = np.linalg.inv(over_samples(made.machine.inverse_jacobian, motion.pose)[1])
    found = regressor_squares(made.model, motion, to_twist_rate @ change[:, :, None], np.eye(6))
    effect = other - made.regressors(0.0)
    np.testing.assert_allclose(found, np.einsum("nku,nkv->uv", effect, effect), rtol=1e-9, atol=1e-9)


def noisy(recording: Recording, seed: int, std_um: float) -> Recording:
    errors = np.random.default_rng(seed).normal(0.0, std_um * 1e-6, recording.struts.shape)
    return replace(recording, struts=recording.struts + errors)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [True, False])
def test_attenuation_is_the_mean_bias_of_a_coarse_encoder(steps: bool) -> None:
    """Steps of 20 um on a small motion, and white noise as large: estimates are off by what is said, size and sign."""
    size, seeds, resolution = 0.7, range(8), 20.0
    clean, coarse = ideal(CASE), simulated(ideal(CASE), encoder_resolution_um=resolution)
    noise = stated(clean, encoder_resolution_um=resolution)
    off, said, std = [], [], []
    for seed in seeds:
        exact = run(clean, seed, size)
        recorded = run(coarse, seed, size) if steps else noisy(exact, seed, resolution / np.sqrt(12.0))
        true, found = estimate_parameters(exact, clean), estimate_parameters(recorded, noise)
        off.append([found.physical[n].value - true.physical[n].value for n in true.physical])
        said.append([a["bias"] for a in found.attenuation.values()])
        std.append([v.std for v in found.physical.values()])
    bias, told, error = np.mean(off, axis=0), np.mean(said, axis=0), np.mean(std, axis=0) / np.sqrt(len(seeds))
    clear = np.abs(told) > 6 * error  # of the others, the mean is too uncertain to compare with
    assert {"m", "IC33", "k0", "k2"} <= {n for n, c in zip(true.physical, clear, strict=True) if c}
    np.testing.assert_allclose(bias[clear], told[clear], rtol=0.3)
    assert np.abs((bias - told) / error)[~clear].max() < 5


def test_attenuation_that_cannot_be_told_is_said_to_be_so() -> None:
    found = estimate_parameters(run(CASE), stated(CASE, encoder_resolution_um=500.0))
    assert found.attenuation is None
    assert any("half or more" in w and "sensors.encoder_resolution_um" in w for w in found.warnings)


def test_a_case_that_states_nothing_is_told_nothing() -> None:
    found = estimate_parameters(run(CASE), CASE)
    assert found.noise is None
    assert found.attenuation is None


def test_too_much_stated_noise_is_told() -> None:
    found = estimate_parameters(run(CASE), stated(CASE, force_noise_N=2.0))
    assert any("check sensors.force_noise_N" in w for w in found.warnings)


def test_an_estimator_without_comparison_says_so() -> None:
    found = estimate_parameters(run(CASE), stated(CASE, force_noise_N=1.0), how=method("full"))
    assert found.noise is None
    assert any("gauss-markov and consistent" in w for w in found.warnings)
