"""Stages say what the folder holds: what is done, what is out of date, and what cannot be yet."""

import html
import json
import math
import os
import re
import subprocess
import sys
import time
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from cases.base.errors import AT_OWN_RISK, Code, FileProblem, option
from cases.base.phrases import enumerated, phrase
from cases.basis import COMPUTED_FROM, plan_basis, result_basis
from cases.editing import write_table
from cases.readiness import languages_of
from cases.recording_format import Role
from cases.scaffold import new_case
from cases.schema import Case, load_case
from cases.tables import built_in_cases
from hexcite.page import forms
from hexcite.page.actions.common import Context
from hexcite.page.actions.data import looked_at
from hexcite.page.actions.table import ACTIONS, asked
from hexcite.page.jobs import Job, Jobs
from hexcite.page.journal import Journal
from hexcite.page.reading import chosen_settings
from hexcite.page.refusals import Unfit
from hexcite.page.stages import MARK, Workspace, free, machine_of, own_machines, workspace
from hexcite.page.views import job as job_view
from hexcite.page.views.common import chosen_plan
from hexcite.page.views.data import shown as data_view
from hexcite.page.words import ENGLISH
from hexcite.texts import LANGUAGES, text
from identification.motion.motion import Standstill
from postprocessors.blocks import ToHome, Trigger


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
    record = {
        "case": case.name,
        "case_hash": case.hash,
        "family": "ptp",
        COMPUTED_FROM: plan_basis(case),
        "duration_s": 12.0,
    }
    (folder / "plan.json").write_text(json.dumps(record))
    return folder


def states(root: Path) -> str:
    found = there(root)
    return " ".join(found.state(stage) for stage in ("machine", "plan", "program", "data", "result", "use"))


def test_stages_follow_what_commands_write(root: Path, case: Case, client: TestClient):
    assert states(root) == "open open closed open closed closed"
    folder = plan_folder(root, case)
    assert states(root) == "open done open open closed closed"
    fingerprint = there(root).plans[0].fingerprint
    (root / "run.mpf").write_text(f"; plan hash {fingerprint[:16]}\nG1 X0\n")
    (root / "other.mpf").write_text("; plan hash 0123456789abcdef\n")
    assert [program.name for program in there(root).programs] == ["run.mpf"]
    assert states(root) == "open done done open closed closed"
    (root / "rec.csv").write_text("t_s,f1_N\n0,1\n")
    assert [recording.name for recording in there(root).recordings] == ["rec.csv"]
    assert states(root) == "open done done open closed closed"  # whose file it is, nobody has seen yet
    (root / "res").mkdir()
    record = {
        "case": "mill",
        "case_hash": case.hash,
        COMPUTED_FROM: result_basis(case),
        "parameters": {},
        "findings": [],
    }
    (root / "res" / "result.json").write_text(json.dumps(record))
    assert states(root) == "open done done done done open"
    for stage in ("machine", "plan", "program", "data", "result", "use"):
        assert client.get(f"/m/+mill/{stage}").status_code == 200
    file = root / "mill" / "case.toml"
    file.write_text(file.read_text().replace("radius_mm = 700.0", "radius_mm = 705.0", 1))
    assert states(root) == "open stale stale done stale closed"
    assert any("radius_mm was 700" in words for words in there(root).plans[0].changed)
    assert "700" in client.get("/m/+mill/plan").text
    (folder / "plan.json").write_text("{")
    assert there(root).plans == ()


STAGES = ("machine", "plan", "program", "data", "result", "use")
RECORDS = ("plan.json", "recording.json", "result.json")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
@pytest.mark.parametrize("name", [*RECORDS, "run.mpf", "run.csv", "run.yaml", "run.json"])
def test_a_pipe_in_the_place_of_a_file_holds_nobody_up(root: Path, case: Case, client: TestClient, name: str):
    plan_folder(root, case)
    folder = root / "piped" if name in RECORDS else root
    folder.mkdir(exist_ok=True)
    os.mkfifo(folder / name)
    assert states(root).split()[1] == "done"
    assert [client.get(f"/m/+mill/{stage}").status_code for stage in STAGES] == [200] * len(STAGES)


DAMAGED_RECORDS = {
    "deep": "[" * 200_000,
    "deep in an entry": '{"case": "mill", "computed_from": ' + '{"a":' * 200_000,
    "a number": "1",
    "a number of many digits": '{"case": "mill", "duration_s": ' + "1" * 5000 + "}",
    "not a number": '{"case": "mill", "payload": NaN, "duration_s": Infinity}',
    "a payload that is none": '{"case": "mill", "payload": "x"}',
    "lists for values": '{"case": "mill", "payload": [], "family": [], "computed_from": [], "findings": 1, "name": {}}',
    "a list that was asked for": '{"case": "mill", "asked": [], "settings": {"made_for": []}, "d_efficiency": "x"}',
    "bytes": "\ufeff\x00",
}


@pytest.mark.parametrize("what", DAMAGED_RECORDS)
def test_damaged_records_are_left_out_of_the_page(root: Path, case: Case, client: TestClient, what: str):
    plan_folder(root, case)
    for name in RECORDS:
        (root / f"with-{name}").mkdir()
        (root / f"with-{name}" / name).write_text(DAMAGED_RECORDS[what])
    assert states(root).split()[1] == "done"
    assert [client.get(f"/m/+mill/{stage}").status_code for stage in STAGES] == [200] * len(STAGES)


def test_a_case_that_is_not_read_says_why_and_opens_no_stage(root: Path, client: TestClient):
    (root / "odd").mkdir()
    (root / "odd" / "case.toml").write_text("setup = 3")
    (machine,) = own_machines(root)
    assert machine.case is None
    answer = client.get("/m/+odd/machine")
    assert answer.status_code == 200
    assert "case.toml" in answer.text
    assert client.get("/m/+odd/plan").status_code == 200


@pytest.mark.first(2)
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


def menus(**chosen: str) -> dict[str, list[str]]:
    return {name.replace("__", "."): [value] for name, value in chosen.items()}


def test_menus_say_layout_clock_trigger_orientation_and_scale():
    answer = {
        "columns": [{"name": name} for name in ("T", "st", "Fx")],
        "settings": {"delimiter": ";", "columns": {"t_s": "T", "trigger": "st", "fx_N": "Fx"}, "clock": {"unit": "ms"}},
    }
    form = menus(c__trigger="st", l__bit="3", s__fx_N="-0,5", l__unit="us", l__orientation="zyx intrinsic")
    settings = chosen_settings(answer, form)
    assert settings["trigger"] == {"column": "st", "bit": 3}
    assert settings["columns"] == {"t_s": "T", "fx_N": "Fx"}
    assert settings["scale"] == {"fx_N": -0.5}
    assert settings["clock"] == {"unit": "us"}
    assert settings["orientation"] == "zyx intrinsic"
    back = chosen_settings({**answer, "settings": settings}, menus(c__trigger="st", l__bit="", s__fx_N="", l__unit=""))
    assert back["columns"] == {"t_s": "T", "fx_N": "Fx", "trigger": "st"}
    assert not {"trigger", "scale", "clock"} & {*back}
    moved = chosen_settings(answer, menus(c__t_s="T", l__delimiter="tab", l__decimal=",", l__header_rows="7"))
    assert (moved["delimiter"], moved["decimal"], moved["header_rows"]) == ("\t", ",", 7)
    assert "columns" not in moved  # their names are of another line
    assert "delimiter" not in chosen_settings(answer, menus(l__delimiter=""))
    for wrong in (
        menus(l__bit="1.5"), menus(l__bit="99"), menus(l__delimiter="x"), menus(l__unit="weeks"), menus(s__fx_N="0"),
        menus(u__forces="volts"), menus(l__names_row="5"), menus(l__orientation="upside down"),
    ):  # fmt: skip
        with pytest.raises(Unfit):
            chosen_settings(answer, wrong)


def test_each_file_of_a_run_has_menus_of_its_own():
    answer = {
        "columns": [{"name": name} for name in ("t", "l1", "T", "f1")],
        "files": [{"file": "s.csv", "columns": ["t", "l1"], "table": 0},
                  {"file": "f.csv", "columns": ["T", "f1"], "table": 1}],
        "settings": {"filter_cutoff_Hz": 40.0, "files": [
            {"match": "s.csv", "columns": {"t_s": "t", "l1_mm": "l1"}},
            {"match": "f.csv", "columns": {"t_s": "T", "f1_N": "f1"}, "clock": {"unit": "ms"}}]},
    }  # fmt: skip
    form = {"c.f1_N@1": ["f1"], "l.unit@1": ["us"], "c.t_s@0": ["t"], "s.l1_mm@0": ["2"]}
    struts, forces = chosen_settings(answer, form)["files"]
    assert struts == {"match": "s.csv", "columns": {"t_s": "t", "l1_mm": "l1"}, "scale": {"l1_mm": 2.0}}
    assert forces["clock"] == {"unit": "us"}
    with pytest.raises(Unfit, match="not a column"):
        chosen_settings(answer, {"c.f1_N@1": ["l1"]})  # of the other file


def test_folders_of_recorded_files_are_runs(root: Path, case: Case):
    for folder, files in {
        "two": ("a.csv", "b.txt"), "bag": ("metadata.yaml", "x.db3"), "mixed": ("a.csv", "notes.md"), "empty": (),
        "incomplete-abcdefgh": ("a.csv", MARK),
    }.items():  # fmt: skip
        (root / folder).mkdir()
        for name in files:
            (root / folder / name).write_text("t_s,f1_N\n0,1\n")
    (root / "linked").symlink_to(root.parent)
    found = {recording.name: recording.arguments for recording in there(root).recordings}
    assert found == {"two": ("two/a.csv", "two/b.txt"), "bag": ("bag",)}


def test_exports_are_no_recordings(root: Path, case: Case):
    (root / "load.xml").write_text("<!--\n  made by hexcite 0.3\n-->\n<inertial/>\n")
    (root / "trace.xml").write_text("<?xml version='1.0'?>\n<trace/>\n")
    assert [recording.name for recording in there(root).recordings] == ["trace.xml"]


def test_files_of_a_run_appear_together(root: Path, client: TestClient):
    part = client.post("/runs").json()["name"]
    for name in ("day_struts.csv", "day_forces.csv", "metadata.yaml"):
        assert client.put(f"/upload/{name}?into={part}", content=b"t_s\n0\n").status_code == 200
    assert sorted(file.name for file in (root / part).iterdir() if file.name != MARK) == [
        "day_forces.csv", "day_struts.csv", "metadata.yaml"
    ]  # fmt: skip
    assert not part.startswith(".")  # seen whatever becomes of the server
    assert client.put(f"/upload/a.exe?into={part}", content=b"").status_code == 415
    assert client.put("/upload/metadata.yaml", content=b"").status_code == 415
    assert not (root / "day").exists()
    assert client.post(f"/runs/{part}").json() == {"name": "day"}
    assert sorted(file.name for file in (root / "day").iterdir()) == [
        "day_forces.csv",
        "day_struts.csv",
        "metadata.yaml",
    ]
    for stranger in ("day", "..", "incomplete-ABCDEFGH", "incomplete-abcdefgh", "incomplete-../../etc"):
        assert client.post(f"/runs/{stranger}").status_code in (404, 405)
        assert client.put(f"/upload/a.csv?into={stranger}", content=b"").status_code == 404
    assert client.post(f"/runs/{client.post('/runs').json()['name']}").status_code == 409
    assert not [*root.glob("incomplete-*")]


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
    shown = _lines(ENGLISH, "G90\nG1 X1\nG1 X2\n", answer, Program("run.mpf", "plan", 0.0))
    assert [row[0] for row in shown] == [1, 2, 3]
    assert shown[0][2] == ""
    assert "velocity (x)" in shown[1][2]
    assert "50 %" in shown[1][2]
    assert not shown[1][3]
    assert "NOT enforced" in shown[2][2]
    assert shown[2][3]
    assert all(not row[2] for row in _lines(ENGLISH, "G90\n", answer, Program("other.mpf", "plan", 0.0)))


def test_a_search_brings_the_motion_by_hand_along_once(root: Path, case: Case):
    """It is planned beside the first search, and not again while it is up to date; it is shown, never chosen."""
    plan_folder(root, case, "other")

    def started() -> Job:
        context = Context(root, machine_of(root, "+mill"), Jobs(root))
        return asked(ACTIONS["plan"], context, {"duration": ["12"], "family": ["ptp"]})

    (beside,) = started().beside
    assert beside.command[:4] == ("plan", "mill/case.toml", "--family", "manual")
    assert beside.stage == ""
    folder = root / beside.output
    folder.mkdir()
    record = json.loads((root / "other" / "plan.json").read_text())
    (folder / "plan.json").write_text(json.dumps(record | {"family": "manual"}))
    assert started().beside == ()
    chosen = chosen_plan(there(root).plans, None)
    assert chosen is not None
    assert chosen.name == "other"


def test_results_that_are_known_are_arguments_where_they_are_there(root: Path, case: Case):
    """Names that the form makes up are not passed on; poses take them too."""
    machine = machine_of(root, "+mill")
    fields = {"duration": ["12"], "known": ["a", "made-up"]}
    command = forms.plan(machine, fields, "out", ["a", "b"])
    assert [word for word in command if "known" in word] == ["--known=a"]
    assert "--known=a" in forms.plan(machine, {**fields, "family": ["poses"]}, "out", ["a"])


def test_a_program_says_how_its_run_is_recorded(root: Path, case: Case, client: TestClient):
    """The trigger's output is that of the case, the file that of the program."""
    plan_folder(root, case)
    fingerprint = there(root).plans[0].fingerprint
    (root / "run.mpf").write_text(f"; plan hash {fingerprint[:16]}\nG1 X0\n")
    page = client.get("/m/+mill/program").text
    assert "$A_OUT[1]" in page
    assert "run-recording.xml" in page
    assert "z 900.0" in page


def test_a_slow_program_is_watched_and_not_recorded(root: Path, case: Case, client: TestClient):
    plan_folder(root, case)
    mark = f"; plan hash {there(root).plans[0].fingerprint[:16]}\n"
    (root / "slow.mpf").write_text(
        f"; plan mill-plan: ptp, 12 s at speed 0.1\n{mark}; duration 150.2 s, excitation 120 s\n"
    )
    assert "slow-recording" not in client.get("/m/+mill/program").text
    (root / "run.mpf").write_text(f"; plan mill-plan: ptp, 12 s at speed 1\n{mark}; duration 55.2 s, excitation 52 s\n")
    page = client.get("/m/+mill/program?program=run.mpf").text
    assert "run-recording.xml" in page
    assert re.findall(r"about (\S+)\ss", page) == ["75"]  # and some before and after


@pytest.mark.parametrize("name", ["linuxcnc", "sinumerik", "twincat", "setpoints", "urscript", "ros2"])
def test_a_slow_program_is_told_by_the_comments_of_every_language(name: str):
    from hexcite.page.views.program import _DURATION, _is_slow
    from postprocessors.program import dialect

    machine = load_case("ur10_wrist" if name in ("urscript", "ros2") else "hexapod")
    home = machine.need_motion("a test")[0]
    for speed, slow in (("0.1", True), ("1", False)):
        header = (f"plan a: ptp, 12 s at speed {speed}", "duration 15.250 s, excitation 12.000 s")
        blocks = (ToHome(home, 0.05), Standstill(home, 0.3), Trigger(True), Standstill(home, 0.5), Trigger(False))
        text = dialect(name).write((*header, *blocks), machine).decode()
        assert _is_slow(text) is slow
        assert (found := _DURATION.search(text)) is not None
        assert found[1] == "15.250"


def test_controls_without_settings_are_named_with_the_way_to_them(root: Path, client: TestClient):
    case = load_case(str(new_case("posts", "strut_sensors", root / "posts")))
    plan_folder(root, case, "posts-plan")
    page = client.get("/m/+posts/program").text
    assert re.findall(r'name="control" value="(\w+)"', page) == ["sinumerik", "twincat"]
    assert 'href="/m/+posts/machine#t.controller"' in page
    assert 'id="t.controller"' in client.get("/m/+posts/machine").text


def test_usual_settings_of_a_control_are_added_at_a_click(root: Path):
    case = load_case(str(file := new_case("posts", "strut_sensors", root / "posts")))
    plan_folder(root, case, "posts-plan")
    machine = machine_of(root, "+posts")
    assert machine is not None
    wanted = {"plan": ["posts-plan"], "control": ["sinumerik"]}
    context = Context(root, machine, Jobs(root))
    job = ACTIONS["settings"](context, workspace(root, machine), wanted)
    assert job.command[:3] == ("case", "set", "posts/case.toml")
    subprocess.run([sys.executable, "-P", "-m", "hexcite", *job.command], cwd=root, check=True, capture_output=True)
    assert tomllib.loads(file.read_text())["controller"]["sinumerik"]["transformation"] == "TRAORI"
    assert "sinumerik" in languages_of(load_case(str(file)))
    assert workspace(root, machine).plans[0].fresh
    with pytest.raises(Unfit):
        ACTIONS["settings"](context, workspace(root, machine), {**wanted, "control": ["linuxcnc"]})  # which it has


def test_programs_of_other_plans_stay_in_sight(root: Path, case: Case, client: TestClient):
    plan_folder(root, case)
    (root / "run.mpf").write_text(f"; plan hash {there(root).plans[0].fingerprint[:16]}\n")
    later = plan_folder(root, case, "mill-plan-2") / "plan.json"
    later.write_text(json.dumps(json.loads(later.read_text()) | {"duration_s": 13.0}))
    page = client.get("/m/+mill/program?plan=mill-plan-2").text
    assert "program=run.mpf" in page
    assert "Download" not in page


def test_a_plan_that_is_being_written_is_not_shown(root: Path, case: Case):
    plan_folder(root, case, ".mill-plan.hexcite.part")
    assert not there(root).plans


def test_a_program_says_what_it_relies_on_the_controller_for():
    from hexcite.page.views.program import relied_on

    checks = {"jerk": {"ratio": 0.9, "status": "proven"}}
    assert not relied_on(ENGLISH, {"limits": checks})
    checks |= {"acceleration": {"ratio": 0.9, "status": "enforced by controller"}}
    assert len(relied_on(ENGLISH, {"limits": checks})) == 1
    beyond = {"ratio": 1.011, "status": "enforced by controller", "at": "strut acceleration (strut 1)"}
    (_, sentence) = relied_on(ENGLISH, {"limits": checks | {"strut acceleration": beyond}})
    assert "strut acceleration (strut 1) 101.1 %" in sentence


def test_a_program_for_ros_has_the_form_that_is_chosen(root: Path, client: TestClient):
    case = load_case(str(new_case("arm", "ur10_wrist", root / "arm")))
    plan_folder(root, case, "arm-plan")
    plan_folder(root, case, "arm-plan-2")
    page = client.get("/m/+arm/program").text
    assert [form in page for form in ('value=".yaml"', 'value=".json"', 'value=".py"')] == [True] * 3
    assert 'name="form"' not in client.get("/m/hexapod/program").text
    machine = machine_of(root, "+arm")
    assert machine is not None
    context = Context(root, machine, Jobs(root))
    fields = {"plan": ["arm-plan-2"], "dialect": ["ros2"], "form": [".json"]}
    assert asked(ACTIONS["program"], context, fields).command[-1] == "arm-plan-2.json"
    assert asked(ACTIONS["program"], context, fields | {"form": [".py"]}).output == "arm-plan-2.py"
    with pytest.raises(Unfit):
        asked(ACTIONS["program"], context, fields | {"form": [".exe"]})
    assert asked(ACTIONS["program"], context, fields | {"dialect": ["urscript"]}).output == "arm-plan-2.script"
    (root / "arm-plan-2.json").write_text('{"joint_names": ["a"], "points": []}')
    (root / "arm-plan-2-payload.json").write_text('{"parameters": {}}')
    found = workspace(root, machine).programs
    assert [(program.name, program.plan) for program in found] == [("arm-plan-2.json", "arm-plan-2")]


def test_a_command_that_ends_while_its_stage_is_drawn_is_still_followed(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
):
    """Else the page would say that it is over, without its answer, until somebody reloads it."""
    from hexcite.page import views

    assert client.post("/m/hexapod/do/check", data={}).status_code == 303
    original = views.stage

    def slow(context: Context, *arguments: Any) -> dict[str, Any]:
        values = original(context, *arguments)
        for _ in range(600):
            if all(job.over for job in context.jobs.of("hexapod", "machine")):
                break
            time.sleep(0.1)
        return values

    with monkeypatch.context() as patch:
        patch.setattr(views, "stage", slow)
        drawn = client.get("/m/hexapod/machine").text
    answered = "of the motion box is within reach"
    assert answered in drawn or re.search(r'data-job="\d+"(?! data-over)', drawn)
    assert answered in client.get("/m/hexapod/machine").text


@pytest.mark.repeats
def test_a_check_of_a_machine_is_shown_with_and_without_a_proposal(client: TestClient):
    for fields in ({}, {"propose": "1"}):
        assert client.post("/m/hexapod/do/check", data=fields).status_code == 303
        for _ in range(600):
            shown = client.get("/m/hexapod/machine")
            assert shown.status_code == 200
            if not re.search(r'data-job="\d+"(?! data-over)', shown.text):  # an earlier check may be shown as over
                break
            time.sleep(0.1)
        assert "of the motion box is within reach" in shown.text
    assert "x_mm = [" in shown.text


def test_a_name_as_people_write_it_becomes_one_of_a_folder(client: TestClient, root: Path):
    assert client.post("/new", data={"name": "HX-260", "like": "hexapod"}).status_code == 303
    assert "hexcite case new hx_260" in client.get("/").text


def test_the_stage_machine_is_done_when_all_values_are_the_users(client: TestClient, root: Path):
    file = new_case("mill", "hexapod", root / "mill")
    before = client.get("/m/+mill/machine").text
    assert '<li class="open">' in before.partition("</li>")[0] + "</li>"
    assert client.get("/m/+mill/do/save").headers["location"] == "/m/+mill/machine"  # of a refused form
    assert client.post("/m/+mill/do/mine", data={}).status_code == 303
    assert load_case(str(file)).template is None
    assert '<li class="done">' in client.get("/m/+mill/machine").text.partition("</li>")[0]


def test_a_run_of_another_machine_is_no_data_of_this_one(root: Path, case: Case):
    """A rehearsal counts for the machine that it is of; so does a result."""
    record = {"case_hash": case.hash, COMPUTED_FROM: {}}
    for name, of in (("theirs", "lathe"), ("ours", "mill")):
        (root / name).mkdir()
        (root / name / "recording.json").write_text(json.dumps({**record, "case": of}))
        expected = "done open" if of == "mill" else "open closed"
        assert f"{there(root).state('data')} {there(root).state('result')}" == expected


def test_a_program_in_the_place_of_a_recording_is_named_on_the_stage_data(root: Path, case: Case, client: TestClient):
    """Of this machine or of another one; a name that there is not is refused as before."""
    fingerprint = "0123456789abcdef"
    (root / "set_points.csv").write_text(f"# plan hash {fingerprint}\nt_s,l1_mm\n0,1\n")
    answer = client.post("/m/+mill/do/look", data={"recording": "set_points.csv"})
    assert answer.status_code == 303
    page = client.get(answer.headers["location"])
    assert page.status_code == 200
    (alert,) = re.findall(r'<p class="error" role="alert">([^<]*)</p>', page.text)
    assert "set_points.csv" in alert
    assert ENGLISH.say("is_program", name="set_points.csv") in html.unescape(alert)
    client.cookies.set("hexcite-language", "de")
    assert "keine Aufzeichnung" in client.get(answer.headers["location"]).text
    assert "nowhere.csv" not in client.get("/m/+mill/data?program=nowhere.csv").text.split("<main", 1)[1]
    assert client.post("/m/+mill/do/look", data={"recording": "nowhere.csv"}).status_code == 400


@dataclass
class Looked:
    """A look that is over, and nothing else under way."""

    settings: dict[str, Any]
    outputs: frozenset[str] = frozenset()
    finished: float = math.inf

    @property
    def answer(self) -> dict[str, Any]:
        """What it answered."""
        return {"settings": self.settings}

    def latest(self, *of: str) -> "Looked":
        """Itself."""
        return self


def test_a_proposal_that_is_taken_says_which_kept_units_it_changes(root: Path, case: Case):
    """The case has the file's unit then; keys that were not stated before are not listed."""
    file = root / "mill" / "case.toml"
    write_table(file, "recording", {"units": {"forces": "N"}, "filter_cutoff_Hz": 40.0})
    (root / "run.csv").write_text("t,F1\n0,1\n")
    settings = {"units": {"forces": "kN", "struts": "m"}, "columns": {"f1_N": "F1"}, "filter_cutoff_Hz": 40.0}
    machine = machine_of(root, "+mill")
    assert machine is not None
    context = Context(root, machine, Looked(settings))  # type: ignore[arg-type]
    job = asked(ACTIONS["take"], context, {"recording": ["run.csv"], "identify": ["1"]})
    assert load_case(str(file)).recording.units[Role.FORCES] == "kN"
    said = " ".join(job.notes)
    assert '"N"' in said
    assert '"kN"' in said
    assert "F1" not in said
    assert job.notes[-1] == ""  # no earlier file was kept


def planned(root: Path, case: Case, name: str, efficiency: float, seconds: float, asked: float, for_: str = "") -> None:
    """A plan that was written some seconds after the epoch, and asked for as long."""
    file = plan_folder(root, case, name) / "plan.json"
    about = {"d_efficiency": efficiency, "asked": {"duration_s": asked}, "settings": {"made_for": for_}}
    file.write_text(json.dumps(json.loads(file.read_text()) | about))
    os.utime(file, (seconds, seconds))


def test_of_equal_searches_the_best_is_chosen_and_of_others_the_newest(root: Path, case: Case, client: TestClient):
    planned(root, case, "best", 0.446, 10.0, 12.0)
    planned(root, case, "second", 0.259, 20.0, 12.0)
    planned(root, case, "longer", 0.9, 5.0, 30.0)  # not asked for alike, as the next one
    planned(root, case, "lathe", 0.8, 6.0, 12.0, "sinumerik")
    plans = there(root).plans
    assert chosen_plan(plans, None).name == "best"
    assert chosen_plan(plans, "second").name == "second"
    assert 'plan?plan=best">best</a>' in client.get("/m/+mill/plan?plan=second").text
    assert 'plan?plan=best">best</a>' not in client.get("/m/+mill/plan").text
    planned(root, case, "newest", 0.1, 40.0, 6.0)
    assert chosen_plan(there(root).plans, None).name == "newest"


def test_the_seed_of_a_search_is_a_field(root: Path, case: Case):
    machine = machine_of(root, "+mill")
    assert machine is not None
    fields = {"duration": ["12"], "effort": ["quick"]}
    command = forms.plan(machine, fields | {"seed": ["7"]}, "out")
    assert command[command.index("--seed") + 1] == "7"
    assert "--seed" not in forms.plan(machine, fields, "out")
    for typed in ("1.5", "-1", "x"):
        with pytest.raises(Unfit):
            forms.plan(machine, fields | {"seed": [typed]}, "out")


def test_each_recording_says_what_came_of_it(root: Path, case: Case, client: TestClient):
    for name in ("read.csv", "unread.csv", "refused.csv", "known.csv", "new.csv"):
        (root / name).write_text("t_s,l1_mm\n0,1\n")
    journal = Journal(root)
    answers: dict[str, tuple[str, str, dict[str, Any] | None]] = {
        "read.csv": ("look", "done", {"reads": True}),
        "unread.csv": ("look", "failed", {"reads": False}),
        "refused.csv": ("identify", "failed", None),
    }
    for number, (name, (command, state, answer)) in enumerate(answers.items(), 1):
        job = Job("+mill", "data", (command, name), about=name, number=number, state=state)  # type: ignore[arg-type]
        job.ended, job.finished, job.answer = job.began, 1.0, answer
        journal.write(f"{number}-1-1", job.record)
    (root / "known").mkdir()
    record = {"case": case.name, "case_hash": case.hash, COMPUTED_FROM: result_basis(case), "recording": "known.csv"}
    (root / "known" / "result.json").write_text(json.dumps(record))
    context = Context(root, machine_of(root, "+mill"), Jobs(root))  # type: ignore[arg-type]
    view = data_view(context, there(root), {})
    come_to = {"read.csv": "read", "unread.csv": "unread", "refused.csv": "refused", "known.csv": "identified"}
    assert view["come_to"] == come_to
    page = client.get("/m/+mill/data").text
    assert ENGLISH.say("recording_identified") in page


def test_only_programs_for_linuxcnc_are_rehearsed_on_it(root: Path, case: Case):
    fingerprint = there(root).plans[0].fingerprint if plan_folder(root, case) else ""
    for suffix in (".mpf", ".ngc"):
        (root / f"run{suffix}").write_text(f"; plan hash {fingerprint[:16]}\nG1 X0\n")
    context = Context(root, machine_of(root, "+mill"), Looked({}))  # type: ignore[arg-type]
    with pytest.raises(Unfit, match="LinuxCNC"):
        asked(ACTIONS["rehearse"], context, {"program": ["run.mpf"], "on": ["linuxcnc"]})
    job = asked(ACTIONS["rehearse"], context, {"program": ["run.ngc"], "on": ["linuxcnc"]})
    assert "linuxcnc" in job.command


def test_a_refused_export_names_no_way_that_the_page_does_not_have():
    problem = FileProblem(
        place="res",
        problem="is old",
        remedy=enumerated(
            "comma_or", ["identify", "restore", phrase(AT_OWN_RISK, "use {stale}", stale=option("stale"))]
        ),
        code=Code.STALE,
    ).without(AT_OWN_RISK)
    job = Job("+mill", "use", ("export", "res"), state="failed")
    job.messages, job.refused = [problem.typed], problem.to_json()
    for language in LANGUAGES:
        assert "--stale" not in str(job_view(job, language))
        assert "restore" in str(job_view(job, language))


def test_a_look_holds_where_the_case_states_what_it_proposed(root: Path, case: Case):
    file = root / "mill" / "case.toml"
    settings = {"columns": {"f1_N": "F1"}, "filter_cutoff_Hz": 40.0}
    looked = Looked(settings, finished=0.0)  # before the file was written

    def held() -> Mapping[str, Any] | None:
        return looked_at(Context(root, machine_of(root, "+mill"), looked), "run.csv")  # type: ignore[arg-type]

    assert held() is None
    write_table(file, "recording", settings)
    answer = held()
    assert answer is not None
    assert answer["unchanged"]
    write_table(file, "recording", {"columns": {"f1_N": "G1"}, "filter_cutoff_Hz": 40.0})
    assert held() is None


def test_examples_say_where_their_sensors_are_and_machines_can_be_copied(client: TestClient, root: Path):
    new_case("mill", "hexapod", root / "mill")
    shown = client.get("/").text
    for name in built_in_cases():
        assert f'type="radio" name="like" value="{name}"' in shown
    assert {text(f"sensors_{setup}", "en") in shown for setup in ("1a", "1b", "2x", "R")} == {True}
    assert 'value="+mill"' in shown
    assert client.post("/new", data={"name": "mill_2", "like": "+mill"}).status_code == 303
    assert "hexcite case new mill_2 --like mill/case.toml" in client.get("/").text
    assert client.post("/new", data={"name": "mill_2", "like": "+other"}).status_code == 400


def test_a_doubt_links_to_its_field_and_proposes_a_value(client: TestClient, root: Path):
    file = new_case("mill", "hexapod", root / "mill")
    file.write_text(file.read_text().replace("strut_velocity_m_s = ", "strut_velocity_m_s = 700.0 # "))
    shown = client.get("/m/+mill/machine").text
    remarks = shown.partition('id="remarks"')[2].partition('<div class="beside">')[0]
    assert 'href="#v.limits.motion.strut_velocity_m_s"' in remarks
    (take,) = re.findall(r'data-take="([^"]*)"', remarks)
    assert json.loads(html.unescape(take)) == {"limits.motion.strut_velocity_m_s": "0.7"}
    assert 'id="v.limits.motion.strut_velocity_m_s"' in shown
    assert "data-take" not in client.get("/m/hexapod/machine").text


def test_what_was_refused_before_the_machine_was_changed_is_folded(client: TestClient, root: Path):
    file = new_case("mill", "hexapod", root / "mill")
    file.write_text(file.read_text().replace('setup = "1b"', 'setup = "4"'))
    client.post("/m/+mill/do/check", data={})
    for _ in range(600):
        shown = client.get("/m/+mill/machine").text
        if "data-over" in shown:
            break
        time.sleep(0.1)
    assert 'class="old"' not in shown
    assert 'class="line failed"' in shown
    file.write_text(file.read_text().replace('setup = "4"', 'setup = "1b"'))
    assert 'class="old"' in client.get("/m/+mill/machine").text
