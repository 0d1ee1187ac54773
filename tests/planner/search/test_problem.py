"""Rows are the limits of the motion; random starts keep them; what is drawn back keeps them and no more than needed."""

from dataclasses import replace

import numpy as np
import pytest

from cases.base.errors import InfeasiblePlan
from cases.schema import Case
from identification.estimation.criteria import box_middle, reference_scaling
from identification.limits.limit import UNUSED_SHARE
from identification.limits.proof import prove
from identification.model.model import identification_model
from planner.families.family import Family
from planner.families.fourier import START_SHARE, FourierFamily
from planner.families.rows import LinearRows, Rows, StateRows
from planner.families.states import state_size
from planner.search.feasibility import CLOSE_ENOUGH, keep_limits
from planner.search.nlp import NonlinearProgram
from planner.search.problem import build_program, near_limits, state_limits
from planner.search.rounds import seeds_of
from tests.bench.machines.description import case_of
from tests.bench.machines.designed import DESIGNED
from tests.helpers import few, seeds
from tests.planner.search.conftest import Small, family_of
from tests.postprocessors.changed_case import changed
from tests.postprocessors.independent import strut_lengths
from tests.random_start import random_start


def fourier(case: Case, order: int = 4, period: float = 2.0) -> FourierFamily:
    return FourierFamily(order, period, 1, *box_middle(case))


@pytest.fixture(scope="module")
def problem(hexapod_case: Case) -> NonlinearProgram:
    model = identification_model(hexapod_case, 0)
    return build_program(
        hexapod_case, model, fourier(hexapod_case), reference_scaling(hexapod_case, model), UNUSED_SHARE
    )


@pytest.fixture(scope="module")
def unknowns(hexapod_case: Case) -> np.ndarray:
    return np.random.default_rng(8).normal(size=fourier(hexapod_case).unknowns * 6)


def linear(problem: NonlinearProgram) -> LinearRows:
    part = problem.rows[0]
    assert isinstance(part, LinearRows)
    return part


def box_shares(case: Case, some: FourierFamily, unknowns: np.ndarray) -> np.ndarray:
    """Largest share of each limit of pose, rate, acceleration and jerk on the grid."""
    box, motion = case.limits.motion, some.motion(unknowns).at(some.grid)
    half = np.ptp(box.coordinates, axis=0) / 2
    values = [(motion.coordinates - some.middle) / half, motion.rates / box.rate]
    values += [motion.accelerations / box.acceleration, motion.jerks / box.jerk]
    return np.array([np.abs(v).max() for v in values])


def test_rows_are_shares_of_the_limits(problem: NonlinearProgram, unknowns: np.ndarray, hexapod_case: Case):
    values = np.abs(linear(problem).all_values(unknowns))
    assert values.max() == pytest.approx(box_shares(hexapod_case, fourier(hexapod_case), unknowns).max())


@pytest.mark.parametrize(("order", "period"), [(2, 12.0), (3, 6.0), (5, 3.0), (7, 2.0)])
def test_limits_without_rows_are_satisfied_by_every_motion_that_satisfies_the_rows(
    order: int, period: float, hexapod_case: Case
):
    """Bernstein: a slow series cannot reach the limits of the higher derivatives; the optimiser saves their rows."""
    some = fourier(hexapod_case, order, period)
    model = identification_model(hexapod_case, 0)
    problem = build_program(hexapod_case, model, some, reference_scaling(hexapod_case, model), UNUSED_SHARE)
    for seed in range(20):
        draw = np.random.default_rng(seed).normal(size=some.unknowns * 6)
        draw /= np.abs(linear(problem).all_values(draw)).max()
        assert box_shares(hexapod_case, some, draw).max() <= 1.0 / np.cos(np.pi / 24)  # it slips between samples
    assert linear(problem).matrix.shape[0] <= 4 * 6 * len(some.grid)


def test_strut_limits_are_the_struts_of_the_motion(problem: NonlinearProgram, unknowns: np.ndarray, hexapod_case: Case):
    """Velocities and accelerations against differences of lengths that follow from the definition."""
    some, h = fourier(hexapod_case), 1e-4
    motion = some.motion(0.1 * unknowns)
    before, now, after = (strut_lengths(motion.at(some.grid + d).coordinates, hexapod_case) for d in (-h, 0.0, h))
    box = hexapod_case.limits.motion
    short, long = box.strut_length
    expected = {
        "strut length": (now - (short + long) / 2) / ((long - short) / 2),
        "strut velocity": (after - before) / (2 * h) / box.strut_velocity_m_s,
        "strut acceleration": (after - 2 * now + before) / h**2 / box.strut_acceleration_m_s2,
    }
    states = problem.rows[-1].states.at(0.1 * unknowns).reshape(-1, state_size(6))
    for kind, _, kernel in state_limits(hexapod_case):
        if kind in expected:
            assert kernel.values(states) == pytest.approx(expected.pop(kind), abs=1e-5)
    assert not expected


@pytest.mark.parametrize("name", few(*DESIGNED, kept=4))
def test_limits_that_are_left_out_are_not_near_anywhere_in_the_box(name: str):
    """States of the box other than those by which limits are judged: to the proof is left what hardly ever binds."""
    case = case_of(name, DESIGNED[name])
    machine, _, box = case.need_machine("this test")
    draw = np.random.default_rng(1)
    signs = draw.choice((-1.0, 1.0), (2, 500, 6))
    table = np.zeros((500, state_size(6)))
    table[:, :18] = np.hstack(
        [
            machine.home.vector + draw.uniform(*box.coordinates, (500, 6)),
            signs[0] * box.rate,
            signs[1] * box.acceleration,
        ]
    )
    near = [kind for kind, *_ in near_limits(case)]
    for kind, _, kernel in state_limits(case):
        assert kind in near or np.abs(kernel.values(table)).max() <= 1.0, kind


def chosen(part: Rows) -> np.ndarray | None:
    return None if part.equal is not None else part.chosen.ravel()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_rows_above_a_share_are_added_and_none_is_taken_away(share: float, small: Small):
    _, problem, at = small
    before = without_some_rows(problem)
    after = before.with_rows_above(at, share)
    for old, new in zip(before.rows, after.rows, strict=True):
        if (had := chosen(old)) is None or (has := chosen(new)) is None:
            assert old is new
            continue
        values = np.abs(old.all_values(at)).ravel()
        assert np.array_equal(has, had | (values > share))
        assert len(new.values(at)) == has.sum() == len(new.upper)
    assert np.all(np.isin(np.round(before.row_values(at), 12), np.round(after.row_values(at), 12)))


def without_some_rows(problem: NonlinearProgram) -> NonlinearProgram:
    """Every third row of what can be left out."""
    rows = []
    for part in problem.rows:
        if part.equal is None:
            part = part.choosing(part.chosen & (np.arange(part.chosen.size).reshape(part.chosen.shape) % 3 == 0))
        rows.append(part)
    return replace(problem, rows=tuple(rows))


def test_tightening_lowers_bounds_of_what_slips_and_never_loosens(small: Small):
    _, problem, _ = small
    slips = [1.02, 0.5, 1.0 - UNUSED_SHARE, 0.99] + [1.1 - 0.2 * (k % 2) for k in range(len(problem.limits))]
    tighter = problem.tightened(slips, 1.0 - UNUSED_SHARE)
    again = tighter.tightened([0.1] * len(slips), 1.0 - UNUSED_SHARE)
    for other in (tighter, again):
        for old, new in zip(problem.rows, other.rows, strict=True):
            assert np.all(new.upper <= old.upper)
        assert np.all(other.row_bounds[0] >= problem.row_bounds[0])
    factors = [min(1.0, (1.0 - UNUSED_SHARE) / slip) for slip in slips]
    last = list(zip(problem.rows, tighter.rows, strict=True))[-len(problem.limits) :]
    for (old, new), factor in zip(last, factors[4:], strict=True):
        assert isinstance(old, StateRows)
        assert isinstance(new, StateRows)
        assert new.bound == pytest.approx(old.bound * factor)
    for old, new in zip(problem.rows, tighter.rows, strict=True):
        if isinstance(old, LinearRows) and old.equal is None:
            assert new.bound == pytest.approx(old.bound * np.array(factors)[old.order])


@seeds(3)
@pytest.mark.parametrize("name", ["fourier", "spline"])
def test_a_random_start_is_inside_all_limits_and_far_from_rest(seed: int, name: str, hexapod_case: Case):
    model = identification_model(hexapod_case, 0)
    some = family_of(hexapod_case, name)
    problem = build_program(hexapod_case, model, some, reference_scaling(hexapod_case, model), UNUSED_SHARE)
    start = random_start(some, np.random.default_rng(seed), problem.worst)
    assert problem.worst(start) <= START_SHARE * (1 + 1e-9)
    assert np.abs(linear(problem).all_values(start)).max() > 0.1
    assert prove(some.motion(start), hexapod_case, 1000.0).kept
    assert np.array_equal(start, random_start(some, np.random.default_rng(seed), problem.worst))


def test_more_starts_go_on_where_fewer_ended():
    assert seeds_of(7, 8)[:3] == seeds_of(7, 3)
    assert len(set(seeds_of(7, 100))) == 100
    assert set(seeds_of(7, 8)).isdisjoint(seeds_of(8, 8))


@pytest.mark.first(1)
@pytest.mark.parametrize("name", ["fourier", "ptp", "spline"])
@pytest.mark.parametrize("far", few(1.3, 1.02, 3.0))
def test_what_is_drawn_back_satisfies_every_limit_and_is_not_smaller_than_needed(
    name: str, far: float, hexapod_case: Case
):
    some = family_of(hexapod_case, name)
    model = identification_model(hexapod_case, 0)
    problem = build_program(hexapod_case, model, some, reference_scaling(hexapod_case, model), UNUSED_SHARE)
    at = random_start(some, np.random.default_rng(1), problem.worst)
    at = some.shrunk(at, far / problem.worst(at))
    inside, share = keep_limits(hexapod_case, some, at, 1000.0)
    report = prove(some.motion(inside), hexapod_case, 1000.0)
    assert report.kept
    assert report.worst_ratio <= 1.0 - UNUSED_SHARE + 1e-6
    larger = prove(some.motion(some.shrunk(at, share + 2 * CLOSE_ENOUGH)), hexapod_case, 1000.0)
    assert larger.worst_ratio > 1.0 - UNUSED_SHARE
    assert inside == pytest.approx(some.shrunk(at, share))


@pytest.mark.parametrize("name", ["fourier", "ptp"])
def test_what_is_inside_is_not_drawn_back(name: str, hexapod_case: Case):
    some: Family = family_of(hexapod_case, name)
    model = identification_model(hexapod_case, 0)
    problem = build_program(hexapod_case, model, some, reference_scaling(hexapod_case, model), UNUSED_SHARE)
    at = random_start(some, np.random.default_rng(1), problem.worst)
    at = some.shrunk(at, 0.9)
    inside, share = keep_limits(hexapod_case, some, at, 1000.0)
    assert share == 1.0
    assert inside == pytest.approx(at, abs=1e-12)


def test_a_large_motion_is_drawn_back_on_a_box_that_is_not_within_reach_as_a_whole():
    case = case_of("small", DESIGNED["small"])
    some = fourier(case, 2, 3.0)
    at = 3.0 * np.random.default_rng(2).normal(size=some.unknowns * 6)
    inside, share = keep_limits(case, some, at, 1000.0)
    assert prove(some.motion(inside), case, 1000.0).kept
    assert not prove(some.motion(some.shrunk(at, share + 2 * CLOSE_ENOUGH)), case, 1000.0).worst_ratio <= (
        1.0 - UNUSED_SHARE
    )


def test_where_nothing_may_move_the_limit_is_named(hexapod_case: Case):
    case = changed(hexapod_case, limits__motion__strut_length_mm=[1100.0, 1460.0])
    some = fourier(case)
    with pytest.raises(InfeasiblePlan, match="no feasible motion: strut length"):
        keep_limits(case, some, np.full(some.unknowns * 6, 0.1), 1000.0)
