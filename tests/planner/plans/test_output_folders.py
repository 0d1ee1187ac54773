"""Where to write: a place that cannot be written or holds somebody else's files is refused, and nothing is lost."""

import os
import shutil
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import Code, HexciteError
from planner.plans import making as planning
from tests.helpers import tells
from tests.hexcite.command_line import ACCEPT, call, refused

QUICK = ("plan", "hexapod", "--family", "fourier", "--order", "2", "--model", "0", "--starts", "1", "--json")


@pytest.fixture
def sources(chain: dict[str, Any], shared: Path) -> dict[str, tuple[object, ...]]:
    return {
        "plan": QUICK,
        "run": ("run", shared / "excitation.ngc", "--case", "hexapod", "--json"),
        "identify": ("identify", shared / "recording", "--json"),
        "post": ("post", shared / "plan", *ACCEPT, "--json"),
    }


def contents(folder: Path) -> dict[str, bytes]:
    return {str(f.relative_to(folder)): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()}


@pytest.mark.parametrize("command", ["plan", "run", "identify"])
def test_a_folder_that_holds_other_files_is_refused_and_stays(command: str, sources: dict, tmp_path: Path):
    folder = tmp_path / "thesis"
    folder.mkdir()
    (folder / "chapter.tex").write_text("years of work")
    line = refused(*sources[command], "-o", folder)
    assert str(folder) in line
    assert "choose another place with -o" in line
    assert contents(folder) == {"chapter.tex": b"years of work"}
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.parametrize("command", ["plan", "run", "identify", "post"])
def test_a_place_that_cannot_be_written_is_refused(command: str, sources: dict, tmp_path: Path):
    (tmp_path / "file").write_text("no folder")
    place = tmp_path / "file" / ("out.ngc" if command == "post" else "out")
    line = refused(*sources[command], "-o", place)
    assert str(place) in line
    assert "choose another place with -o" in line


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_refused(sources: dict, tmp_path: Path):
    (tmp_path / "locked").mkdir(mode=0o500)
    assert "ermission denied" in refused(*sources["identify"], "-o", tmp_path / "locked" / "result")


@pytest.mark.parametrize("place", ["file/out", "thesis"])
def test_a_place_that_cannot_be_written_is_known_before_the_work_begins(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Half a minute of optimising would be lost otherwise."""

    def work(*_: object) -> None:
        raise HexciteError(problem="optimised before it was known where to write", code=Code.WRONG_KIND)

    monkeypatch.setattr(planning, "make", work)
    (tmp_path / "file").write_text("no folder")
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("years of work")
    line = refused("plan", "hexapod", "-o", tmp_path / place, "--json")
    assert str(tmp_path / place) in line
    assert "choose another place with -o" in line


def test_a_recording_is_not_overwritten_by_the_result_that_is_made_from_it(chain: Any, shared: Path, tmp_path: Path):
    recording = Path(shutil.copytree(shared / "recording", tmp_path / "recording"))
    before = contents(recording)
    line = refused("identify", recording, "-o", recording, "--json")
    assert str(recording) in line
    assert contents(recording) == before


@pytest.mark.parametrize("words", [("force", "--parameters", "result"), ("retime",)])
def test_a_table_is_not_overwritten_by_what_is_made_from_it(words: tuple[str, ...], tmp_path: Path):
    table = tmp_path / "run.csv"
    table.write_text("t_s,x_mm\n")
    line = refused(*words, table, "--case", "hexapod", "-o", table, "--json")
    assert str(table) in line
    assert tells(line, "read; ", "another place with -o")
    assert table.read_text() == "t_s,x_mm\n"


@pytest.mark.parametrize("command", ["plan", "run"])
def test_a_folder_of_another_kind_is_not_overwritten(
    command: str, sources: dict, chain: Any, shared: Path, tmp_path: Path
):
    result = Path(shutil.copytree(shared / "result", tmp_path / "result"))
    before = contents(result)
    assert str(result) in refused(*sources[command], "-o", result)
    assert contents(result) == before


def test_what_an_earlier_run_made_stays_unless_it_may_be_replaced(
    sources: dict, chain: Any, shared: Path, tmp_path: Path
):
    result = Path(shutil.copytree(shared / "result", tmp_path / "result"))
    (result / ".hexcite").unlink()  # as of an earlier version, which wrote plots too
    (result / "plots").mkdir(exist_ok=True)
    (result / "plots" / "old.svg").write_text("of another run")
    assert "--overwrite" in refused(*sources["identify"], "-o", result)
    assert (result / "plots" / "old.svg").exists()
    call(*sources["identify"], "-o", result, "--overwrite").json()
    assert not (result / "plots" / "old.svg").exists()
    assert (result / "result.json").is_file()
    (result / "plots").mkdir()
    (result / "plots" / "mine.svg").write_text("of the user")
    assert "it holds plots/mine.svg" in refused(*sources["identify"], "-o", result, "--overwrite")
    assert (result / "plots" / "mine.svg").exists()


@pytest.mark.slow
def test_without_o_a_command_writes_beside_the_user_under_a_name_that_tells(
    sources: dict, chain: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    assert call(*sources["post"]).json()["program"] == "plan.mpf"
    assert call(*sources["run"]).json()["recording"] == "excitation-recording"
    assert call(*sources["identify"]).json()["result"] == "recording-result"
    Path("plan-2.mpf").touch()
    assert call(*sources["post"]).json()["program"] == "plan-3.mpf"
    names = {"plan.mpf", "plan-2.mpf", "plan-3.mpf", "excitation-recording", "recording-result"}
    assert {p.name for p in tmp_path.iterdir()} == names


def test_the_folder_in_which_the_user_stands_is_refused_and_left_as_it_was(
    sources: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    assert "with -o" in refused(*sources["identify"], "-o", ".")
    assert list(tmp_path.iterdir()) == []


def test_a_program_is_not_written_under_a_name_that_check_would_not_read(sources: dict, tmp_path: Path):
    line = refused(*sources["post"], "-o", tmp_path / "program.txt")
    assert "program.txt" in line
    assert ".ngc" in line
    assert list(tmp_path.iterdir()) == []
