"""Two runs of the bench are compared figure by figure: what changed is named, what is alike is not."""

from pathlib import Path

import pytest

from tests.bench import tables
from tests.bench.tables import Change, changes, load, print_table, save

BEFORE = {
    "Searches": [
        ["machine", "seconds", "D-efficiency"],
        ["hexapod", "16.2 s", "0.577"],
        ["  spline", "21.4 s", "0.633"],
        ["panda", "31.6 s", "0.351"],
        ["  spline", "40 s", "0.300"],
    ]
}


def with_cell(row: int, column: int, cell: str) -> dict[str, list[list[str]]]:
    """The tables with another cell."""
    other = {title: [[*cells] for cells in rows] for title, rows in BEFORE.items()}
    other["Searches"][row][column] = cell
    return other


def test_a_run_does_not_differ_from_itself() -> None:
    assert changes(BEFORE, BEFORE) == []


def test_a_figure_that_changed_is_named_with_its_ratio() -> None:
    assert changes(BEFORE, with_cell(3, 1, "15.8 s")) == [
        Change("Searches", "panda", "seconds", "31.6 s", "15.8 s", "0.5")
    ]


def test_rows_of_one_name_are_told_apart_by_the_row_above_them() -> None:
    assert [change.row for change in changes(BEFORE, with_cell(4, 2, "0.400"))] == ["panda / spline"]


@pytest.mark.parametrize(("cell", "named"), [("0.355", False), ("0.359", True), ("none", True)])
def test_changes_of_two_percent_are_chance(cell: str, named: bool) -> None:
    assert bool(changes(BEFORE, with_cell(3, 2, cell))) == named


def test_new_tables_and_rows_have_nothing_to_be_compared_with() -> None:
    more = BEFORE | {"Poses": [["figure", "measured"], ["time", "3 s"]]}
    more["Searches"] = [*BEFORE["Searches"], ["ur10_wrist", "30 s", "0.2"]]
    assert changes(BEFORE, more) == []


def test_what_is_printed_is_saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "printed", {})
    for title, (columns, *rows) in BEFORE.items():
        print_table(title, columns, rows)
    save(tmp_path / "figures.json")
    assert load(tmp_path / "figures.json") == BEFORE
