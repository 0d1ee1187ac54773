"""Home and limits of motion of all joints as one table, in place of two tables of the case for each joint."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from hexcite.page.units import Spelling
from hexcite.page.values import Entry, Section

COLUMNS = ("home", "position", "velocity", "acceleration", "jerk")
NAME = "joints"  # of the table, in forms
_PLACE = re.compile(
    r"(?:machine\.chain\.joints\[(\d+)\]\.(home)_|limits\.motion\.joints\[(\d+)\]\.(position|velocity|acceleration|jerk|name)(?:_|$))"
)


@dataclass(frozen=True)
class Cell:
    """A value of a joint, and the kind of its field: `v` of one that is stated, `w` of one that may be added."""

    field: str
    entry: Entry


@dataclass(frozen=True)
class Row:
    """A joint: its name, cells by column, and its name in `[limits.motion]`."""

    name: str
    cells: Mapping[str, Cell]
    hidden: Cell | None


@dataclass(frozen=True)
class JointTable:
    """All joints of a chain.

    Args:
        units: of the columns whose values all have the same ones: ways to state them.
        missing: how many values are not stated yet.
    """

    rows: tuple[Row, ...]
    units: Mapping[str, tuple[Spelling, ...]]
    missing: int


def cut_out(sections: Sequence[Section]) -> tuple[JointTable | None, tuple[Section, ...]]:
    """The table of all joints, None of a machine without joints, and the other values by their tables."""
    rows: dict[int, dict[str, Cell]] = {}
    names: dict[int, str] = {}
    for section in sections:
        for field, entries in (("v", section.entries), ("w", section.more)):
            for entry in entries:
                if column := _column(entry.name):
                    rows.setdefault(column[0], {})[column[1]] = Cell(field, entry)
                elif chain := re.fullmatch(r"machine\.chain\.joints\[(\d+)\]\.name", entry.name):
                    names[int(chain[1])] = entry.text
    if not rows or not names:
        return None, tuple(sections)
    others = [
        replace(
            section,
            entries=tuple(entry for entry in section.entries if not _column(entry.name)),
            more=tuple(entry for entry in section.more if not _column(entry.name)),
        )
        for section in sections
    ]
    table = [
        Row(names.get(k, str(k + 1)), {key: cell for key, cell in cells.items() if key != "name"}, cells.get("name"))
        for k, cells in sorted(rows.items())
    ]
    missing = sum(cell.field == "w" for row in table for cell in row.cells.values())
    rest = tuple(each for each, before in zip(others, sections, strict=True) if each == before or _any(each))
    return JointTable(tuple(table), _units(table), missing), rest


def _any(section: Section) -> bool:
    return bool(section.entries or section.more)


def _column(name: str) -> tuple[int, str] | None:
    """Number of the joint and column of a value; None of all other values."""
    if (place := _PLACE.match(name)) is None:
        return None
    return int(place[1] or place[3] or 0), place[2] or place[4]


def _units(rows: Sequence[Row]) -> dict[str, tuple[Spelling, ...]]:
    units = {}
    for column in COLUMNS:
        ways = {row.cells[column].entry.spellings for row in rows if column in row.cells}
        if len(ways) == 1 and len(only := ways.pop()) > 1:
            units[column] = only
    return units


def spread(given: Mapping[str, str]) -> dict[str, str]:
    """What a form says, with that which it says of all joints (`on.joints`, `u.joints.COLUMN`) said of each."""
    result = {name: text for name, text in given.items() if not re.match(rf"(on|u)\.{NAME}\b", name)}
    for name in given:
        kind, _, value = name.partition(".")
        if kind not in ("v", "w") or (place := _column(value)) is None:
            continue
        if kind == "w" and f"on.{NAME}" in given:
            result[f"on.{value}"] = "1"
        if unit := given.get(f"u.{NAME}.{place[1]}"):
            result.setdefault(f"u.{value}", unit)
    return result
