"""Jerk-limited splines: rows that hold at some instants hold the limits at all of them."""

import numpy as np
import pytest

from cases.schema import Case
from identification.estimation.criteria import reference_scaling
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.motion.motion import sample
from planner.families.rows import LinearRows
from planner.families.spline import FINE, SplineFamily
from planner.families.states import state_size
from planner.search.nlp import NonlinearProgram
from planner.search.problem import build_program, state_limits
from tests.helpers import seeds


@pytest.fixture(scope="module")
def family(hexapod_case: Case) -> SplineFamily:
    return SplineFamily.of(hexapod_case, 40, 4.0)


@pytest.fixture(scope="module")
def problem(hexapod_case: Case, family: SplineFamily) -> NonlinearProgram:
    model = identification_model(hexapod_case, 9)
    return build_program(hexapod_case, model, family, reference_scaling(hexapod_case, model), 0.0)


@pytest.fixture(scope="module")
def start(family: SplineFamily, problem: NonlinearProgram) -> np.ndarray:
    return family.start(np.random.default_rng(2), problem.worst)


def test_it_is_at_rest_at_both_ends_which_differ(start: np.ndarray, family: SplineFamily):
    ends = family.motion(start).at([0.0, 4.0])
    assert np.abs(ends.rates).max() < 1e-9
    assert np.abs(ends.accelerations).max() < 1e-7
    assert np.abs(ends.coordinates[1] - ends.coordinates[0]).max() > 1e-3


def test_its_derivatives_are_those_of_its_poses(start: np.ndarray, family: SplineFamily):
    motion, h = family.motion(start), 1e-5
    t = np.arange(2, 78) * 0.05 + 0.023  # away from the knots, where the jerk jumps
    before, now, after = (motion.at(t + d) for d in (-h, 0.0, h))
    assert (after.coordinates - before.coordinates) / (2 * h) == pytest.approx(now.rates, abs=1e-8)
    assert (after.rates - before.rates) / (2 * h) == pytest.approx(now.accelerations, abs=1e-4)
    assert (after.accelerations - before.accelerations) / (2 * h) == pytest.approx(now.jerks, abs=1e-3)


@seeds(6)
def test_what_satisfies_the_rows_satisfies_the_limits_at_every_instant(
    seed: int, family: SplineFamily, problem: NonlinearProgram, hexapod_case: Case
):
    """The slip between the instants of positions and rates is left free by the rows, not taken from the limits."""
    draw = np.random.default_rng(seed).normal(size=(family.unknowns, 6)).cumsum(axis=0).ravel()
    rows = problem.rows[0]
    assert isinstance(rows, LinearRows)
    draw /= np.abs(rows.all_values(draw)).max()
    motion, box = sample(family.motion(draw), 20_000.0), hexapod_case.limits.motion
    shares = [(motion.coordinates - family.middle) / family.half, motion.rates / box.rate]
    shares += [motion.accelerations / box.acceleration, motion.jerks / box.jerk]
    assert max(np.abs(s).max() for s in shares) <= 1.0 + 1e-9
    assert max(np.abs(s).max() for s in shares) > 0.95


@seeds(4)
def test_strut_velocities_peak_near_the_instants_at_which_they_are_constrained(
    seed: int, family: SplineFamily, problem: NonlinearProgram, hexapod_case: Case
):
    """Constrained at the knots alone, they would exceed their limit by much more: they peak between them."""
    unknowns = np.random.default_rng(seed).normal(size=family.unknowns * 6)
    unknowns *= 0.9 / problem.worst(unknowns)
    (velocity,) = (kernel for kind, _, kernel in state_limits(hexapod_case) if kind == "strut velocity")
    shares = np.abs(velocity.values(problem.rows[-1].states.at(unknowns).reshape(-1, state_size(6)))).max(axis=1)
    constrained = family.layout(hexapod_case, 0.0).peaks[1].ravel()
    motion = sample(family.motion(unknowns), 5_000.0)
    lengths = Hexapod.of(hexapod_case).strut_lengths(motion.coordinates)
    peak = np.abs(np.gradient(lengths, motion.t, axis=0)).max() / hexapod_case.limits.motion.strut_velocity_m_s
    assert shares[constrained].max() > 0.9 * peak
    assert shares[::FINE].max() < shares[constrained].max()
