"""A pipe or a device is not a program: reading it would wait for ever, or take all memory."""

import os
from pathlib import Path

import pytest

from cases.base.errors import FileProblem, ProgramError
from cases.schema import load_case
from planner.families.manual import load_poses
from postprocessors.program import read_program
from tests.helpers import refused_at


@pytest.mark.parametrize("kind", ["pipe", "endless device", "folder", "nothing"])
def test_what_is_not_a_regular_file_is_refused_at_once(kind: str, tmp_path: Path) -> None:
    place = {"endless device": Path("/dev/zero"), "folder": tmp_path}.get(kind, tmp_path / "run.ngc")
    if kind == "pipe":
        os.mkfifo(place)
    problem = {"folder": "is a folder", "nothing": "No such file"}.get(kind, "is a pipe or device, not a file")
    with refused_at(place, rf"cannot be read \({problem}.*name a program file", ProgramError):
        read_program(place, load_case("hexapod"), "linuxcnc")
    with pytest.raises(FileProblem, match=rf"cannot be read \({problem}.*CSV of poses"):
        load_poses(place)
