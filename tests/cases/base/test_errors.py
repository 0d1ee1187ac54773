"""An error says place, problem and remedy in one line, and comes back whole from another process."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import CaseError, FileProblem, HexciteError, ProgramError, RecordingError
from tests.helpers import one_line

WORDS = st.text(st.characters(exclude_categories=("C", "Z"), exclude_characters=";:"), min_size=1)


@given(place=WORDS, problem=WORDS, remedy=WORDS | st.just(""), kind=st.sampled_from([FileProblem, RecordingError]))
def test_the_line_is_made_of_the_parts(place: str, problem: str, remedy: str, kind: type[HexciteError]) -> None:
    error = kind(place, problem, remedy)
    assert (error.place, error.problem, error.remedy) == (place, problem, remedy)
    assert one_line(error) == f"{place}: {problem}" + (f"; {remedy}" if remedy else "")


@given(problem=WORDS, remedy=WORDS)
def test_a_sentence_ends_with_its_remedy(problem: str, remedy: str) -> None:
    error = HexciteError(f"{problem}; {remedy}")
    assert (error.place, error.remedy) == ("", remedy)
    assert HexciteError(problem).remedy == ""


def test_errors_of_cases_and_programs_know_key_and_line() -> None:
    case = CaseError("case.toml", "machine.home", "is out of reach; move it", ("two", "problems"))
    assert (case.place, case.quantity, case.remedy) == ("case.toml: machine.home", "machine.home", "move it")
    program = ProgramError("run.ngc", 7, 3, "G5 is not known; write G1")
    assert (program.place, program.remedy) == ("run.ngc, line 7, column 3", "write G1")
    assert one_line(program) == "run.ngc, line 7, column 3: G5 is not known; write G1"


@pytest.mark.parametrize(
    "error",
    [
        HexciteError("no; yes"),
        FileProblem("a", "b", "c"),
        CaseError("f", "k", "p; r", ("x",)),
        ProgramError("f", 1, 2, "p; r"),
    ],
)
def test_errors_come_back_whole_from_a_worker(error: HexciteError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_mathematics_does_not_know_the_file() -> None:
    error = RecordingError("line 7", "is not a number", "correct it").at("run.csv")
    assert type(error) is RecordingError
    assert (str(error), error.place) == ("run.csv: line 7: is not a number; correct it", "run.csv: line 7")
    assert str(error.at("run.csv")) == str(error)
    assert RecordingError("is empty; record again").at("run.csv").place == "run.csv"


def test_the_library_names_arguments_where_the_command_line_names_options() -> None:
    error = HexciteError("--time-limit 0 s", "is too short; see hexcite bound CASE --model", "allow --time-limit 60")
    assert str(error) == "time_limit 0 s: is too short; see hexcite bound CASE --model; allow time_limit 60"
    assert error.typed == "--time-limit 0 s: is too short; see hexcite bound CASE --model; allow --time-limit 60"
    assert (error.place, error.remedy) == ("time_limit 0 s", "allow time_limit 60")
    assert str(HexciteError("a.json", "is there", "choose another place with -o, or --overwrite")).endswith(
        "choose another place, or overwrite"
    )


@pytest.mark.parametrize("file", ["/data/run --final.csv", "/data/run --final", "run --a/-- b --c.toml"])
def test_the_name_of_a_file_is_not_rewritten_whatever_it_holds(file: str) -> None:
    error = HexciteError(file, "is empty", "record again, or --overwrite")
    assert (error.place, error.remedy) == (file, "record again, or overwrite")
    assert str(error) == f"{file}: is empty; record again, or overwrite"
    assert error.typed == f"{file}: is empty; record again, or --overwrite"
    assert str(RecordingError("holds no row; record again").at(file)).startswith(f"{file}: ")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
