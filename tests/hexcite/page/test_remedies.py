"""Keys that a finding of a result, or a refusal, names are written at a click, and no other."""

import json
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from cases.basis import COMPUTED_FROM, result_basis
from cases.scaffold import new_case
from cases.schema import load_case

WORDS = "the sensor is turned on its flange by 2.7 deg <b>"
PLACE = ["machine", "chain", "sensor", "rpy_deg"]


@pytest.fixture
def file(root: Path) -> Path:
    file = new_case("arm", "ur10_wrist", root / "arm")
    (root / "rec.csv").write_text("t_s,fx_N\n0,1\n")
    case = load_case(str(file))
    finding = {
        "kind": "case", "severity": "note", "sentence": f"the run tells that {WORDS}",
        "remedies": [{"words": WORDS, "keys": [[PLACE, [0.0, 0.0, 32.7]]]}],
    }  # fmt: skip
    parameter = {"value": 2.0, "std": 0.01, "std_robust": 0.01, "unit": "kg"}
    record = {
        "case": "arm", "case_hash": case.hash, COMPUTED_FROM: result_basis(case), "recording": "rec.csv",
        "parameters": {"m": parameter}, "findings": [finding],
    }  # fmt: skip
    (root / "res").mkdir()
    (root / "res" / "result.json").write_text(json.dumps(record))
    return file


def test_a_remedy_of_a_result_is_shown_and_written(client: TestClient, root: Path, file: Path) -> None:
    shown = client.get("/m/+arm/result?result=res").text
    assert "machine.chain.sensor.rpy_deg = [0.0, 0.0, 32.7]" in shown
    assert "2.7 deg &lt;b&gt;" in shown
    assert "<b>2.7" not in shown
    before = file.read_text()
    form = {"result": "res", "recording": "rec.csv", "remedy": "0", "words": WORDS}
    for wrong in ({"remedy": "1"}, {"remedy": "-1"}, {"words": "another"}, {"recording": "../rec.csv"}):
        assert client.post("/m/+arm/do/apply", data=form | wrong).status_code == 400
        assert file.read_text() == before
    answer = client.post("/m/+arm/do/apply", data=form)
    assert answer.status_code == 303
    assert load_case(str(file)).chain.sensor.rpy_deg == (0.0, 0.0, 32.7)
    assert (file.parent / "case-1.toml").read_text() == before
    page = client.get("/m/+arm/data?recording=rec.csv").text
    assert "hexcite case set arm/case.toml" in page


def test_a_built_in_machine_shows_remedies_and_is_not_written(client: TestClient, root: Path, file: Path) -> None:
    record = json.loads((root / "res" / "result.json").read_text()) | {"case": "ur10_wrist"}
    (root / "res" / "result.json").write_text(json.dumps(record))
    shown = client.get("/m/ur10_wrist/result?result=res").text
    assert "rpy_deg = [0.0, 0.0, 32.7]" in shown
    assert 'action="/m/ur10_wrist/do/apply"' not in shown or "<button>Accept" not in shown
    form = {"result": "res", "recording": "rec.csv", "remedy": "0", "words": WORDS}
    assert client.post("/m/ur10_wrist/do/apply", data=form).status_code == 400
