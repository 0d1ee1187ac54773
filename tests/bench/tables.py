"""Tables of figures as `make bench` prints them, kept in a file, and compared with those of an earlier run."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from hexcite.cli import console

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
NOTICED = 0.02  # share by which a number must have changed to be named: less is chance in most figures

Tables = dict[str, list[list[str]]]  # rows by title, the first of them the columns' names

printed: Tables = {}  # by this process


class Change(NamedTuple):
    """A figure that is another one than before."""

    table: str
    row: str
    column: str
    before: str
    now: str
    ratio: str  # of the first numbers, now over before; empty where there are none


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Prints a table; every row is a line."""
    console.print_table(title, columns, rows)
    printed[title] = [[*columns], *([*row] for row in rows)]


def save(file: Path) -> None:
    """Writes all tables that were printed so far."""
    file.write_text(json.dumps(printed, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def load(file: Path) -> Tables:
    """The tables that an earlier run saved."""
    tables: Tables = json.loads(file.read_text(encoding="utf-8"))
    return tables


def changes(before: Mapping[str, Sequence[Sequence[str]]], now: Mapping[str, Sequence[Sequence[str]]]) -> list[Change]:
    """Cells of tables that both runs have, in rows of the same name, whose numbers differ by more than `NOTICED`."""
    return [change for title in now if title in before for change in _of_table(title, before[title], now[title])]


def _of_table(title: str, before: Sequence[Sequence[str]], now: Sequence[Sequence[str]]) -> Iterator[Change]:
    earlier, columns = _by_name(before), now[0]
    for name, cells in _by_name(now).items():
        for column, old, new in zip(columns[1:], earlier.get(name, ()), cells, strict=False):
            ratio = _ratio(old, new)
            if ratio is None or abs(ratio - 1.0) > NOTICED:
                yield Change(title, " / ".join(name[:-1]), column, old, new, "" if ratio is None else f"{ratio:.3g}")


def _by_name(table: Sequence[Sequence[str]]) -> dict[tuple[str, ...], Sequence[str]]:
    """Cells of each row behind its name. Rows that are indented belong to the last one that is not."""
    rows: dict[tuple[str, ...], Sequence[str]] = {}
    head = ""
    for first, *cells in table[1:]:
        head = head if first.startswith(" ") else first
        name = (head, first.strip()) if first.startswith(" ") else (head,)
        count = sum(other[:-1] == name for other in rows)
        rows[*name, str(count)] = cells
    return rows


def _ratio(before: str, now: str) -> float | None:
    """The first number of a cell over that of another; 1 for cells that are the same, None where it is not defined."""
    if before == now:
        return 1.0
    numbers = [NUMBER.search(cell) for cell in (before, now)]
    old, new = (None if number is None else float(number[0]) for number in numbers)
    return None if old is None or new is None or old == 0.0 else new / old
