"""Several commands that write one folder at the same time: each finds a place, and no folder is mixed or lost."""

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from cases.base.atomic import atomic_folder
from cases.base.errors import FileProblem
from cases.base.folder_kinds import MARKER, PLAN

WRITERS, ROUNDS = 6, 40


def written_at_once(write: Callable[[int], None]) -> list[BaseException]:
    """What went wrong in threads that all begin at one instant."""
    wrong, start = list[BaseException](), threading.Barrier(WRITERS)

    def one(number: int) -> None:
        try:
            start.wait()
            write(number)
        except BaseException as error:
            wrong.append(error)

    threads = [threading.Thread(target=one, args=(k,)) for k in range(WRITERS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return wrong


@pytest.mark.first(1)
@pytest.mark.parametrize("overwrite", [True, False])
@pytest.mark.parametrize("before", ["absent", "empty", "old"])
def test_each_of_several_writers_finds_a_place(overwrite: bool, before: str, tmp_path: Path) -> None:
    for turn in range(ROUNDS):
        folder = tmp_path / str(turn) / "plan"
        folder.parent.mkdir()
        if before != "absent":
            folder.mkdir()
        if before == "old":
            (folder / "plan.json").write_text('{"case": "old"}')

        def write(number: int, folder: Path = folder) -> None:
            with atomic_folder(folder, PLAN, overwrite) as part:
                for name in ("plan.json", "motion.csv"):
                    (part / name).write_text(str(number))

        wrong = written_at_once(write)
        assert all(isinstance(error, FileProblem) and "the new one is in" in str(error) for error in wrong), wrong
        found = {p.name: {f.read_text() for f in p.iterdir() if f.name != MARKER} for p in folder.parent.iterdir()}
        assert all(len(texts) == 1 for texts in found.values()), found
        if overwrite:
            assert (list(found), wrong) == (["plan"], [])
        else:
            assert len(found) == WRITERS + (before == "old")
            assert len(wrong) == len(found) - 1
