"""Tables 3 and 5 of the paper as our stand-in of its machine reproduces them."""

from importlib import import_module

import numpy as np
import pytest

from cases.schema import load_case
from identification.estimation.criteria import Criterion, candidate_scaling
from identification.results.estimate import Estimate
from planner.poses.removal import reduce_best
from tests.bench.fit_frame import HIGH, LOW, Q5M, STARTS
from tests.bench.table_3 import rows_of as rows_of_table_3
from tests.bench.table_3 import table_3
from tests.bench.table_5 import GROUPS, PUBLISHED, Table5, group_deviations, rows_of, table_5
from tests.helpers import few

CASE = load_case("hexapod")
G = 9.81


@pytest.fixture(scope="module")
def table() -> Table5:
    return table_5(CASE)


@pytest.mark.parametrize(("column", "within"), [("Q5M", 0.12), ("Q5D", 0.13), ("Q5A", 0.15), ("Q5N", 0.15)])
def test_columns_of_table_5_are_met_for_all_eight_groups(table: Table5, column: str, within: float) -> None:
    published = np.array(PUBLISHED[column].deviations)
    assert len(published) == len(GROUPS) == 8
    np.testing.assert_allclose(table.deviations[column], published, rtol=within)


def test_the_other_reading_of_k_is_the_one_that_the_paper_used(table: Table5) -> None:
    """Removing what changes the condition least meets column Q5K within 22 %; seeking the best condition does not."""
    published = np.array(PUBLISHED["Q5K"].deviations)
    np.testing.assert_allclose(table.deviations["Q5K'"], published, rtol=0.22)
    assert np.abs(table.deviations["Q5K"] / published - 1.0).max() > 0.3


def test_deviations_grow_about_fivefold_by_the_reduction_from_480_to_30(table: Table5) -> None:
    """Section 6; at equal s0 the square root of 480 / 30, 4, is the least one could expect of equally good poses."""
    for name in ("Q5A", "Q5D", "Q5N"):
        growth = table.deviations[name] / table.deviations["Q5M"]
        assert np.all((growth > 3.5) & (growth < 5.5))


def test_the_printed_table_holds_every_column_beside_the_paper(table: Table5) -> None:
    rows = rows_of(table)
    assert [len(row) for row in rows] == [7] * 9
    assert rows[0][1].startswith("0.22 / 0.2")
    assert rows[-1][2:] == ["3 / 3", "4 / 3", "4 / 3", "4 / 3", "3 / 3"]


@pytest.mark.parametrize("start", few(*range(len(STARTS))))
def test_a_frame_fitted_to_column_q5m_alone_meets_q5d_untouched(start: int) -> None:
    column = Q5M(CASE)
    fit = column.fit(STARTS[start])
    assert np.all((fit.frame > LOW) & (fit.frame < HIGH))  # a frame of this kind, not one at the edge of what was tried
    assert np.abs(np.expm1(fit.misfit)).max() < 0.12
    regressors = column.regressors(fit.frame)
    kept = reduce_best(regressors * candidate_scaling(regressors), Criterion("D"), 30)[0]
    ours = group_deviations(regressors[kept], CASE, PUBLISHED["Q5D"])
    np.testing.assert_allclose(ours, PUBLISHED["Q5D"].deviations, rtol=0.13)


def test_the_frame_of_the_case_is_one_of_those_that_fit(table: Table5) -> None:
    assert CASE.sensor_frame.bars is not None
    frame = np.array([146.0, 20.0, 9.0, 171.0, 52.0, 121.0])
    column = Q5M(CASE)
    assert np.abs(np.expm1(column.misfit(frame))).max() < 0.12
    np.testing.assert_allclose(
        column.misfit(frame), np.log(table.deviations["Q5M"] / PUBLISHED["Q5M"].deviations), atol=1e-9
    )


@pytest.fixture(scope="module", params=["causes aside", pytest.param("causes sought", marks=pytest.mark.repeats)])
def models(request: pytest.FixtureRequest) -> dict[int, Estimate | str]:
    """Estimates, or why there is none; models that leave much out are searched for causes at length alone."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "causes aside":
            patch.setattr(import_module("identification.identify"), "answer", lambda *_: None)
        return table_3(CASE, noise=0.1)


def value(models: dict[int, Estimate | str], number: int, name: str) -> float:
    estimate = models[number]
    assert isinstance(estimate, Estimate)
    return estimate.physical[name].value


@pytest.mark.repeats
@pytest.mark.parametrize("number", [0, 1, 2])
def test_models_without_orientation_terms_bias_mass_and_centre_of_gravity_as_section_5_says(
    models: dict[int, Estimate | str], number: int
) -> None:
    """To first order in the tilt k2 looks like a mass of k2 / (2 g), k3 like a first moment of -k3 / (2 g)."""
    mass = 31.83 + 37.38 / (2 * G)
    moment = 31.83 * 0.10505 - 28.27 / (2 * G)
    assert value(models, number, "m") == pytest.approx(mass, abs=0.1)
    assert value(models, number, "m") * value(models, number, "zC") == pytest.approx(moment, rel=0.02)


def test_the_paper_biases_are_of_that_size() -> None:
    """Table 3, models 2 and 5. The moment agrees in sign too; the mass falls where (15) as printed makes it rise."""
    assert pytest.approx(65.50 / (2 * G), rel=0.03) == 33.78 - 30.36
    assert pytest.approx(26.87 / (2 * G), rel=0.03) == 33.78 * 0.10893 - 30.36 * 0.07491


@pytest.mark.parametrize("number", [4, 5])
def test_models_with_orientation_terms_find_the_true_mass_and_centre_of_gravity(
    models: dict[int, Estimate | str], number: int
) -> None:
    estimate = models[number]
    assert isinstance(estimate, Estimate)
    for name, truth in {"m": 31.83, "xC": 0.01e-3, "yC": -0.32e-3, "zC": 105.05e-3}.items():
        found = estimate.physical[name]
        assert abs(found.value - truth) < 4.0 * found.std


def test_model_3_is_refused_and_its_parameters_are_named(models: dict[int, Estimate | str]) -> None:
    reason = models[3]
    assert isinstance(reason, str)
    assert "m, mxC, myC, mzC, K3_1x" in reason
    assert "not determined" in reason


def test_models_1_and_2_say_the_same_with_different_numbers_of_parameters(models: dict[int, Estimate | str]) -> None:
    """The paper prints identical values for them, to two decimals; what remains (s0) is the orientation's error."""
    for name in ("m", "xC", "yC", "zC", "f_q0_1", "f_q0_6"):
        scale = 1e3 if name.endswith("C") else 1.0
        assert scale * value(models, 1, name) == pytest.approx(scale * value(models, 2, name), abs=0.05)
    s0 = [models[k].fit.white_noise for k in (0, 1, 2, 5)]
    assert s0[0] > 3 * s0[1]
    assert s0[1] == pytest.approx(s0[2], rel=0.05)
    assert s0[3] < 0.2 * s0[2]


def test_the_printed_table_3_shows_truth_and_all_models(models: dict[int, Estimate | str]) -> None:
    rows = rows_of_table_3(CASE, models)
    assert rows[0][:2] == ["s0 in N", "-"]
    assert rows[0][5] == "refused"
    assert all(len(row) == 8 for row in rows)
