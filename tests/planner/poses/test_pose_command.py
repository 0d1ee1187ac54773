"""`hexcite poses`, and the way of its plan through post, run and identify, as a user goes it."""

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.tables import built_in_cases
from identification.motion.motion import Standstill
from planner.plans.plan import Plan
from tests.helpers import tells
from tests.hexcite.command_line import call, refused

FEW = "8"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("poses")


@pytest.fixture(scope="module")
def quick(folder: Path) -> Path:
    """The hexapod, measuring for a tenth of the time at each pose."""
    text = built_in_cases()["hexapod"].read_text(encoding="utf-8")
    text = text.replace("settle_s = 0.8", "settle_s = 0.1").replace("average_s = 1.0", "average_s = 0.2")
    file = folder / "quick.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def planned(folder: Path, quick: Path) -> dict[str, Any]:
    return call("poses", quick, "--count", FEW, "-o", folder / "plan", "--json").json()


@pytest.fixture(scope="module")
def recorded(folder: Path, quick: Path, planned: dict[str, Any]) -> Path:
    program, run = folder / "few.mpf", folder / "run"
    call("post", planned["plan"], "--dialect", "sinumerik", "-o", program, "--json").json()
    answer = call("run", program, "--case", quick, "-o", run, "--json").json()
    assert answer["poses"] == 8
    assert answer["duration_s"] == pytest.approx(planned["duration_s"], abs=0.02)
    assert answer["path_error_mm"] < 1e-3
    return run


def test_the_answer_holds_what_was_promised(planned: dict[str, Any]) -> None:
    assert planned["count"] == len(planned["poses"]) == 8
    assert planned["criterion"] == "D"
    assert set(planned["predicted_std"]) >= {"m", "xC", "zC", "k0", "k3", "f_q0_6"}
    assert 0.9 < planned["efficiency"] < 1.1
    assert planned["duration_s"] == pytest.approx(planned["travel_s"] + 8 * 0.3, rel=1e-9)
    assert all(limit["status"] == "proven" for limit in planned["limits"].values())


def test_the_folder_is_a_plan_with_poses(planned: dict[str, Any]) -> None:
    plan = Path(planned["plan"])
    saved = Plan.load(plan)
    with (plan / "poses.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    poses = [part.coordinates for part in saved.motion.parts if isinstance(part, Standstill)]  # type: ignore[attr-defined]
    written = np.array([[float(row[k]) for k in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")] for row in rows])
    np.testing.assert_allclose(written[:, :3] * 1e-3, np.array(poses)[:, :3], atol=1e-9)
    np.testing.assert_allclose(np.deg2rad(written[:, 3:]), np.array(poses)[:, 3:], atol=1e-9)


@pytest.mark.parametrize(("dialect", "suffix"), [("linuxcnc", ".ngc"), ("sinumerik", ".mpf"), ("twincat", ".nc")])
def test_every_dialect_measures_at_each_pose_with_the_trigger_on_and_moves_with_it_off(
    folder: Path, quick: Path, planned: dict[str, Any], dialect: str, suffix: str
) -> None:
    from cases.schema import load_case
    from postprocessors.program import read_program

    program = folder / f"dialect{suffix}"
    accept = ("--accept", "jerk,strut-acceleration") if dialect == "linuxcnc" else ()
    call("post", planned["plan"], "--dialect", dialect, *accept, "-o", program, "--json").json()
    reading = read_program(program, load_case(str(quick))).reading
    assert reading.measures_at_poses
    wanted = np.array([list(p.values()) for p in planned["poses"]]) * np.r_[[1e-3] * 3, np.deg2rad([1.0] * 3)]
    np.testing.assert_allclose(
        reading.measured_poses, wanted, atol=2e-8 if dialect == "linuxcnc" else 1e-5
    )  # rounded as the control rounds


def test_identified_parameters_lie_within_their_error_bars(folder: Path, recorded: Path) -> None:
    answer = call("identify", recorded, "-o", folder / "result", "--json").json()
    assert answer["model"] == 5
    assert answer["standstills"] == {"count": 8, "matched_to_poses": True, "found_by": "trigger"}
    truth = {"m": 31.83, "zC": 0.10505, "k0": 24.05, "k1": -8.46, "k2": 37.38, "k3": 28.27, "f_q0_3": 328.38}
    for name, value in truth.items():
        found = answer["parameters"][name]
        assert abs(found["value"] - value) < 4.5 * found["std"], name
    assert answer["s0"] == pytest.approx(1.0 / np.sqrt(200), rel=0.5)


def without_trigger(recorded: Path, plain: Path) -> Path:
    """Another file of the recording, which does not say where standstills are."""
    with (recorded / "recording.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    trigger = rows[0].index("trigger")
    with plain.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([row[:trigger] + row[trigger + 1 :] for row in rows])
    return plain


@pytest.mark.repeats
def test_without_a_trigger_standstills_are_found_from_the_motion(folder: Path, recorded: Path, quick: Path) -> None:
    plain = without_trigger(recorded, folder / "plain.csv")
    plan = folder / "plan"
    answer = call("identify", plain, "--case", quick, "--poses", plan, "-o", folder / "r", "--json").json()
    assert answer["standstills"]["found_by"] == "motion"
    assert answer["standstills"]["count"] == 8
    assert abs(answer["parameters"]["m"]["value"] - 31.83) < 4.5 * answer["parameters"]["m"]["std"]


@pytest.mark.repeats
def test_a_plan_of_other_poses_is_refused_with_the_pose_that_differs(folder: Path, quick: Path, recorded: Path) -> None:
    other = call("poses", quick, "--count", FEW, "--criterion", "N", "-o", folder / "other", "--json").json()
    line = refused("identify", recorded, "--poses", other["plan"], "-o", folder / "no")
    assert re.search(r"standstill (\d+): x .*; pose \1 of .*: x ", line)
    assert not (folder / "no").exists()


@pytest.mark.repeats
def test_a_plan_of_a_moving_excitation_is_no_plan_of_poses(folder: Path, recorded: Path) -> None:
    plan, poses = folder / "moving", folder / "three.csv"
    poses.write_text("x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n50,20,930,9,5,-9\n-40,60,880,-8,9,4\n20,-70,950,5,-9,9\n")
    moving = ("--family", "manual", "--sequence", poses, "--model", 0)
    call("plan", "hexapod", *moving, "-o", plan, "--json").json()
    assert "not of poses" in refused("identify", recorded, "--poses", plan, "-o", folder / "no")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--count", "2"), "2 poses give 12 forces for 14 parameters of model 5; ask for 3 or more"),
        (("--count", "481"), "481 poses are asked for, only 480 candidates are valid"),
        (("--count", "-1"), "ask for 3 or more"),
        (("--model", "9"), "model 9 contains inertia, which standstills cannot excite"),
        (("--model", "3"), "model 3: rank 26 of 30: m, mxC, myC, mzC, K3_1x"),
        (("--criterion", "E"), "criterion 'E' is unknown; choose A, D, K, N"),
        (("--method", "luck"), "method 'luck' is unknown; choose backward, backward-change, refine, all"),
        (("--method", "all", "--count", "3"), "leave --count out"),
        (("--candidates", "10000000"), "10000000 candidates; choose 1 to 200000"),
        (("--candidates", "20", "--count", "30"), "only 20 candidates are valid"),
        (("--candidates", "3000", "--method", "backward-change"), "choose backward"),
        (("--seed", "-1"), "seed -1 is negative"),
    ],
)  # fmt: skip
def test_impossible_wishes_are_refused_in_one_line(tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    assert said in refused("poses", "hexapod", *words, "-o", tmp_path / "plan")
    assert not (tmp_path / "plan").exists()


def test_only_methods_that_can_be_named_are_offered(tmp_path: Path) -> None:
    assert refused("poses", "hexapod", "--method", "luck", "-o", tmp_path / "plan").endswith("refine, all")
    assert "--at" in refused("poses", "hexapod", "--method", "given", "-o", tmp_path / "plan")


def test_a_case_without_a_machine_cannot_plan_poses(tmp_path: Path) -> None:
    assert "machine: is missing" in refused("poses", "ft_wrist", "-o", tmp_path / "plan")


@pytest.mark.first(1)
@pytest.mark.parametrize("method", ["backward", "backward-change"])
def test_each_method_gives_as_many_poses_as_asked_for(tmp_path: Path, method: str) -> None:
    answer = call("poses", "hexapod", "--count", "12", "--method", method, "-o", tmp_path / "plan", "--json").json()
    assert answer["count"] == 12
    assert answer["method"] == method
    assert 0.8 < answer["efficiency"] <= 1.0


@pytest.mark.repeats
def test_30_poses_take_at_most_81_s(tmp_path: Path) -> None:
    """The paper's figure, with 0.8 s of settling and 1.0 s of averaging; travel included."""
    answer = call("poses", "hexapod", "--method", "backward", "--criterion", "N", "-o", tmp_path / "n", "--json").json()
    assert answer["count"] == 30
    assert answer["settings"]["settle_s"] == 0.8
    assert answer["settings"]["average_s"] == 1.0
    assert 54.0 < answer["duration_s"] <= 81.0


@pytest.mark.slow
def test_standstills_are_averaged_wherever_they_are_if_asked_for(folder: Path, recorded: Path, quick: Path) -> None:
    """Without trigger and without plan; home counts too where the machine rests there long enough."""
    plain = without_trigger(recorded, folder / "unnamed.csv")
    words = ("identify", plain, "--case", quick, "--standstills", "-o", folder / "wherever", "--overwrite")
    answer = call(*words, "--json").json()
    assert answer["standstills"]["count"] in (8, 9, 10)
    assert not answer["standstills"]["matched_to_poses"]
    assert tells(call(*words).out, "averaged standstills")


def test_averaged_rows_are_not_averaged_again(folder: Path, quick: Path) -> None:
    names = [f"l{k}_mm" for k in range(1, 7)] + [f"f{k}_N" for k in range(1, 7)]
    rows = [[1000.0 + 7 * j * (k + 1) % 90 for k in range(6)] + [float(j * k % 11) for k in range(6)] for j in range(5)]
    file = folder / "averaged.csv"
    with file.open("w", newline="", encoding="utf-8") as out:
        csv.writer(out).writerows([names, *rows])
    line = refused("identify", file, "--case", quick, "--standstills", "-o", folder / "no")
    assert "averaged already" in line


@pytest.mark.parametrize("entry", [[[1.0, 2.0]], "poses", [[None] * 6], [["x"] * 6]])
def test_damaged_poses_of_a_recording_are_refused(folder: Path, recorded: Path, tmp_path: Path, entry: object) -> None:
    damaged = tmp_path / "run"
    damaged.mkdir()
    (damaged / "recording.csv").symlink_to(recorded / "recording.csv")
    about = json.loads((recorded / "recording.json").read_text(encoding="utf-8"))
    del about["content"]
    (damaged / "recording.json").write_text(json.dumps(about | {"poses_m_rad": entry}), encoding="utf-8")
    assert "poses_m_rad" in refused("identify", damaged, "-o", tmp_path / "no")


@pytest.mark.parametrize(
    "change", [{"average_s": 0.0}, {"settle_s": -1.0}, {"average_s": "long"}, {"pose_m_rad": [0.0] * 5}, {"kind": "x"}]
)
def test_damaged_measurements_of_a_plan_are_refused(
    planned: dict[str, Any], tmp_path: Path, change: dict[str, object]
) -> None:
    data = json.loads((Path(planned["plan"]) / "plan.json").read_text(encoding="utf-8"))
    first = next(m for m in data["moves"] if m["kind"] == "measure")
    first.update(change)
    (tmp_path / "plan.json").write_text(json.dumps(data), encoding="utf-8")
    line = refused("post", tmp_path, "--dialect", "sinumerik", "-o", tmp_path / "no.mpf")
    assert "plan.json" in line
    assert "plan again" in line


def test_the_fewest_poses_of_each_criterion_are_said_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Model 0 has ten parameters: two poses of six sensors at least; where Algorithm 1 ends, any removal loses rank."""
    monkeypatch.chdir(tmp_path)
    answer = call("poses", "hexapod", "--least", "--model", 0, "--candidates", 40, "--json").json()
    found = answer["least"]
    assert [(each["criterion"], each["method"]) for each in found] == [
        ("A", "backward"), ("D", "backward"), ("K", "backward"), ("K", "backward-change"), ("N", "backward"),
    ]  # fmt: skip
    assert all(2 <= each["poses"] <= 4 for each in found)
    assert not list(tmp_path.iterdir())
