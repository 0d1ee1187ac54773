"""Known weights on a machine that was measured: what was added is what is known of them, and an order is noticed."""

from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import Code, HexciteError
from hexcite.comparison.trials import Trial, measured_trials, trials
from hexcite.comparison.validation import validate_results
from identification.results.payload import payload
from identification.results.result import Result
from tests.hexcite.command_line import call, refused
from tests.hexcite.comparison.excitations import CASE, moving

MOUNTED = (0, 1, 3)


@pytest.fixture(scope="module")
def simulated() -> list[Trial]:
    """An undisturbed machine with noise, without weights, with one and with three."""
    return list(trials(moving(CASE), MOUNTED, None))


@pytest.fixture
def results(simulated: list[Trial]) -> list[Result]:
    """What its runs say."""
    return [trial.result for trial in simulated]


def code_of(*arguments: Any) -> Code:
    """The code with which `validate_results` refuses."""
    with pytest.raises(HexciteError) as raised:
        validate_results(*arguments)
    return raised.value.code


def test_theory_is_that_of_the_simulated_experiment_and_errors_are_of_what_was_added(
    simulated: list[Trial], results: list[Result]
):
    measured = list(measured_trials(results, MOUNTED))
    assert [trial.theory for trial in measured] == [trial.theory for trial in simulated]
    assert not measured[0].errors
    for trial, mass in zip(measured[1:], (19.93, 3 * 19.93), strict=True):
        added = payload(results[0], trial.result).parameters["m"]
        assert trial.errors["m"] == pytest.approx((added.value - mass) / added.reported, rel=1e-9)
        assert set(trial.errors) == {"m", "xC", "yC", "zC", "IC11", "IC22", "IC33"}
        assert max(map(abs, trial.errors.values())) < 4.0


def test_a_sentence_counts_what_is_near_to_what_is_known(results: list[Result]):
    validation = validate_results(results, MOUNTED)
    near = sum(abs(error) <= 3.0 for trial in validation.trials for error in trial.errors.values())
    assert f"{near} of 14 are within 3" in validation.sentences[0]
    assert validation.to_json()["controller"] is None


@pytest.mark.parametrize(("order", "weights", "said"), [((0, 2, 1), MOUNTED, "3 weights"), ((0, 2), None, "3 weights")])
def test_results_in_another_order_than_the_weights_are_refused(results, order, weights, said: str):
    with pytest.raises(HexciteError, match=said) as raised:
        validate_results([results[k] for k in order], weights)
    assert raised.value.code == Code.CONTRADICTION


def test_one_result_or_too_few_for_the_weights_are_refused(results: list[Result]):
    assert code_of(results[:1]) == Code.MISSING
    assert code_of(results, (0, 3)) == Code.CONTRADICTION
    assert code_of([results[0], results[0]]) == Code.OTHER_SOURCE


def test_the_command_writes_what_was_added_with_its_page(results: list[Result], tmp_path: Path):
    places = []
    for result, count in zip(results, MOUNTED, strict=True):
        result.save(tmp_path / f"with-{count}")
        places.append(tmp_path / f"with-{count}")
    answer = call("validate", "hexapod", *places, "--weights", "0,1,3", "-o", tmp_path / "v", "--json").json()
    assert [row["weights"] for row in answer["rows"]] == list(MOUNTED)
    added = answer["rows"][1]["parameters"]["m"]["value"] - answer["rows"][0]["parameters"]["m"]["value"]
    assert added == pytest.approx(19.93, rel=0.01)
    page = Path(answer["report"]).read_text(encoding="utf-8")
    assert "what is known of the weights" in page
    assert all(f"with-{count}" in page for count in MOUNTED)
    assert "--starts" in refused("validate", "hexapod", *places, "--starts", "3", "-o", tmp_path / "w")
    assert not (tmp_path / "w").exists()
