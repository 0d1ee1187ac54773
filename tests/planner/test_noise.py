"""Plans for the noise that a run will have: weights, predicted deviations and what a payload changes."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cases.schema import Case
from cases.tables import built_in_cases
from identification.estimation.criteria import Criterion, box_middle, reference_scaling, singular_values
from identification.limits.limit import UNUSED_SHARE
from identification.model.model import identification_model
from identification.motion.curves import FourierMotion
from planner.families.fourier import FourierFamily
from planner.noise import ExpectedNoise, expected_noise, mean_information, seen_through
from planner.search.feasibility import keep_limits
from planner.search.problem import build_program
from planner.search.solving import Task, run_start
from tests.helpers import tells
from tests.hexcite.command_line import call
from tests.planner.monte_carlo import vibrating, vibrating_runs
from tests.random_start import random_start

RUNS = 500
NOISE = (1.0, 0.05, 1.0)  # N, m/s^2, rad/s^2


@pytest.fixture(scope="module")
def motion(hexapod_case: Case) -> FourierMotion:
    family = FourierFamily(5, 3.0, 1, *box_middle(hexapod_case))
    draw = np.random.default_rng(2).normal(size=family.unknowns * 6)
    return family.motion(keep_limits(hexapod_case, family, draw, 1000.0)[0])


@pytest.mark.slow
@pytest.mark.parametrize("weights", ["equal", "stated"])
def test_vibration_spreads_the_estimates_as_predicted(weights: str, motion: FourierMotion, hexapod_case: Case) -> None:
    """Of point masses shaken by Newton's law; 500 runs know a standard deviation to 3.2 %."""
    spread = vibrating_runs(vibrating(hexapod_case, *NOISE, weights), motion, RUNS)
    assert spread.found == pytest.approx(spread.predicted, rel=0.12)
    assert np.exp(np.mean(np.log(spread.found / spread.predicted))) == pytest.approx(1.0, abs=0.04)
    assert np.abs(spread.bias / spread.predicted).max() < 4.5 / np.sqrt(RUNS)  # vibration attenuates nothing


@pytest.mark.parametrize("weights", ["equal", "stated", "per_channel", "per_unit"])
def test_the_predicted_covariance_is_that_of_the_weighted_estimate(weights: str) -> None:
    """(F^-1) A^T W C W A (F^-1), sample by sample."""
    draw = np.random.default_rng(3)
    root = draw.normal(size=(6, 6))
    noise = ExpectedNoise(2.0, root @ root.T + np.eye(6), weights, True)
    a = draw.normal(size=(40, 6, 5))
    variance = np.diag(noise.channels)
    w = {
        "equal": np.eye(6),
        "stated": np.linalg.inv(noise.channels),
        "per_channel": np.diag(1 / variance),
        "per_unit": np.diag(1 / np.repeat([variance[:3].mean(), variance[3:].mean()], 3)),
    }[weights]
    estimator = np.linalg.inv(np.einsum("nku,kl,nlv->uv", a, w, a)) @ np.einsum("nku,kl->unl", a, w).reshape(5, -1)
    expected = estimator @ np.kron(np.eye(40), noise.channels) @ estimator.T

    def information(by: np.ndarray | None) -> np.ndarray:
        rows = (a if by is None else by @ a).reshape(-1, 5)
        return rows.T @ rows

    inverse = np.linalg.inv(information(noise.whitening))
    meat = information(noise.whitening) if noise.scatter is None else information(noise.scatter)
    np.testing.assert_allclose(noise.sensors**2 * inverse @ meat @ inverse, expected, rtol=1e-9)
    assert (noise.scatter is None) == (weights == "stated")


def test_without_noise_of_accelerations_weights_are_equal_and_payloads_change_no_force(hexapod_case: Case) -> None:
    model = identification_model(hexapod_case, 9)
    plain = expected_noise(hexapod_case, model, 3)
    assert plain.whitening is None
    assert plain.scatter is None
    assert np.allclose(plain.std, hexapod_case.simulation.force_noise_N)
    stated = expected_noise(vibrating(hexapod_case, 2.0, None, None, "stated"), model, 3)
    assert np.allclose(stated.whitening, np.eye(6))
    assert np.allclose(stated.std, 2.0)


def test_a_payload_makes_vibration_felt_more(hexapod_case: Case) -> None:
    model, case = identification_model(hexapod_case, 9), vibrating(hexapod_case, 1.0, 0.1, 0.2, "stated")
    sizes = [np.linalg.eigvalsh(expected_noise(case, model, k).channels) for k in range(6)]
    assert all(np.all(b >= a * (1 - 1e-12)) for a, b in pairwise(sizes))
    assert sizes[5][-1] > 10 * sizes[0][-1]  # 133 kg instead of 33 kg, and further out


@pytest.mark.slow
def test_the_search_is_for_the_information_that_the_weights_leave(hexapod_case: Case) -> None:
    case = vibrating(hexapod_case, *NOISE, "stated")
    model, scaling = identification_model(case, 9), reference_scaling(case, identification_model(case, 9))
    family = FourierFamily(3, 3.0, 1, *box_middle(case))
    scores = []
    for payload in (0, 5):
        seen = seen_through(model, expected_noise(case, model, payload).whitening)
        found = run_start(Task(case, 9, family, "D", 1, payload))
        information = mean_information(seen, scaling, family.motion(found.unknowns))
        assert found.record.criterion_value == pytest.approx(
            Criterion("D").of_singular_values(singular_values(information, model.names)), rel=1e-9
        )
        problem = build_program(case, seen, family, scaling, UNUSED_SHARE)
        at = random_start(family, np.random.default_rng(3), problem.worst)
        exact = np.linalg.slogdet(mean_information(seen, scaling, family.motion(at)))[1]
        assert problem.value(at) == pytest.approx(-exact / 20, abs=1e-4)  # means over the grid, and over all
        scores.append(found.record.criterion_value)
    assert scores[1] < scores[0] - 5.0  # with weights mounted, noise hides more


@pytest.mark.parametrize("weights", ["equal", pytest.param("stated", marks=pytest.mark.slow)])
def test_a_plan_tells_what_the_payload_does_to_the_noise(weights: str, tmp_path: Path) -> None:
    noise = "[sensors]\nforce_noise_N = 1.0\nacceleration_noise_m_s2 = 0.05\nangular_acceleration_noise_rad_s2 = 0.5"
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8").replace("[sensors]", noise)
    text = text.replace('weights = "equal"', f'weights = "{weights}"')
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    (tmp_path / "moves.csv").write_text(MOVES, encoding="utf-8")
    words = ("--family", "manual", "--sequence", tmp_path / "moves.csv", "--model", "6")
    plans = []
    for case, payload in ((tmp_path, 0), (tmp_path, 2), ("hexapod", 0)):
        done = call("plan", case, *words, "--payload", payload, "-o", tmp_path / f"plan{len(plans)}")
        plans.append(
            (json.loads((tmp_path / f"plan{len(plans)}" / "plan.json").read_text()), " ".join(done.out.split()))
        )
    (bare, _), (loaded, printed), (plain, _) = plans
    assert tells(printed, "2 payloads")
    assert f"weights {weights};" in printed
    assert loaded["predicted_std"]["m"] > bare["predicted_std"]["m"] > plain["predicted_std"]["m"]
    assert loaded["d_efficiency"] == bare["d_efficiency"] == plain["d_efficiency"]  # W = 1: comparable


MOVES = """x_mm,y_mm,z_mm,a_deg,b_deg,c_deg
150,0,900,10,0,0
0,150,850,0,10,10
-150,0,950,-10,0,-10
0,-150,900,0,-10,5
100,100,920,10,10,-5
-100,50,880,-5,5,15
"""
