"""Noise of encoders reaches the forces through accelerations: residuals that it explains accuse nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from identification.findings.causes.hypothesis import AS_RECORDED
from identification.findings.causes.instants import instants_of
from identification.findings.causes.trials import residual_forces
from identification.identify import default_model, estimate_parameters, identify
from identification.model.model import identification_model
from identification.recording.recording import Recording
from identification.results.pooling import pool
from identification.results.verdicts import accept
from tests.helpers import tells
from tests.mistaken.machines import run

SOUND = run("ur10_wrist", 0)
NOISE = 1e-4  # of each joint [rad]: many times what the sensor's own noise makes


def noisy(seed: int, size: float = NOISE) -> Recording:
    assert SOUND.recording.drives is not None
    draw = np.random.default_rng(seed).normal(size=SOUND.recording.drives.shape)
    return replace(SOUND.recording, drives=SOUND.recording.drives + size * draw)


def test_it_is_counted_where_residuals_are_judged() -> None:
    found = estimate_parameters(noisy(0), SOUND.case)
    (finding,) = [finding for finding in found.findings if "noise_excess" in finding.quantity]
    excess = finding.quantity["noise_excess"]
    assert finding.severity == "note"
    assert max(excess["ratios"]) > 1.6
    measured = np.array(excess["ratios"]) * np.array([SOUND.case.sensors.force_noise_N] * 3 + [0.0] * 3)
    np.testing.assert_allclose(excess["by_drives"][:3], measured[:3], rtol=0.25)
    assert not any("Do not use the result" in warning for warning in found.warnings)


@pytest.mark.repeats
def test_a_sound_run_is_accepted_with_it_and_a_mean_of_two_as_well() -> None:
    results = [identify(noisy(seed), SOUND.case) for seed in range(2)]
    for result in (*results, pool(results)):
        (check,) = [check for check in accept(result, SOUND.case).checks if check.code == "noise"]
        assert check.value < 1.3
        assert check.passed
        noise = result.record.channel_noise
        assert noise is not None
        assert max(np.array(noise["measured"]) / np.array(noise["stated"])) > 1.6


@pytest.mark.repeats
def test_what_else_is_wrong_is_found_beside_it() -> None:
    turn = Rotation.from_euler("z", 40.0, degrees=True).as_matrix()
    turned = noisy(1).forces.reshape(-1, 2, 3) @ turn
    with pytest.raises(IdentificationError) as caught:
        estimate_parameters(replace(noisy(1), forces=turned.reshape(-1, 6)), SOUND.case)
    assert tells(str(caught.value), "turned by", "about its z")


def test_trials_know_what_it_makes_of_the_forces() -> None:
    """Twice the noise makes twice the forces, and next to none where there is none."""
    model = identification_model(SOUND.case, default_model(SOUND.recording, SOUND.case))
    shaking = []
    for size in (0.0, NOISE, 2.0 * NOISE):
        instants = instants_of(noisy(2, size), SOUND.case, model)
        assert instants is not None
        shaking.append(residual_forces(instants, AS_RECORDED, 0.0).shaking)
    assert shaking[0] < 0.5
    assert shaking[1] > 1.0
    assert shaking[2] / shaking[1] == pytest.approx(2.0, rel=0.1)
