"""Errors that depend on the pose: what a motion tells of a machine that has them, against dense least squares."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.special import gamma, kv

from cases.schema import load_case
from cases.sensors import PoseField
from cases.tables import find_case
from identification.estimation.criteria import box_middle, pose_regressors, reference_scaling
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.motion.motion import Trajectory
from planner.families.family import Family
from planner.families.fourier import FourierFamily
from planner.families.manual import manual_motion, sequence_file
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.noise import PoseErrors, expected_noise, information_of, mean_information, of_estimate
from planner.plans.figures import prediction_at_poses, prediction_of
from planner.search.problem import build_program
from tests.bench.pose_errors import over_machines
from tests.helpers import few, taylor_slope
from tests.random_start import random_start

CASE = load_case("hexapod")
MODEL = identification_model(CASE, 9)
SCALING = reference_scaling(CASE, MODEL)
SIZE, LENGTH = 1.45, 28.0  # [N, mm] as identify finds them on the built-in machine
OFFSETS = [k for k, name in enumerate(MODEL.names) if name.startswith("f_q0")]


def erring(size: float, length: float, **others: object):
    stated = {"pose_error_N": size, "pose_error_length_mm": length, **others}
    return CASE.model_copy(update={"sensors": CASE.sensors.model_copy(update=stated)})


def errors_of(size: float, length: float, **others: object) -> PoseErrors:
    case = erring(size, length, **others)
    errors = PoseErrors.of(case, expected_noise(case, MODEL))
    assert errors is not None
    return errors


def drawn(samples: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Regressors with offsets, and struts of places some of which are visited twice."""
    draw = np.random.default_rng(1)
    struts = 1.0 + draw.uniform(-0.05, 0.05, (samples, 6))
    struts[samples // 2 :] = struts[: samples - samples // 2]
    regressors = draw.normal(size=(samples, 6, len(SCALING)))
    regressors[:, :, OFFSETS] = np.eye(6)
    return regressors, struts


def dense(struts: np.ndarray, size: float, length: float) -> np.ndarray:
    """Covariance of all channels, channel by channel, by the general formula of Matern's family with smoothness 3/2."""
    distance = np.linalg.norm(struts[:, None] - struts, axis=2) * np.sqrt(3.0) / length
    with np.errstate(invalid="ignore"):
        one = 2.0 ** (1 - 1.5) / gamma(1.5) * distance**1.5 * kv(1.5, distance)
    return block_diag(*[size**2 * np.where(distance == 0.0, 1.0, one)] * 6)


def stacked(regressors: np.ndarray) -> np.ndarray:
    return regressors.transpose(1, 0, 2).reshape(-1, regressors.shape[2])


def test_the_information_is_the_inverse_of_the_dense_covariance_of_least_squares():
    regressors, struts = drawn()
    errors, rows = errors_of(SIZE, LENGTH), stacked(regressors)
    seconds = len(struts) / CASE.recording.rate_Hz  # noise of 1 N a sample
    mean = rows.T @ rows / len(struts)
    found = of_estimate(mean, mean + errors.scatter(regressors, struts, seconds)) * len(struts)
    covariance = np.eye(len(rows)) + dense(struts, SIZE, LENGTH / 1e3)
    answer = np.linalg.pinv(rows)
    assert np.linalg.inv(found) == pytest.approx(answer @ covariance @ answer.T, rel=1e-8, abs=1e-14)
    # Gauss and Markov: the estimate in which the field is marginalised is never worse.
    best = rows.T @ np.linalg.solve(covariance, rows)
    assert np.linalg.eigvalsh(best - found).min() > -1e-9 * np.linalg.eigvalsh(best).max()


def test_weights_that_mix_channels_count_as_in_dense_least_squares():
    regressors, struts = drawn(30)
    vibrating = {"force_noise_N": 1.0, "acceleration_noise_m_s2": 0.05, "weights": "stated"}
    case = erring(SIZE, LENGTH, **vibrating)
    noise, errors = expected_noise(case, MODEL), errors_of(SIZE, LENGTH, **vibrating)
    root = noise.whitening
    weighted = root @ regressors
    found = errors.scatter(weighted, struts, len(struts) / CASE.recording.rate_Hz) * len(struts)
    rows = stacked(root.T @ weighted)
    assert found == pytest.approx(rows.T @ dense(struts, SIZE, LENGTH / 1e3) @ rows, rel=1e-8)


def test_limits_are_no_errors_white_noise_and_an_offset_of_each_channel():
    regressors, struts = drawn()
    struts = struts + np.linspace(0.0, 1e-3, len(struts))[:, None]  # no place is visited twice
    rows = stacked(regressors)
    mean = rows.T @ rows / len(struts)

    def covariance(size: float, length: float) -> np.ndarray:
        errors = errors_of(size, length)
        scatter = errors.scatter(regressors, struts, len(struts) / CASE.recording.rate_Hz)
        return np.linalg.inv(of_estimate(mean, mean + scatter) * len(struts))

    white = np.linalg.inv(rows.T @ rows)
    assert covariance(1e-9, 10.0) == pytest.approx(white, rel=1e-9, abs=1e-15)
    assert covariance(3.0, 1e-2) == pytest.approx(10.0 * white, rel=1e-5, abs=1e-12)
    offset = np.zeros_like(white)
    offset[OFFSETS, OFFSETS] = 9.0
    assert covariance(3.0, 1e9) == pytest.approx(white + offset, rel=1e-6, abs=1e-8)


FAMILIES: dict[str, Family] = {
    "ptp": PointToPointFamily.of(CASE, 8, 2.4),
    "spline": SplineFamily.of(CASE, 20, 2.0),
    "fourier": FourierFamily(3, 2.0, 2, *box_middle(CASE)),
}


@pytest.mark.first(1)
@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("letter", few(*"ADN"))
def test_the_gradient_is_the_slope_of_the_criterion(name: str, letter: str):
    family, draw = FAMILIES[name], np.random.default_rng(0)
    problem = build_program(CASE, MODEL, family, SCALING, 1e-3, errors_of(SIZE, LENGTH))
    program = replace(problem, letter=letter, halvings=1)
    at = random_start(family, draw, problem.worst)
    at = at * (1.0 + 0.02 * draw.normal(size=len(at)))
    along = draw.normal(size=len(at))
    along /= np.linalg.norm(along)
    slope = np.array([program.gradient(at) @ along])
    assert taylor_slope(lambda h: np.array([program.value(at + h * along)]), 0.0, slope, 2e-3) == pytest.approx(
        2.0, abs=0.15
    )
    bent = program.hessian(at, 1.0, np.zeros(len(program.row_bounds[0])))
    assert np.isfinite(bent).all()
    assert np.abs(bent).max() > 0.0


@pytest.mark.parametrize("name", FAMILIES)
def test_the_search_sees_nearly_the_information_of_the_motion(name: str):
    family, errors = FAMILIES[name], errors_of(SIZE, LENGTH)
    problem = build_program(CASE, MODEL, family, SCALING, 1e-3, errors)
    at = random_start(family, np.random.default_rng(0), problem.worst)
    seen = np.linalg.slogdet(problem.information(at))[1]
    whole = np.linalg.slogdet(information_of(MODEL, SCALING, family.motion(at), errors))[1]
    white = np.linalg.slogdet(mean_information(MODEL, SCALING, family.motion(at)))[1]
    assert seen == pytest.approx(whole, abs=1.0)  # of a log det of 20 parameters: 5 % of a variance
    assert whole < white - 20.0


def test_a_case_that_states_none_is_rated_as_before():
    family = FAMILIES["ptp"]
    problem = build_program(CASE, MODEL, family, SCALING, 1e-3, PoseErrors.of(CASE, expected_noise(CASE, MODEL)))
    assert problem.errors is None
    motion = family.motion(random_start(family, np.random.default_rng(0), problem.worst))
    assert np.array_equal(information_of(MODEL, SCALING, motion, None), mean_information(MODEL, SCALING, motion))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["manual", *FAMILIES])
def test_predictions_are_the_scatter_over_machines_that_err_otherwise(name: str):
    """Machines err by a smoother field over the poses; the stated one over the struts is what identify makes of it."""
    case = erring(SIZE, LENGTH)
    motion: Trajectory = manual_motion(CASE, sequence_file(CASE))
    if name != "manual":
        family = FAMILIES[name]
        motion = family.motion(
            random_start(family, np.random.default_rng(0), build_program(CASE, MODEL, family, SCALING, 1e-3).worst)
        )
    predicted = prediction_of(case, MODEL, SCALING, motion, expected_noise(case, MODEL), 0).std
    true = over_machines(motion)
    ratio = np.array([predicted[n] / true[n] for n in true])
    assert np.exp(np.mean(np.log(ratio))) == pytest.approx(1.0, abs=0.25)


def test_standstills_do_not_average_them_out():
    model = identification_model(CASE, 5)
    draw = np.random.default_rng(0)
    low, high = CASE.limits.motion.coordinates
    poses = CASE.machine.home.vector + draw.uniform(low, high, (40, 6)) / 2
    matrices = pose_regressors(model, poses)
    scaling = np.ones(len(model.names))
    plain = prediction_at_poses(CASE, model, scaling, matrices, poses, 0.03).std
    found = prediction_at_poses(erring(SIZE, LENGTH), model, scaling, matrices, poses, 0.03).std
    far = prediction_at_poses(erring(SIZE, 0.1), model, scaling, matrices, poses, 0.03).std
    struts = Hexapod.of(CASE).strut_lengths(poses)
    assert np.linalg.norm(struts[1:] - struts[:-1], axis=1).min() > 1e-3  # beyond 0.1 mm errors are independent
    for name, std in plain.items():
        assert far[name] == pytest.approx(std * np.hypot(SIZE, 0.03) / 0.03, rel=1e-6)
        assert found[name] > 10.0 * std


def test_keys_that_identify_prints_are_read_back(tmp_path: Path):
    field = PoseField(1.4567, 0.028123)
    lines = "\n".join(f"{key} = {value!r}" for key, value in field.keys.items())
    text = find_case("hexapod").read_text(encoding="utf-8").replace('weights = "equal"', f'weights = "equal"\n{lines}')
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    read = load_case(tmp_path / "case.toml").sensors.pose_field
    assert read is not None
    assert read.keys == field.keys
    assert (read.size, read.length) == pytest.approx((field.size, field.length), rel=5e-3)
