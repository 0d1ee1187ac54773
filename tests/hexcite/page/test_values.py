"""Values of a case are changed by a form, one by one, and everything else of the file stays."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from starlette.testclient import TestClient

from cases.readiness import readiness
from cases.scaffold import new_case
from cases.schema import load_case
from hexcite._new_arm import new_arm
from hexcite.page import values
from hexcite.page.joint_table import cut_out, spread
from hexcite.page.refusals import Refused, RefusedFields
from hexcite.page.values import digest, edited, sections
from hexcite.page.words import ENGLISH


@pytest.fixture
def file(root: Path) -> Path:
    return new_case("mill", "hexapod", root / "mill")


RADIUS = "machine.base.ring.radius_mm"


def form(file: Path, **given: str) -> dict[str, str]:
    return {"digest": digest(file.read_text()), **{f"v.{name}": value for name, value in given.items()}}


def test_every_value_of_a_case_has_a_field_that_reads_back(file: Path):
    content = file.read_text()
    entries = [entry for section in sections(content, load_case(str(file))) for entry in section.entries]
    assert {entry.name for entry in entries} >= {RADIUS, "limits.motion.x_mm", "machine.home.z_mm"}
    assert edited(content, {f"v.{entry.name}": entry.text for entry in entries}).text == content
    assert sum(bool(entry.words) for entry in entries) > len(entries) / 2
    assert all(entry.mark == "example" for entry in entries if entry.name.startswith("machine"))


@pytest.mark.parametrize("typed", ["701.5", "701,5", " 701.5 "])
def test_a_value_is_changed_and_comments_stay(file: Path, typed: str):
    content = file.read_text()
    after = edited(content, {f"v.{RADIUS}": typed}).text
    assert tomllib.loads(after)["machine"]["base"]["ring"]["radius_mm"] == 701.5
    comments = [line for line in content.splitlines() if line.startswith("#")]
    assert [line for line in after.splitlines() if line.startswith("#")] == comments


@pytest.mark.parametrize(
    ("name", "typed", "words"),
    [
        (RADIUS, "wide", "not a number"),
        (RADIUS, "true", "not a number"),
        (RADIUS, "1\nname = 'other'", "not a number"),
        ("limits.motion.x_mm", "3", "not a list"),
        ("name", "other", "no such value"),
        ("machine.base.ring.colour", "1", "no such value"),
    ],
)
def test_what_is_no_value_of_the_kind_is_refused(file: Path, name: str, typed: str, words: str):
    with pytest.raises(Refused, match=words):
        edited(file.read_text(), {f"v.{name}": typed})


def test_saving_writes_what_can_be_and_nothing_else(client: TestClient, file: Path):
    before = file.read_text()
    answer = client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "710"}))
    assert answer.headers["location"] == "/m/+mill/machine?saved=1"
    assert load_case(str(file)).hash != ""
    assert tomllib.loads(file.read_text())["machine"]["base"]["ring"]["radius_mm"] == 710.0
    impossible = client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "-5"}))
    assert impossible.status_code == 409
    assert "radius_mm" in impossible.text
    assert 'value="-5"' in impossible.text  # what was typed is not lost
    assert file.read_text() != before
    assert tomllib.loads(file.read_text())["machine"]["base"]["ring"]["radius_mm"] == 710.0


def test_a_second_window_does_not_overwrite_the_first(client: TestClient, file: Path):
    old = form(file, **{RADIUS: "720"})
    client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "710"}))
    answer = client.post("/m/+mill/do/save", data=old)
    assert answer.status_code == 409
    assert tomllib.loads(file.read_text())["machine"]["base"]["ring"]["radius_mm"] == 710.0


def test_a_built_in_case_stays(client: TestClient):
    assert client.post("/m/hexapod/do/save", data={"digest": "", f"v.{RADIUS}": "1"}).status_code == 400


def test_the_drawing_follows_what_is_typed(client: TestClient, file: Path):
    before = client.post("/m/+mill/do/preview", data=form(file)).text
    after = client.post("/m/+mill/do/preview", data=form(file, **{"machine.home.z_mm": "950"})).text
    assert before.count("<svg") == after.count("<svg") == 2
    assert "1038.91" in before  # length of the struts at home, by hand: sqrt(dx^2 + dy^2 + 900^2)
    assert "1038.91" not in after
    wrong = client.post("/m/+mill/do/preview", data=form(file, **{"machine.home.z_mm": "up"}))
    assert wrong.status_code == 200
    assert "not a number" in wrong.text
    assert values.digest(file.read_text()) == form(file)["digest"]


HALF = "machine.base.ring.half_angle_deg"


def test_a_drawing_in_other_units_and_angles_is_the_same_machine(file: Path):
    drawn = {
        f"v.{RADIUS}": "0,7", f"u.{RADIUS}": "radius_mm:m",
        f"v.{HALF}": "24", f"u.{HALF}": "included_angle_deg:deg",
        "v.limits.motion.angular_acceleration_rad_s2": "[540.0, 540.0, 540.0]",
        "u.limits.motion.angular_acceleration_rad_s2": "angular_acceleration_deg_s2:deg/s²",
        "v.limits.motion.acceleration_m_s2": "[6000, 6000, 6000]",
        "u.limits.motion.acceleration_m_s2": "acceleration_m_s2:mm/s²",
    }  # fmt: skip
    written = edited(file.read_text(), drawn)
    before, after = load_case(str(file)), values.case_of(written.text, file)
    assert before.hexapod is not None
    assert after.hexapod is not None
    assert np.allclose(after.hexapod.base.points, before.hexapod.base.points, atol=1e-12)
    ring = tomllib.loads(written.text)["machine"]["base"]["ring"]
    assert ring["included_angle_deg"] == 24.0
    assert "half_angle_deg" not in ring
    motion = tomllib.loads(written.text)["limits"]["motion"]
    assert motion["acceleration_m_s2"] == [6.0, 6.0, 6.0]
    assert motion["angular_acceleration_deg_s2"] == [540.0, 540.0, 540.0]
    assert "angular_acceleration_rad_s2" not in motion
    assert len(written.converted) == 4
    assert any("radius_mm = 700.0" in words and "0,7 m" in words for words in written.converted)


def test_what_stands_there_as_a_comment_is_switched_on_where_it_stands(file: Path):
    content = file.read_text()
    offered = {entry.name: entry for section in sections(content, load_case(str(file))) for entry in section.more}
    typed = {f"w.{name}": entry.text for name, entry in offered.items() if name.startswith("tolerances.")}
    one = edited(content, {**typed, "on.tolerances.joints_mm": "1"}).text
    assert tomllib.loads(one)["tolerances"] == {"joints_mm": 0.03}
    assert "# joints_mm" not in one
    assert "# bars_mm" in one
    whole = edited(content, {**typed, "on.tolerances": "1"}).text
    assert values.case_of(whole, file).tolerances is not None
    assert len(tomllib.loads(whole)["tolerances"]) == sum(bool(text) for text in typed.values()) > 4
    assert edited(content, typed).text == content  # nothing is switched on by itself
    with pytest.raises(Refused, match="no such value"):
        edited(content, {"w.tolerances.colour": "1", "on.tolerances.colour": "1"})


@pytest.mark.parametrize("control", ["sinumerik", "twincat"])
def test_a_control_that_the_example_does_not_have_is_switched_on(root: Path, control: str):
    file = new_case("mine", "strut_sensors", root / "mine")
    content = file.read_text()
    case = load_case(str(file))
    assert readiness(case)[f"post --dialect {control}"]
    typed = {f"w.{entry.name}": entry.text for section in sections(content, case) for entry in section.more}
    with_it = values.case_of(edited(content, {**typed, f"on.controller.{control}": "1"}).text, file)
    assert not readiness(with_it)[f"post --dialect {control}"]


def test_controls_of_other_machines_are_not_offered(root: Path):
    file = new_case("mine", "five_axis_table", root / "mine")
    offered = [entry.name for each in sections(file.read_text(), load_case(str(file))) for entry in each.more]
    assert not [name for name in offered if name.startswith("controller.urscript")]


def test_an_implausible_value_is_marked_beside_its_field(client: TestClient, file: Path):
    def marks() -> dict[str, bool]:
        content = file.read_text()
        found = [entry for section in sections(content, load_case(str(file))) for entry in section.entries]
        return {entry.name: bool(entry.doubts) for entry in found}

    assert not any(marks().values())
    client.post("/m/+mill/do/save", data=form(file, **{"recording.filter_cutoff_Hz": "40", "nominal.mass_kg": "33000"}))
    assert marks()["nominal.mass_kg"]
    assert not marks()[RADIUS]
    assert "mark doubtful" in client.get("/m/+mill/machine").text


ARM = """<robot name="two">
<link name="a"/><link name="b"/><link name="tool0"/>
<joint name="first" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="2" effort="100"/></joint>
<joint name="second" type="revolute"><parent link="b"/><child link="tool0"/><axis xyz="0 1 0"/>
<origin xyz="0 0 0.4"/><limit lower="-2" upper="2" velocity="3" effort="50"/></joint>
</robot>"""


def test_an_arm_is_completed_by_switching_on(client: TestClient, root: Path):
    (root / "two.urdf").write_text(ARM)
    file = new_arm("arm", root / "two.urdf", "tool0", root / "arm")
    content = file.read_text()
    found = sections(content, None)
    needed = {entry.name for section in found for entry in section.more if entry.needed}
    assert "sensor_frame.transducer.sense" in needed
    fields = {"digest": digest(content)}
    for entry in (entry for section in found for entry in section.more):
        fields[f"w.{entry.name}"] = entry.text or (entry.choices[0] if entry.choices else "")
        wanted = entry.name.rpartition(".")[2].startswith(("home_", "sense", "force_noise", "moment_noise"))
        wanted = wanted and not entry.name.startswith("simulation")
        if wanted or entry.name.startswith(("limits.motion", "nominal.")):
            fields[f"on.{entry.name}"] = "1"
    answer = client.post("/m/+arm/do/save", data=fields)
    assert answer.status_code == 303, answer.text
    case = load_case(str(file))
    assert case.chain is not None
    assert case.limits is not None
    assert readiness(case)["plan"] == ()
    assert case.limits.motion.rate == pytest.approx([2.0, 3.0])  # what the URDF says, which stood there as comments
    assert "# home_deg" not in file.read_text()
    marks = {entry.name: entry.mark for section in sections(file.read_text(), case) for entry in section.entries}
    assert marks["limits.motion.joints[0].jerk_rad_s3"] == "typical"
    assert client.get("/m/+arm/machine").status_code == 200


def test_a_proposed_box_is_written(file: Path):
    values.write_motion_box(file, {"x_mm": [-100, 120]})
    assert load_case(str(file)).limits.motion.x_mm == (-100.0, 120.0)
    with pytest.raises(Refused):
        values.write_motion_box(file, {"x_mm": [50, 120]})  # home is not in it


def test_an_arm_is_completed_in_one_table(client: TestClient, root: Path):
    """One value typed states all of the table; units and values of all joints at once."""
    (root / "two.urdf").write_text(ARM)
    file = new_arm("arm", root / "two.urdf", "tool0", root / "arm")
    table, others = cut_out(sections(file.read_text(), None))
    assert table is not None
    assert [row.name for row in table.rows] == ["first", "second"]
    assert table.missing == 10
    assert not any("home" in entry.name for section in others for entry in section.more)
    page = client.get("/m/+arm/machine").text
    names = re.findall(r'name="([vw][.][^"]+)"', page)
    assert len(names) == len({*names})  # each value has one field
    fields = {"digest": digest(file.read_text()), "on.joints": "1", "u.joints.velocity": "velocity_deg_s:rad/s"}
    for row in table.rows:
        assert row.hidden is not None
        fields[f"w.{row.hidden.entry.name}"] = row.name
        for column, cell in row.cells.items():
            fields[f"w.{cell.entry.name}"] = "1.5" if column == "velocity" else cell.entry.text
    answer = client.post("/m/+arm/do/save", data=fields)
    assert answer.status_code == 303, answer.text
    assert "2+x+limits.motion.joints" in answer.headers["location"].replace("%20", "+")
    case = load_case(str(file))
    assert case.limits is not None
    assert case.limits.motion.rate == pytest.approx([1.5, 1.5])
    table, _ = cut_out(sections(file.read_text(), case))
    assert table is not None
    assert table.missing == 0
    page = client.get("/m/+arm/machine").text
    assert 'name="on.joints"' not in page
    assert case.chain is not None
    assert [joint.home_deg for joint in case.chain.joints] == [0.0, 0.0]


def test_what_is_not_stated_of_joints_stays_so_until_it_is_switched_on(root: Path):
    (root / "two.urdf").write_text(ARM)
    content = new_arm("arm", root / "two.urdf", "tool0", root / "arm").read_text()
    table, _ = cut_out(sections(content, None))
    assert table is not None
    proposed = {f"w.{cell.entry.name}": cell.entry.text for row in table.rows for cell in row.cells.values()}
    assert edited(content, spread(proposed)).text == content


def test_the_simulated_body_that_is_proposed_is_the_nominal_one(root: Path):
    (root / "two.urdf").write_text(ARM)
    content = new_arm("arm", root / "two.urdf", "tool0", root / "arm").read_text()
    body = (
        "mass_kg = 1.25\ncentre_of_gravity_mm = [1.0, 2.0, 30.0]\ninertia_kg_m2 = [0.01, 0.0, 0.0, 0.01, 0.0, 0.01]\n"
    )
    entries = [entry for section in sections(f"{content}\n[nominal]\n{body}", None) for entry in section.more]
    proposed = {entry.name: entry.text for entry in entries}
    assert proposed["simulation.parameters.body.mass_kg"] == "1.25"
    assert proposed["simulation.parameters.body.centre_of_gravity_mm"] == "[1.0, 2.0, 30.0]"


CENTRES = "machine.base.ring.pair_centres_deg"


@pytest.mark.parametrize(
    "typed",
    ["0, 120, 240", "0 120 240", "0; 120; 240", "0,120,240", "[0, 120, 240]", "0,0; 120,0; 240,0", " 0 ,  120 , 240"],
)
def test_a_list_is_read_as_people_write_it(file: Path, typed: str):
    after = tomllib.loads(edited(file.read_text(), {f"v.{CENTRES}": typed}).text)
    assert after["machine"]["base"]["ring"]["pair_centres_deg"] == [0, 120, 240]


X, FASTEST = "limits.motion.x_mm", "limits.motion.velocity_mm_s"


@pytest.mark.parametrize(
    ("name", "typed", "meant"),
    [
        (X, "±60", [-60, 60]), (X, "+-60,5", [-60.5, 60.5]), (X, "+/-60", [-60, 60]), (X, "-40 .. 60", [-40, 60]),
        (FASTEST, "200", [200, 200, 200]), (FASTEST, "0,5", [0.5, 0.5, 0.5]),
    ],
)  # fmt: skip
def test_limits_are_read_as_drawings_have_them_and_shown_as_they_are_written(
    file: Path, name: str, typed: str, meant: list[float]
):
    written = edited(file.read_text(), {f"v.{name}": typed})
    assert tomllib.loads(written.text)["limits"]["motion"][name.rpartition(".")[2]] == meant
    assert len(written.converted) == 1


def test_what_is_written_as_it_was_typed_is_not_shown_again(file: Path):
    assert edited(file.read_text(), {f"v.{X}": "-60, 60", f"v.{FASTEST}": "200 300 400"}).converted == ()


@pytest.mark.parametrize(
    ("name", "typed"),
    [
        (CENTRES, "0,5, 120,5"), (CENTRES, "0,5 120,5 240,5"), (CENTRES, "0,5,120,5,240,5"), (CENTRES, "0"),
        (CENTRES, "0; 1.200,5; 240"), (CENTRES, ""), ("limits.motion.x_mm", "0,80"),
        ("limits.motion.x_mm", "-80 to 80"),
    ],
)  # fmt: skip
def test_a_list_that_may_be_read_in_two_ways_is_refused_with_the_way_to_write_it(file: Path, name: str, typed: str):
    with pytest.raises(Refused, match="0,5; 120,5; 240,5"):
        edited(file.read_text(), {f"v.{name}": typed})


def test_all_refused_fields_are_marked_with_their_reason_and_led_to(client: TestClient, file: Path):
    wrong = {RADIUS: "wide", CENTRES: "0, hundred"}
    whole = client.post("/m/+mill/do/save", data=form(file, **wrong, **{"machine.home.z_mm": "950"}))
    impossible = client.post("/m/+mill/do/save", data=form(file, **{RADIUS: "-5", CENTRES: "0, 120"}))
    for answer in (whole, impossible):
        assert answer.status_code == 409
        for name in wrong:
            field = re.search(rf'<input id="v\.{re.escape(name)}"[^>]*>', answer.text)
            assert field is not None
            assert 'aria-invalid="true"' in field[0]
            assert f'aria-describedby="e.v.{name}"' in field[0]
            assert f'id="e.v.{name}"' in answer.text
            assert f'href="#v.{name}"' in answer.text
        assert answer.text.count('aria-invalid="true"') == 2
        assert answer.text.count("<svg") >= 2  # the drawings stay
    assert tomllib.loads(file.read_text())["machine"]["home"]["z_mm"] != 950.0  # all or nothing


def test_a_preview_says_what_is_refused_and_draws_the_rest(client: TestClient, file: Path):
    typed = form(file, **{RADIUS: "wide", "machine.home.z_mm": "950"})
    answer = client.post("/m/+mill/do/preview", data=typed).text
    refused = re.search(r'<script type="application/json" id="refused">(.*?)</script>', answer)
    assert refused is not None
    assert set(json.loads(refused[1])) == {f"v.{RADIUS}"}
    assert answer.count("<svg") == 2
    assert "1038.91" not in answer  # home is that which was typed


def test_limits_of_all_joints_are_refused_at_the_joint_that_they_do_not_fit(client: TestClient, root: Path):
    (root / "two.urdf").write_text(ARM)
    file = new_arm("arm", root / "two.urdf", "tool0", root / "arm")
    content = file.read_text()
    form = {"digest": digest(content), "on.joints": "1"}
    for k, home in enumerate((100.0, 0.0)):
        form[f"w.machine.chain.joints[{k}].home_deg"] = str(home)
        entries = {"name": ("first", "second")[k], "position_deg": "-30, 30", "velocity_deg_s": "60"}
        entries |= {"acceleration_rad_s2": "5", "jerk_rad_s3": "50"}
        form |= {f"w.limits.motion.joints[{k}].{key}": text for key, text in entries.items()}
    answer = client.post("/m/+arm/do/save", data=form)
    assert answer.status_code == 409
    assert 'id="e.w.limits.motion.joints[0].position_deg"' in answer.text
    assert 'id="e.w.limits.motion.joints[1]' not in answer.text
    assert file.read_text() == content
    form["w.machine.chain.joints[0].home_deg"] = "20"
    assert client.post("/m/+arm/do/save", data=form).status_code == 303


def test_only_keys_of_tables_that_are_there_or_that_a_plan_needs_are_needed(client: TestClient, root: Path):
    (root / "two.urdf").write_text(ARM)
    file = new_arm("arm", root / "two.urdf", "tool0", root / "arm")
    found = sections(file.read_text(), load_case(str(file)))
    needed = {entry.name for section in found for entry in section.more if entry.needed}
    assert "nominal.mass_kg" in needed
    assert not {name for name in needed if name.startswith(("simulation", "payloads", "controller.", "tolerances"))}
    assert "open" in client.get("/m/+arm/machine").text.partition("</li>")[0]  # the stage asks for these


@pytest.mark.parametrize(
    ("machine", "typed", "field"),
    [
        ("hexapod", {"workspace.x_mm": "-1, 1"}, "limits.motion.x_mm"),
        ("hexapod", {"controller.safe_feed_mm_min": "1e9"}, "controller.safe_feed_mm_min"),
        ("hexapod", {"nominal.inertia_kg_m2": "1, 0, 0, 1, 0, 9"}, "nominal.inertia_kg_m2"),
        ("hexapod", {"payloads.weights[1].inertia_kg_m2": "1, 0, 0, 1, 0, 9"}, "payloads.weights[1].inertia_kg_m2"),
        ("hexapod", {"limits.motion.a_deg": "5, 9"}, "limits.motion.a_deg"),
        ("hexapod", {"machine.base.ring.radius_mm": "0.7"}, "machine.base.ring.radius_mm"),
        ("hexapod", {CENTRES: "0, -900, 1e30"}, CENTRES),
        ("ur10_wrist", {"machine.chain.joints[2].home_deg": "700"}, "machine.chain.joints[2].home_deg"),
        ("ur10_wrist", {"limits.motion.joints[4].position_deg": "-700, 700"}, "limits.motion.joints[4].position_deg"),
        ("ur10_wrist", {"limits.motion.joints[3].position_deg": "5, 9"}, "limits.motion.joints[3].position_deg"),
    ],
)
def test_what_a_table_or_a_case_refuses_is_refused_at_the_value(
    root: Path, machine: str, typed: dict[str, str], field: str
):
    """Rules of whole tables too: they know their keys, whatever their sentences say."""
    file = new_case("other", machine, root / "other")
    written = edited(file.read_text(), {f"v.{name}": text for name, text in typed.items()})
    with pytest.raises(RefusedFields) as caught:
        values.case_of(written.text, file)
    assert f"v.{field}" in caught.value.fields
    assert not str(ENGLISH.refused_fields(caught.value.fields)[f"v.{field}"]).startswith(f"{field}: ")


def test_joints_of_one_mistake_are_refused_at_the_first_of_them(root: Path):
    """The case says them in one sentence, with their names."""
    file = new_case("other", "ur10_wrist", root / "other")
    names = [f"limits.motion.joints[{k}].position_deg" for k in (1, 3)]
    written = edited(file.read_text(), {f"v.{name}": "5, 9" for name in names})
    with pytest.raises(RefusedFields) as caught:
        values.case_of(written.text, file)
    assert [*caught.value.fields] == [f"v.{names[0]}"]
