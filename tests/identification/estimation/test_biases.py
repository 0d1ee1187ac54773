"""Offsets taken from another result: their errors reach the other parameters as reported, and drift is told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cases.errors import HexciteError, IdentificationError
from cases.schema import load_case
from identification.estimation.biases import OFFSET_NAMES, Biases, accelerometer_bias
from identification.estimation.estimators import method
from identification.hexapod import Hexapod
from identification.identify import estimate_parameters
from identification.simulate import simulate_recording
from tests.helpers import Harmonic, one_line
from tests.identification.moving_run import CASE, NAMES, U
from tests.simulated_machine import PoseExecution

GRAVITY = np.array([0.0, 0.0, -9.81])
OFFSETS = [NAMES.index(n) for n in OFFSET_NAMES]
STD = np.array([5.0, 0.1, 2.0, 1.0, 3.0, 0.5])
RUN = simulate_recording(
    CASE, PoseExecution(Hexapod.of(CASE), Harmonic(seed=1, duration=3.0)), np.array([[0.2, 2.8]]), 0
)


def given(values: np.ndarray, std: np.ndarray = STD) -> Biases:
    return Biases("static", values, np.diag(std**2), None)


def readings(seed: int, poses: int, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """An accelerometer with biases (0.1, -0.2, 0.05) m/s^2, turned by 10 mrad about x, at rest in all directions."""
    draw = np.random.default_rng(seed)
    turns = Rotation.random(poses, rng=draw).as_matrix()
    felt = -np.einsum("nji,j->ni", turns, GRAVITY) @ Rotation.from_rotvec([0.01, 0.0, 0.0]).as_matrix().T
    return felt + [0.1, -0.2, 0.05] + noise * draw.normal(size=felt.shape), turns


def test_biases_of_an_accelerometer_are_found_within_their_errors() -> None:
    away = []
    for seed in range(200):
        found = accelerometer_bias(*readings(seed, 12, 0.03), GRAVITY)
        assert found is not None
        away.append((np.array(found.bias_m_s2) - [0.1, -0.2, 0.05]) / found.std_m_s2)
    assert found.turn_rad == pytest.approx([0.01, 0.0, 0.0], abs=0.005)
    assert np.std(away) == pytest.approx(1.0, abs=0.1)


def test_poses_that_are_too_few_or_too_alike_tell_no_bias() -> None:
    felt, turns = readings(0, 12, 0.03)
    assert accelerometer_bias(felt[:2], turns[:2], GRAVITY) is None
    assert accelerometer_bias(np.tile(felt[0], (9, 1)), np.tile(turns[0], (9, 1, 1)), GRAVITY) is None


@pytest.mark.slow
def test_errors_of_given_offsets_are_in_the_reported_deviations() -> None:
    """One run, offsets and noise drawn anew each time: errors spread as reported, and not as with exact offsets."""
    away, bare = [], []
    for seed in range(12):
        draw = np.random.default_rng(seed)
        biases = given(U[OFFSETS] + STD * draw.normal(size=6))
        run = replace(RUN, forces=RUN.forces + draw.normal(size=RUN.forces.shape))
        estimate = estimate_parameters(run, CASE, how=method(biases=biases))
        away.append((estimate.fit.values - U) / np.sqrt(np.diag(estimate.fit.covariance)))
        offsets_exact = np.diag(estimate_parameters(run, CASE, how=method(known=biases.known)).fit.covariance)
        free = offsets_exact > 0.0
        bare.append((estimate.fit.values - U)[free] / np.sqrt(offsets_exact[free]))
    assert np.std(away) == pytest.approx(1.0, abs=0.25)
    assert np.std(bare) > 2.0


def test_an_offset_that_has_drifted_is_named() -> None:
    off = U[OFFSETS] + [0.0, 0.0, 0.0, 40.0, 0.0, 0.0]
    warnings = estimate_parameters(RUN, CASE, how=method(biases=given(off))).warnings
    assert any("f_q0_4 of this run is" in w and "have drifted" in w for w in warnings)
    assert not any(
        "drifted" in w for w in estimate_parameters(RUN, CASE, how=method(biases=given(U[OFFSETS]))).warnings
    )


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"name": "robust"}, "does not go with the estimator robust"),
        ({"known": {"f_q0_2": 1.0}}, "does not go with f_q0_2 given otherwise"),
        ({"dropped": ["f_q0_3"]}, "does not go with f_q0_3 given otherwise"),
    ],
)
def test_what_contradicts_given_offsets_is_refused(more: dict[str, object], says: str) -> None:
    with pytest.raises(IdentificationError, match=says) as caught:
        method(biases=given(U[OFFSETS]), **more)
    one_line(caught.value)


def test_offsets_alone_leave_nothing_to_a_model_of_offsets() -> None:
    table = load_case("clamping_table")
    run = replace(RUN, rotations=np.tile(np.eye(3), (len(RUN.forces), 1, 1)), struts=None, trigger=None)
    with pytest.raises(HexciteError, match="all parameters are known"):
        estimate_parameters(run, table, 0, method(biases=given(U[OFFSETS])))


def test_the_deviations_grow_with_what_the_offsets_are_uncertain_by() -> None:
    """The regressor's own least squares: du/db by differences of two fits."""
    values = U[OFFSETS]
    sure = estimate_parameters(RUN, CASE, how=method(biases=given(values, 1e-9 * STD)))
    unsure = estimate_parameters(RUN, CASE, how=method(biases=given(values, STD)))
    moved = [
        (estimate_parameters(RUN, CASE, how=method(known=given(values + step).known)).fit.values - sure.fit.values)
        / 1e-3
        for step in 1e-3 * np.eye(6)
    ]
    expected = np.array(moved).T @ np.diag(STD**2) @ np.array(moved)
    difference = np.diag(unsure.fit.covariance - sure.fit.covariance)
    np.testing.assert_allclose(difference, np.diag(expected), rtol=0.02)
