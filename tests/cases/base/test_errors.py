"""An error says place, problem and remedy in one line, and comes back whole from another process."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import (
    WITH_OUTPUT,
    CaseError,
    Code,
    FileProblem,
    HexciteError,
    ProgramError,
    RecordingError,
    option,
)
from tests.helpers import one_line

WORDS = st.text(st.characters(exclude_categories=("C", "Z"), exclude_characters=";:"), min_size=1)


@given(place=WORDS, problem=WORDS, remedy=WORDS | st.just(""), kind=st.sampled_from([FileProblem, RecordingError]))
def test_the_line_is_made_of_the_parts(place: str, problem: str, remedy: str, kind: type[HexciteError]) -> None:
    error = kind(place=place, problem=problem, remedy=remedy, code=Code.UNIT)
    assert (error.place, error.problem, error.remedy) == (place, problem, remedy)
    assert one_line(error) == f"{place}: {problem}" + (f"; {remedy}" if remedy else "")


@given(problem=WORDS, remedy=WORDS)
def test_a_sentence_ends_with_its_remedy(problem: str, remedy: str) -> None:
    error = HexciteError(problem=f"{problem}", remedy=f"{remedy}", code=Code.WRONG_KIND)
    assert (error.place, error.remedy) == ("", remedy)
    assert HexciteError(problem=problem, code=Code.WRONG_KIND).remedy == ""


def test_errors_of_cases_and_programs_know_key_and_line() -> None:
    case = CaseError(
        file="case.toml",
        key="machine.home",
        problem="is out of reach",
        problems=("two", "problems"),
        remedy="move it",
        code=Code.INFEASIBLE,
    )
    assert (case.place, case.quantity, case.remedy) == ("case.toml: machine.home", "machine.home", "move it")
    program = ProgramError(
        file="run.ngc", line=7, column=3, problem="G5 is not known", remedy="write G1", code=Code.SYNTAX
    )
    assert (program.place, program.remedy) == ("run.ngc, line 7, column 3", "write G1")
    assert one_line(program) == "run.ngc, line 7, column 3: G5 is not known; write G1"


@pytest.mark.parametrize(
    "error",
    [
        HexciteError(problem="no", remedy="yes", code=Code.WRONG_KIND),
        FileProblem(place="a", problem="b", remedy="c", code=Code.WRONG_KIND),
        CaseError(file="f", key="k", problem="p", problems=("x",), remedy="r", code=Code.WRONG_KIND),
        ProgramError(file="f", line=1, column=2, problem="p", remedy="r", code=Code.SYNTAX),
    ],
)
def test_errors_come_back_whole_from_a_worker(error: HexciteError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_mathematics_does_not_know_the_file() -> None:
    error = RecordingError(place="line 7", problem="is not a number", remedy="correct it", code=Code.WRONG_KIND).at(
        "run.csv"
    )
    assert type(error) is RecordingError
    assert (str(error), error.place) == ("run.csv: line 7: is not a number; correct it", "run.csv: line 7")
    assert str(error.at("run.csv")) == str(error)
    assert (
        RecordingError(problem="is empty", remedy="record again", code=Code.CONTRADICTION).at("run.csv").place
        == "run.csv"
    )


def test_the_library_names_arguments_where_the_command_line_names_options() -> None:
    error = HexciteError(
        place=f"{option('time_limit')} 0 s",
        problem="is too short; see hexcite bound CASE --model",
        remedy=f"allow {option('time_limit')} 60",
        code=Code.OUT_OF_RANGE,
    )
    assert str(error) == "time_limit 0 s: is too short; see hexcite bound CASE --model; allow time_limit 60"
    assert error.typed == "--time-limit 0 s: is too short; see hexcite bound CASE --model; allow --time-limit 60"
    assert (error.place, error.remedy) == ("time_limit 0 s", "allow time_limit 60")
    remedy = f"choose another place{WITH_OUTPUT}, or {option('overwrite')}"
    there = FileProblem(place="a.json", problem="is there", remedy=remedy, code=Code.EXISTS)
    assert str(there) == "a.json: is there; choose another place, or overwrite"
    assert there.typed == "a.json: is there; choose another place with -o, or --overwrite"


def test_an_error_inside_another_one_names_options_where_it_is_read() -> None:
    inner = HexciteError(problem="takes long", remedy=f"allow {option('time_limit')} 60", code=Code.INFEASIBLE)
    outer = RecordingError(place="run.csv", problem=inner.message, code=inner.code).beside([f"see {option('case')}"])
    assert str(outer) == "run.csv: takes long; allow time_limit 60; also: see case"
    assert outer.typed == "run.csv: takes long; allow --time-limit 60; also: see --case"


@given(text=st.text(st.characters(exclude_characters="\ufdd0\ufdd1\ufdd2\ufdd3\ufdd4")))
def test_no_text_is_rewritten_that_does_not_say_that_it_names_an_option(text: str) -> None:
    """Whatever a path or value holds, such as two hyphens and a word."""
    error = HexciteError(place=text, problem=f"{text} --final", remedy=text, code=Code.MISSING)
    assert (error.place, error.problem, error.remedy) == (text, f"{text} --final", text)
    assert str(error) == error.typed


@pytest.mark.parametrize("file", ["/data/run --final.csv", "/data/run --final", "run --a/-- b --c.toml"])
def test_the_name_of_a_file_is_not_rewritten_whatever_it_holds(file: str) -> None:
    remedy = f"record again, or {option('overwrite')}"
    error = HexciteError(place=file, problem="is empty", remedy=remedy, code=Code.EXISTS)
    assert (error.place, error.remedy) == (file, "record again, or overwrite")
    assert str(error) == f"{file}: is empty; record again, or overwrite"
    assert error.typed == f"{file}: is empty; record again, or --overwrite"
    assert str(RecordingError(problem="holds no row", code=Code.TOO_FEW).at(file)).startswith(f"{file}: ")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
