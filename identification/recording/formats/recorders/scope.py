"""CSV exports of the TwinCAT 3 Scope: a header of channels, then columns of values, each group with its own clock.

Verified with genuine exports of Scope 3.4.3145 (test data of github CagtayFabry/pytcs) and Beckhoff's description
(infosys.beckhoff.com, TE13xx, "Export to csv"): a second line that starts with `Name` lists the channels, and each
`Name` in it stands above a clock. Lines below it, such as `SymbolName` and `Unit`, say more of each. Where a channel
has ended, its fields are a blank, or missing at the end of the line; a line `EOF` may follow. Not verified: marker
tables and trigger information (switch them off), other versions.
"""

import re
from collections.abc import Sequence

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import TICKS, FileFormat
from identification.recording.formats.content import Content, section_of
from identification.recording.formats.recorders.plain import SAMPLE
from identification.recording.formats.text_layout import Field, Layout, cells
from identification.recording.formats.words import is_missing, is_number, is_switch, number_of, split

_NAME, _UNIT, _END = "Name", "Unit", b"EOF"
_OTHER_NAMES = ("SymbolName", "SymbolComment")
_NO_UNIT = "(None)"
# FILETIME of the year 2000 in its own units; stamps in ms stay below for four million years.
_LEAST_FILETIME = 1.26e17
_DATED = re.compile(r"\s*\d{1,4}[-./]\d{1,2}[-./]\d{1,4}[ T]\s*\d{1,2}:\d{2}")


def knows(head: Sequence[bytes], form: FileFormat) -> bool:
    """Whether a file begins as exports of the Scope do: with its name, and with the channels further down."""
    del form
    start = head[0][: len(_NAME) + 1]
    return start in (b"Name\t", b"Name;", b"Name,") and any(line.startswith(start) for line in head[1:])


def layout(content: Content, head: Sequence[bytes], form: FileFormat) -> Layout:
    """The layout of an export; raises RecordingError where its header or its rows are not as the Scope writes them."""
    lines = [line.decode(form.encoding, "replace") for line in head]
    separator = form.delimiter or lines[0][len(_NAME) : len(_NAME) + 1] or "\t"
    tops = [k for k, line in enumerate(lines) if line.startswith(_NAME + separator)]
    top = tops[1] if len(tops) > 1 and not tops[0] else len(lines)
    first = next((k for k, line in enumerate(lines) if k > top and _is_row(split(line, separator))), None)
    if first is None:
        raise RecordingError(
            place=content.file,
            problem=phrase(
                "not_scope",
                "has no two lines that start with Name and a separator, and rows of numbers below, as exports of "
                "TwinCAT Scope have",
            ),
            remedy=phrase("export_scope", "export it as CSV with its header, or set recording.format in the case"),
            code=Code.WRONG_KIND,
        )
    rows = [split(line, separator) for line in lines[first : first + SAMPLE]]
    form = form.model_copy(update={"delimiter": separator, "decimal": form.decimal or _decimal(rows, separator)})
    header = [cells(line, form) for line in lines[top:first]]
    names = header[0]
    while names and not names[-1]:  # some exports end each line with a separator
        names.pop()
    return Layout(
        form=form,
        fields=_fields(names, [row for row in header[1:] if len(row) >= len(names)]),
        sections=(section_of(content, first, form.trailing_rows, (_END,)),),
        names_row=top + 1,
        tick=TICKS[_unit(content, rows[0][0], form)],
        uneven=True,
        no_rows=(_END,),
    )


def _is_row(row: Sequence[str]) -> bool:
    """Whether a line is one of values: numbers, or a date and numbers."""
    filled = [field.replace(",", ".", 1) for field in row if field.strip()]
    return bool(filled) and (is_number(filled[0]) or bool(_DATED.match(filled[0]))) and all(map(_is_value, filled[1:]))


def _is_value(field: str) -> bool:
    return is_number(field) or is_missing(field) or is_switch(field) or bool(_DATED.match(field))


def _decimal(rows: Sequence[Sequence[str]], separator: str) -> str:
    """The decimal sign of numbers; a point where none of them has one."""
    numbers = [field for row in rows for field in row if not _DATED.match(field)]
    return "," if separator != "," and any("," in field for field in numbers) else "."


def _fields(names: Sequence[str], about: Sequence[Sequence[str]]) -> tuple[Field, ...]:
    """The fields of rows, from the names of channels and the lines below, each of which begins with what it says."""
    rows = {row[0]: row for row in about}
    units = rows.get(_UNIT, [""] * len(names))
    clocks = [k for k, name in enumerate(names) if name == _NAME]
    fields = []
    for k, name in enumerate(names):
        if name in ("", _NAME):
            fields.append(Field(name))
            continue
        others = (rows[line][k] for line in _OTHER_NAMES if line in rows)
        unit = "" if units[k] == _NO_UNIT else units[k]
        also = tuple(other for other in others if other and other != name)
        fields.append(Field(name, also, unit, max((c for c in clocks if c < k), default=None)))
    return tuple(fields)


def _unit(content: Content, stamp: str, form: FileFormat) -> str:
    """The unit of time stamps, by the first of them and by the case; raises RecordingError where they differ."""
    if _DATED.match(stamp):  # Full Timestamp, which is read in ns
        return "ns"
    counted = (number_of(stamp) or 0.0) >= _LEAST_FILETIME
    stated = form.clock.unit or ("filetime" if counted else "ms")
    if counted != (stated == "filetime"):
        problem = f"its time stamps, such as {stamp.strip()}, are not in {stated}"
        raise RecordingError(
            place=content.file,
            problem=problem,
            remedy="set recording.clock.unit in the case: 'ms' or 'filetime'",
            code=Code.UNIT,
        )
    return stated
