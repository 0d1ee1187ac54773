"""Bounds of sensor forces: nothing that keeps the limits passes them, and something comes close."""

import numpy as np

from cases.schema import load_case
from identification.limits.limit import LimitCheck, Status
from identification.limits.sensor_loads import SHARE, Loads
from identification.motion.motion import Motion, rotation_motion
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.reading import Reading
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
LOADS = Loads.of(CASE)
LIMITS = CASE.limits.motion


def forces(pose, rates, accelerations) -> np.ndarray:
    """Newton and Euler for each body."""
    none = np.zeros_like(pose)
    motion = Motion(np.zeros(len(pose)), pose.copy(), rates.copy(), accelerations.copy(), none)
    return np.abs(LOADS.forces(motion, rotation_motion(motion), motion.accelerations[:, :3]))


def bounds(case) -> tuple[LimitCheck, ...]:
    """Bounds of programs for LinuxCNC, which enforces velocities and accelerations of moves."""
    return linuxcnc_guarantees(Reading("", (), 0), case).force_bounds()


def corners(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Rates and accelerations with every coordinate at one of its limits."""
    signs = rng.choice([-1.0, 1.0], (2, count, 6))
    return signs[0] * LIMITS.rate, signs[1] * LIMITS.acceleration


def test_no_motion_within_the_limits_passes_the_bound_of_any_pose():
    rng = np.random.default_rng(1)
    angles = np.column_stack([rng.uniform(-np.pi, np.pi, 50_000) for _ in range(3)])
    pose = np.hstack([np.zeros_like(angles), angles])
    found = forces(pose, *corners(rng, len(pose))).max()
    bound = bounds(CASE)[0].worst
    assert 0.7 * bound < found <= bound


def test_a_bound_above_the_range_is_proven_by_nobody():
    weak = changed(CASE, sensors__range_N=0.9 * bounds(CASE)[0].worst / SHARE)
    assert [c.status for c in bounds(weak)] == [Status.NOT_ENFORCED]
    assert [c.status for c in bounds(CASE)] == [Status.PROVEN]


def test_without_a_range_there_is_no_bound():
    assert Loads.of(changed(CASE, sensors__range_N=None)) is None
