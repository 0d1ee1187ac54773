"""Table 3: all models of one run, and which of them predicts what it has not seen."""

import numpy as np
import pytest

import hexcite as hx
from cases.base.errors import IdentificationError
from cases.schema import load_case
from identification.fitting import fitted_run
from identification.machines.hexapod import Hexapod
from identification.model.model import identification_model
from identification.model.parameters import linear_parameters
from identification.model_choice import ModelChoice, left_out
from identification.simulate import simulate_recording
from tests.bench.table_3 import standing_run
from tests.helpers import Harmonic, one_line
from tests.simulated_machine import PoseExecution

CASE = load_case("hexapod")
STANDING = standing_run(CASE, 1.0, 0)
TRUTH = CASE.need_simulation("the test").parameters


@pytest.fixture(scope="module")
def standing() -> ModelChoice:
    return hx.identify_models(STANDING, CASE)


def test_the_model_with_which_the_machine_was_simulated_is_preferred(standing: ModelChoice) -> None:
    """Model 2 has smaller deviations, and a centre of gravity that is 50 mm off; model 4 has more parameters."""
    rows = {row.model: row for row in standing.rows}
    assert (standing.best, list(rows)) == (5, [0, 1, 2, 3, 4, 5])
    true = dict(
        zip(identification_model(CASE, 5).names, linear_parameters(identification_model(CASE, 5), TRUTH), strict=True)
    )
    height = true["mzC"] / true["m"]
    small, own = rows[2].parameters["zC"], rows[5].parameters["zC"]
    assert small.reported < 0.2 * own.reported
    assert abs(small.value - height) > 100.0 * small.reported
    assert abs(own.value - height) < 4.0 * own.reported
    assert rows[5].predicted == pytest.approx(1.0, rel=0.05)  # the noise, whatever was left out
    assert rows[2].predicted > 1.3
    assert rows[2].worse > 5.0


def test_what_cannot_be_identified_is_said_and_left_out(standing: ModelChoice) -> None:
    (third,) = (row for row in standing.rows if row.model == 3)
    assert third.parameters is None
    assert "rank 26 of 30" in third.reason
    assert any("model 3" in sentence and "rank 26 of 30" in sentence for sentence in standing.sentences)


@pytest.mark.repeats
def test_s0_and_parameters_are_those_of_each_model_alone(standing: ModelChoice) -> None:
    for row in standing.rows:
        if row.parameters is not None:
            alone = hx.identify(STANDING, CASE, row.model)
            assert row.s0 == pytest.approx(alone.record.s0, rel=1e-9)
            assert row.parameters["m"].value == pytest.approx(alone["m"].value, rel=1e-9)


def test_each_block_is_predicted_from_the_others_alone() -> None:
    """By hand: forty-eight poses left out, the rest solved by least squares."""
    fitted = fitted_run(STANDING, CASE, identification_model(CASE, 5), hx.Method()).fitted
    a, f = fitted.regression.regressors, fitted.regression.forces
    outside = np.ones(480, dtype=bool)
    outside[96:144] = False
    u = np.linalg.lstsq(a[outside].reshape(-1, 14), f[outside].ravel(), rcond=None)[0]
    expected = np.sum((f[~outside] - a[~outside] @ u) ** 2) / 48
    assert left_out(fitted, np.eye(6))[2] == pytest.approx(expected, rel=1e-9)


@pytest.mark.repeats
def test_in_motion_all_ten_models_and_the_third_with_inertia_stand_beside_each_other() -> None:
    execution = PoseExecution(Hexapod.of(CASE), Harmonic(duration=2.5))
    choice = hx.identify_models(simulate_recording(CASE, execution, np.array([[0.15, 2.35]]), 0, "run.csv"), CASE)
    assert [row.model for row in choice.rows] == list(range(11))
    assert choice.best == 9
    predicted = {row.model: row.predicted for row in choice.rows if row.parameters is not None}
    assert predicted[9] < 0.8 * predicted[7] < 0.8 * predicted[0]


def test_a_run_that_carries_no_model_is_refused() -> None:
    from dataclasses import replace

    few = replace(STANDING, drives=STANDING.drives[:1], forces=STANDING.forces[:1])
    with pytest.raises(IdentificationError, match="no model can be identified") as caught:
        hx.identify_models(few, CASE)
    one_line(caught.value)
