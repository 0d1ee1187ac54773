"""Plain tables as text, one row a sample: lines of names, then lines of numbers, separated by one character each.

The case states what differs from `csv` as hexcite writes it: commas, points, one line of names, UTF-8.

SINUMERIK traces exported as text are read so too, with every property that differs between exports stated by the case.
No export of our own was at hand and no manual that describes the file was found. What public programs that read such
files show (searched November 2026): SINUMERIK Operate saves a trace session as XML (`traceSession/traceData/dataFrame`
with `dataSignal` and `rec`, three programs agree), which is not read here: export it as text. One group of programs
reads CSV with commas and points, one line of names, a first column `time` in seconds and names such as
`+/Nck/!SD/nckServoDataActPos1stEnc32 [u1; 1]`; another reads files whose names stand above the numbers, one line a
signal, so that there are more header lines than signals. Delimiter, decimal sign, header rows and the clock's unit
therefore have no default here; header rows, times in ms from the first sample and trailing rows are read as the case
says, and `column_names` names the columns where the header has no single line of names. Unverified: whether any export
repeats the time for each signal, or leaves fields empty where signals have different cycles; empty fields are
refused with their line.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from cases.errors import RecordingError
from cases.recording_format import CLOCK, COLUMNS, VELOCITIES, RecordingFormat
from identification.formats.table import ColumnTable, listed, shown
from identification.formats.text import TextBlock, TextFormat, lines_of, not_text, parse, read_blocks, read_head

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabulators", " ": "blanks", "|": "vertical bars"}
_SEARCHED_LINES = 50  # no export known to us has a longer header
_TYPICAL = ("t_s", "l1_mm", "q1_mm", "x_mm", "r11", "ax", "f1_N", "fx_N")


def decoded(file: Path, lines: Sequence[bytes], dialect: TextFormat) -> list[str]:
    """Header lines as text.

    Raises:
        RecordingError: a line is not text in the file's encoding, or ends in a way that nobody expects.
    """
    texts = []
    for k, line in enumerate(lines, 1):
        if b"\r" in line:
            raise RecordingError(f"{file}, line {k}", "has a carriage return inside", "save the file with LF or CR LF")
        if b"\0" in line:
            raise RecordingError(
                f"{file}, line {k}", "is not a CSV table but binary data", "export the recording as text"
            )
        try:
            texts.append(line.decode(dialect.encoding))
        except UnicodeDecodeError:
            raise not_text(f"{file}, line {k}", dialect) from None
    return texts


def cells(line: str, dialect: TextFormat) -> list[str]:
    """Fields of a header line."""
    return [name.strip() for name in dialect.split(line)]


def select(file: Path, names: Sequence[str], form: RecordingFormat) -> dict[str, int]:
    """Our columns among those of a file, each with its position.

    Raises:
        RecordingError: one of ours is there twice.
    """
    positions = {}
    for ours in COLUMNS:
        if ours in VELOCITIES:
            continue
        theirs = form.file_name(ours)
        if names.count(theirs) > 1:
            raise RecordingError(file, f"column {shown(theirs)} is there twice", "rename or remove one")
        if theirs in names:
            positions[ours] = names.index(theirs)
    return positions


def require_known(file: Path, names: Sequence[str], lines: Sequence[bytes], form: RecordingFormat, row: int) -> None:
    """Raises RecordingError unless some of the names are ours; looks for ours elsewhere in the header.

    Args:
        row: line in which the names were sought, counted from 1.
    """
    ours = {form.file_name(c) for c in COLUMNS}
    if ours & set(names):
        return
    expected = form.delimiter or ","
    for k, line in enumerate(lines[:_SEARCHED_LINES], 1):
        for separator, word in _SEPARATORS.items():
            fields = {c.strip() for c in TextFormat(separator).split(line.decode(form.encoding, "replace"))}
            if not (fields & ours) or len(fields) < 2:
                continue
            if separator != expected:
                raise RecordingError(
                    f"{file}, line {k}",
                    f"its columns are separated by {word}, where the case expects them separated by "
                    f"{_SEPARATORS.get(expected, repr(expected))}",
                    f"set recording.delimiter = {separator!r} in the case",
                )
            raise RecordingError(
                file,
                f"the names of its columns are in line {k}, not in line {row}",
                f"set recording.names_row = {k} in the case, and recording.header_rows to the number of lines "
                "above the numbers",
            )
    raise RecordingError(file, unknown_columns(names, form))


def unknown_columns(names: Iterable[str], form: RecordingFormat) -> str:
    """What to say of a file that has none of our columns."""
    return without([form.file_name(c) for c in _TYPICAL], names)


def without(wanted: Iterable[str], names: Iterable[str]) -> str:
    """What to say of a file that lacks columns that are wanted."""
    return (
        f"none of the columns {listed(wanted)}; it has {listed(names)}: name them so or map them in "
        "[recording.columns] of the case"
    )


NOTHING = ("", " ")  # fields of what was not measured


def tables(file: Path, form: RecordingFormat) -> Iterator[ColumnTable]:
    """Reads a file batch by batch.

    Raises:
        RecordingError: it cannot be read, with the place and the remedy.
    """
    dialect = TextFormat(form.delimiter or ",", form.decimal or ".", NOTHING, form.encoding)
    header_rows, names = _header(file, form, dialect)
    chosen = select(file, names, form)
    tick = form.tick if CLOCK in chosen else form.clock.period
    blocks = read_blocks(file, header_rows, form.trailing_rows)
    yield from rows_of(file, blocks, names, chosen, dialect, tick)


def rows_of(
    file: Path,
    blocks: Iterable[TextBlock],
    names: Sequence[str],
    chosen: Mapping[str, int],
    dialect: TextFormat,
    tick: float | None,
) -> Iterator[ColumnTable]:
    """Turns lines of numbers into tables.

    Args:
        chosen: the fields that are wanted, our name -> position; `CLOCK` is that of the time stamps.
        tick: duration of a unit of the time stamps, or, without such, between rows [s]; None: there is no clock.

    Raises:
        RecordingError: a line cannot be read, or there is none.
    """
    positions = {ours: k for ours, k in chosen.items() if ours != CLOCK}
    at = chosen.get(CLOCK)
    count = 0
    for block in blocks:
        columns = parse(file, block, dialect, names, positions.values(), [] if at is None else [at])
        rows = len(next(iter(columns.values())))
        values = {ours: columns[k].to_numpy() for ours, k in positions.items()}
        stamps = None
        if tick is not None:
            stamps = np.arange(count, count + rows)
            if at is not None:
                clock = columns[at]
                if clock.null_count:
                    place = lines_of(block, rows).place(int(np.argmin(clock.is_valid().to_numpy())))
                    raise RecordingError(
                        f"{file}, {place}, {shown(names[at])}",
                        "is empty where a time stamp is needed",
                        "remove the row",
                    )
                stamps = clock.to_numpy()
        yield ColumnTable(str(file), tuple(names), values, stamps, tick or 0.0, lines_of(block, rows))
        count += rows
    if not count:
        raise RecordingError(file, "has a header but no rows", "record again")


def _header(file: Path, form: RecordingFormat, dialect: TextFormat) -> tuple[int, list[str]]:
    """Number of header lines, and names of the columns."""
    rows = form.header_rows if form.header_rows is not None else int(form.column_names is None)
    lines = read_head(file)
    if len(lines) < rows:
        raise RecordingError(file, f"has {len(lines)} lines, no more than recording.header_rows = {rows}")
    header = decoded(file, lines[:rows], dialect)
    if form.column_names is not None:
        return rows, list(form.column_names)
    row = form.names_row or rows
    if row == 0:
        raise RecordingError(file, "recording.header_rows = 0 leaves no names", "list them in recording.column_names")
    names = cells(header[row - 1], dialect)
    require_known(file, names, lines, form, row)
    return rows, names


_OVERRUN = b"overrun"
_NUMBER_OF_SAMPLE = "sample number"


def halsampler_tables(file: Path, form: RecordingFormat) -> Iterator[ColumnTable]:
    """Reads a file of LinuxCNC's halsampler batch by batch; errors as `tables`."""
    assert form.column_names is not None  # the case is checked
    dialect = TextFormat(form.delimiter or " ", form.decimal or ".")
    names, numbered = _columns(file, list(form.column_names), dialect)
    chosen = select(file, names, form)
    tick = form.tick if CLOCK in chosen else form.clock.period
    if numbered:
        chosen.setdefault(CLOCK, 0)
    lines = read_blocks(file, form.header_rows or 0, form.trailing_rows)
    blocks = (_without_overruns(file, block, CLOCK in chosen) for block in lines)
    yield from rows_of(file, (b for b in blocks if b.data.strip()), names, chosen, dialect, tick)


def _columns(file: Path, names: list[str], dialect: TextFormat) -> tuple[list[str], bool]:
    """Names of all fields of a line, and whether the first is the number of the sample."""
    lines = (line for line in read_head(file) if line.strip() and not line.startswith(_OVERRUN))
    text = next(lines, b"").decode(errors="replace")
    end = [""] if text.endswith(dialect.delimiter) else []
    values = dialect.split(text)
    count = len(values) - len(end)
    if count == len(names):
        return [*names, *end], False
    if count == len(names) + 1 and values[0].isdecimal():
        return [_NUMBER_OF_SAMPLE, *names, *end], True
    raise RecordingError(
        file,
        f"has {count} values in a line, where recording.column_names lists {len(names)}",
        "list one name for each pin of the sampler",
    )


def _without_overruns(file: Path, block: TextBlock, counted: bool) -> TextBlock:
    """The block with its lines `overrun` blanked; the first line of a file may be one without a loss."""
    if _OVERRUN not in block.data:
        return block
    lines = block.data.split(b"\n")
    for k, line in enumerate(lines):
        if line.strip() != _OVERRUN:
            continue
        number = block.first_line + k
        if number > 1 and not counted:
            raise RecordingError(
                f"{file}, line {number}",
                "LinuxCNC lost samples here and does not say how many",
                "record with halsampler -t and a longer queue (depth of the sampler)",
            )
        lines[k] = b""
    return TextBlock(block.first_line, b"\n".join(lines))
