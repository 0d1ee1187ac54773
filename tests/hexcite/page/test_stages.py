"""Stages say what the folder holds: what is done, what is out of date, and what cannot be yet."""

import json
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from cases.basis import KEPT, plan_basis, result_basis
from cases.scaffold import new_case
from cases.schema import Case, load_case
from hexcite.page import forms
from hexcite.page.actions.data import chosen_settings
from hexcite.page.forms import Unfit
from hexcite.page.stages import Workspace, free, machine_of, own_machines, workspace


@pytest.fixture
def case(root: Path) -> Case:
    return load_case(str(new_case("mill", "hexapod", root / "mill")))


def there(root: Path) -> Workspace:
    machine = machine_of(root, "+mill")
    assert machine is not None
    return workspace(root, machine)


def plan_folder(root: Path, case: Case, name: str = "mill-plan") -> Path:
    folder = root / name
    folder.mkdir()
    record = {"case": case.name, "case_hash": case.hash, "family": "ptp", KEPT: plan_basis(case), "duration_s": 12.0}
    (folder / "plan.json").write_text(json.dumps(record))
    return folder


def states(root: Path) -> str:
    found = there(root)
    return " ".join(found.state(stage) for stage in ("machine", "plan", "program", "data", "result", "use"))


def test_stages_follow_what_commands_write(root: Path, case: Case, client: TestClient):
    assert states(root) == "done open closed open closed closed"
    folder = plan_folder(root, case)
    assert states(root) == "done done open open closed closed"
    fingerprint = there(root).plans[0].fingerprint
    (root / "run.mpf").write_text(f"; plan hash {fingerprint[:16]}\nG1 X0\n")
    (root / "other.mpf").write_text("; plan hash 0123456789abcdef\n")
    assert [program.name for program in there(root).programs] == ["run.mpf"]
    assert states(root) == "done done done open closed closed"
    (root / "rec.csv").write_text("t_s,f1_N\n0,1\n")
    assert states(root) == "done done done done open closed"
    (root / "res").mkdir()
    record = {"case": "mill", "case_hash": case.hash, KEPT: result_basis(case), "parameters": {}, "findings": []}
    (root / "res" / "result.json").write_text(json.dumps(record))
    assert states(root) == "done done done done done open"
    for stage in ("machine", "plan", "program", "data", "result", "use"):
        assert client.get(f"/m/+mill/{stage}").status_code == 200
    file = root / "mill" / "case.toml"
    file.write_text(file.read_text().replace("radius_mm = 700.0", "radius_mm = 705.0", 1))
    assert states(root) == "done stale stale done stale closed"
    assert any("radius_mm was 700" in words for words in there(root).plans[0].changed)
    assert "700" in client.get("/m/+mill/plan").text
    (folder / "plan.json").write_text("{")
    assert there(root).plans == ()


def test_a_case_that_is_not_read_says_why_and_opens_no_stage(root: Path, client: TestClient):
    (root / "odd").mkdir()
    (root / "odd" / "case.toml").write_text("setup = 3")
    (machine,) = own_machines(root)
    assert machine.case is None
    answer = client.get("/m/+odd/machine")
    assert answer.status_code == 200
    assert "case.toml" in answer.text
    assert client.get("/m/+odd/plan").status_code == 200


@pytest.mark.parametrize(
    "name", ["hexapod", "ur10_wrist", "ft_wrist", "five_axis_table", "strut_sensors", "clamping_table"]
)
def test_every_built_in_case_has_all_stages_in_both_languages(client: TestClient, name: str):
    for language in ("de", "en"):
        for stage in ("machine", "plan", "program", "data", "result", "use"):
            answer = client.get(f"/m/{name}/{stage}", headers={"accept-language": language})
            assert answer.status_code == 200
            assert f'<html lang="{language}">' in answer.text


def test_a_machine_that_cannot_be_planned_says_what_it_lacks_and_reads_recordings(client: TestClient):
    plan = client.get("/m/ft_wrist/plan").text
    assert "limits.motion" in plan
    assert "/m/ft_wrist/data" in plan
    assert 'action="/m/ft_wrist/do/plan"' not in plan


def test_names_of_what_is_written_are_free(root: Path):
    (root / "a").mkdir()
    (root / "a-3").symlink_to(root / "nowhere")
    assert free(root, "a", {"a-2"}) == "a-4"
    assert free(root, "b", set(), ".mpf") == "b.mpf"


def test_forms_become_commands(root: Path, case: Case):
    machine = machine_of(root, "+mill")
    assert machine is not None
    fields = {"duration": ["12,5"], "effort": ["quick"], "target": ["m=5g; zC=0.1mm"]}
    command = forms.plan(machine, fields, "out")
    assert command[:2] == ["plan", "mill/case.toml"]
    assert {"12.5", "--target=m=5g", "--target=zC=0.1mm", "20", "--progress"} <= {*command}
    assert forms.plan(machine, {"family": ["poses"], "count": ["9"]}, "out") == [
        "poses", "mill/case.toml", "--count", "9", "-o", "out"
    ]  # fmt: skip
    for wrong in ({"duration": ["nan"]}, {"duration": ["-1"]}, {"duration": ["12"], "effort": ["--seed"]}):
        with pytest.raises(Unfit):
            forms.plan(machine, wrong, "out")
    assert forms.place("-o") == "./-o"


def test_menus_replace_columns_and_units_of_a_proposal():
    answer = {
        "columns": [{"name": name} for name in ("A", "B", "C")],
        "settings": {"filter_cutoff_Hz": 40.0, "columns": {"l1_mm": "A", "l2_mm": "B"}, "units": {"struts": "m"}},
    }
    fields = {"c.l1_mm": ["B"], "c.l2_mm": ["A"], "c.trigger": ["C"], "u.struts": [""], "u.forces": ["lbf"]}
    settings = chosen_settings(answer, fields)
    assert settings["columns"] == {"l1_mm": "B", "l2_mm": "A", "trigger": "C"}
    assert settings["units"] == {"forces": "lbf"}
    assert settings["filter_cutoff_Hz"] == 40.0
    with pytest.raises(Unfit, match="twice"):
        chosen_settings(answer, {"c.l1_mm": ["B"], "c.l2_mm": ["B"]})
    with pytest.raises(Unfit, match="not a column"):
        chosen_settings(answer, {"c.l1_mm": ["D"]})


def test_a_form_that_cannot_be_is_refused_with_words(client: TestClient):
    answer = client.post("/m/hexapod/do/plan", data={"duration": "soon"})
    assert answer.status_code == 400
    assert "soon" in answer.text
    assert client.post("/m/hexapod/do/identify", data={"recording": "../a.csv"}).status_code == 400
    assert client.post("/new", data={"name": "--help", "like": "hexapod"}).status_code == 400


def test_each_line_of_a_program_has_its_worst_limit():
    from hexcite.page.stages import Program
    from hexcite.page.views.program import _lines

    answer = {
        "program": "folder/run.mpf",
        "lines": [
            {"line": 2, "limit": "velocity (x)", "ratio": 0.5, "status": "proven"},
            {"line": 3, "limit": "jerk (x)", "ratio": 1.0, "status": "NOT enforced"},
        ],
    }
    shown = _lines("G90\nG1 X1\nG1 X2\n", answer, Program("run.mpf", "plan", 0.0))
    assert [row[0] for row in shown] == [1, 2, 3]
    assert shown[0][2] == ""
    assert "velocity (x)" in shown[1][2]
    assert "50 %" in shown[1][2]
    assert not shown[1][3]
    assert "NOT enforced" in shown[2][2]
    assert shown[2][3]
    assert all(not row[2] for row in _lines("G90\n", answer, Program("other.mpf", "plan", 0.0)))
