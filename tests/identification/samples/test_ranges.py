"""Ranges, digits and noise of sensors and encoders: what is an end of a range, stuck, or motion."""

import numpy as np
import pytest

from identification.recording.recording import Recording
from identification.samples.sample_checks import at_full_range, scan
from identification.samples.standstills import find_standstills
from identification.signals import white_noise
from tests.identification.recording.formats.loaded_hexapod import CASE, run

T = 1e-3 * np.arange(4000)
RUN = run(T)


def recording(forces: np.ndarray) -> Recording:
    return Recording("run", T, RUN.struts, None, forces, None)


@pytest.mark.parametrize("offset", [0.0, -12_797.0, 22_106.0])
def test_a_constant_far_beyond_the_range_is_no_clipping(offset: float) -> None:
    force = offset + 60.0 * np.sin(3.0 * T)
    assert not at_full_range(force, 100.0).any()
    clipped = np.clip(force, offset - 45.0, offset + 45.0) if offset else np.clip(2.0 * force, -100.0, 100.0)
    ends = at_full_range(clipped, 100.0)
    assert 0.2 < ends.mean() < 0.8
    assert np.ptp(np.abs(clipped[ends] - offset)) < 1e-9 or not offset


def test_forces_beyond_twice_the_range_are_at_its_end_whatever_their_constant() -> None:
    assert at_full_range(5e4 + 300.0 * np.sin(3.0 * T), 100.0).all()


@pytest.mark.parametrize("digit", [2.0, 10.0])
def test_a_sensor_of_coarse_digits_is_not_stuck(digit: float) -> None:
    coarse = digit * np.rint(RUN.forces / digit)
    scanned, findings = scan(recording(coarse), CASE)
    assert not scanned.bad.any(), [str(f) for f in findings]


def test_a_sensor_that_is_stuck_is_found_among_coarse_ones() -> None:
    coarse = 2.0 * np.rint(RUN.forces / 2.0)
    coarse[1500:2500, 2] = coarse[1500, 2]
    scanned, findings = scan(recording(coarse), CASE)
    assert scanned.bad[1500:2500].mean() > 0.9
    assert "stuck" in str(findings[0])


@pytest.mark.parametrize("noise", [0.0, 2e-6, 2e-5])
def test_standstills_are_found_by_the_noise_of_the_encoders(noise: float) -> None:
    """Eight standstills of a second between smooth moves of half a second."""
    t = 2e-3 * np.arange(6000)
    u = np.clip((t % 1.5 - 1.0) / 0.5, 0.0, 1.0)
    way = np.floor(t / 1.5) + u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    joints = 0.1 * way[:, None] * np.array([1.0, -0.5, 0.3, 1.0, 0.2, -1.0])
    joints = joints + noise * np.random.default_rng(0).normal(size=joints.shape)
    assert white_noise(joints) == pytest.approx(noise, rel=0.1, abs=1e-8)
    found = find_standstills(Recording("run", t, joints, None, np.zeros((6000, 6)), None), 0.1)
    assert len(found) == 8
    assert all(np.ptp(way[window]) < 1e-3 for window in found)
