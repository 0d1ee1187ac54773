"""Disks that are full or read-only, and a recording that grows while it is read: one line, and nothing half-written."""

import subprocess
import threading
from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import RecordingError
from cases.schema import Case
from identification.recording.recording import read
from tests.helpers import one_line
from tests.hexcite.command_line import PROGRAM, Answer

# A file system of its own in a namespace of its own, where root too is refused; what is left on it is told at the end.
ON_A_DISK = """
mount -t tmpfs -o size="$1" none "$2" || exit 77
[ "$3" = ro ] && mount -o remount,ro "$2"
shift 3; "$@"; code=$?
ls -A "$0" >&2
exit $code
"""


def on_disk(size: str, mode: str, place: Path, *words: object) -> Answer:
    """A command whose output goes to a disk of `size`, mounted `rw` or `ro` at `place`; skips where none can be had."""
    place.mkdir(exist_ok=True)
    shell = ["unshare", "-rm", "sh", "-c", ON_A_DISK, place, size, place, mode, PROGRAM, *words]
    try:
        run = subprocess.run([*map(str, shell)], capture_output=True, text=True, timeout=1200)
    except FileNotFoundError:
        pytest.skip("unshare is missing")
    if run.returncode == 77 or "unshare:" in run.stderr:
        pytest.skip(f"no file system can be mounted here: {run.stderr.strip()}")
    return Answer(run.returncode, run.stdout, run.stderr)


COMMANDS = {
    "plan": ("plan", "hexapod", "--family", "manual"),
    "post": ("post", "plan", "--accept", "acceleration,jerk,strut-acceleration,sensor-force"),
    "run": ("run", "excitation.ngc", "--case", "hexapod"),
    "identify": ("identify", "recording"),
    "export": ("export", "result", "--to", "c"),
}


@pytest.mark.parametrize(
    ("command", "size", "mode", "word"),
    [
        ("post", "1m", "ro", "Read-only file system"),
        pytest.param("identify", "300k", "rw", "make room there", marks=pytest.mark.slow),
        *(
            pytest.param(command, size, mode, word, marks=pytest.mark.slow)
            for size, mode, word in (("12k", "rw", "make room there"), ("1m", "ro", "Read-only file system"))
            for command in COMMANDS
            if (command, mode) not in (("post", "rw"), ("post", "ro"))
        ),
    ],
)
def test_a_full_or_read_only_disk_is_told_in_one_line_and_keeps_nothing(
    command: str, size: str, mode: str, word: str, chain: dict[str, Any], shared: Path, tmp_path: Path
) -> None:
    words = [shared / w if (shared / w).exists() and w != command else w for w in COMMANDS[command]]
    target = tmp_path / "disk" / ("p.ngc" if command == "post" else "out")
    line = on_disk(size, mode, tmp_path / "disk", *words, "-o", target).refusal()  # and no file is listed behind it
    assert word in line
    assert str(target) in line


def test_a_recording_that_grows_while_it_is_read_is_read_or_refused(
    chain: dict[str, Any], shared: Path, tmp_path: Path, hexapod_case: Case
) -> None:
    content, file, ended = (
        (shared / "recording" / "recording.csv").read_bytes(),
        tmp_path / "run.csv",
        threading.Event(),
    )
    file.touch()

    def write() -> None:
        with file.open("ab", buffering=0) as out:
            for k in range(0, len(content), 997):  # mostly in the middle of a row
                out.write(content[k : k + 997])
        ended.set()

    writer = threading.Thread(target=write)
    writer.start()
    rows = []
    while not ended.is_set():
        try:
            rows.append(len(read(file, hexapod_case).forces))
        except RecordingError as error:
            assert str(file) in one_line(error)
    writer.join()
    assert rows == sorted(rows)
    assert len(read(file, hexapod_case).forces) == content.count(b"\n") - 1
