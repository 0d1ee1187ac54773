"""`post`, `check` and `run` refuse what cannot end well before they work, and list what they can do."""

import re
from pathlib import Path

import pytest

from cases.basis import motion_hash
from cases.schema import load_case
from hexcite._write import case_line
from tests.helpers import tells
from tests.hexcite.command_line import call, refused
from tests.postprocessors.programs import there_and_back, timed, typed


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """A small program with its trigger on."""
    file = tmp_path / "small.ngc"
    file.write_text(typed(f"M64 P0\n{timed(there_and_back())}\nM65 P0"))
    return file


def test_post_needs_a_plan():
    assert call("post").code == 2


def test_a_controller_that_does_not_exist_is_refused_before_anything_is_read(tmp_path: Path):
    line = refused("run", tmp_path / "none.ngc", "--case", "hexapod", "--on", "fanuc")
    assert tells(line, "'fanuc'", "choose virtual, linuxcnc")


def test_a_run_does_not_replace_the_folder_that_holds_its_program(program: Path):
    line = refused("run", program, "--case", "hexapod", "-o", program.parent)
    assert tells(line, "small.ngc", "is read", "another place")
    assert program.exists()


@pytest.mark.parametrize("name", ["small.txt", "small", "small.ngc.bak"])
def test_a_program_whose_suffix_names_no_controller_is_refused(name: str, program: Path):
    other = program.rename(program.with_name(name))
    assert tells(refused("check", other, "--case", "hexapod"), "no controller", ".ngc")


def test_the_suffix_counts_in_any_case(program: Path):
    shouted = program.rename(program.with_name("SMALL.NGC"))
    answer = call("check", shouted, "--case", "hexapod", "--json").json()
    assert answer["ok"]
    assert sorted(answer["relies_on"]) == ["acceleration", "jerk", "sensor force", "strut acceleration"]


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", "G1 X1 (\N{DEGREE SIGN})\n".encode(), b"G21 G90\rG1 X5\nM2\n"])
def test_bytes_that_are_no_ascii_line_of_the_controller_are_refused_with_their_place(content: bytes, program: Path):
    program.write_bytes(content)
    line = refused("check", program, "--case", "hexapod")
    assert "small.ngc, line 1, column" in line
    assert "is not plain ASCII" in line


@pytest.mark.parametrize(
    ("machine", "settings", "said"),
    [
        ("", "", None),
        ("0", "", r"for hexapod with another .machine., .workspace., .limits."),
        ("", "0", "other settings of .controller."),
    ],
)
def test_a_program_of_another_state_of_the_case_is_checked_by_this_one_and_says_so(
    machine: str, settings: str, said: str | None, program: Path
):
    case = load_case("hexapod")
    header = case_line(case)
    for hash_, change in ((motion_hash(case), machine), (case.controller_hash, settings)):
        header = header.replace(hash_, change * 16 or hash_)
    program.write_text(f"(- {header})\n{program.read_text()}")
    answer = call("check", program, "--case", "hexapod", "--json").json()
    assert answer["ok"]
    found = [remark for remark in answer["remarks"] if "written" in remark]
    assert len(found) == (said is not None)
    assert all(re.search(str(said), remark) for remark in found)


@pytest.mark.parametrize(
    ("command", "case"), [("check", "five_axis_table"), ("check", "ft_wrist"), ("run", "ur10_wrist")]
)
def test_a_program_that_a_machine_cannot_even_read_names_its_own(command: str, case: str, program: Path):
    program.write_text(f"(- {case_line(load_case('hexapod'))})\n{program.read_text()}")
    line = refused(command, program, "--case", case)
    assert tells(line, "another case, hexapod", f"this is {case}; ")


def test_a_program_checked_by_the_wrong_case_is_named_as_that_and_each_limit_stands_once(tmp_path: Path):
    program = tmp_path / "far.ngc"
    moves = "\n".join(f"G1 X{x} F3000" for x in (-400, 400, -410, 410))
    program.write_text(f"(- {case_line(load_case('hexapod'))})\n{typed(moves)}".replace("case hexapod", "case other"))
    answer = call("check", program, "--case", "hexapod")
    assert answer.code == 1
    assert tells(answer.refusal(), "another case, other", "this is hexapod; ")
    told = [line for line in answer.out.splitlines() if line.startswith("line ")]
    limits = [line.split(": ", 1)[1].split(" reaches")[0].split(" (")[0] for line in told]
    assert len(limits) == len(set(limits))
    assert any(re.search(r"position \(x\) .*\d+ more lines", line) for line in told)
