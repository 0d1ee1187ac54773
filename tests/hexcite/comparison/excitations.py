"""Methods of a validation, short enough for tests: one that moves, one that stands, on a machine that is disturbed."""

from functools import cache

import numpy as np

from cases.schema import Case, load_case
from hexcite.comparison.trials import Excitation, Trial, trials
from identification.machines.hexapod import Hexapod
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import StraightMove
from tests.helpers import Harmonic, paper_poses
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
FOUND = CASE.simulation.disturbances.model_copy(update={"strut_velocity_noise_percent": 0.8})  # slow motions
HOME = CASE.machine.home.vector


def poses() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    places, turns = paper_poses()
    return np.column_stack([places, Rotation.from_matrix(turns).as_euler("xyz")])[::8]


def moving(case: Case, seconds: float = 5.0, seed: int = 1) -> Excitation:
    """A method that moves."""
    execution = PoseExecution(Hexapod.of(case), Harmonic(seed=seed, duration=seconds))
    trigger = np.array([[0.5, seconds - 0.5]])
    return Excitation(case, "D", seconds - 1.0, execution, trigger, np.zeros((0, 6)), 0)


def brisk(case: Case) -> Excitation:
    """One that does not look as if its vibrations were errors of the pose."""
    return moving(case, 4.0, seed=0)


def standing(case: Case) -> Excitation:
    """A method that stands still for a quarter of a second in each of twenty poses."""
    box, stations = case.limits.motion, np.random.default_rng(3).permutation(poses())[:20]
    parts: list[Trajectory] = [Standstill(HOME, 0.3)]
    trigger, clock, here = [], 0.3, HOME
    for pose in stations:
        move = StraightMove.fastest(here, pose, box.rate, box.acceleration, box.jerk)
        parts += [move, Standstill(pose, 0.45)]
        clock += move.duration + 0.45
        trigger.append((clock - 0.25, clock))
        here = pose
    execution = PoseExecution(Hexapod.of(case), Joined(tuple(parts)))
    return Excitation(case, "Q", clock, execution, np.array(trigger), stations, 0)


@cache
def disturbed(method: str) -> tuple[Trial, ...]:
    """Trials of the disturbed machine, without weights and with three."""
    return tuple(trials({"D": moving, "Q": standing}[method](CASE), (0, 3), FOUND))


NO_MODE = {"mode_Hz": 1e5}
NO_POSE_ERROR = {"pose_error_N": 0.0, "pose_error_of_load": 0.0}
