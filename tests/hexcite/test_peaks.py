"""What a run reached: coordinates' derivatives found back from twists, and peaks between a controller's cycles."""

import numpy as np
import pytest

from cases.schema import Case
from hexcite._run import executed_peaks
from identification.limits.limit import LimitKind
from identification.limits.proof import prove
from identification.machines.casadi_batch import over_samples
from identification.machines.executed import Execution, coordinate_rates
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import StraightMove
from tests.simulated_machine import PoseExecution, kinematics_of_coordinates


def test_rates_and_accelerations_of_the_coordinates_are_found_back_from_twist_and_twist_rate():
    draw = np.random.default_rng(3)
    pose, rates, accelerations = draw.normal(size=(50, 6)) * 0.4, draw.normal(size=(50, 6)), draw.normal(size=(50, 6))
    moving = kinematics_of_coordinates(pose, rates, accelerations)
    found = over_samples(coordinate_rates(), moving.pose, moving.twist, moving.twist_rate)
    assert np.allclose(found[0], rates, atol=1e-12)
    assert np.allclose(found[1], accelerations, atol=1e-12)


@pytest.fixture(scope="module")
def move(hexapod_case: Case) -> Joined:
    """Home, a skew move near its limits, and rest."""
    box, home = hexapod_case.limits.motion, hexapod_case.machine.home.vector
    end = home + np.array([0.1, -0.05, 0.03, 0.1, -0.2, 0.05])
    there = StraightMove.fastest(home, end, box.rate, box.acceleration, box.jerk)
    return Joined((Standstill(home, 0.1), there, Standstill(end, 0.1)))


def test_peaks_of_a_motion_that_is_followed_exactly_are_those_of_its_proof(move: Joined, hexapod_case: Case):
    peaks = executed_peaks(PoseExecution(Hexapod.of(hexapod_case), move), hexapod_case)
    proof = prove(move, hexapod_case).to_json()
    assert set(peaks) == {
        "velocity", "angular velocity", "acceleration", "angular acceleration", "strut velocity", "strut acceleration"
    }  # fmt: skip
    for name, share in peaks.items():
        assert share == pytest.approx(proof[name]["ratio"], rel=2e-3), name


def test_a_jolt_of_one_cycle_outside_the_excitation_is_seen_at_its_peak(move: Joined, hexapod_case: Case):
    """A step of 10 um in one strut between two cycles of 1 ms: 6 d / T^2 in a cubic spline, ten times the limit."""
    hexapod = Hexapod.of(hexapod_case)
    t = np.arange(0.0, move.duration, 1e-3)
    lengths = hexapod.strut_lengths(move.at(t).coordinates)
    before = executed_peaks(Execution.of_log(hexapod, 1e-3, lengths), hexapod_case)
    lengths[30:, 2] += 1e-5
    after = executed_peaks(Execution.of_log(hexapod, 1e-3, lengths), hexapod_case)
    kind = LimitKind("strut acceleration")
    assert before[kind] < 1.2
    limit = hexapod_case.limits.motion.strut_acceleration_m_s2
    assert after[kind] == pytest.approx(1e-5 / 1e-6 * (3 * (np.sqrt(3) - 1)) / limit, rel=0.01)
