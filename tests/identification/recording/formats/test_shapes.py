"""Headers and rows that do not match at first sight: the table is read nevertheless, by `look` and by the reader."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.base.errors import RecordingError
from identification.looks.looking import look
from identification.recording.formats.content import Content, blocks_of, lines_of, section_of
from identification.recording.formats.text_numbers import squeezed
from identification.recording.formats.words import aligned_fields
from identification.recording.recording import Recording, read
from tests.helpers import examples, refused_at
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, case_with, csv, rows, written

RUN = Truth()
ROWS = rows(RUN.numbers())


def require_the_run(recording: Recording) -> None:
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)


def aligned(width: int = 16, names: str = " ".join(NAMES), left: bool = False) -> str:
    lines = ["".join(f.ljust(width) if left else f.rjust(width) for f in row.split(",")) for row in ROWS]
    return "\n".join([names, *lines]) + "\n"


def fortran(value: float) -> str:
    return f"{value:.9e}".replace("e", "D")


READABLE: dict[str, str] = {
    "a separator behind each row": csv(RUN.numbers()).replace("\n", ",\n").replace(",\n", "\n", 1),
    "a separator behind each line": csv(RUN.numbers()).replace("\n", ",\n"),
    "two separators behind some rows": csv(RUN.numbers()).replace("5\n", "5,,\n"),
    "row numbers without a name": "\n".join([",".join(NAMES), *(f"{k},{row}" for k, row in enumerate(ROWS, 1))]),
    "quoted names": csv(RUN.numbers(), [f'"{name}"' for name in NAMES]),
    "quoted values": csv(RUN.numbers(), NAMES).replace(",", '","').replace("\n", '"\n"').join(['"', '"'])[:-2],
    "blanks behind separators": csv(RUN.numbers()).replace(",", ", "),
    "blank lines between the rows": csv(RUN.numbers()).replace("\n", "\n\n"),
    "lines of blanks between the rows": csv(RUN.numbers()).replace("\n", "\n  \n"),
    "remarks among the rows": csv(RUN.numbers()).replace("\n0.01,", "\n# on\n0.01,").replace("\n0.02,", "\n%\n0.02,"),
    "the separator in the first line": "sep=,\n" + csv(RUN.numbers()),
    "a remark's sign before the names": "# " + csv(RUN.numbers()),
    "a remark's sign on the names": "%" + csv(RUN.numbers()),
    "aligned to the right": aligned(),
    "aligned to the left": aligned(left=True),
    "aligned, a remark's sign before the names": aligned(names="# " + " ".join(NAMES)),
    "aligned names": aligned(names="".join(name.rjust(16) for name in NAMES)),
    "aligned, blanks behind each row": aligned().replace("\n", "  \n"),
    "aligned by two blanks each": "\n".join(["  ".join(NAMES), *(row.replace(",", "  ") for row in ROWS)]) + "\n",
    "the decimal comma in quotation marks": "\n".join(
        [",".join(NAMES), *('"' + row.replace(";", '","') + '"' for row in rows(RUN.numbers(), ";", ","))]
    ),
    "aligned with tabs": aligned().replace("    ", "\t "),
    "as MATLAB saves": "\n".join([" ".join(NAMES), *("".join(f"{v:16.7e}" for v in row) for row in RUN.numbers())]),
    "as Fortran writes": "\n".join(
        [" ".join(NAMES), *("  " + "  ".join(map(fortran, row)) for row in RUN.numbers())]
    ),
}  # fmt: skip


@pytest.mark.parametrize("how", READABLE)
def test_look_proposes_what_reads_the_run(how: str, tmp_path: Path) -> None:
    file = written(tmp_path, READABLE[how])
    seen = look(file, HEXAPOD)
    assert seen.reads, seen.odd
    recording = read(file, case_with(**seen.settings))
    if how == "as MATLAB saves":  # with eight digits
        np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-7)
    else:
        require_the_run(recording)


@pytest.mark.parametrize(
    "how",
    [how for how in READABLE if how[:3] != "the" and "ligned" not in how and "Fortran" not in how and how[:2] != "as"],
)
def test_what_is_separated_by_commas_needs_no_settings(how: str, tmp_path: Path) -> None:
    require_the_run(read(written(tmp_path, READABLE[how]), HEXAPOD))


def test_a_number_that_fills_its_column_touches_the_one_before(tmp_path: Path) -> None:
    lines = ["".join(f"{v:{10 if k < 7 else 9}.4f}" for k, v in enumerate(row)) for row in RUN.numbers()]
    few = [line for line in lines if len(line.split()) < len(NAMES)]
    assert 0 < len(few) < len(lines) / 2
    file = written(tmp_path, "\n".join([" ".join(NAMES), *lines]) + "\n")
    recording = read(file, case_with(**look(file, HEXAPOD).settings))
    np.testing.assert_allclose(recording.drives, RUN.struts, atol=1e-7)
    np.testing.assert_allclose(recording.forces, RUN.forces, atol=1e-4)


@pytest.mark.parametrize(
    ("line", "fields"),
    [
        ("1.5 2.5", ["1.5", "2.5"]),
        ("1.25-2.5 3", ["1.25", "-2.5", "3"]),
        ("1.-2.5-3.", ["1.", "-2.5", "-3."]),
        ("1.5e-03-2.5e+01 3", ["1.5e-03", "-2.5e+01", "3"]),
        ("2026-11-28 3", ["2026-11-28", "3"]),  # a day
        ("1.5-2.5", ["1.5-2.5"]),  # two fields, where three are expected
        ("a1.5-2 3", ["a1.5-2", "3"]),
    ],
)
def test_fields_that_touch_are_told_apart_where_all_are_there(line: str, fields: list[str]) -> None:
    assert aligned_fields(line, 3) == fields


def test_a_number_without_the_letter_of_its_exponent_is_not_two() -> None:
    assert aligned_fields("1.5-103 2.5", 2) == ["1.5-103", "2.5"]


HIOKI = [
    '"File name","WAVE0001.CSV","V1.00"', '"Title comment",""', '"Start trigger time","\'24-06-30 15:53:03"',
    ",".join(['"CH"', *(f'"CH{k}"' for k in range(1, 13))]), ",".join(['"Mode"', *['"DC"'] * 12]),
    ",".join(['"Range"', *['"5V"'] * 12]), ",".join(['"Comment"', *['""'] * 12]),
]  # fmt: skip
PLAIN = [*(f"Strut{k}" for k in range(1, 7)), *(f"Force{k}" for k in range(1, 7))]
LINE, UNITS = ",".join(["Time", *PLAIN]), "s" + ",mm" * 6 + ",N" * 6
LABELS = ",".join(["Time", *(f"{name}[{unit}]" for name, unit in zip(PLAIN, ["mm"] * 6 + ["N"] * 6, strict=True))])
HEADERS: dict[str, list[str]] = {
    "names above units": [LINE, UNITS],
    "units above names": [UNITS, LINE],
    "numbers of channels above names": [*HIOKI, LABELS],
    "names above a line on each channel": [LABELS, "Sensor" + ",S2M/500" * 12, ""],
    "words about the run above names": ["Recorder 7", "Operator;somebody", "Rate: 1000 Hz", "", LABELS],
}


@pytest.mark.parametrize("how", HEADERS)
@pytest.mark.parametrize("end", ["", ","])
def test_names_are_found_in_the_line_that_has_them(how: str, end: str, tmp_path: Path) -> None:
    file = written(tmp_path, "\n".join([*HEADERS[how], *(row + end for row in ROWS)]) + "\n")
    seen = look(file, HEXAPOD)
    assert seen.reads, seen.odd
    require_the_run(read(file, case_with(**seen.settings)))


@pytest.mark.parametrize("names", [None, ["zeit", *(f"b{k}" for k in range(12))], NAMES])
def test_a_headless_file_is_looked_at_and_its_columns_are_to_be_named(names: list[str] | None, tmp_path: Path) -> None:
    file = written(tmp_path, "\n".join(ROWS))
    seen = look(file)
    assert seen.settings["column_names"] == [f"column {k}" for k in range(1, 14)]
    assert seen.rows == RUN.count
    if names is NAMES:
        require_the_run(read(file, case_with(column_names=names)))
    elif names is None:
        with pytest.raises(RecordingError, match=r"line 1: holds numbers where names should be; .*column_names"):
            read(file, HEXAPOD)
    else:
        with pytest.raises(
            RecordingError, match=r"none of the columns t_s, .*; it has zeit, b0 .. b11: .*recording.columns"
        ):
            read(file, case_with(column_names=names))


UNREADABLE: dict[str, tuple[str, str]] = {
    "a name too few": (csv(RUN.numbers(), NAMES[:-1]), r"line 2: expected 12 columns, got 13"),
    "a name too many": (csv(RUN.numbers(), [*NAMES, "f7_N"]), r"line 2: expected 14 columns, got 13"),
    "a row that ends early": (
        csv(RUN.numbers()).replace(ROWS[8], ROWS[8].rsplit(",", 1)[0]), r"line 10: .*13 .*got 12",
    ),
    "text behind a row": (csv(RUN.numbers()).replace(ROWS[8], ROWS[8] + ",here"), r"line 10: .* got 14"),
    "the end of a row": (csv(RUN.numbers())[:-20], r"line 41: .* cut off in its last line"),
}  # fmt: skip


@pytest.mark.parametrize("what", UNREADABLE)
def test_what_may_be_shifted_is_refused_with_its_line(what: str, tmp_path: Path) -> None:
    """Nobody can say which of the fields is missing, or is one too many."""
    text, message = UNREADABLE[what]
    file = written(tmp_path, text)
    with refused_at(file, message):
        read(file, HEXAPOD)


@given(
    words=st.lists(st.lists(st.sampled_from(["1", "-2.5", "3e4", "nan"]), min_size=2, max_size=5), max_size=30),
    data=st.data(),
)
def test_aligned_columns_keep_their_fields(words: list[list[str]], data: st.DataObject) -> None:
    blanks = st.text(" \t", min_size=1, max_size=4)
    lines = []
    for row in words:
        between = [data.draw(blanks) for _ in row[1:]]
        start, end = (data.draw(st.text(" \t", max_size=3)) for _ in range(2))
        lines.append(start + "".join(a + b for a, b in zip(row, [*between, ""], strict=True)) + end)
    newline = data.draw(st.sampled_from(["\n", "\r\n"]))
    assert (
        squeezed(newline.join(lines).encode()).decode().split(newline) == [" ".join(row) for row in words] or not words
    )


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(60))
@given(lengths=st.lists(st.integers(0, 20), max_size=40), size=st.integers(1, 50), end=st.sampled_from([b"", b"\n"]))
def test_lines_in_parts_are_the_lines(lengths: list[int], size: int, end: bytes, tmp_path: Path) -> None:
    text = Content(written(tmp_path, b"\n".join(b"x" * n for n in lengths) + end or b"\n"))
    section = section_of(text, 0, 0)
    whole, first = lines_of(text, section), section.first
    for number, part in blocks_of(text, section, size):
        assert number == first
        assert whole.startswith(part)
        whole, first = whole[len(part) :], first + part.count(b"\n")
    assert whole == b""
