"""A sensor frame that does not move (setup 1a): tare, external force and payload, and no more than that."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from cases.schema import load_case
from tests.helpers import tells
from tests.hexcite.command_line import call, refused

CASE = load_case("clamping_table")
OFFSETS = np.array([10.0, -20.0, 5.0, 3.0, 8.0, -4.0])
MASS, CENTRE = 12.5, np.array([0.03, -0.02, 0.2])
HEADER = ",".join(f"f{k}_N" for k in range(1, 7))


def bars(mass: float, centre: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """Forces of six bars that carry a load at rest: their resultant is the opposite of its weight (statics)."""
    weight = mass * gravity
    return OFFSETS - np.linalg.solve(CASE.sensor_frame.structure, np.r_[weight, np.cross(centre, weight)])


def record(file: Path, mean: np.ndarray, seed: int, clock: bool = True) -> Path:
    forces = mean + np.random.default_rng(seed).normal(size=(400, 6))
    rows = [",".join(f"{v:.4f}" for v in row) for row in forces]
    lines = [f"{k * 1e-3:.3f},{row}" for k, row in enumerate(rows)] if clock else rows
    file.write_text("\n".join([("t_s," if clock else "") + HEADER, *lines]))
    return file


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Results of the table without and with the payload."""
    folder = tmp_path_factory.mktemp("table")
    for name, mass, seed in (("empty", 0.0, 1), ("loaded", MASS, 2)):
        file = record(folder / f"{name}.csv", bars(mass, CENTRE, CASE.gravity), seed)
        call("identify", file, "--case", "clamping_table", "-o", folder / name, "--json").json()
    return folder / "empty", folder / "loaded"


@pytest.mark.first(1)
@pytest.mark.parametrize("clock", [True, False])
def test_a_standstill_gives_the_offsets(clock: bool, tmp_path: Path) -> None:
    file = record(tmp_path / "empty.csv", bars(0.0, CENTRE, CASE.gravity), 0, clock)
    answer = call("identify", file, "--case", "clamping_table", "-o", tmp_path / "r", "--json").json()
    found = answer["parameters"]
    assert list(found) == [f"f_q0_{k}" for k in range(1, 7)]
    for k, p in enumerate(found.values()):
        assert abs(p["value"] - OFFSETS[k]) < 4.0 * p["std"]
        assert p["std"] == pytest.approx(0.05, rel=0.15)  # 1 N over the root of 400 samples
    assert answer["warnings"] == []


def test_two_standstills_weigh_the_payload_and_refuse_its_height_by_name(results: tuple[Path, Path]) -> None:
    answer = call("payload", *results, "--case", "clamping_table", "--json").json()
    p = answer["parameters"]
    assert list(p) == ["m", "xC", "yC"]
    for name, truth in (("m", MASS), ("xC", CENTRE[0]), ("yC", CENTRE[1])):
        assert abs(p[name]["value"] - truth) < 4.0 * p[name]["std"], name
    assert any(tells(w, "zC not determined", "gravity") for w in answer["warnings"])


def test_a_payload_is_written_with_what_it_was_computed_from(results: tuple[Path, Path], tmp_path: Path) -> None:
    file = tmp_path / "payload.json"
    answer = call("payload", *results, "--case", "clamping_table", "-o", file, "--json").json()
    assert (answer.pop("file"), answer.pop("report")) == (str(file), str(file.with_suffix(".html")))
    assert json.loads(file.read_text()) == answer
    page = file.with_suffix(".html").read_text()
    assert "zC not determined" in page
    assert answer["computed_from"]["with"]["sha256"] in page
    for name, folder in zip(("without", "with"), results, strict=True):
        content = (folder / "result.json").read_bytes()
        assert answer["computed_from"][name]["sha256"] == hashlib.sha256(content).hexdigest()
    before = file.read_bytes()
    assert tells(refused("payload", *results, "--case", "clamping_table", "-o", file), "payload.json", "--overwrite")
    load = tmp_path / "load.xml"
    message = refused("payload", *results, "--case", "clamping_table", "--to", "urdf", "-o", load)
    assert tells(message, "zC", "not determined")
    assert file.read_bytes() == before
    assert not load.exists()
    assert len(answer["warnings"]) == 1


@pytest.mark.repeats
def test_a_tilted_table_determines_what_lies_across_gravity(tmp_path: Path) -> None:
    """Gravity along x of the table, as on a machine with a horizontal table axis: then yC and zC are known."""
    text = (Path(__file__).parents[2] / "cases" / "clamping_table" / "case.toml").read_text()
    case = tmp_path / "case.toml"
    case.write_text(text.replace("[0.0, 0.0, -9.81]", "[-9.81, 0.0, 0.0]"))
    for name, mass, seed in (("empty", 0.0, 1), ("loaded", MASS, 2)):
        file = record(tmp_path / f"{name}.csv", bars(mass, CENTRE, np.array([-9.81, 0.0, 0.0])), seed)
        call("identify", file, "--case", case, "-o", tmp_path / name, "--json").json()
    answer = call("payload", tmp_path / "empty", tmp_path / "loaded", "--case", case, "--json").json()
    assert list(answer["parameters"]) == ["m", "yC", "zC"]
    assert answer["parameters"]["zC"]["value"] == pytest.approx(0.2, abs=5e-4)
    assert "xC not determined" in answer["warnings"][0]


def test_a_change_that_is_no_weight_is_told(results: tuple[Path, Path], tmp_path: Path) -> None:
    """A horizontal push beside the payload."""
    pushed = bars(MASS, CENTRE, CASE.gravity) - np.linalg.solve(CASE.sensor_frame.structure, [5.0, 0, 0, 0, 0, 0])
    file = record(tmp_path / "pushed.csv", pushed, 3)
    call("identify", file, "--case", "clamping_table", "-o", tmp_path / "pushed", "--json").json()
    answer = call("payload", results[0], tmp_path / "pushed", "--case", "clamping_table", "--json").json()
    assert any("not a weight alone" in w for w in answer["warnings"])


def test_the_same_table_twice_is_no_payload(results: tuple[Path, Path]) -> None:
    reason = refused("payload", results[0], results[0], "--case", "clamping_table")
    assert tells(reason, "of the same recording", "without the payload")


def test_external_force_and_tare(results: tuple[Path, Path], tmp_path: Path) -> None:
    loaded = results[1].with_suffix(".csv")
    words = ("force", loaded, "--parameters", results[0], "--case", "clamping_table", "-o", tmp_path / "f.csv")
    answer = call(*words, "--json").json()
    assert answer["rms"]["fz_N"] == pytest.approx(MASS * 9.81, rel=0.02)
    assert (tmp_path / "f.csv").read_text().splitlines()[2].startswith("0.001,")  # over the recording's own time
    tared = ("tare", loaded, "--parameters", results[0], "--case", "clamping_table", "-o", tmp_path / "t", "--json")
    new = call(*tared).json()["linear"]["values"]
    assert new == pytest.approx(bars(MASS, CENTRE, CASE.gravity), abs=0.25)


def test_a_moving_plan_is_refused_with_the_reason(tmp_path: Path) -> None:
    line = refused("plan", "clamping_table", "-o", tmp_path / "plan")
    assert tells(line, "setup: is 1a", "not move")
    assert "hexcite tare" in line


@pytest.mark.parametrize("model", [5, 9])
def test_a_model_of_motion_is_refused_with_the_reason(model: int, tmp_path: Path) -> None:
    file = record(tmp_path / "empty.csv", OFFSETS, 0)
    line = refused("identify", file, "--case", "clamping_table", "--model", model, "-o", tmp_path / "r")
    assert tells(line, "not move", "offsets")
