"""`hexcite identify` tells where a run went at another feed than planned: by its folder, --plan, or its own column."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from cases.loading import load_case
from identification.recording import write_recording
from planner.runs.followed import followed_plan
from tests.identification.findings.test_feed import AtFeed, recorded
from tests.planner.command_line import call, refused
from tests.postprocessors.programs import small_excitation

CASE = load_case("hexapod")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A program, its run on the virtual controller, and `slow.csv`: the same at 60 % from 0.5 s on."""
    folder = tmp_path_factory.mktemp("feed")
    (folder / "p.ngc").write_text(small_excitation(CASE), encoding="utf-8")
    call("run", folder / "p.ngc", "--case", "hexapod", "--on", "virtual", "-o", folder / "run", "--json").json()
    motion = followed_plan(folder / "p.ngc", CASE).motion
    write_recording(folder / "slow.csv", recorded(AtFeed(motion, (0.5,), (1.0, 0.6))), CASE)
    return folder


def identified(path: Path, tmp_path: Path, *words: object) -> dict:
    return call("identify", path, "--case", "hexapod", "-o", tmp_path / "r", "--json", *words).json()


def test_a_run_as_programmed_is_not_spoken_of(folder: Path, tmp_path: Path) -> None:
    answer = identified(folder / "run", tmp_path)
    assert "feed" not in answer
    assert not any("feed" in w for w in answer["warnings"])
    assert identified(folder / "run", tmp_path / "b", "--plan", folder / "p.ngc")["feed"]["stretches"] == []


def test_a_slower_run_is_told_with_its_rows_and_what_follows(folder: Path, tmp_path: Path) -> None:
    answer = identified(folder / "slow.csv", tmp_path, "--plan", folder / "p.ngc")
    stretches = answer["feed"]["stretches"]
    assert stretches[-1]["feed"] == pytest.approx(0.6, abs=0.04)
    assert stretches[0]["from_s"] == pytest.approx(0.9, abs=0.3)
    (warning,) = [w for w in answer["warnings"] if "feed other than 100 %" in w]
    assert f"comparison with {folder / 'p.ngc'}: lines " in warning
    assert "the parameters are valid" in warning


def test_a_run_folder_knows_its_program(folder: Path, tmp_path: Path) -> None:
    """As if an operator had turned the override while the program ran."""
    run = tmp_path / "run"
    shutil.copytree(folder / "run", run)
    shutil.copy(folder / "slow.csv", run / "recording.csv")
    assert identified(run, tmp_path)["feed"]["found_by"] == "comparison with p.ngc"
    about = json.loads((run / "recording.json").read_text())
    (run / "recording.json").write_text(json.dumps(about | {"program_hash": "another"}))
    assert "feed" not in identified(run, tmp_path / "b")  # the program has changed since


def test_the_column_of_the_override_is_read(folder: Path, tmp_path: Path) -> None:
    lines = (folder / "run" / "recording.csv").read_text().splitlines()
    on = [k for k, line in enumerate(lines) if line.endswith(",1")]
    middle = on[len(on) // 2]
    values = [80 if abs(k - middle) < 100 else 100 for k in range(1, len(lines))]
    table = [f"{lines[0]},override_percent", *(f"{a},{b}" for a, b in zip(lines[1:], values, strict=True))]
    file = tmp_path / "o.csv"
    file.write_text("\n".join(table) + "\n")
    (stretch,) = identified(file, tmp_path)["feed"]["stretches"]
    assert stretch["feed"] == pytest.approx(0.8)
    assert stretch["where"] == f"lines {middle - 98} to {middle + 100}"
    table[40] = table[40].rsplit(",", 1)[0] + ",-5"
    file.write_text("\n".join(table) + "\n")
    message = refused("identify", file, "--case", "hexapod", "-o", tmp_path / "s")
    assert "line 41, override_percent: -5 % is no feed override, they are 0 to 300 %" in message


@pytest.mark.parametrize("name", ["missing.ngc", "slow.csv", "run"])
def test_what_is_no_plan_is_refused(name: str, folder: Path, tmp_path: Path) -> None:
    words = ("identify", folder / "slow.csv", "--case", "hexapod", "-o", tmp_path / "r", "--plan", folder / name)
    assert name in refused(*words)
    assert not (tmp_path / "r").exists()


def test_a_run_of_another_program_is_refused(folder: Path, tmp_path: Path) -> None:
    file = tmp_path / "other.csv"
    write_recording(file, recorded(AtFeed(_other(), (), (1.0,))), CASE)
    words = ("identify", file, "--case", "hexapod", "-o", tmp_path / "r", "--plan", folder / "p.ngc")
    assert "it is no run of that plan" in refused(*words)


def _other() -> object:
    from tests.identification.findings.test_feed import through

    return through(9)


def test_overrides_as_ratios_are_read_with_their_unit(folder: Path) -> None:
    from identification.recording import read_recording

    case = CASE.model_copy(
        update={
            "recording": type(CASE.recording).model_validate(
                CASE.recording.model_dump() | {"columns": {"override_percent": "ovr"}, "units": {"override": "1"}}
            )
        }
    )
    lines = (folder / "run" / "recording.csv").read_text().splitlines()
    file = folder / "ratio.csv"
    file.write_text("\n".join([f"{lines[0]},ovr", *(f"{line},0.5" for line in lines[1:])]) + "\n")
    np.testing.assert_array_equal(read_recording(file, case).override, 0.5)
