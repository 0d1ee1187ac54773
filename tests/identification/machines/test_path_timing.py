"""Re-timed paths: the same poses, limits kept as the independent proof sees them, and reasons where there is no way."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import ArrayLike

from cases.schema import Case, load_case
from identification.limits.limit import LimitReport
from identification.limits.proof import prove
from identification.machines.path_timing import retime
from identification.motion.motion import Joined, Motion, Standstill, TimedPoints
from identification.motion.moves import StraightMove, UntimedMotion
from tests.postprocessors.changed_case import changed

CASE = load_case("hexapod")
HOME = CASE.machine.home.vector
LIMITED = (
    "velocity",
    "angular velocity",
    "acceleration",
    "angular acceleration",
    "strut velocity",
    "strut acceleration",
)


@dataclass(frozen=True)
class Wave:
    """All coordinates as sin^4, from rest to rest, `scale` of a comfortable amplitude."""

    scale: float
    duration: float = 4.0

    def at(self, t: ArrayLike) -> Motion:
        time = np.asarray(t, dtype=float)
        phase = np.pi * time[:, None] / self.duration
        s, c = np.sin(phase), np.cos(phase)
        w = np.pi / self.duration
        amplitude = self.scale * np.array([0.1, -0.1, 0.05, 0.1, -0.1, 0.1])
        values = [
            s**4,
            4 * w * s**3 * c,
            w**2 * (12 * s**2 * c**2 - 4 * s**4),
            w**3 * (24 * s * c**3 - 40 * s**3 * c),
        ]
        return Motion(time, HOME + amplitude * values[0], *(amplitude * v for v in values[1:]))


def ratio(report: LimitReport, *names: str) -> float:
    return max(c.ratio for c in report.checks if str(c.of) in (names or LIMITED))


def test_the_wave_is_what_it_says():
    t = np.linspace(0.0, 4.0, 40_001)
    m = Wave(1.0).at(t)
    for lower, upper in ((m.coordinates, m.rates), (m.rates, m.accelerations), (m.accelerations, m.jerks)):
        assert np.allclose(np.gradient(lower, t, axis=0)[5:-5], upper[5:-5], atol=1e-5)


def test_a_motion_inside_its_limits_keeps_its_pace():
    wave = Wave(1.0)
    assert ratio(prove(wave, CASE, 1000.0)) < 1.0
    found = retime(wave, CASE)
    assert found.duration == pytest.approx(wave.duration, rel=1e-5)
    t = np.linspace(0.0, wave.duration, 500)
    assert np.allclose(found.at(t).coordinates, wave.at(t).coordinates, atol=1e-5)
    assert np.allclose(found.at(t).jerks, wave.at(t).jerks, atol=1e-3)


@pytest.mark.parametrize("hurry", [6.0, 8.0, 12.0])
def test_whatever_is_passed_is_kept_afterwards(hurry: float):
    wave = Wave(1.5, 4.0 / hurry)
    assert ratio(prove(wave, CASE, 1000.0)) > 1.0
    found = retime(wave, CASE)
    assert ratio(prove(found, CASE)) <= 1.0 + 1e-6
    assert found.duration > wave.duration


def test_struts_slow_a_motion_down_although_the_coordinates_could_go_faster():
    weak = {"limits__motion__strut_velocity_m_s": 0.05, "limits__motion__strut_acceleration_m_s2": 0.8}
    case = changed(CASE, **weak)
    wave = Wave(1.0)
    before = prove(wave, case, 1000.0)
    assert ratio(before, *LIMITED[:4]) < 1.0 < ratio(before, "strut velocity")
    found = retime(wave, case)
    after = prove(found, case)
    assert ratio(after, "strut velocity", "strut acceleration") <= 1.0 + 1e-6
    assert ratio(after, "strut velocity") > 0.99  # and not slower than they ask for


def test_the_same_poses_are_passed_in_the_same_order():
    wave = Wave(1.5, 0.5)
    found = retime(wave, CASE)
    here = found.at(found.times).coordinates
    assert np.allclose(here, wave.at(found.shares * wave.duration).coordinates, atol=1e-9)
    assert np.all(np.diff(found.times) > 0.0)


def test_derivatives_belong_together():
    found = retime(Wave(1.5, 0.5), CASE)
    t = np.linspace(0.0, found.duration, 200_001)
    m = found.at(t)
    assert np.allclose(np.gradient(m.coordinates, t, axis=0), m.rates, atol=1e-4)
    assert np.abs(np.gradient(m.rates, t, axis=0) - m.accelerations).mean() < 1e-2  # accelerations may step


def test_a_path_with_stops_is_timed_through_them():
    there = HOME + np.array([0.1, 0.05, -0.02, 0.1, 0.0, -0.1])
    box = CASE.limits.motion
    hasty = [3 * v for v in (box.rate, 9 * box.acceleration, 27 * box.jerk)]
    parts = (
        StraightMove.fastest(HOME, there, *hasty),
        Standstill(there, 0.2),
        StraightMove.fastest(there, HOME, *hasty),
    )
    path = Joined(parts)
    assert ratio(prove(path, CASE)) > 1.0
    found = retime(path, CASE)
    assert ratio(prove(found, CASE)) <= 1.0 + 1e-6
    assert np.allclose(found.at([found.duration]).coordinates[0], HOME, atol=1e-9)


class InMotion(Wave):
    """Begins in the middle."""

    def at(self, t: ArrayLike) -> Motion:
        m = super().at(np.asarray(t, dtype=float) * 0.75 + self.duration / 4)
        return Motion(np.asarray(t, dtype=float), m.coordinates, m.rates, m.accelerations, m.jerks)


class Broken(Wave):
    """Not a number somewhere."""

    def at(self, t: ArrayLike) -> Motion:
        m = super().at(t)
        pose = m.coordinates.copy()
        pose[len(pose) // 2, 2] = np.nan
        return Motion(m.t, pose, m.rates, m.accelerations, m.jerks)


def test_a_path_that_begins_in_motion_is_refused():
    with pytest.raises(UntimedMotion, match=r"at an end; it must rest"):
        retime(InMotion(1.0), CASE)


def test_a_path_that_is_no_number_is_refused():
    with pytest.raises(UntimedMotion, match="not finite"):
        retime(Broken(1.0), CASE)


def test_a_path_that_no_pace_makes_possible_says_why(monkeypatch: pytest.MonkeyPatch):
    """Toppra gives up and returns nothing but a code: the code becomes a sentence."""
    from toppra.algorithm import TOPPRA

    def give_up(self: TOPPRA, *_: float) -> None:
        self.problem_data.return_code = type(self.problem_data.return_code).FailUncontrollable

    monkeypatch.setattr(TOPPRA, "compute_parameterization", give_up)
    with pytest.raises(UntimedMotion, match="no pace keeps all limits"):
        retime(Wave(1.0), CASE)


def test_timed_points_of_a_user_are_a_path_too():
    t = np.linspace(0.0, 1.0, 21)
    points = TimedPoints.through(t, Wave(2.0, 1.0).at(t).coordinates)
    found = retime(points, CASE)
    assert ratio(prove(found, CASE)) <= 1.0 + 1e-6


def test_a_case_without_a_machine_is_refused():
    wrist: Case = load_case("ft_wrist")
    with pytest.raises(Exception, match="machine"):
        retime(Wave(1.0), wrist)
