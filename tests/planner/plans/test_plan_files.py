"""A plan folder: what is written is what was planned, and what is damaged is not used."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.plans.plan import Plan
from tests.hexcite.command_line import ACCEPT, call, refused
from tests.hexcite.json_answer import one_json_object


@pytest.fixture
def copy(saved_plan: Plan, tmp_path: Path) -> Path:
    return Path(shutil.copytree(saved_plan.folder, tmp_path / "plan"))


def test_plan_json_is_the_answer_of_the_command(saved_plan: Plan, planned: dict[str, Any]):
    content = one_json_object((saved_plan.folder / "plan.json").read_text(encoding="utf-8"))
    paths = {"plan": str(saved_plan.folder), "report": str(saved_plan.folder / "report.html")}
    assert paths | content == {key: value for key, value in planned.items() if key != "identifiability"}
    assert planned["identifiability"]["model"] == content["model"]


def test_motion_csv_is_the_motion_in_millimetres_and_degrees_a_thousand_times_a_second(saved_plan: Plan):
    file = saved_plan.folder / "motion.csv"
    assert file.read_text().splitlines()[0] == (
        "t_s,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg,v_x_mm_s,v_y_mm_s,v_z_mm_s,v_a_deg_s,v_b_deg_s,v_c_deg_s,"
        "acc_x_mm_s2,acc_y_mm_s2,acc_z_mm_s2,acc_a_deg_s2,acc_b_deg_s2,acc_c_deg_s2"
    )
    table = np.loadtxt(file, delimiter=",", skiprows=1)
    assert table[:, 0] == pytest.approx(np.arange(round(1000 * saved_plan.motion.duration) + 1) / 1000, abs=1e-8)
    motion = saved_plan.motion.at(table[:, 0])
    assert table[:, 1:4] == pytest.approx(motion.coordinates[:, :3] * 1000, abs=1e-5)
    assert table[:, 4:7] == pytest.approx(np.degrees(motion.coordinates[:, 3:]), abs=1e-6)
    assert table[:, 7:10] == pytest.approx(motion.rates[:, :3] * 1000, abs=1e-4)
    assert table[:, 10:13] == pytest.approx(np.degrees(motion.rates[:, 3:]), abs=1e-4)
    assert table[:, 13:16] == pytest.approx(motion.accelerations[:, :3] * 1000, abs=1e-3)
    assert table[:, 16:] == pytest.approx(np.degrees(motion.accelerations[:, 3:]), abs=1e-3)


def rewrite(folder: Path, *path: str, **value: Any) -> None:
    """Changes or, without a value, removes an entry of plan.json."""
    data = json.loads((folder / "plan.json").read_text())
    *tables, key = path
    table = data
    for name in tables:
        table = table[name]
    if value:
        table[key] = value["to"]
    else:
        del table[key]
    (folder / "plan.json").write_text(json.dumps(data))


@pytest.mark.parametrize("key", ["case_file", "case_hash", "fourier", "family", "model", "notes", "weaknesses"])
def test_a_plan_without_an_entry_that_is_needed_is_refused(key: str, copy: Path):
    rewrite(copy, key)
    line = refused("post", copy, "-o", copy.parent / "p.ngc", "--json")
    assert str(copy / "plan.json") in line
    assert key in line
    assert "plan again" in line


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("fourier", "period_s"), 0.0),
        (("fourier", "period_s"), -3.0),
        (("fourier", "period_s"), float("nan")),
        (("fourier", "period_s"), "three"),
        (("fourier", "repeats"), 0),
        (("fourier", "repeats"), -1),
        (("fourier", "repeats"), 2.5),
        (("fourier", "repeats"), 1e9),
        (("fourier",), None),
        (("fourier", "centre_m_rad"), [0.0, 0.9]),
        (("fourier", "a_m_s_rad_s"), [[1.0]]),
        (("fourier", "b_m_s_rad_s"), "x"),
        (("fourier", "a_m_s_rad_s"), []),
        (("fourier", "centre_m_rad"), [float("nan")] * 6),
        (("limits", "strut length", "bounds"), [0.4]),
        (("bound",), 3),
        (("bound", "logdet"), None),
        (("bound", "dmax"), "x"),
        (("model",), 1e999),
        (("model",), None),
        (("model",), 6.0),
        (("payload",), None),
        (("payload",), "0"),
        (("payload_from",), "abc"),
        (("settings",), None),
        (("settings",), {"without": "jerk"}),
        (("settings", "order"), "five"),
        (("settings", "period_s"), None),
        (("settings", "without"), "velocity"),
        (("settings", "of_nothing"), 1.0),
        (("predicted_std", "xC"), None),
        (("predicted_std", "xC"), "abc"),
    ],
)
def test_a_plan_with_a_damaged_entry_is_refused(path: tuple[str, ...], value: Any, copy: Path):
    rewrite(copy, *path, to=value)
    line = refused("post", copy, "-o", copy.parent / "p.ngc", "--json")
    assert str(copy / "plan.json") in line
    told_by_the_motion = path[0] in ("fourier", "limits")
    assert told_by_the_motion or any(word in line for word in (".".join(path), "entry settings is", "JSON"))
    assert not (copy.parent / "p.ngc").exists()


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "3", '"plan"', "{}", "\x00\x01"])
def test_a_file_that_is_no_plan_is_refused(text: str, copy: Path):
    (copy / "plan.json").write_text(text)
    assert str(copy / "plan.json") in refused("post", copy, "--json")


def test_a_faster_motion_that_somebody_typed_into_the_plan_is_not_written(copy: Path):
    data = json.loads((copy / "plan.json").read_text())
    rewrite(copy, "fourier", "a_m_s_rad_s", to=(1.2 * np.array(data["fourier"]["a_m_s_rad_s"])).tolist())
    line = refused("post", copy, "-o", copy.parent / "p.ngc", "--json")
    assert "changed by hand" in line
    assert not (copy.parent / "p.ngc").exists()


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("duration_s",), 8.0),
        (("duration_s",), "12"),
        (("duration_s",), True),
        (("logdet",), 3.0),
        (("condition",), 1.0),
        (("criterion_value",), 1e9),
        (("criterion",), "E"),
        (("d_efficiency",), 0.9),
        (("bound",), None),
        (("bound", "logdet"), 0.0),
        (("predicted_std", "m"), 1e-9),
        (("predicted_std",), {}),
        (("predicted_std",), 3),
        (("payload",), 5),
        (("payload",), 99),
        (("model",), 8),
        (("model",), 42),
        (("model",), "9"),
        (("family",), "chirp"),
        (("family",), 3),
        (("assumed_noise_N",), 1e-6),
    ],
)
def test_figures_that_somebody_typed_into_a_plan_are_not_believed(path: tuple[str, ...], value: Any, copy: Path):
    """Who shortens the duration or the deviations by hand is told so."""
    rewrite(copy, *path, to=value)
    line = refused("post", copy, "-o", copy.parent / "p.ngc", "--json")
    assert line.startswith(f"hexcite: {copy / 'plan.json'}: ")
    assert line.endswith("; plan again")
    assert not (copy.parent / "p.ngc").exists()


def test_a_plan_whose_fingerprint_was_taken_out_is_refused(copy: Path):
    rewrite(copy, "predicted_std", "m", to=1e-9)
    rewrite(copy, "content")
    assert "was changed by hand" in refused("post", copy, "-o", copy.parent / "p.ngc", "--json")


@pytest.mark.parametrize(("path", "entry"), [(("predicted_std", "m"), "predicted_std"), (("limits",), "limits")])
def test_a_plan_without_a_fingerprint_is_complete(path: tuple[str, ...], entry: str, copy: Path):
    rewrite(copy, "content")
    rewrite(copy, *path, **({"to": {}} if entry == "limits" else {}))
    assert f"{entry}' is missing or damaged; plan again" in refused("post", copy, "-o", copy.parent / "p.ngc", "--json")


def count_of_blocks(program: Path) -> int:
    return sum(1 for line in program.read_text().splitlines() if line.startswith("G1"))


def test_a_plan_whose_case_was_edited_since_is_refused(copy: Path, hexapod_file: Path):
    """Another limit is another plan; another comment or another setting of the controller's programs is not."""
    rewrite(copy, "case_file", to=str(hexapod_file))
    hexapod_file.write_text(hexapod_file.read_text() + "\n# a comment\n")
    call("post", copy, *ACCEPT, "-o", copy.parent / "p.ngc", "--json").json()
    hexapod_file.write_text(hexapod_file.read_text().replace("block_ms = 10.0", "block_ms = 12.0"))
    longer = call("post", copy, *ACCEPT, "-o", copy.parent / "longer.ngc", "--json").json()
    assert longer["blocks"] < count_of_blocks(copy.parent / "p.ngc")
    edited = hexapod_file.read_text().replace("velocity_mm_s = [600.0", "velocity_mm_s = [500.0")
    hexapod_file.write_text(edited)
    line = refused("post", copy, "-o", copy.parent / "stale.ngc", "--json")
    assert str(hexapod_file) in line
    assert "limits.motion.velocity_mm_s was [600.0, 600.0, 600.0], is [500.0" in line
    assert "--stale" in line
    hexapod_file.write_text(edited.replace("[500.0", "[600.0").replace("range_N = 5000.0", "range_N = 6000.0"))
    call("post", copy, *ACCEPT, "-o", copy.parent / "stale.ngc", "--stale", "--json").json()
    assert "sensors.range_N was 5000, is 6000" in (copy.parent / "stale.ngc").read_text()
    call("retime", copy, "-o", copy.parent / "retimed", "--stale", "--json").json()
    (remark,) = Plan.load(copy.parent / "retimed").stale  # it stays with what is made of it
    assert "sensors.range_N was 5000, is 6000" in remark
    hexapod_file.unlink()
    assert "no such case" in refused("post", copy, "-o", copy.parent / "gone.ngc", "--json")
