"""Moves straight in the struts: struts in proportion, coordinates as they then must be, by inverse kinematics alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.loading import load_case
from identification.hexapod import Hexapod
from identification.trajectories.profile import fastest_profile
from identification.trajectories.strut_move import NoStrutMove, StrutMove
from tests.helpers import HOME
from tests.postprocessors.independent import strut_lengths

CASE = load_case("hexapod")
HEXAPOD = Hexapod.of(CASE)
LAW = fastest_profile(1.0, 2.0, 8.0, 60.0)
RANGE = np.array([0.25, 0.25, 0.1, 0.35, 0.35, 0.35])

poses = st.tuples(*(st.floats(-1.0, 1.0) for _ in range(6))).map(lambda p: HOME + RANGE * np.array(p))


@given(start=poses, end=poses.filter(lambda p: np.abs(p - HOME).max() > 1e-3))
def test_the_struts_change_in_proportion_from_one_pose_to_the_other(start: np.ndarray, end: np.ndarray) -> None:
    if np.abs(end - start).max() < 1e-3:
        return
    move = StrutMove.between(HEXAPOD, start, end, LAW)
    t = np.linspace(0.0, move.duration, 60)
    share = LAW.at(t)[0][:, None]
    ends = strut_lengths(np.vstack([start, end]), CASE)
    found = strut_lengths(move.at(t).pose, CASE)
    np.testing.assert_allclose(found, ends[0] + share * (ends[1] - ends[0]), atol=1e-9)
    np.testing.assert_allclose(move.at([0.0, move.duration]).pose, [start, end], atol=1e-9)
    assert move.strut_way == pytest.approx(np.abs(ends[1] - ends[0]).max())


def test_rates_accelerations_and_jerks_are_those_of_the_path() -> None:
    move = StrutMove.between(HEXAPOD, HOME - 0.8 * RANGE, HOME + 0.9 * RANGE, LAW)
    step = 1e-4
    t = np.arange(0.0, move.duration, step)
    m = move.at(t)
    smooth = np.all(np.diff(np.searchsorted(phases(), np.add.outer(t, [-5 * step, 5 * step])), axis=1) == 0, axis=1)
    smooth[[0, -1]] = False
    for lower, upper in ((m.pose, m.rates), (m.rates, m.accelerations), (m.accelerations, m.jerks)):
        slope = np.gradient(lower, step, axis=0)
        np.testing.assert_allclose(slope[smooth], upper[smooth], atol=2e-4 * np.abs(upper).max())


def phases() -> np.ndarray:
    return np.cumsum(LAW.lengths)


def test_the_deviation_is_that_from_the_straight_way() -> None:
    """A rise along z from home is straight in both, a far move is not."""
    up = StrutMove.between(HEXAPOD, HOME, HOME + np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.0]), LAW)
    assert max(up.deviation) < 1e-9
    start, end = HOME + np.array([-0.2, 0.0, 0.0, 0.0, 0.0, 0.0]), HOME + np.array([0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    far = StrutMove.between(HEXAPOD, start, end, LAW)
    poses = far.along(np.linspace(0.0, 1.0, 4001))[0]
    assert far.deviation.position == pytest.approx(np.hypot(poses[:, 1], poses[:, 2] - 0.9).max(), rel=1e-3)
    assert far.deviation.position > 0.01
    assert far.deviation.angle == pytest.approx(np.linalg.norm(poses[:, 3:], axis=1).max(), rel=1e-3)


def test_a_way_into_another_assembly_is_refused() -> None:
    """Turned by 130 degrees the platform stands in an assembly that home does not reach."""
    with pytest.raises(NoStrutMove, match=r"assembly|singularity|follow"):
        StrutMove.between(HEXAPOD, HOME, HOME + np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.radians(130.0)]), LAW)
