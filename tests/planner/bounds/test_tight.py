"""The tighter bound: its proof encloses every state, and no motion inside the limits passes it."""

import time
from pathlib import Path

import cvxpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.errors import HexciteError
from cases.units import DEG, MM
from identification.criteria import box_middle, reference_scaling
from identification.limit_proof import prove
from identification.model import Model, identification_model
from identification.motion import Trajectory
from planner.bounds.certificate import TightDerivative, first_tight_cells
from planner.bounds.design import Design
from planner.bounds.features import box_features, lagrangian, motion_moments
from planner.bounds.information_limit import compute_bound, information_limit
from planner.bounds.tight import climbed_from, tight_design
from planner.families.fourier import FourierFamily
from planner.families.manual import manual_motion
from planner.families.ptp import PointToPointFamily
from planner.families.spline import SplineFamily
from planner.noise import mean_information
from planner.search.feasibility import keep_limits
from planner.search.solving import Task, run_start
from tests.helpers import few
from tests.planner.bounds.test_moments import CASE, FAMILIES
from tests.random_start import random_start

MODEL = identification_model(CASE, 0)
SCALING = reference_scaling(CASE, MODEL)
FEATURES = box_features(CASE, MODEL, SCALING)
ALL = identification_model(CASE, 9)
ALL_FEATURES = box_features(CASE, ALL, reference_scaling(CASE, ALL))
PLACES = [3, 4, 5, 9, 10, 11]


@pytest.fixture(scope="module")
def box() -> float:
    return compute_bound(CASE, MODEL).logdet


@pytest.fixture(scope="module")
def found() -> Design:
    return tight_design(CASE, FEATURES, 0.05, time.process_time() + 60, rounds=3)


def bound_of(found: Design) -> float:
    return found.logdet + 10 * np.log(found.dmax / 10)


def test_it_is_proven_and_above_the_best_design_that_was_found(found: Design):
    assert found.certified
    assert found.dmax == found.proven >= 10
    assert found.attained <= bound_of(found)


def test_it_is_far_below_the_bound_of_the_box(found: Design, box: float):
    assert bound_of(found) < box - 0.3


@given(seed=st.integers(0, 2**32 - 1), make=st.sampled_from(FAMILIES))
@settings(max_examples=6, derandomize=True, deadline=None)
def test_no_motion_inside_the_limits_passes_it(seed: int, make, found: Design):
    motion = make(seed)
    states = np.hstack([motion.pose, motion.rates, motion.accelerations])
    matrices = FEATURES.matrices((states - FEATURES.middle) / FEATURES.half)
    information = np.einsum("nki,nkj->ij", matrices, matrices, optimize=True) / len(matrices)
    assert np.linalg.slogdet(information)[1] < bound_of(found)


def feasible(name: str, seed: int, folder: Path) -> Trajectory:
    """A random motion of a family of the planner, inside every limit of the case."""
    draw = np.random.default_rng(seed)
    if name == "manual":
        offsets = draw.uniform(-1.0, 1.0, (int(draw.integers(3, 6)), 6)) * box_middle(CASE)[1]
        poses = (CASE.machine.home.vector + offsets) / np.r_[np.full(3, MM), np.full(3, DEG)]
        file = folder / "poses.csv"
        np.savetxt(file, poses, delimiter=",", header="x_mm,y_mm,z_mm,a_deg,b_deg,c_deg", comments="")
        return manual_motion(CASE, file)
    order, period = int(draw.integers(1, 8)), float(draw.uniform(1.0, 4.0))
    family = {
        "fourier": FourierFamily.lasting(order, period, 2 if order == 1 else 1, *box_middle(CASE)),
        "ptp": PointToPointFamily.of(CASE, int(draw.integers(8, 17)), float(draw.uniform(2.0, 6.0))),
        "spline": SplineFamily.of(CASE, int(draw.integers(20, 41)), float(draw.uniform(2.0, 4.0))),
    }[name]
    unknowns = random_start(family, draw, lambda values: 0.05 * float(np.abs(values).max()))
    return family.motion(keep_limits(CASE, family, unknowns, 1000.0)[0])


@pytest.mark.slow
@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(["fourier", "ptp", "spline", "manual"]))
@settings(max_examples=8, derandomize=True, deadline=None)
def test_no_random_feasible_motion_of_any_family_passes_either_bound(
    seed: int, name: str, found: Design, box: float, tmp_path_factory: pytest.TempPathFactory
):
    """The planner's own classes, drawn to the very edge of the limits: the box bound is passed even less."""
    motion = feasible(name, seed, tmp_path_factory.mktemp("poses"))
    assert prove(motion, CASE, 1000.0).kept
    sign, logdet = np.linalg.slogdet(mean_information(MODEL, SCALING, motion))
    assert sign <= 0 or logdet < bound_of(found) < box


@pytest.mark.slow
@pytest.mark.parametrize("model", few(MODEL, ALL))
def test_nor_does_an_optimised_one(model: Model, found: Design):
    """Thirty iterations towards the bounds leave them out of reach."""
    number = 0 if model is MODEL else 9
    family = FourierFamily(3, 3.0, 1, *box_middle(CASE))
    start = run_start(Task(CASE, number, family, "D", seed=1))
    drawn = family.motion(random_start(family, np.random.default_rng(1), lambda values: float(np.abs(values).max())))
    scaling = reference_scaling(CASE, model)
    assert start.record.logdet > np.linalg.slogdet(mean_information(model, scaling, drawn))[1]
    assert start.record.logdet < information_limit(CASE, model).logdet
    assert model is ALL or start.record.logdet < bound_of(found)


def random_derivative(seed: int) -> TightDerivative:
    draw = np.random.default_rng(seed)
    root = draw.normal(size=(20, 25))
    moments = motion_moments(CASE, ALL_FEATURES)
    of_equal = 0.3 * draw.normal(size=len(moments[0]))
    multipliers = lagrangian(moments, of_equal, draw.uniform(0.0, 2.0, len(moments[1])))
    return TightDerivative(ALL_FEATURES, ALL_FEATURES.form(root @ root.T / 25), multipliers)


@pytest.mark.parametrize("seed", range(10))
def test_upper_bounds_are_above_every_state_of_their_cell(seed: int):
    draw = np.random.default_rng(seed)
    derivative = random_derivative(seed)
    low, high = first_tight_cells(ALL_FEATURES)
    first, second = draw.uniform(low[0], high[0], (2, 4, 12))
    low, high = np.minimum(first, second), np.maximum(first, second)
    low[2:], high[2:] = (low[2:] + high[2:]) / 2, (low[2:] + high[2:]) / 2 + 0.02  # small ones too
    upper, lower, points, _ = derivative(low, high)
    for k in range(4):
        inside = draw.uniform(low[k], high[k], (4000, 12))
        edge = draw.random((4000, 12)) < 0.5
        inside = np.where(edge, np.where(draw.random((4000, 12)) < 0.5, low[k], high[k]), inside)
        shares = draw.choice([-1.0, 1.0], (4000, 18))
        shares[:, PLACES] = (inside[:, :6] - ALL_FEATURES.middle[PLACES]) / ALL_FEATURES.half[PLACES]
        shares[:, 12:] = inside[:, 6:]
        assert derivative.at(shares).max() <= upper[k] + 1e-9
        assert derivative.at(points[k][None])[0] == pytest.approx(lower[k])
    assert np.all(lower <= upper + 1e-9)
    gap = upper - lower
    assert gap[2:].max() < 0.1 * gap[:2].max() + 0.5  # and not by much where cells are small


def test_a_climb_ends_no_lower_than_it_began():
    derivative = random_derivative(3)
    draw = np.random.default_rng(0)
    known = draw.uniform(-1.0, 1.0, (20, 18))
    states, values = climbed_from(derivative, known, draw)
    assert values.max() >= derivative.at(known).max()
    assert np.allclose(derivative.at(states), values)
    assert np.abs(states).max() <= 1.0


def test_without_time_for_the_proof_it_is_an_estimate():
    hasty = tight_design(CASE, FEATURES, 0.01, time.process_time(), rounds=1)
    assert not hasty.certified
    assert hasty.proven >= hasty.dmax


def test_a_solver_that_fails_later_on_leaves_the_bound_found_until_then(monkeypatch: pytest.MonkeyPatch):
    answers = iter([cvxpy.Problem.solve])

    def failing(problem: cvxpy.Problem, **options: object) -> object:
        solve = next(answers, None)
        if solve is None:
            raise cvxpy.SolverError("failed")
        return solve(problem, **options)

    monkeypatch.setattr(cvxpy.Problem, "solve", failing)
    found = tight_design(CASE, FEATURES, 0.05, time.process_time() + 60, rounds=3)
    assert found.attained <= bound_of(found)
    assert len(found.states) == len(found.weights)
    with pytest.raises(HexciteError, match="Clarabel: failed"):
        tight_design(CASE, FEATURES, 0.05, time.process_time() + 60, rounds=3)


@pytest.mark.slow
def test_a_proof_within_the_gap_counts_though_it_missed_its_aim():
    """What was proven when the time was over is a bound all the same; aiming at nothing uses all of it."""
    found = tight_design(CASE, FEATURES, 0.5, time.process_time() + 1.5, rounds=1, aim=1e-9)
    assert found.certified
    assert found.dmax == found.proven
