"""Files and folders appear whole or not at all, and never in the place of somebody else's."""

import os
import shutil
import stat
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from cases.base.atomic import atomic_file, atomic_folder, write_text
from cases.base.errors import Code, FileProblem
from cases.base.folder_kinds import MARKER, PLAN, RESULT, RUN, FolderKind
from cases.base.output_places import check_file, check_folder, free_name, output_place
from tests.helpers import one_line, refused_at


def tree(folder: Path) -> dict[str, str | None]:
    """Everything below a folder but markers: file contents by name, None for folders."""
    every = (p for p in folder.rglob("*") if p.name != MARKER)
    return {str(p.relative_to(folder)): p.read_text() if p.is_file() else None for p in every}


def plan_folder(folder: Path) -> AbstractContextManager[Path]:
    return atomic_folder(folder, PLAN)


def plan(folder: Path, content: str, overwrite: bool = False) -> None:
    with atomic_folder(folder, PLAN, overwrite) as part:
        (part / "plan.json").write_text(content)
        (part / "plots").mkdir()
        (part / "plots" / "pose.svg").write_text(content)


def interrupted(context: AbstractContextManager[Path], name: str, error: type[BaseException]) -> None:
    with context as part:
        (part / name).write_text("new")
        raise error


def test_a_file_appears_when_it_is_whole(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "down" / "run.csv"
    with atomic_file(target) as part:
        part.write_text("half")
        assert not target.exists()
        part.write_text("whole")
    assert tree(tmp_path) == {"deep": None, "deep/down": None, "deep/down/run.csv": "whole"}


def test_a_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "old")
    write_text(tmp_path / "a.txt", "new: äöü")
    assert tree(tmp_path) == {"a.txt": "new: äöü"}


def test_who_has_the_old_file_open_goes_on_reading_the_old_one(tmp_path: Path) -> None:
    """The new file takes the name of the old one in one step; nobody ever sees a part of it."""
    write_text(tmp_path / "a.txt", "old")
    with (tmp_path / "a.txt").open() as reader:
        write_text(tmp_path / "a.txt", "new")
        assert reader.read() == "old"


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit, MemoryError])
def test_an_error_leaves_the_old_file_and_nothing_else(error: type[BaseException], tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "old")
    with pytest.raises(error):
        interrupted(atomic_file(tmp_path / "a.txt"), "", error)
    assert tree(tmp_path) == {"a.txt": "old"}


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit, MemoryError])
def test_an_error_leaves_the_old_folder_and_nothing_else(error: type[BaseException], tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    before = tree(tmp_path)
    with pytest.raises(error):
        interrupted(atomic_folder(tmp_path / "p", PLAN), "plan.json", error)
    assert tree(tmp_path) == before


def test_a_folder_is_replaced_as_a_whole(tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    with atomic_folder(tmp_path / "p", PLAN, overwrite=True) as part:
        (part / "plan.json").write_text("new")
    assert tree(tmp_path) == {"p": None, "p/plan.json": "new"}


def test_what_another_command_made_is_refused_before_the_work(tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    (tmp_path / "a.ngc").write_text("old")
    for check in (lambda: check_folder(tmp_path / "p", PLAN), lambda: check_file(tmp_path / "a.ngc", [".ngc"])):
        with pytest.raises(FileProblem, match="replace it with overwrite"):
            check()
    check_folder(tmp_path / "p", PLAN, overwrite=True)
    check_file(tmp_path / "a.ngc", [".ngc"], overwrite=True)


def test_a_folder_that_was_taken_during_the_work_stays_and_the_new_one_is_beside_it(tmp_path: Path) -> None:
    def slow() -> None:
        with atomic_folder(tmp_path / "p", PLAN) as part:
            (part / "plan.json").write_text("mine")
            plan(tmp_path / "p", "theirs")

    with pytest.raises(FileProblem, match=r"p: a plan stands there.*p-2"):
        slow()
    assert (tmp_path / "p" / "plan.json").read_text() == "theirs"
    assert (tmp_path / "p-2" / "plan.json").read_text() == "mine"


def test_usual_names_do_not_collide_and_named_places_stay(tmp_path: Path) -> None:
    for taken in ("a.ngc", "a-2.ngc"):
        (tmp_path / taken).write_text("old")
    assert free_name(tmp_path / "a.ngc") == tmp_path / "a-3.ngc"
    assert free_name(tmp_path / "b") == tmp_path / "b"
    assert output_place(None, tmp_path / "a.ngc", overwrite=False).name == "a-3.ngc"
    assert output_place(None, tmp_path / "a.ngc", overwrite=True).name == "a.ngc"
    assert output_place(tmp_path / "a.ngc", tmp_path / "b.ngc", overwrite=False).name == "a.ngc"


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    plan(tmp_path / "p", "new")
    assert tree(tmp_path)["p/plan.json"] == "new"


@pytest.mark.parametrize("name", ["thesis.tex", ".git", "plan.json.bak"])
def test_a_folder_of_somebody_else_is_left_alone(name: str, tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / name).write_text("years of work")
    with refused_at(tmp_path / "p", r"not a plan.*holds .*; choose another place", FileProblem):
        plan(tmp_path / "p", "new")
    assert tree(tmp_path) == {"p": None, f"p/{name}": "years of work"}


@pytest.mark.parametrize(
    ("files", "kind", "says"),
    [
        ({"report.html": "page", "plots/deep/thesis.doc": "years of work"}, RESULT, "no result.json"),
        ({"recording.csv": "t_s,.."}, RUN, "no recording.json"),
        ({"result.json": '{"of": "another program"}', "plots/a.svg": ""}, RESULT, "no result.json"),
        ({"result.json": '{"case": "mine"}', "plots/thesis.doc": "years of work"}, RESULT, "plots/thesis.doc"),
        ({"result.json": '{"case": "mine"}', "plots/a/b/c.svg": "years of work"}, RESULT, "plots/a/b/c.svg"),
        ({"plan.json": '{"case": "mine"}', "result.json": '{"case": "mine"}'}, RESULT, "plan.json"),
    ],
)
def test_no_folder_is_deleted_that_only_looks_like_ours(
    files: dict[str, str], kind: FolderKind, says: str, tmp_path: Path
) -> None:
    for name, content in files.items():
        (tmp_path / "p" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "p" / name).write_text(content)
    before = tree(tmp_path)
    with (
        pytest.raises(FileProblem, match=rf"is not .* of hexcite's \(.*{says}") as caught,
        atomic_folder(tmp_path / "p", kind, overwrite=True),
    ):
        pass
    one_line(caught.value)
    assert tree(tmp_path) == before


@pytest.mark.parametrize("name", ["notes.txt", "plots/mine.svg", "plots/deep/thesis.doc", "empty/folder/"])
def test_what_somebody_put_into_a_folder_of_ours_is_never_deleted(name: str, tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    plan(tmp_path / "p", "new", overwrite=True)
    own = tmp_path / "p" / name
    if name.endswith("/"):
        own.mkdir(parents=True)
    else:
        own.parent.mkdir(exist_ok=True)
        own.write_text("years of work")
    before = tree(tmp_path)
    with pytest.raises(FileProblem, match=f"it holds {name.rstrip('/')}"):
        plan(tmp_path / "p", "newer", overwrite=True)
    assert tree(tmp_path) == before


def test_folders_of_earlier_versions_are_known_by_their_record(tmp_path: Path) -> None:
    (tmp_path / "p" / "plots").mkdir(parents=True)
    (tmp_path / "p" / "plan.json").write_text('{"schema_version": 1, "case": "hexapod"}')
    (tmp_path / "p" / "plots" / "pose.svg").write_text("<svg/>")
    plan(tmp_path / "p", "new", overwrite=True)
    assert tree(tmp_path)["p/plan.json"] == "new"


def test_a_link_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "t").mkdir()
    (tmp_path / "link").symlink_to("t")
    with pytest.raises(FileProblem, match="a link; name the folder itself"):
        check_folder(tmp_path / "link", PLAN)
    check_folder(tmp_path / "link" / "below", PLAN)


def test_a_full_disk_is_told_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    with pytest.raises(FileProblem, match=r"0.0 MB are left there\); make room"):
        check_folder(tmp_path / "p", PLAN)


def test_a_file_is_not_replaced_by_a_folder(tmp_path: Path) -> None:
    (tmp_path / "p").write_text("a file")
    with pytest.raises(FileProblem, match=r"exists.*not a folder"):
        plan(tmp_path / "p", "new")
    assert tree(tmp_path) == {"p": "a file"}


def test_a_folder_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    before = tree(tmp_path)
    with pytest.raises(FileProblem, match=r"p: cannot be written.*Is a directory"):
        write_text(tmp_path / "p", "new")
    assert tree(tmp_path) == before


@pytest.mark.parametrize("write", [plan, write_text])
def test_a_place_below_a_file_cannot_be_written(write: Callable[[Path, str], None], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with refused_at(tmp_path / "file" / "below", r"cannot be written \(.*another place", FileProblem):
        write(tmp_path / "file" / "below", "new")


@pytest.mark.parametrize("context", [atomic_file, plan_folder])
def test_a_disk_that_is_full_is_told_in_one_line(context: Callable, tmp_path: Path) -> None:
    with (
        pytest.raises(FileProblem, match=r"cannot be written.*No space left") as caught,
        context(tmp_path / "p"),
    ):
        raise OSError(28, "No space left on device")
    assert one_line(caught.value).startswith(str(tmp_path / "p"))
    assert tree(tmp_path) == {}


@pytest.mark.parametrize("context", [atomic_file, plan_folder])
def test_an_error_of_ours_passes_through_unchanged(context: Callable, tmp_path: Path) -> None:
    """What could not be read is not to be reported as a place that cannot be written."""
    ours = FileProblem(problem="in.json: cannot be read (gone)", code=Code.UNREADABLE)
    with pytest.raises(FileProblem) as caught, context(tmp_path / "p"):
        raise ours
    assert caught.value is ours


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_files_and_folders_have_the_rights_that_the_user_gives_new_ones(mask: int, tmp_path: Path) -> None:
    before = os.umask(mask)
    try:
        plan(tmp_path / "p", "x")
        write_text(tmp_path / "a.txt", "x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o666 & ~mask
    assert stat.S_IMODE((tmp_path / "p").stat().st_mode) == 0o777 & ~mask


def test_a_folder_that_cannot_be_replaced_at_the_last_moment_is_put_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan(tmp_path / "p", "old")
    before, rename = tree(tmp_path), os.rename

    def failing(source: Path, target: Path) -> None:
        if Path(source).suffix == ".part":
            raise OSError(5, "Input/output error")
        rename(source, target)

    monkeypatch.setattr("os.rename", failing)
    with pytest.raises(FileProblem, match="Input/output error"):
        plan(tmp_path / "p", "new", overwrite=True)
    assert tree(tmp_path) == before


def test_a_result_does_not_take_the_place_of_a_plan(tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    before = tree(tmp_path)
    with pytest.raises(FileProblem, match=r"p: .*not a result.*holds plan\.json"):
        check_folder(tmp_path / "p", RESULT)
    assert tree(tmp_path) == before


@pytest.mark.parametrize("source", ["p", "p/plan.json", "p/plots/pose.svg"])
def test_what_is_read_is_never_replaced(source: str, tmp_path: Path) -> None:
    plan(tmp_path / "p", "old")
    check_folder(tmp_path / "p", PLAN, [tmp_path / "other"], overwrite=True)
    with pytest.raises(FileProblem, match="is read; choose another place"):
        check_folder(tmp_path / "p", PLAN, [tmp_path / source], overwrite=True)


@pytest.mark.parametrize("place", [".", ".."])
def test_the_folder_that_one_works_in_is_not_replaced(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileProblem, match="folder that you work in"):
        check_folder(Path(place), PLAN)


def test_an_output_file_is_checked_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "a.ngc").write_text("x")
    check_file(tmp_path / "a.ngc", [".ngc"], overwrite=True)
    check_file(tmp_path / "B.NGC", [".ngc"], [tmp_path / "a.ngc"])
    with pytest.raises(FileProblem, match=r"'\.json'; .*\.ngc or \.nc"):
        check_file(tmp_path / "plan.json", [".ngc", ".nc"])
    with pytest.raises(FileProblem, match="is also what is read"):
        check_file(tmp_path / "a.ngc", [".ngc"], [tmp_path / "sub" / ".." / "a.ngc", tmp_path / "a.ngc"])
    (tmp_path / "f.ngc").mkdir()
    with pytest.raises(FileProblem, match="is a folder"):
        check_file(tmp_path / "f.ngc", [".ngc"])


@pytest.mark.parametrize("name", ["x" * 300, "sub/" + "x" * 300])
def test_a_place_that_only_looks_writable_is_known_before_the_work(name: str, tmp_path: Path) -> None:
    """Permission bits tell nothing of names that are too long, of /proc, of full disks."""
    for check in (lambda: check_folder(tmp_path / name, PLAN), lambda: check_file(tmp_path / f"{name}.csv", [".csv"])):
        with pytest.raises(FileProblem, match=r"File name too long.*another place"):
            check()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="only Linux has a folder that nobody can write to")
def test_a_folder_of_the_kernel_is_no_place() -> None:
    with pytest.raises(FileProblem, match=r"/proc/plan: cannot be written"):
        check_folder(Path("/proc/plan"), PLAN)
