"""A plan keeps all limits, by a computation that shares nothing with the planner, and is worth more than chance."""

import math
from typing import Any

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import box_middle, reference_scaling
from identification.limits.limit import UNUSED_SHARE
from identification.limits.proof import prove
from identification.machines.casadi_batch import over_samples
from identification.model.model import identification_model
from identification.motion.curves import FourierMotion
from planner.families.fourier import DENSITY, FourierFamily
from planner.noise import mean_information
from planner.plans.plan import Plan
from planner.search.feasibility import keep_limits
from planner.search.problem import build_program
from tests.postprocessors.independent import strut_lengths
from tests.random_start import random_start

INSTANTS = 10 * DENSITY * 5  # instants of a period: ten times the optimiser's grid


@pytest.fixture(scope="module")
def motion(saved_plan: Plan) -> FourierMotion:
    assert isinstance(saved_plan.motion, FourierMotion)
    return saved_plan.motion


def difference(values: np.ndarray, step: float, order: int) -> np.ndarray:
    """Derivative of periodic samples by central differences of fourth order."""
    for _ in range(order):
        one, two = (np.roll(values, -k, axis=0) - np.roll(values, k, axis=0) for k in (1, 2))
        values = (8 * one - two) / (12 * step)
    return values


def test_it_keeps_every_limit_of_the_box_by_finite_differences(motion: FourierMotion, hexapod_case: Case):
    """Poses alone, differentiated; the motion repeats, so that its samples have no ends."""
    box, step = hexapod_case.limits.motion, motion.period / INSTANTS
    pose = motion.at(np.arange(INSTANTS) * step).coordinates
    low, high = hexapod_case.machine.home.vector + box.coordinates
    assert np.all((low <= pose) & (pose <= high))
    for order, limit in enumerate((box.rate, box.acceleration, box.jerk), start=1):
        assert np.all(np.abs(difference(pose, step, order)) <= limit * (1 + 1e-5))


def test_it_keeps_every_limit_of_the_struts_by_finite_differences(motion: FourierMotion, hexapod_case: Case):
    box, step = hexapod_case.limits.motion, motion.period / INSTANTS
    lengths = strut_lengths(motion.at(np.arange(INSTANTS) * step).coordinates, hexapod_case)
    assert np.all((box.strut_length[0] <= lengths) & (lengths <= box.strut_length[1]))
    assert np.abs(difference(lengths, step, 1)).max() <= box.strut_velocity_m_s * (1 + 1e-5)
    assert np.abs(difference(lengths, step, 2)).max() <= box.strut_acceleration_m_s2 * (1 + 1e-5)


def test_it_keeps_them_on_a_finer_grid_than_it_was_proven_on(motion: FourierMotion, hexapod_case: Case):
    one_period = FourierMotion(motion.centre, motion.a, motion.b, motion.period, 1)
    report = prove(one_period, hexapod_case, 23_456.0)
    assert report.kept
    assert report.worst_ratio > 0.99  # optimal motions touch their limits


def test_what_comes_again_uses_no_more_of_a_limit(hexapod_case: Case):
    """One period, for quick looks."""
    repeats = 3
    family = FourierFamily(5, 2.0, repeats, *box_middle(hexapod_case))
    unknowns = 0.05 * np.random.default_rng(2).normal(size=family.unknowns * 6)
    whole, once = (prove(f.motion(unknowns), hexapod_case, 2000.0) for f in (family, family.once))
    assert family.once.duration == pytest.approx(family.duration - (repeats - 1) * 2.0)
    for long, short in zip(whole.checks, once.checks, strict=True):
        assert long.kind is short.kind
        assert long.ratio == pytest.approx(short.ratio, rel=1e-4)


def test_it_rests_at_both_ends(motion: FourierMotion):
    ends = motion.at([0.0, motion.duration])
    assert np.abs(ends.rates).max() < 1e-9
    assert np.abs(ends.accelerations).max() < 1e-9
    assert np.allclose(ends.coordinates[0], ends.coordinates[1], atol=1e-12)


def test_it_carries_more_information_than_any_of_many_random_motions(saved_plan: Plan, hexapod_case: Case):
    model = identification_model(hexapod_case, 9)
    scaling = reference_scaling(hexapod_case, model)
    half = np.ptp(hexapod_case.limits.motion.coordinates, axis=0) / 2
    family = FourierFamily(5, 3.0, 1, hexapod_case.machine.home.vector, half)
    problem = build_program(hexapod_case, model, family, scaling, UNUSED_SHARE)
    best = -math.inf
    for seed in range(12):
        random = random_start(family, np.random.default_rng(seed), problem.worst)
        unknowns = keep_limits(hexapod_case, family, random / 0.8, 500.0)[0]
        information = mean_information(model, scaling, family.motion(unknowns), 200.0)
        best = max(best, float(np.linalg.slogdet(information)[1]))
    assert saved_plan.worth.logdet > best + 10.0  # 20 parameters: better by a factor of 1.6 each, on average


def test_its_figures_follow_from_its_motion(planned: dict[str, Any], motion: FourierMotion, hexapod_case: Case):
    """Information over the whole excitation, summed anew from samples at 2 kHz."""
    model = identification_model(hexapod_case, 9)
    scaling = reference_scaling(hexapod_case, model)
    count = round(2000 * motion.duration)
    samples = motion.at((np.arange(count) + 0.5) / 2000)
    states = (samples.coordinates, samples.rates, samples.accelerations)
    stacked = over_samples(model.coordinate_regressor, *states)[0].reshape(-1, 20)
    scaled = np.linalg.svd(stacked * scaling, compute_uv=False)
    logdet = 2 * np.log(scaled).sum() - 20 * np.log(count)
    assert planned["logdet"] == pytest.approx(logdet, abs=1e-6)
    assert planned["condition"] == pytest.approx(scaled[0] / scaled[-1], rel=1e-6)
    assert 0.0 < planned["d_efficiency"] < 1.0
    assert planned["d_efficiency"] == pytest.approx(np.exp((logdet - planned["bound"]["logdet"]) / 20), rel=1e-6)
    # A run at 1 kHz has half of these samples; parameters that are linear in u are predicted directly.
    std = np.sqrt(2 * np.diag(np.linalg.inv(stacked.T @ stacked))) * planned["assumed_noise_N"]
    for name in ("m", "k0", "k1", "k2", "k3", *(f"f_q0_{k}" for k in range(1, 7))):
        assert planned["predicted_std"][name] == pytest.approx(std[model.names.index(name)], rel=1e-6)


def test_every_start_is_told_the_best_first_and_refining_never_makes_it_worse(planned: dict[str, Any]):
    starts = planned["starts"]
    found = [s["logdet"] for s in starts]
    assert found == sorted(found, reverse=True)
    assert planned["logdet"] == pytest.approx(found[0], abs=1e-3)  # the finer proof may draw back a little more
    explored = {s["seed"]: s["logdet"] for s in starts if not s["refined"]}
    refined = {s["seed"]: s["logdet"] for s in starts if s["refined"]}
    assert refined
    for seed, logdet in refined.items():
        assert logdet > explored.get(seed, -np.inf)


def test_every_limit_is_proven(planned: dict[str, Any]):
    assert {v["status"] for v in planned["limits"].values()} == {"proven"}
    assert planned["status"] == "proven"
    kinds = {"position", "angle", "velocity", "angular velocity", "acceleration", "angular acceleration", "jerk"}
    kinds |= {"angular jerk", "strut length", "strut velocity", "strut acceleration", "base joint angle"}
    kinds |= {"platform joint angle", "singularity", "workspace position"}
    assert set(planned["limits"]) >= kinds
