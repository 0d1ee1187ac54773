"""Words in the fields of a table: states of a switch and values that are missing; fields that hold the last value."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import RecordingError
from cases.recording_format import FileFormat
from identification.looks.looking import look
from identification.recording.formats.words import MISSING, is_value, regular
from identification.recording.recording import read
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, case_with, csv, rows, written

RUN = Truth()
SWITCHED = (RUN.t > 0.01) & (RUN.t < 0.03)
HELD = NAMES.index("f4_N")


def with_trigger(words: tuple[str, str], delimiter: str = ",", decimal: str = ".") -> str:
    lines = rows(RUN.numbers(), delimiter, decimal)
    lines = [f"{line}{delimiter}{words[int(on)]}" for line, on in zip(lines, SWITCHED, strict=True)]
    return "\n".join([delimiter.join([*NAMES, "trigger"]), *lines]) + "\n"


@pytest.mark.parametrize("words", [("FALSE", "TRUE"), ("false", "true"), ("Falsch", "Wahr"), ("FALSCH", "WAHR")])
@pytest.mark.parametrize("delimiter", [",", ";"])
def test_a_switch_may_be_in_words(words: tuple[str, str], delimiter: str, tmp_path: Path) -> None:
    decimal = "," if delimiter == ";" else "."
    file = written(tmp_path, with_trigger(words, delimiter, decimal))
    case = case_with(delimiter=delimiter, decimal=decimal)
    assert np.array_equal(read(file, case).trigger, SWITCHED)
    seen = look(file, HEXAPOD)
    assert seen.reads, seen.odd


def test_a_switch_that_begins_as_a_number_may_go_on_in_words(tmp_path: Path) -> None:
    """Beyond what is looked at first, some rows are written anew."""
    long = Truth(count=9000)
    on = long.t > 4.0
    words = np.where(np.arange(len(on)) < 8000, np.where(on, "1", "0"), np.where(on, "TRUE", "FALSE"))
    lines = [f"{line},{word}" for line, word in zip(rows(long.numbers()), words, strict=True)]
    file = written(tmp_path, "\n".join([",".join([*NAMES, "trigger"]), *lines]))
    recording = read(file, HEXAPOD)
    assert np.array_equal(recording.trigger, on)
    np.testing.assert_allclose(recording.forces, long.forces, rtol=1e-8)


def test_a_force_is_not_a_switch(tmp_path: Path) -> None:
    lines = with_trigger(("FALSE", "TRUE")).splitlines()
    lines[5] = lines[5].replace(lines[5].split(",")[HELD], "TRUE")
    with pytest.raises(RecordingError, match=r"line 6, f4_N: 'TRUE' is not a number"):
        read(written(tmp_path, "\n".join(lines)), HEXAPOD)


@pytest.mark.parametrize(
    "word", ["--", "#N/A", "1.#QNAN", "-1.#IND00", "NaN", "n/a", "#NV", "null", " -- ", "-nan(ind)"]
)
def test_a_word_for_no_value_is_bridged_like_an_empty_field(word: str, tmp_path: Path) -> None:
    lines = csv(RUN.numbers()).splitlines()
    fields = lines[21].split(",")
    fields[HELD] = word
    lines[21] = ",".join(fields)
    recording = read(written(tmp_path, "\n".join(lines)), HEXAPOD)
    assert np.flatnonzero(recording.missing).tolist() == [20]
    assert recording.missing_in == ("f4_N",)
    cubic = RUN.forces[[18, 19, 21, 22], 3] @ [-1.0, 4.0, 4.0, -1.0] / 6.0  # through its neighbours
    assert recording.forces[20, 3] == pytest.approx(cubic)
    np.testing.assert_allclose(np.delete(recording.forces, 20, 0), np.delete(RUN.forces, 20, 0), rtol=1e-8)


@given(st.sampled_from([*MISSING, "nan", "1.5", "-2e3", "1.5D+03", ".5"]), st.sampled_from(["", " ", "\t "]))
def test_what_a_field_may_be_has_one_meaning(word: str, blanks: str) -> None:
    """What `look` takes for a value the reader turns into a number, and the other way round."""
    form = FileFormat()
    assert is_value(blanks + word + blanks, form)
    number = regular(blanks + word + blanks, form, switch=False)
    assert number is not None
    assert number == "" or np.isfinite(float(number)) == (word[-1:].isdigit() and "#" not in word)


def sparse() -> str:
    """The run, a value of forces only where it has changed: in every third row."""
    held = RUN.forces[(np.arange(RUN.count) // 3) * 3]
    lines = rows(np.column_stack([RUN.t, RUN.struts * 1e3, held]))
    for k, line in enumerate(lines):
        if k % 3:
            lines[k] = ",".join([*line.split(",")[:7], *[""] * 6])
    return "\n".join([",".join(NAMES), *lines]) + "\n"


def test_an_empty_field_holds_the_last_value_where_the_case_says_so(tmp_path: Path) -> None:
    file = written(tmp_path, sparse())
    recording = read(file, case_with(empty="hold"))
    np.testing.assert_allclose(recording.forces, RUN.forces[(np.arange(RUN.count) // 3) * 3], rtol=1e-8)
    assert recording.missing is None
    with pytest.raises(RecordingError, match=r"line 3, f1_N: is empty, like 26 of the 40 .*'apart'.*'hold'"):
        read(file, HEXAPOD)
    assert look(file, HEXAPOD).settings["empty"] == "hold"


def test_what_holds_a_word_for_no_value_is_missing_too(tmp_path: Path) -> None:
    lines = sparse().splitlines()
    fields = lines[4].split(",")
    fields[HELD] = "--"
    lines[4] = ",".join(fields)
    recording = read(written(tmp_path, "\n".join(lines)), case_with(empty="hold"))
    assert np.flatnonzero(recording.missing).tolist() == [3, 4, 5]
