"""What the header of a file says of its columns beside their names: units, in brackets, behind a name, in a row."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from cases.base.unit_names import COUNTS, SHARES, Units, is_other_unit, is_unit, plain_unit

LONGEST = 1000
"""Characters of a label, or of a line that states something; what is longer is text, and patterns take its square."""
_BRACKETED = re.compile(r"\[([^\]]*)\]|\(([^)]*)\)|<([^>]*)>|\{([^}]*)\}")
_PREFIX = re.compile(r"^(?:in|units?|einheit)\b[:=\s]+", re.I)
# Letters and signs of any script may be a unit which we do not know: names of channels and addresses have digits or
# other signs, and a single Latin letter is as likely an index.
_LIKE_A_UNIT = re.compile(r"(?![A-Za-z*/.]$)[^\s\d_\[\](){}<>\"'`|\\,;:=!?&@~+\-]{1,12}")
_WORD = re.compile(r"(?<![^\W\d_])(?:[^\W\d_]|[°%‰])+(?![^\W_])")  # not those that a number follows, as in m1
_DIGIT = re.compile(r"\d")
_WORDS = frozenset(
    {
        "abs", "absolute", "achse", "act", "actual", "angle", "average", "avg", "axis", "back", "base", "bottom",
        "brutto", "cmd", "command", "dint", "double", "east", "epoch", "filt", "filtered", "flange", "float", "force",
        "front", "fx", "fy", "fz", "gefiltert", "gmt", "gross", "hinten", "host", "inner", "int", "iso", "ist",
        "istwert", "joint", "kraft", "left", "links", "local", "lokal", "lower", "lreal", "mean", "meas", "measured",
        "mess", "messwert", "mittel", "mittelwert", "moment", "mx", "my", "mz", "net", "netto", "nord", "north",
        "oben", "ost", "outer", "pitch", "position", "raw", "real", "rear", "rechts", "ref", "rel", "relative",
        "right", "roh", "rohwert", "roll", "rx", "ry", "rz", "sensor", "set", "soll", "south", "sued", "tara", "tare",
        "tared", "target", "tcp", "time", "tool", "top", "torque", "tx", "ty", "tz", "unix", "unten", "upper", "utc",
        "value", "vorne", "wert", "west", "winkel", "world", "yaw", "zeit", "zeroed",
    }
)  # fmt: skip
"""Words in brackets that are not units, in small letters."""
_AMBIGUOUS = frozenset({"in", "d", "h", "t", "g", "ft", "rev", "turn", "turns", "s"})
"""Units that, behind a name and without brackets, are as likely a part of the name."""
_UNIT_CELLS = frozenset({"unit", "units", "einheit", "einheiten", "dimension", "y_unit_label", "vert_units"})
_MULTIPLE = re.compile(
    r"(?:(?P<one>1)\s*/\s*)?(?P<number>\d+(?:[.,]\d+)?(?:e[+-]?\d{1,2})?)\s*[x*·]?\s*(?P<unit>[^\W\d].*)"
)
"""A unit with a factor, as in 0.1 ms, 100 ns and 1/100 mm."""


@dataclass(frozen=True, slots=True)
class StatedUnit:
    """What a header states as the unit of a column."""

    text: str  # as the file writes it
    symbol: str | None  # as hexcite writes it; None: it is not a unit of this quantity
    counts: float = 1.0  # numbers in the file for one unit
    several: bool = False  # whether the header states several that differ


_LINES = re.compile(r"(force|torque|moment|length|position|angle)s?\s+units?\s*[:=]\s*([^,;\t\n\"]+)", re.I)
_COUNTS = re.compile(r"counts\s+per\s+(?:unit\s+)?(force|torque|moment)\s*[:=]\s*(\d+(?:\.\d*)?(?:e\+?\d{1,2})?)", re.I)
_QUANTITIES = {"torque": "moment", "position": "length"}


def stated_unit(label: str, cell: str, units: Units, header: Sequence[str] = ()) -> StatedUnit | None:
    """The unit that a header states for a column; None: it states none.

    Args:
        label: name of the column in the file.
        cell: what a row of units has for it; empty where there is none.
        units: those that the column can have.
        header: lines above the rows, which may state the units of all forces or moments, and counts for one unit.
    """
    unit = None if max(len(label), len(cell)) > LONGEST else _of_column(label, cell, units)
    whole = "\n".join(line for line in header if len(line) <= LONGEST)
    counts = [float(number) for word, number in _COUNTS.findall(whole) if _quantity(word) == units.quantity]
    lines = [text.strip() for word, text in _LINES.findall(whole) if _quantity(word) == units.quantity]
    if lines and (unit is None or (counts and is_count(unit.text))):
        unit = StatedUnit(lines[0], units.symbol(lines[0]))
    return unit if unit is None or not counts or counts[0] == 0.0 else replace(unit, counts=counts[0])


def _quantity(word: str) -> str:
    return _QUANTITIES.get(word.casefold(), word.casefold())


def without_brackets(label: str) -> str:
    """A label without what stands in brackets."""
    return label if len(label) > LONGEST else _BRACKETED.sub(" ", label)


def _of_column(label: str, cell: str, units: Units) -> StatedUnit | None:
    """The unit that the label of a column, or its cell in a row of units, states."""
    in_row = plain_unit(cell)
    if in_row in ("", "-", "none"):
        return _of_label(label, units)
    row = StatedUnit(in_row, units.symbol(in_row))
    name = _of_label(label, units)
    if name is None or name.symbol in (None, row.symbol):
        return row
    return StatedUnit(f"{name.text} and {row.text}", None, several=True)


def _of_label(label: str, units: Units) -> StatedUnit | None:
    """The unit that a label states itself."""
    contents = (next(filter(None, groups), "") for groups in _BRACKETED.findall(label))
    bracketed = [text for content in contents if (text := _PREFIX.sub("", content.strip())) and text != "1"]  # an index
    stated = [unit for text in bracketed if (unit := _in_brackets(text, units)) is not None]
    known = next((unit for unit in stated if unit.symbol is not None), None)
    if known is not None or stated:
        return known or stated[0]
    return next(_behind(_BRACKETED.sub(" ", label).strip(" \"'|"), units), None)


def _in_brackets(text: str, units: Units) -> StatedUnit | None:
    """The unit that a text in brackets is, or holds beside words about the signal; None: it is about something else."""
    if symbol := units.symbol(text):
        return StatedUnit(text, symbol)
    if (is_unit(text) and text not in ("-", "none")) or set(text) == {"?"}:  # ?: the recorder does not know it
        return StatedUnit(text, None)
    # of a force, `10 N` may be a range as well
    multiple = _MULTIPLE.fullmatch(text) if units.quantity == "time" else None
    if multiple is not None and (symbol := units.symbol(multiple["unit"])) is not None:
        number = float(multiple["number"].replace(",", "."))
        if number > 0.0:
            return StatedUnit(text, symbol, number if multiple["one"] else 1.0 / number)
    parts = [part for part in re.split(r"\s*[,;:]\s*", text) if part]
    words = parts if len(parts) > 1 and any(map(units.symbol, parts)) else _WORD.findall(text)
    known = [word for word in words if units.symbol(word) not in (None, "1")]
    others = [word for word in words if word not in known]
    about = all(word.casefold() in _WORDS for word in others)
    if known:  # with a factor it is another unit
        return StatedUnit(
            text, units.symbol(known[0]) if len(known) == 1 and about and not _DIGIT.search(text) else None
        )
    return StatedUnit(text, None) if _LIKE_A_UNIT.fullmatch(text) and not (others and about) else None


def _behind(label: str, units: Units) -> Iterator[StatedUnit]:
    """Units that end a label without brackets, as in `Force 1 kN`, `x_mm` and `Kraft / N`, the longest first."""
    share = re.search(r"%.*|\b(?:percent|prozent|pct)\b.*", label, re.I) if units is not SHARES else None
    if share is not None:
        yield StatedUnit(share[0], None)
    for match in re.finditer(r"(?<=[\w°])(?P<sep>[_\s/,;:=.|\"'\-]+)(?=[^_\s/,;:=.|\"'\-])", label):
        text = label[match.end() :]
        certain = "/" in match["sep"] or text.casefold() not in _AMBIGUOUS
        if certain and (symbol := units.symbol(text)) is not None and symbol != "1":
            yield StatedUnit(text, symbol)
        elif is_other_unit(text, units) and (len(text) > 1 or (text == "V" and units.quantity in ("force", "moment"))):
            yield StatedUnit(text, None)


_RAW = frozenset({"raw", "roh", "rohwert"})  # what also is said of readings in newtons, in small letters


def counted(label: str, whole: bool) -> str | None:
    """The word in a label that says that a column holds counts of a converter; None: there is none.

    `whole`: whether its numbers are whole, as counts are: then they are raw ones too.
    """
    words = re.findall(r"[A-Za-z]+", label)
    return next((word for word in words if is_count(word) and (whole or word.casefold() not in _RAW)), None)


def is_count(text: str) -> bool:
    """Whether a text is a word for counts of a converter."""
    return text.casefold() in COUNTS | _RAW


def units_row(head: Sequence[Sequence[str]], names_row: int) -> list[str]:
    """Cells of the row of units, one for each name; empty where there is no such row.

    A row is one of units where at least half of its cells are known ones, or its first cell says so.

    Args:
        head: cells of the lines above the first row of numbers.
        names_row: which of them holds the names, counted from 1; 0: none of them.
    """
    if not names_row:
        return []
    count = len(head[names_row - 1])
    for k, row in enumerate(head, 1):
        cells = [plain_unit(cell) for cell in row]
        filled = [cell for cell in cells if cell and cell != "-"]
        if k == names_row or not filled or abs(len(cells) - count) > 1:  # lines of two cells are about the whole file
            continue
        if cells[0].casefold() in _UNIT_CELLS:
            cells = cells[1:] if len(cells) == count + 1 else ["", *cells[1:]]
        elif 2 * sum(map(is_unit, filled)) < len(filled):
            continue
        return [*cells, ""][:count]
    return []
