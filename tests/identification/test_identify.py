"""From a simulated run back to the parameters of the simulated machine."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import cho_factor
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_info, threadpool_limits

from cases.base.errors import IdentificationError
from cases.schema import Case, load_case
from identification.estimation import pose_noise
from identification.identify import estimate_parameters
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters, physical_form
from identification.recording.recording import Recording
from identification.simulate import simulate_recording
from tests.helpers import HOME, Harmonic, few, ideal, seeds, simulated
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
TRUTH = linear_parameters(identification_model(CASE, 9), CASE.simulation.parameters)
PHYSICAL = physical_form(identification_model(CASE, 9)).of(TRUTH, np.eye(20))[0]
MOTION = Harmonic()


def run(case: Case, motion: Harmonic = MOTION, seed: int = 0) -> Recording:
    """The whole motion but a tenth of a second at each end, which the filter needs."""
    window = np.array([[0.1, motion.duration - 0.1]])
    return simulate_recording(case, PoseExecution(Hexapod.of(case), motion), window, seed, "run.csv")


def test_an_ideal_machine_gives_its_parameters_back() -> None:
    """What remains is what the filter does to the motion: at most 1e-4 of its amplitude in the pass band."""
    estimate = estimate_parameters(run(ideal(CASE)), CASE)
    found = np.array([v.value for v in estimate.physical.values()])
    np.testing.assert_allclose(found, PHYSICAL, rtol=1e-4, atol=1e-5)
    assert estimate.delay.value == pytest.approx(0.0, abs=1e-6)
    assert estimate.fit.white_noise < 1e-2
    assert (estimate.fit.rank, estimate.model.number) == (20, 9)


@seeds(4)
def test_the_default_machine_gives_its_parameters_back_within_their_errors(seed: int) -> None:
    """With encoder steps, noise, delay and sampling between cycles, on four motions: 80 values within 4.5 std."""
    estimate = estimate_parameters(run(CASE, Harmonic(seed=seed), seed), CASE)
    found, std = (np.array([getattr(v, k) for v in estimate.physical.values()]) for k in ("value", "std"))
    assert np.abs((found - PHYSICAL) / std).max() < 4.5
    assert estimate.fit.white_noise == pytest.approx(CASE.simulation.force_noise_N, rel=0.1)
    assert estimate.warnings == ()


@pytest.mark.parametrize("delay_ms", few(2.0, 0.0, 8.0, 15.0))
@pytest.mark.parametrize("cycles", few(0.5, 0.0, 1.0))
def test_delay_and_sampling_offset_are_found_together(delay_ms: float, cycles: float) -> None:
    case = simulated(CASE, force_delay_ms=delay_ms, force_sampling_offset_cycles=cycles)
    estimate = estimate_parameters(run(case), case)
    late = delay_ms * 1e-3 + cycles / case.simulation.encoder_rate_Hz
    assert abs(estimate.delay.value - late) < 4 * estimate.delay.std
    assert abs(estimate.physical["m"].value - 31.83) < 4.5 * estimate.physical["m"].std


@pytest.mark.parametrize("delay_ms", few(8.5, 2.5, 15.5))
def test_without_noise_the_delay_is_found_to_ten_microseconds(delay_ms: float) -> None:
    case = simulated(ideal(CASE), force_delay_ms=delay_ms)
    assert estimate_parameters(run(case), case).delay.value == pytest.approx(delay_ms * 1e-3, abs=1e-5)


@pytest.mark.repeats
@pytest.mark.parametrize("cutoff", few(100.0, 15.0, 190.0))
def test_the_cutoff_of_the_filter_is_no_matter_of_truth(cutoff: float) -> None:
    """A fast filter is short; its kernel must still reach as far as the delay."""
    recording = CASE.recording.model_copy(update={"filter_cutoff_Hz": cutoff})
    case = simulated(ideal(CASE), force_delay_ms=15.0).model_copy(update={"recording": recording})
    estimate = estimate_parameters(run(case, Harmonic(duration=4.0)), case)
    assert estimate.delay.value == pytest.approx(0.015, abs=1e-5)
    assert estimate.physical["m"].value == pytest.approx(31.83, abs=0.01)


@pytest.mark.repeats
def test_a_delay_beyond_reason_is_warned_of() -> None:
    case = simulated(CASE, force_delay_ms=30.0)
    assert any("do the streams match?" in w for w in estimate_parameters(run(case), case).warnings)


@pytest.mark.repeats
def test_a_clock_that_started_long_ago_gives_the_same_parameters() -> None:
    recording = run(CASE)
    plain, late = (
        estimate_parameters(recording, CASE),
        estimate_parameters(replace(recording, t=recording.t + 8192.0), CASE),
    )
    np.testing.assert_allclose(late.fit.values, plain.fit.values, rtol=1e-6, atol=1e-6)


def test_the_window_of_the_motion_is_found_without_a_trigger() -> None:
    recording = run(CASE)
    with_trigger, without = (
        estimate_parameters(recording, CASE),
        estimate_parameters(replace(recording, trigger=None), CASE),
    )
    std = np.array([v.std for v in with_trigger.physical.values()])
    change = [without.physical[n].value - v.value for n, v in with_trigger.physical.items()]
    assert np.abs(change / std).max() < 3.0


@pytest.mark.repeats
def test_rows_outside_the_trigger_do_not_count() -> None:
    recording = run(CASE, Harmonic(duration=4.0))
    trigger = (recording.t > 0.5) & (recording.t < 3.0)
    disturbed = recording.forces.copy()
    disturbed[recording.t > 3.5] += 100.0  # further from the window than the filter reaches
    plain, other = (
        estimate_parameters(replace(recording, trigger=trigger, forces=forces), CASE)
        for forces in (recording.forces, disturbed)
    )
    np.testing.assert_allclose(other.fit.values, plain.fit.values, rtol=1e-9, atol=1e-9)


@pytest.mark.repeats
def test_ten_kilogrammes_more_are_found_as_ten_kilogrammes() -> None:
    parameters = CASE.simulation.parameters
    body = parameters.body.model_copy(update={"mass_kg": parameters.body.mass_kg + 10.0})
    heavier = simulated(CASE, parameters=parameters.model_copy(update={"body": body}))
    light, heavy = (estimate_parameters(run(c), c).physical["m"] for c in (CASE, heavier))
    assert heavy.value - light.value == pytest.approx(10.0, abs=4.5 * np.hypot(light.std, heavy.std))


@pytest.mark.parametrize("number", [0, 2, 5])
def test_standstills_give_the_static_parameters(number: int) -> None:
    """Forces from the full model at rest; models without the deformation see it as error, so it is switched off."""
    draw, model = np.random.default_rng(number), identification_model(CASE, 5)
    poses = HOME + draw.uniform(*CASE.limits.motion.coordinates, (60, 6))
    u = np.r_[TRUTH[:4], TRUTH[10:16], [24.05, -8.46] if number else [0, 0], [37.38, 28.27] if number == 5 else [0, 0]]
    turns = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix()
    forces = model.matrices(poses[:, :3], turns, np.zeros((60, 6)), np.zeros((60, 6))) @ u
    recording = Recording("poses.csv", None, Hexapod.of(CASE).strut_lengths(poses), None, forces, None)
    estimate = estimate_parameters(recording, CASE, number)
    np.testing.assert_allclose(estimate.fit.values, u[: len(estimate.fit.values)], rtol=1e-7, atol=1e-6)
    assert estimate.delay is None


@pytest.mark.repeats
def test_by_default_the_model_is_what_the_recording_can_carry() -> None:
    recording = run(CASE)
    assert estimate_parameters(recording, CASE).model.number == 9
    standing = replace(recording, t=None, trigger=None, drives=recording.drives[::50], forces=recording.forces[::50])
    assert estimate_parameters(standing, CASE).model.number == 5


@pytest.mark.repeats
@pytest.mark.parametrize("threads", few(2, 1))
def test_blas_has_one_thread_meanwhile_and_the_callers_setting_again_afterwards(
    monkeypatch: pytest.MonkeyPatch, threads: int
) -> None:
    """Every pool, for NumPy and SciPy bring one each; after a refused run too."""

    def pools() -> dict[str, int]:
        return {pool["filepath"]: pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    during: list[dict[str, int]] = []

    def factorised(matrix: np.ndarray, lower: bool) -> tuple[np.ndarray, bool]:
        during.append(pools())
        return cho_factor(matrix, lower=lower)

    monkeypatch.setattr(pose_noise, "cho_factor", factorised)
    moving = run(CASE)
    with threadpool_limits(limits=threads, user_api="blas"):
        before = pools()  # some libraries know one number only
        estimate_parameters(moving, CASE)
        assert pools() == before
        with pytest.raises(IdentificationError):
            estimate_parameters(replace(moving, forces=0.0 * moving.forces), CASE)
        assert pools() == before
    assert threads in before.values()
    assert during
    assert {number for some in during for number in some.values()} == {1}
