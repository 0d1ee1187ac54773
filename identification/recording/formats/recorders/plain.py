"""Any table of text: a header, then rows of as many fields as it names, by what the case states of it."""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import FileFormat
from identification.recording.formats.content import Content, section_of
from identification.recording.formats.names.labels import units_row
from identification.recording.formats.text_layout import Field, Layout, cells, decoded
from identification.recording.formats.words import is_number

SAMPLE = 200  # rows from which the number of their fields is known
_REMARK = re.compile(r"^(?:#|%|//|!|;|\*)+\s*")  # how a line begins that is a remark to the program that wrote it


def layout(content: Content, head: Sequence[bytes], form: FileFormat) -> Layout:
    """The layout that a case states; raises RecordingError where the header is shorter, or has no names."""
    file = content.file
    rows = form.header_rows if form.header_rows is not None else int(form.column_names is None)
    if len(head) < rows:
        raise RecordingError(
            place=file,
            problem=phrase(
                "header_longer",
                "has {count} lines, no more than recording.header_rows = {rows}",
                count=len(head),
                rows=rows,
            ),
            code=Code.TOO_FEW,
        )
    header = decoded(file, head[:rows], form)
    sample = [line.decode(form.encoding, "replace") for line in head[rows : rows + SAMPLE] if line.strip()]
    names_row = 0 if form.column_names is not None else form.names_row or rows
    if form.column_names is None and not names_row:
        raise RecordingError(
            place=file,
            problem=phrase("no_header_names", "recording.header_rows = 0 leaves no names"),
            remedy=phrase("list_them", "list them in recording.column_names"),
            code=Code.CONTRADICTION,
        )
    aligned = is_aligned(sample, form.separator)
    if form.column_names is None:
        fields = named(header, names_row, sample, form, aligned)
    else:
        names = shaped(form.column_names, _rows(sample, form, aligned))
        units = units_row([names, *(cells(line, form) for line in header)], 1) or [""] * len(names)
        fields = [Field(name, unit=unit) for name, unit in zip(names, units, strict=True)]
    return Layout(
        form=form,
        fields=tuple(fields),
        sections=(section_of(content, rows, form.trailing_rows),),
        names_row=names_row,
        tick=form.tick,
        period=form.clock.period,
        aligned=aligned,
        hold=form.empty == "hold",
        apart=form.empty == "apart",
        header=tuple(header),
    )


def is_aligned(sample: Sequence[str], separator: str) -> bool:
    """Whether rows separated by blanks have any number of them between two fields, and before the first."""
    if separator != " ":
        return False
    rows = [line.split(" ") for line in sample]
    if len(set(map(len, rows))) > 1 or any(line[:1] == " " or line[-1:] == " " for line in sample):
        return True
    return any(not any(column) for column in zip(*rows, strict=True))  # two blanks between two fields, in each row


def _rows(sample: Sequence[str], form: FileFormat, aligned: bool) -> list[list[str]]:
    """Fields of the rows whose number of fields is the usual one."""
    rows = [line.split() if aligned else cells(line, form) for line in sample]
    width = Counter(map(len, rows)).most_common(1)[0][0] if rows else 0
    return [row for row in rows if len(row) == width]


def named(header: Sequence[str], names_row: int, sample: Sequence[str], form: FileFormat, aligned: bool) -> list[Field]:
    """The fields of rows, by the line of the header that names them, counted from 1, and by a line of units."""
    rows = _rows(sample, form, aligned)
    width = len(rows[0]) if rows else 0
    line = header[names_row - 1]
    names = _aligned_names(line, width) if aligned else cells(line, form)
    bare = [_REMARK.sub("", name) for name in names[:1]] + names[1:]
    if bare[:1] == [""] and len(names) == width + 1:
        names = bare = names[1:]  # the sign of a remark stands apart
    names = shaped(names, rows)
    others = [line.split() if aligned else cells(line, form) for k, line in enumerate(header, 1) if k != names_row]
    units = units_row([names, *others], 1) or [""] * len(names)
    also = [(other,) if other != name else () for other, name in zip(bare, names, strict=False)]
    also += [()] * (len(names) - len(also))
    return [Field(name, other, unit) for name, other, unit in zip(names, also, units, strict=True)]


def _aligned_names(line: str, width: int) -> list[str]:
    """Names that stand above aligned columns; they may hold single blanks."""
    apart = [name.strip() for name in re.split(r"\s{2,}|\t", line.strip())]
    return apart if len(apart) == width else line.split()


def shaped(names: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Names for each field of rows: without empty ones at the end, with such for separators at the end of rows.

    Rows may also begin with their number, which has no name.
    """
    result, width = list(names), len(rows[0]) if rows else 0
    while len(result) > width > 0 and not result[-1]:
        result.pop()
    surplus = width - len(result)
    if surplus > 0 and not any(field.strip() for row in rows for field in row[len(result) :]):
        return result + [""] * surplus
    if surplus == 1 and counts([row[0] for row in rows]):
        return ["", *result]
    return result


def counts(values: Sequence[str]) -> bool:
    """Whether values are numbers of rows: whole ones, each by one larger than the one before."""
    if len(values) < 2 or not all(value.strip().isdecimal() for value in values):
        return False
    numbers = [int(value) for value in values]
    return all(later - earlier == 1 for earlier, later in pairwise(numbers))


def is_units(row: Sequence[str]) -> bool:
    """Whether a line of a header has the units of columns."""
    return bool(units_row([row, row], 1))


def is_headless(names: Sequence[str]) -> bool:
    """Whether what should be names are the numbers of a row."""
    filled = [name.replace(",", ".", 1) for name in names if name]
    return bool(filled) and 2 * sum(map(is_number, filled)) > len(filled)
