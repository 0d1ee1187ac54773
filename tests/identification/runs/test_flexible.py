"""A machine whose structure yields: its lowest mode is told, and no longer drawn into mass and inertia."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import ArrayLike

from cases.errors import RecordingError
from cases.schema import load_case
from identification.hexapod import Hexapod
from identification.identify import estimate_parameters
from identification.motion import Motion
from identification.recording import Recording
from identification.result import Estimate
from identification.samples import Conditioning
from identification.simulate import Circumstances, simulate_recording
from tests.helpers import Harmonic, simulated
from tests.simulated_machine import PoseExecution, simulate_standstills

CASE = load_case("hexapod")


@dataclass(frozen=True)
class Repeated:
    """Harmonics of half a hertz to two, for eight seconds."""

    motion: Harmonic = field(default_factory=lambda: Harmonic(seed=1, duration=2.0))
    duration: float = 8.0

    def at(self, t: ArrayLike) -> Motion:
        return self.motion.at(t)


EXECUTION = PoseExecution(Hexapod.of(CASE), Repeated())
QUIET = simulated(CASE, force_noise_N=0.1)
CALM = {"pose_error_N": 0.0, "pose_error_of_load": 0.0, "strut_velocity_noise_percent": 0.0}
FLEXIBLE = Conditioning(flexible=True)
TRUE_MASS = 31.83


def run(mode: float) -> Recording:
    found = CASE.simulation.disturbances.model_copy(update=CALM | {"mode_Hz": mode})
    return simulate_recording(QUIET, EXECUTION, np.array([[0.5, 7.5]]), 0, "run.csv", Circumstances((), found))


def off(estimate: Estimate) -> float:
    mass = estimate.physical["m"]
    return abs(mass.value - TRUE_MASS) / mass.reported


@pytest.mark.parametrize("mode", [25.0, pytest.param(40.0, marks=pytest.mark.slow)])
def test_the_mode_is_found_and_no_longer_draws_the_mass(mode: float):
    recording = run(mode)
    rigid, flexible = estimate_parameters(recording, CASE), estimate_parameters(recording, CASE, conditioning=FLEXIBLE)
    found = flexible.quantities["structural_mode_Hz"]
    assert found["value"] == pytest.approx(mode, rel=0.05)
    assert abs(flexible.physical["m"].value - TRUE_MASS) < 0.3 * abs(rigid.physical["m"].value - TRUE_MASS)
    assert off(rigid) > 5.0
    assert any(f"a structural mode at {found['value']:.3g} +-" in note for note in flexible.notes)
    assert flexible.case == CASE


def test_a_rigid_machine_has_no_mode():
    estimate = estimate_parameters(run(1e5), CASE, conditioning=FLEXIBLE)
    assert "structural_mode_Hz" not in estimate.quantities
    assert any("no structural mode is seen" in note for note in estimate.notes)
    assert off(estimate) < 4.0


def test_what_does_not_move_has_no_mode_to_see():
    poses = CASE.machine.home.vector + np.random.default_rng(0).uniform(-0.1, 0.1, (20, 6))
    with pytest.raises(RecordingError, match="flexible is for moving runs"):
        estimate_parameters(simulate_standstills(CASE, poses, 100, 0), CASE, conditioning=FLEXIBLE)
