"""A wrench that a controller has compensated or turned does not pass unnoticed, at rest or in motion."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.base.errors import IdentificationError
from identification.identify import estimate_parameters
from identification.machines.of_case import machine_of
from identification.recording.recording import Recording
from tests.chains import ROBOT, standing_forces, swing, swung_forces
from tests.helpers import few

T = np.arange(0.0, 8.0, 0.002)
MOVING = swing(T)[0], T, swung_forces(T)
PLACES = ROBOT.chain.home + np.random.default_rng(5).uniform(-0.7, 0.7, (40, 6))
STANDING = PLACES, None, standing_forces(PLACES)
RUNS = {"moving": MOVING, "standing": STANDING}


def in_base(q: np.ndarray, forces: np.ndarray) -> np.ndarray:
    still = np.zeros_like(q)
    turn = Rotation.from_euler("xyz", machine_of(ROBOT).kinematics(q, still, still).pose[:, 3:]).as_matrix()
    return np.hstack([np.einsum("nij,nj->ni", turn, forces[:, k : k + 3]) for k in (0, 3)])


def weightless(q: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Without what the load weighs at rest; offsets were zeroed once."""
    return forces - standing_forces(q)


def recorded(run: str, change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Recording:
    q, t, forces = RUNS[run]
    noise = np.random.default_rng(3).normal(size=forces.shape) * ([0.3] * 3 + [0.01] * 3)
    forces = change(q, forces) + noise / (1.0 if t is not None else 20)
    return Recording("run.csv", t, q, None, forces, None, case=ROBOT)


@pytest.mark.first(1)
@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("change", few(in_base, weightless))
def test_what_was_done_to_the_readings_does_not_pass_unnoticed(change, run: str) -> None:
    try:
        said = " ".join(estimate_parameters(recorded(run, change), ROBOT).warnings)
    except IdentificationError as error:
        said = str(error)
    assert "raw" in said or "compensated" in said


@pytest.mark.first(2)
@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("share", [0.3, 1.0, 1.6])
def test_another_load_is_not_refused(share: float, run: str) -> None:
    estimate_parameters(recorded(run, lambda q, forces: share * forces), ROBOT)


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("change", "words"),
    few(
        (lambda q, forces: -forces, "signs of force channels 1, 2, 3, 4, 5, 6"),
        (lambda q, forces: forces[:, [1, 0, 2, 3, 4, 5]], "force channels 1 and 2"),
        (lambda q, forces: forces[:, [3, 4, 5, 0, 1, 2]], "force channels 1 and 4, 2 and 5, 3 and 6"),
    ),
)
def test_wrong_cables_are_named_as_such(change: Callable[[np.ndarray, np.ndarray], np.ndarray], words: str) -> None:
    with pytest.raises(IdentificationError, match=words):
        estimate_parameters(recorded("moving", change), ROBOT)
