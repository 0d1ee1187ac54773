"""However a program lays out its table, the case can say so, and the run that is read is the same."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.base.errors import RecordingError
from identification.recording.recording import read
from tests.helpers import examples, refused_at
from tests.identification.recording.formats.runs import NAMES, Truth, case_with, csv, rows, written

RUN = Truth()
LENGTHS = {"mm": 1e-3, "m": 1.0, "um": 1e-6, "in": 0.0254, "cm": 1e-2}


@st.composite
def layouts(draw: st.DrawFn) -> tuple[str, dict[str, object]]:
    """A file's text, and what the case says of it."""
    delimiter = draw(st.sampled_from([",", ";", "\t", " ", "|", ":"]))
    decimal = draw(st.sampled_from([".", ","] if delimiter != "," else ["."]))
    above, below, end = draw(st.integers(0, 3)), draw(st.integers(0, 3)), draw(st.integers(0, 3))
    unit, newline = draw(st.sampled_from([*LENGTHS])), draw(st.sampled_from(["\n", "\r\n"]))
    order = draw(st.permutations(range(len(NAMES))))
    names = [f"{n} of axis" if delimiter != " " else n.upper() for n in NAMES]
    numbers = RUN.numbers(length=LENGTHS[unit])[:, order]
    lines = [
        *["written by a machine"] * above,
        delimiter.join(names[k] for k in order),
        *["unit" + delimiter + "N"] * below,
        *rows(numbers, delimiter, decimal),
        *["END OF DATA", "; 17 rows", "bye"][:end],
    ]
    text = newline.join(lines) + draw(st.sampled_from(["", newline, newline * 3]))
    settings = {
        "delimiter": delimiter, "decimal": decimal, "header_rows": above + below + 1, "names_row": above + 1,
        "trailing_rows": end, "columns": dict(zip(NAMES, names, strict=True)), "units": {"struts": unit},
    }  # fmt: skip
    return text, settings


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(100))
@given(layout=layouts(), mark=st.sampled_from(["", "\ufeff"]))
def test_any_layout_that_the_case_states_is_read(
    layout: tuple[str, dict[str, object]], mark: str, tmp_path: Path
) -> None:
    text, says = layout
    recording = read(written(tmp_path, mark + text), case_with(**says))
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)


def test_names_of_a_table_without_any_come_from_the_case(tmp_path: Path) -> None:
    file = written(tmp_path, "\n".join(rows(RUN.numbers())))
    recording = read(file, case_with(column_names=NAMES))
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)


def test_names_in_the_letters_of_windows_are_found(tmp_path: Path) -> None:
    names = ["Länge" if n == "l1_mm" else n for n in NAMES]
    file = written(tmp_path, csv(RUN.numbers(), names).encode("cp1252"))
    case = case_with(encoding="cp1252", columns={"l1_mm": "Länge"})
    np.testing.assert_allclose(read(file, case).drives, RUN.struts, rtol=1e-8)
    with pytest.raises(RecordingError, match=r"not UTF-8.*save"):
        read(file, case_with(columns={"l1_mm": "Länge"}))


def test_a_column_that_the_case_gives_another_meaning_has_only_this_one(tmp_path: Path) -> None:
    drives = {f"l{k}_mm": f"q{k}_mm" for k in range(1, 7)}
    file = written(tmp_path, csv(RUN.numbers(), [drives.get(n, n) for n in NAMES]))
    np.testing.assert_allclose(read(file, case_with(columns=drives)).drives, RUN.struts, rtol=1e-8)


WRONG = {
    "semicolons": (csv(RUN.numbers(), delimiter=";"), {}, r"none of .* it has t_s;l1_mm;.*separator.* hexcite look"),
    "commas": (csv(RUN.numbers()), {"delimiter": ";"}, r"none of .* it has t_s,l1_mm,.*separator.* hexcite look"),
    "blanks": (csv(RUN.numbers(), delimiter=" "), {}, r"it has t_s l1_mm .*separator"),
    "decimal comma": (
        csv(RUN.numbers(), delimiter=";", decimal=","),
        {"delimiter": ";"},
        r"line 2, l1_mm: '[0-9]+,[0-9]+' is not a number with a decimal '\.'; .*set recording.decimal",
    ),
    "decimal point": (
        csv(RUN.numbers(), delimiter=";"),
        {"delimiter": ";", "decimal": ","},
        r"line 2, l1_mm: '[0-9]+\.[0-9]+' is not a number with a decimal ','; .*set recording.decimal",
    ),
    "commas for both": (csv(RUN.numbers(), decimal=","), {}, r"line 2: expected 13 columns, got 2.*delimiter, decimal"),
    "a title": ("title\n" + csv(RUN.numbers()), {}, r"it has title: .*header in .recording. .*look proposes"),
    "units below": (
        csv(RUN.numbers()).replace("\n", "\ns,mm" + ",N" * 11 + "\n", 1),
        {},
        r"line 2, \w+: '\w+' is not a number",
    ),
    "rows below": (csv(RUN.numbers()) + "END\n", {}, r"line 42: expected 13 columns, got 1; correct or remove the row"),
    "more header than file": (csv(RUN.numbers()), {"header_rows": 100}, r"has 42 lines, no more than .*rows = 100"),
    "no names": (csv(RUN.numbers()), {"header_rows": 0}, r"header_rows = 0 leaves no names; .*column_names"),
    "names for fewer columns": (csv(RUN.numbers()), {"column_names": NAMES[1:], "header_rows": 1}, "12 .*got 13"),
    "another unit": (csv(RUN.numbers(length=1.0)), {}, r"line 2: struts of 1(\.0\d+|) mm where .* 1550 mm; .* in m: "),
    "another unit declared": (csv(RUN.numbers()), {"units": {"struts": "m"}}, r"they seem to be in mm: .* = 'mm'"),
    "inches": (csv(RUN.numbers(length=0.0254)), {}, r"they seem to be in in: set recording.units.struts = 'in'"),
    "two of one name": (csv(RUN.numbers(), [*NAMES[:-1], "f1_N"]), {}, r"column f1_N is there twice; rename"),
    "cut off": (csv(RUN.numbers())[:-40].rstrip(), {}, r"line 41: expected 13.* cut off in its last line: remove"),
    "zeros at the end": (csv(RUN.numbers()) + "\0" * 3000, {}, r"line 42: is binary zero, as after a crash"),
    "a spreadsheet": (b"PK\x03\x04" + bytes(500), {}, r"a workbook.*save the sheet as CSV"),
    "compressed": (b"\x1f\x8b" + bytes(500), {}, r"is a damaged gzip file; copy it again"),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(500), {}, r"is a picture; export"),
    "one endless line": (b"1" * 3_000_000, {}, r"line 1: is longer than a million|none of the columns"),
    "an endless line below": (csv(RUN.numbers()).encode() + b"1" * 6_000_000, {}, r"expected 13 columns, got 1"),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_what_the_case_states_wrongly_is_named_with_the_setting(what: str, tmp_path: Path) -> None:
    content, says, message = WRONG[what]
    file = written(tmp_path, content)
    with refused_at(file, message):
        read(file, case_with(**says))


def test_a_pipe_is_no_recording(tmp_path: Path) -> None:
    """Opening one would wait for somebody to write."""
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(RecordingError, match=r"pipe\.csv: .*not a regular file"):
        read(tmp_path / "pipe.csv", case_with())


def test_what_hexcite_wrote_is_read_whatever_the_case_says_of_other_files(tmp_path: Path) -> None:
    """The folder of `hexcite run` has our names and units; beside `recording.json` its file is known to be ours."""
    written(tmp_path, csv(RUN.numbers()), "recording.csv")
    written(tmp_path, "{}", "recording.json")
    elsewhere = case_with(format="twincat-scope", decimal=",", columns={"l1_mm": "MAIN.l1"}, units={"forces": "kN"})
    for place in (tmp_path, tmp_path / "recording.csv"):
        np.testing.assert_allclose(read(place, elsewhere).forces, RUN.forces, rtol=1e-8)
