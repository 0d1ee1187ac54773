"""Ranges, digits and noise of sensors and encoders: what is an end of a range, stuck, or motion."""

import numpy as np
import pytest

from cases.schema import Case
from identification.finding import Kind
from identification.recording.recording import Recording
from identification.samples.sample_checks import at_full_range, scan
from identification.samples.standstills import find_standstills
from identification.signals import white_noise
from tests.chains import ROBOT, swing, swung_forces
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


ROBOT_T = 2e-3 * np.arange(4000)


def robot_recording(joints: np.ndarray, forces: np.ndarray | None = None) -> Recording:
    draw = np.random.default_rng(5)
    noise = draw.normal(size=(len(ROBOT_T), 6)) * np.repeat([0.3, 0.01], 3)
    return Recording("run", ROBOT_T, joints, None, swung_forces(ROBOT_T) + noise if forces is None else forces, None)


def test_moments_at_the_end_of_their_range_are_left_out() -> None:
    """Of a noisy converter, whose values at the end differ, so that it is not stuck."""
    forces = np.array(robot_recording(swing(ROBOT_T)[0]).forces)
    forces[1000:1100, 4] = 10.0 + 1e-3 * np.random.default_rng(1).random(100)
    scanned, findings = scan(robot_recording(swing(ROBOT_T)[0], forces), ROBOT)
    assert scanned.bad[1000:1100].all()
    assert scanned.bad.sum() == 100
    told = [str(f) for f in findings if f.kind is Kind.DAMAGE]
    assert len(told) == 1
    assert all(word in told[0] for word in ("channel 5", "10 N m"))


def test_a_glitch_of_a_joint_is_left_out_and_named() -> None:
    joints = swing(ROBOT_T)[0].copy()
    joints[2000, 2] += 0.05
    scanned, findings = scan(robot_recording(joints), ROBOT)
    assert np.flatnonzero(scanned.bad).tolist() == [2000]
    (told,) = [str(f) for f in findings]
    assert all(word in told for word in ("line 2002", "joint 3", "2.86"))


def test_joints_and_struts_that_are_held_for_some_samples_do_not_leap() -> None:
    joints = swing(ROBOT_T)[0].repeat(2, axis=0)[: len(ROBOT_T)]  # twice as slow, each value twice
    assert not scan(robot_recording(joints), ROBOT).recording.bad.any()
    struts = np.array(RUN.struts)
    struts[1::2] = struts[::2]
    held = Recording("run", T, struts, None, RUN.forces, None)
    assert not scan(held, CASE).recording.bad.any()


def test_a_joint_beyond_its_ends_is_named_with_them() -> None:
    joints = swing(ROBOT_T)[0].copy()
    joints[:, 2] += 2.0 * np.pi
    (told,) = scan(robot_recording(joints), ROBOT).findings
    assert told.kind is Kind.CASE
    low, high = np.rad2deg(ROBOT.chain.position[:, 2])
    name = ROBOT.chain.names[2]
    assert all(text in str(told) for text in (name, f"{low:g} to {high:g}", "machine.chain.joints[3].position_deg"))
    assert not scan(robot_recording(swing(ROBOT_T)[0]), ROBOT).findings


@pytest.mark.parametrize("case", [ROBOT, CASE])
def test_a_range_of_moments_alone_or_of_bars_is_an_error(case: Case) -> None:
    """Nothing would read the first, and half of the bars would count the second."""
    tables = case.model_dump(mode="json", exclude_defaults=True)
    tables["sensors"]["range_Nm"] = 10.0
    if case is ROBOT:
        del tables["sensors"]["range_N"]
    with pytest.raises(ValueError, match=r"sensors\.range_Nm .*range_N"):
        Case.model_validate(tables)
