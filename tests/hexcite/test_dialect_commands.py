"""`check` and `run` take programs of every dialect, told by the ending or by name."""

from pathlib import Path
from typing import Any

import pytest

from cases.base.errors import CaseError
from cases.schema import load_case
from hexcite._run import exceeded
from identification.limits.limit import LimitKind
from planner.plans.plan import Plan
from postprocessors.dialects.setpoints.write import write_setpoints
from postprocessors.dialects.twincat.promises import twincat_guarantees
from postprocessors.program import DIALECTS, require_language
from postprocessors.reading import Reading
from tests.helpers import tells
from tests.hexcite.command_line import call, refused
from tests.postprocessors.other_dialects import BOTH, SINUMERIK, TWINCAT, Typed, smooth_points
from tests.postprocessors.test_setpoints import CASE, moves

ENDING = {"sinumerik": "mpf", "twincat": "nc"}


def written(typed: Typed, folder: Path, ending: str) -> Path:
    file = folder / f"small.{ending}"
    on, off = ("DO $A_OUT[1]=1", "DO $A_OUT[1]=0\nG4 F0.1") if typed is SINUMERIK else ("M100", "M101")
    file.write_text(typed.text(f"{on}\n{typed.timed(smooth_points(typed, 'X', 2.0))}\n{off}"))
    return file


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_a_program_is_checked_by_its_ending_and_by_the_name_of_its_language(typed: Typed, tmp_path: Path):
    by_ending = call("check", written(typed, tmp_path, ENDING[typed.name]), "--case", "hexapod", "--json").json()
    by_name = call(
        "check", written(typed, tmp_path, "txt"), "--case", "hexapod", "--dialect", typed.name, "--json"
    ).json()
    assert by_ending["ok"]
    assert by_ending == by_name
    assert by_ending["limits"]["jerk"]["status"] == "enforced by controller"


def test_the_wrong_language_is_refused_with_its_first_strange_word(tmp_path: Path):
    file = written(TWINCAT, tmp_path, "nc")
    assert tells(refused("check", file, "--case", "hexapod", "--dialect", "sinumerik"), "line 1, column 1: ", "'%TEST'")
    assert tells(
        refused("check", file, "--case", "hexapod", "--dialect", "fanuc"),
        "'fanuc'",
        "choose linuxcnc, sinumerik, twincat, urscript, setpoints",
    )


def test_tables_are_checked(tmp_path: Path):
    file = tmp_path / "table.csv"
    file.write_bytes(write_setpoints(moves(), CASE))
    answer = call("check", file, "--case", "hexapod", "--json").json()
    assert answer["ok"]
    assert answer["relies_on"] == []


def test_a_table_that_is_something_else_is_refused(tmp_path: Path):
    file = tmp_path / "recording.csv"
    file.write_text("t_s,l1_mm\n0,1\n")
    assert tells(refused("check", file, "--case", "hexapod"), "columns", "t_s,x_mm,..,trigger")


def test_a_case_without_settings_names_the_missing_table(tmp_path: Path):
    text = Path("cases/hexapod/case.toml").read_text(encoding="utf-8")
    start, end = text.index("[controller.twincat]"), text.index("[controller.setpoints]")
    case = tmp_path / "case.toml"
    case.write_text(text[:start] + text[end:], encoding="utf-8")
    line = refused("check", written(TWINCAT, tmp_path, "nc"), "--case", case)
    assert tells(line, "controller.twincat: ", "missing", "add the table")
    assert tells(line, "linuxcnc or sinumerik or setpoints")  # what the case has


@pytest.mark.parametrize(
    ("case", "dialect", "machine"),
    [
        ("ur10_wrist", "sinumerik", "X, Y, Z, A, B, C"),
        ("ur10_wrist", "twincat", "X, Y, Z, A, B, C"),
        ("ur10_wrist", "linuxcnc", "X, Y, Z, A, B, C"),
        ("hexapod", "ros2", "a chain of joints"),
        ("five_axis_table", "urscript", "six joints"),
    ],
)
@pytest.mark.parametrize("command", ["check", pytest.param("run", marks=pytest.mark.repeats)])
def test_a_language_of_other_machines_is_named_as_that(
    command: str, case: str, dialect: str, machine: str, tmp_path: Path
):
    """No table of the case would mend it."""
    file = tmp_path / f"program{DIALECTS[dialect].suffix}"
    file.write_text("G90\nM30\n")
    line = refused(command, file, "--case", case)
    assert tells(line, f"case {case}: machine: {dialect} runs programs of", machine)
    assert "controller." not in line
    with pytest.raises(CaseError, match="runs programs of"):
        require_language(load_case(case), DIALECTS[dialect])
    for other in line.split("name a program of ")[1].split(" or "):
        require_language(load_case(case), DIALECTS[other])


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (("post", "plan", "--dialect", "twincatt"), "did you mean twincat?"),
        (("plan", "hexapod", "--family", "splin"), "did you mean spline?"),
        (("plan", "hexapod", "--criterion", "d"), "did you mean D?"),
        (("validate", "hexapod", "--methods", "D9n"), "did you mean D9N?"),
        (("case", "check", "hexpod"), "did you mean 'hexapod'?"),
        (("run", "p.ngc", "--case", "hexapod", "--on", "virtal"), "did you mean virtual?"),
    ],
)
def test_what_does_not_exist_proposes_the_nearest(words: tuple[str, ...], meant: str, saved_plan: Plan):
    assert tells(
        refused(*(str(saved_plan.folder) if word == "plan" and words[0] == "post" else word for word in words)), meant
    )


@pytest.mark.parametrize("real", [False, True])
def test_a_limit_that_only_the_built_in_controller_passes_is_not_put_down_to_the_machines(real: bool):
    """The case says that a TwinCAT keeps strut accelerations; the built-in controller and LinuxCNC do not."""
    guarantees = twincat_guarantees(Reading("p", (), 0), CASE)
    peaks = {LimitKind.ANGULAR_VELOCITY: 1.0, LimitKind.STRUT_ACCELERATION: 1.03}
    sentences = exceeded(peaks, guarantees, real)
    assert len(sentences) == real
    assert all(tells(sentence, "EXCEEDED BY THE CONTROLLER", ": strut acceleration") for sentence in sentences)
    assert exceeded({LimitKind.JERK: 1.005}, guarantees, real) == []


def test_a_program_is_written_in_the_language_that_its_suffix_names(planned: dict[str, Any], tmp_path: Path):
    answer = call("post", planned["plan"], "-o", tmp_path / "run.csv", "--json").json()
    assert answer["dialect"] == "setpoints"
    assert (tmp_path / "run.csv").is_file()
    assert "names no controller" in refused("post", planned["plan"], "-o", tmp_path / "run.txt")
    assert "ends in '.csv'" in refused("post", planned["plan"], "-o", tmp_path / "b.csv", "--dialect", "linuxcnc")
