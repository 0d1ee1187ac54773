"""A range of payloads: what is promised holds with every number of them, and the plan says which is the worst."""

from pathlib import Path

import pytest

from cases.schema import load_case
from hexcite.cli.plan import read_payloads
from identification.estimation.criteria import reference_scaling
from identification.model.model import identification_model
from planner.families.manual import manual_motion, sequence_file
from planner.plans.figures import predictions_of
from planner.plans.plan import Plan
from planner.plans.prediction import Promise
from planner.request import Request
from tests.hexcite.command_line import call, refused
from tests.planner.monte_carlo import vibrating

CASE = load_case("hexapod")


@pytest.mark.parametrize(("text", "found"), [("2", (2, None)), ("0-5", (5, 0)), (" 1-1 ", (1, 1))])
def test_a_number_or_a_range_is_read(text: str, found: tuple[int, int | None]):
    assert read_payloads(text) == found
    request = Request(payload=found[0], payload_from=found[1])
    assert list(request.payloads)[-1] == found[0]


@pytest.mark.parametrize("shaken", [False, True])
def test_what_is_predicted_for_a_range_is_the_largest_within_it(shaken: bool):
    case = vibrating(CASE, 1.0, 0.05, 1.0, "stated") if shaken else CASE
    model, motion = identification_model(CASE, 9), manual_motion(CASE, sequence_file(CASE))
    runs = predictions_of(case, model, reference_scaling(CASE, model), motion, range(3))
    each, worst = [run.std for run in runs], Promise.of(runs).std
    for name, std in worst.items():
        assert std == pytest.approx(max(one[name] for one in each), rel=1e-9)
    # A centre of gravity is told by a moment over a mass: it is least certain where the mass is smallest. Forces that
    # the sensors feel of vibration grow with the mass.
    assert shaken or worst["xC"] == each[0]["xC"]
    assert worst["k0"] == each[2 if shaken else 0]["k0"]


def test_a_plan_for_a_range_is_believed(cache: Path, tmp_path: Path):
    answer = call("plan", "hexapod", "--family", "manual", "--payload", "0-5", "-o", tmp_path / "plan", "--json").json()
    assert (answer["payload_from"], answer["payload"]) == (0, 5)
    assert Plan.load(tmp_path / "plan").predicted_std == answer["predicted_std"]
    text = (tmp_path / "plan" / "plan.json").read_text(encoding="utf-8")
    (tmp_path / "plan" / "plan.json").write_text(text.replace('"payload_from": 0', '"payload_from": 5'))
    assert "changed by hand" in refused("post", tmp_path / "plan", "-o", tmp_path / "run.ngc")
