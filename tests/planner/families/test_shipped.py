"""Starts that come with hexcite: in units that any machine understands, and as good as they say."""

import json
from typing import Any

import numpy as np
import pytest

from cases.schema import Case, load_case
from identification.criteria import reference_scaling
from identification.limit_proof import prove
from identification.model import identification_model
from planner.bounds.information_limit import information_limit
from planner.families import Family
from planner.families.ptp import PointToPointFamily
from planner.families.settings import family_class
from planner.noise import mean_information
from planner.planning import SHIPPED, shipped_start
from planner.search.annealing import annealed_start
from planner.search.problem import build_program
from planner.search.solving import CLOSE
from tests.bench.shipped_starts import table_of

FAMILIES = ("fourier", "ptp", "ptp, steps", "spline")
CASE = load_case("hexapod")


def family_of(name: str, duration: float = 12.0, **settings: Any) -> Family:
    (family,) = family_class(name.partition(",")[0])(**settings).families(case_of(name), duration)
    return family


def case_of(name: str) -> Case:
    """The built-in hexapod, with or without limits of jerk."""
    return CASE.without_jerk() if name.endswith("steps") else CASE


@pytest.mark.parametrize("name", FAMILIES)
def test_a_table_of_unknowns_gives_them_back(name: str):
    family = family_of(name)
    layout = family.layout(CASE, 0.0)
    unknowns = np.random.default_rng(3).uniform(-0.1, 0.1, len(layout.lower))
    if isinstance(family, PointToPointFamily):
        count = family.moves
        times = 1.0 + unknowns[-3 * count :].reshape(count, 3)
        times[:, 0] *= not family.steps
        unknowns[-3 * count :] = (times * count / (times @ [4, 2, 1]).sum()).ravel()
    again = family.like(table_of(family, unknowns))
    assert again is not None
    np.testing.assert_allclose(again, unknowns, atol=1e-12)


@pytest.mark.parametrize("name", FAMILIES)
def test_on_the_built_in_hexapod_it_is_worth_what_it_says_within_all_limits(name: str):
    case, family = case_of(name), family_of(name)
    model, start = identification_model(case, 9), shipped_start(family, CASE)
    assert start is not None
    scaling = reference_scaling(case, model)
    logdet = np.linalg.slogdet(mean_information(model, scaling, family.motion(start)))[1]
    stated = json.loads(SHIPPED.read_text())[name]["d_efficiency"]
    assert information_limit(case, model).efficiency(logdet) == pytest.approx(stated, abs=1e-3)
    assert prove(family.motion(start), case).worst_ratio < 1.0
    assert build_program(case, model, family, scaling, 0.0).worst(start) <= CLOSE  # rows may hold a bound of a limit


def test_fourier_series_of_another_order_are_not_like_it():
    assert shipped_start(family_of("fourier", order=4), CASE) is None
    assert shipped_start(family_of("fourier", order=5, duration=4.0), CASE) is not None


def test_splines_of_other_numbers_of_knots_follow_the_same_curve():
    coarse, fine = family_of("spline", knots=60), family_of("spline")
    t = np.linspace(0.0, 12.0, 200)
    places = [family.motion(shipped_start(family, CASE)).at(t).pose / family.half for family in (coarse, fine)]
    likeness = [np.corrcoef(places[0][:, k], places[1][:, k])[0, 1] for k in range(6)]
    assert min(likeness) > 0.7


@pytest.mark.parametrize("moves", [12, 40, 64])
def test_more_moves_than_it_has_go_back_the_same_way(moves: int):
    family = family_of("ptp", moves=moves, duration=0.3 * moves)
    points, times = family.split(shipped_start(family, CASE))
    assert points.shape == (moves + 1, 6)
    assert np.abs(points).max() <= 1.0
    assert np.all(times >= 0.0)
    if moves > 40:
        np.testing.assert_allclose(points[41:], points[2 * 40 - moves : 40][::-1], atol=1e-12)


def test_a_walk_that_is_annealed_further_is_no_worse():
    family, model = family_of("ptp", moves=20, duration=6.0), identification_model(CASE, 9)
    assert isinstance(family, PointToPointFamily)
    scaling, told = reference_scaling(CASE, model), []
    walk = family.split(shipped_start(family, CASE))[0]
    draw = np.random.default_rng(1)
    unknowns = annealed_start(CASE, model, scaling, family, draw, lambda f: told.append(f) is not None, walk)
    assert told == sorted(told, reverse=True)  # -log det F / u of the best until then
    assert np.abs(family.split(unknowns)[0]).max() <= 1.0 + 1e-9
