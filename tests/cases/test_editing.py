"""A table of a case file is replaced, and no other byte of the file."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases.base.errors import HexciteError
from cases.editing import changes_of, write_table
from cases.tables import built_in_cases
from tests.helpers import examples

WANTED: dict[str, Any] = {
    "filter_cutoff_Hz": 40.0,
    "clock": {"unit": "ms"},
    "columns": {"t_s": "Zeit [ms]", "l1_mm": 'Strebe "1"'},
    "units": {"forces": "kN"},
    "column_names": ["a", "b"],
}
BEFORE = '# top\nname = "x" # n\n\n[sensors] # s\nweights = "equal"\n\n'
AFTER = "\n# about the controller\n[controller] # c\na = 1 # one\n\n[[weights]]\nm = 2.0\n"
TABLES = {
    "absent": "",
    "plain": "# how\n[recording] # r\nfilter_cutoff_Hz = 40.0 # f\n# nothing more\n",
    "with columns": (
        '[recording]\nrate_Hz = 500.0 # goes\nclock = { unit = "s" } # k\n\n[recording.columns] # c\n'
        't_s = "Zeit [ms]" # t\nl2_mm = "gone"\n'
    ),
    "columns alone": '[recording.columns]\nt_s = "Zeit [ms]" # t\n',
    "an array in lines": '[recording]\ncolumn_names = [\n    "a", # first\n    "b",\n]\n',
    "text in lines": '[recording]\ncolumns = { l1_mm = """\na\n[recording]\n""" }\n',
}  # fmt: skip


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("name", TABLES)
def test_all_else_stays_byte_for_byte(name: str, end: str, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    before, table, after = (text.replace("\n", end) for text in (BEFORE, TABLES[name], AFTER))
    file.write_bytes((before + table + after).encode())
    changes = changes_of(file, "recording", WANTED)
    assert write_table(file, "recording", WANTED) == changes
    data = file.read_bytes().decode()
    parsed = tomllib.loads(data.replace("\r\n", "\n"))
    assert parsed["recording"] == WANTED
    assert parsed["controller"] == {"a": 1}
    assert data.startswith(before)
    assert data.endswith(after) or name == "absent"
    assert after.strip() in data
    for comment in ("# r", "# f", "# nothing more", "# k", "# c", "# t", "# first"):
        assert (comment in table) <= (comment in data)
    assert write_table(file, "recording", WANTED) == ()
    assert file.read_bytes().decode() == data


def test_a_mark_of_utf8_and_the_mode_of_the_file_stay(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_bytes(("\ufeff" + BEFORE + TABLES["plain"]).encode())
    file.chmod(0o640)
    write_table(file, "recording", WANTED)
    assert file.read_bytes().startswith(("\ufeff" + BEFORE).encode())
    assert file.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("text", ["name = \n", 'name = "x"\nrecording = 3\n'], ids=["not TOML", "not a table"])
def test_a_file_that_cannot_be_edited_is_not_touched(text: str, tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(text)
    with pytest.raises(HexciteError, match=r"case\.toml"):
        write_table(file, "recording", WANTED)
    assert file.read_text() == text


VALUES = st.recursive(
    st.booleans() | st.integers(-(10**9), 10**9) | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=12),
    lambda inner: st.lists(inner, max_size=3)
    | st.dictionaries(st.from_regex(r"[a-z_]{1,6}", fullmatch=True), inner, max_size=3),
    max_leaves=6,
)  # fmt: skip


@settings(max_examples=examples(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    values=st.dictionaries(st.from_regex(r"[a-z_]{1,8}|columns", fullmatch=True), VALUES, max_size=5),
    name=st.sampled_from(sorted(built_in_cases())),
)
def test_whatever_is_written_is_read_back_and_other_tables_are_as_before(
    values: dict[str, Any], name: str, tmp_path: Path
) -> None:
    text = built_in_cases()[name].read_text(encoding="utf-8")
    file = tmp_path / "case.toml"
    file.write_text(text, encoding="utf-8")
    before = tomllib.loads(text)
    write_table(file, "recording", values)
    after = file.read_text(encoding="utf-8")
    assert tomllib.loads(after) == {**before, "recording": values}
    outside = [line for line in text.splitlines() if line.startswith("#")]
    assert all(line in after for line in outside)
