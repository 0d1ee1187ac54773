"""Each damage of a recording is answered with one line: file, line and column, value, remedy."""

from collections.abc import Callable
from pathlib import Path

import pytest

from cases.base.errors import RecordingError
from cases.orientation import ROTATION
from cases.schema import Case, load_case
from identification.recording.recording import read
from tests.helpers import one_line, refused_at

CASE = load_case("hexapod")
NAMES = ["t_s", *(f"l{k}_mm" for k in range(1, 7)), *(f"f{k}_N" for k in range(1, 7)), "trigger"]
Table = list[list[str]]


def table() -> Table:
    """A header and nine rows; row k is line k + 1 of the file."""
    return [NAMES, *([f"{k / 1000:.3f}"] + ["980.5"] * 6 + ["-12.25"] * 6 + ["1"] for k in range(9))]


def csv(rows: Table, separator: str = ",") -> bytes:
    return "\n".join(separator.join(row) for row in rows).encode() + b"\n"


def cell(row: int, column: str, value: str) -> bytes:
    rows = [list(r) for r in table()]
    rows[row][NAMES.index(column)] = value
    return csv(rows)


def renamed(old: str, new: str) -> bytes:
    return csv([[new if n == old else n for n in NAMES], *table()[1:]])


def column(name: str, value: str) -> bytes:
    return csv([NAMES, *([value if n == name else v for n, v in zip(NAMES, r, strict=True)] for r in table()[1:])])


def without(*names: str) -> bytes:
    keep = [n not in names for n in NAMES]
    return csv([[v for v, k in zip(row, keep, strict=True) if k] for row in table()])


# damage -> file, and what the message must say
DAMAGES: dict[str, tuple[bytes, str]] = {
    "missing strut": (renamed("l2_mm", "zwei"), r"column l2_mm is missing; it has .*zwei.*: add it or map"),
    "missing force": (renamed("f3_N", "f3"), r"column f3_N is missing"),
    "no struts": (without(*NAMES[1:7]), r"no pose: none of the columns l1_mm, .*; it has t_s, f1_N"),
    "no forces": (without(*NAMES[7:13]), r"no forces: none of the columns f1_N"),
    "text in a number": (cell(4, "l2_mm", "9x0"), r", line 5, l2_mm: '9x0' is not a number .*; correct or remove"),
    "nothing in a column": (
        column("f1_N", ""),
        r", line 2, f1_N: is empty, like 9 of the 9 rows of this column, more than 30 %; record again",
    ),
    "nothing in most rows": (
        csv([*table()[:4], *[[*row[:3], "", *row[4:]] for row in table()[4:]]]),
        r", line 5, l3_mm: is empty, like 6 of the 9 rows of .*recording.empty = 'apart'.* 'hold'",
    ),
    "decimal comma in quotes": (cell(4, "f1_N", '"1,5"'), r", line 5, f1_N: '1,5' is not a number"),
    "digits that only Python reads": (cell(4, "l2_mm", "9_8_0"), r", line 5, l2_mm: '9_8_0' is not a number"),
    "digits of another script": (cell(4, "l2_mm", "١٢"), r", line 5, l2_mm: '١٢' is not a number"),
    "true": (column("l2_mm", "true"), r", line 2, l2_mm: 'true' is not a number"),
    "units below the header": (
        csv([NAMES, ["s", *["mm"] * 6, *["N"] * 6, "-"], *table()[1:]]),
        r"line 2, \w+: '(s|mm|N)' is not",
    ),
    "after a blank line": (cell(4, "l2_mm", "9x0").replace(b"\n0.001", b"\n\n0.001"), r"line (6, l2_mm|3)"),
    "time backwards": (cell(6, "t_s", "0.0001"), r"line 7, t_s: 0.0001 is not later .*sort the rows"),
    "trigger of both signs": (cell(4, "trigger", "-1"), r"line 5, trigger: -1.0 is not a level"),
    "trigger of three levels": (cell(4, "trigger", "0.5"), r"line 5, trigger: 0.5 is not a level of a switch; export"),
    "empty": (b"", r": is empty; record again"),
    "header only": (csv([NAMES]), r": has a header but no rows; record or export"),
    "header without newline": (csv([NAMES])[:-1], r"no rows|not a CSV table"),
    "blank lines only": (b"\n\n\n", r"not a CSV table|is empty|none of the columns"),
    "semicolons": (csv(table(), ";"), r"separat"),
    "semicolons and decimal commas": (csv(table(), ";").replace(b".", b","), r"separat"),
    "tabulators": (csv(table(), "\t"), r"separat"),
    "a row too short": (csv(table()) + b"0.009,980.5\n", r"(line |Row #)11\b.*14 columns, got 2"),
    "a row too long": (csv(table()) + csv([[*table()[-1], "1"]]), r"(line |Row #)11\b.*14 columns, got 15"),
    "column twice": (renamed("l2_mm", "l1_mm"), r"column l1_mm is there twice; rename or remove one"),
    "another encoding": (cell(4, "l2_mm", "9ä0").decode().encode("latin-1"), r"UTF-8"),
    "another encoding in the header": (renamed("l2_mm", "Länge").decode().encode("latin-1"), r"UTF-8"),
    "UTF-16 without its mark": (csv(table()).decode().encode("utf-16-le"), r"none of the columns|UTF-8"),
    "half a letter of UTF-16": (csv(table()).decode().encode("utf-16") + b"\x31", r"damaged text in UTF-16"),
    "zeros": (bytes(200), r"not a CSV table|none of the columns"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damage_is_named_with_its_place(damage: str, tmp_path: Path) -> None:
    content, says = DAMAGES[damage]
    file = tmp_path / "run.csv"
    file.write_bytes(content)
    with refused_at(file, says):
        read(file, CASE)


def not_there(folder: Path) -> Path:
    return folder / "nowhere.csv"


def empty_folder(folder: Path) -> Path:
    return folder


def folder_instead_of_file(folder: Path) -> Path:
    (folder / "recording.csv").mkdir()
    return folder


def link_to_itself(folder: Path) -> Path:
    (folder / "loop.csv").symlink_to(folder / "loop.csv")
    return folder / "loop.csv"


def name_too_long(folder: Path) -> Path:
    return folder / ("x" * 300)


@pytest.mark.parametrize("place", [not_there, empty_folder, folder_instead_of_file, link_to_itself, name_too_long])
def test_a_place_that_holds_no_readable_file_is_named(place: Callable[[Path], Path], tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"cannot be read .*CSV or folder") as caught:
        read(place(tmp_path), CASE)
    assert str(tmp_path) in one_line(caught.value)


@pytest.mark.parametrize("damage", ["transposed rows", "mirrored", "stretched", "zero"])
def test_what_is_no_rotation_matrix_is_named(damage: str, tmp_path: Path, wrist_case: Case) -> None:
    good = ["1", "0", "0", "0", "0", "-1", "0", "1", "0"]
    bad = {
        "transposed rows": ["0", "1", "0", "1", "0", "0", "0", "0", "1"],  # two columns in the wrong order: a mirror
        "mirrored": ["-1", "0", "0", "0", "-1", "0", "0", "0", "-1"],
        "stretched": ["1.01", "0", "0", "0", "1", "0", "0", "0", "1"],
        "zero": ["0"] * 9,
    }[damage]
    header = ["fx", "fy", "fz", "tx", "ty", "tz", *ROTATION]
    file = tmp_path / "run.csv"
    file.write_bytes(csv([header, *([["1.0"] * 6 + m for m in (good, good, bad, good)])]))
    with pytest.raises(RecordingError, match=r", line 4, r11: .*rotation.*order and sign") as caught:
        read(file, wrist_case)
    one_line(caught.value)
