"""A process that is killed while it writes leaves the old file whole."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from cases.base.atomic import atomic_folder, write_text
from cases.base.folder_kinds import MARKER, PLAN

WRITE_FILE = """
import sys
from pathlib import Path
from cases.base.atomic import atomic_file
with atomic_file(Path(sys.argv[1])) as part:
    file = part.open("w")
    file.write("n" * 100_000)
    file.flush()
    print("half", flush=True)
    sys.stdin.read()
"""

WRITE_FOLDER = """
import sys
from pathlib import Path
from cases.base.atomic import atomic_folder
from cases.base.folder_kinds import MARKER, PLAN
with atomic_folder(Path(sys.argv[1]), PLAN) as part:
    (part / "plan.json").write_text("new")
    print("half", flush=True)
    sys.stdin.read()
"""


def kill_in_the_middle(program: str, target: Path) -> None:
    """Runs a program until it says that half is written, then takes it away."""
    with subprocess.Popen(
        [sys.executable, "-c", program, str(target)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as writer:
        assert writer.stdout.readline() == "half\n"
        writer.kill()
        assert writer.wait() == -signal.SIGKILL


@pytest.mark.parametrize("old", ["old", None])
def test_a_file_stays_as_it_was(old: str | None, tmp_path: Path) -> None:
    target = tmp_path / "result.json"
    if old is not None:
        write_text(target, old)
    kill_in_the_middle(WRITE_FILE, target)
    assert (target.read_text() if target.exists() else None) == old


def test_what_a_killed_process_left_does_not_keep_the_next_one_from_writing(tmp_path: Path) -> None:
    target = tmp_path / "result.json"
    kill_in_the_middle(WRITE_FILE, target)
    write_text(target, "new")
    assert target.read_text() == "new"


def test_a_folder_stays_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "plan"
    with atomic_folder(target, PLAN) as part:
        (part / "plan.json").write_text("old")
        (part / "motion.csv").write_text("old")
    kill_in_the_middle(WRITE_FOLDER, target)
    kept = {p.name: p.read_text() for p in target.iterdir() if p.name != MARKER}
    assert kept == {"plan.json": "old", "motion.csv": "old"}
