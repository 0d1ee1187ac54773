"""Traces that controllers write as text: CSV exports of the TwinCAT 3 Scope, and files of LinuxCNC's halsampler.

TwinCAT: a header of channels, then columns of values, each group with its own clock. Verified with genuine exports of
Scope 3.4.3145 (test data of github CagtayFabry/pytcs) and Beckhoff's description (infosys.beckhoff.com, TE13xx,
"Export to csv"): line 1 is `Name`, the separator and the scope's name; a second line that starts with `Name` lists
the channels, and each `Name` in it stands above a clock. Up to 17 more lines about the channels follow, a comment in
them may run over several lines. Stamps are ms from the first sample, or FILETIME where Full Timestamp is on. Where a
channel has ended, its fields are a blank, or missing at the end of the line. A line `EOF` may follow. Not verified:
Full Timestamp, marker tables and trigger information (switch them off), Interpolation = Shift value, array channels,
other versions.

SINUMERIK traces exported as text are read as other text is (`text.tables`). No genuine export was at hand and no manual
that describes the file was found; public programs that read such files (searched November 2026) differ in delimiter,
decimal sign, header and clock, so that the case states them. SINUMERIK Operate's own XML is not read.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa

from cases.errors import RecordingError
from cases.recording_format import CLOCK, RecordingFormat
from identification.formats.table import Block, ColumnTable, Stamps, is_number, lines_of, split
from identification.formats.text import cells, decoded, parse, read_head, section_of, select, table_of
from identification.formats.text_errors import without

_NAME, _SYMBOL, _END = "Name", "SymbolName", b"EOF"
_LATE = 2  # samples by which the last of channels with one clock may differ
# FILETIME of the year 2000 in its own units; stamps in ms stay below for four million years.
_LEAST_FILETIME = 1.26e17


def scope_tables(file: Path, form: RecordingFormat) -> Iterator[ColumnTable]:
    """Reads a file: one table for each clock; raises RecordingError with the place and the remedy."""
    lines = read_head(file)
    form = form.model_copy(update={"delimiter": _separator(file, lines[0], form)})
    header_rows, names, positions = _layout(file, lines, form)
    clocks = [k for k, name in enumerate(names) if name == _NAME]
    clock_of = {ours: max(c for c in clocks if c <= k) for ours, k in positions.items()}
    channels = tuple(name for name in names if name not in ("", _NAME))
    if not positions:
        raise RecordingError(file, without(channels, form))
    labels = [f"time of {(*names, 'nothing')[k + 1]}" if k in clocks else name for k, name in enumerate(names)]
    wanted = sorted(set(clock_of.values()))
    block = section_of(file, header_rows, form.trailing_rows, len(positions) + len(wanted)).text()
    filled = _filled(block, len(names), form.separator)
    columns = parse(file, filled, form, labels, positions.values(), wanted) if filled[1].strip() else {}
    stamps = {k: _present(file, filled, column) for k, column in columns.items() if k in wanted}
    if not any(map(len, stamps.values())):
        raise RecordingError(file, "has a header but no rows", "export the recording again")
    places = lines_of(filled, len(columns[wanted[0]]))
    for group in _groups({ours: stamps[k] for ours, k in clock_of.items()}):
        clock = min((stamps[clock_of[ours]] for ours in group), key=len)
        if not len(clock):  # a channel that was not recorded
            continue
        _require_unit(file, clock, form)
        values = {ours: columns[positions[ours]].to_numpy()[: len(clock)] for ours in group}
        yield ColumnTable(str(file), form, channels, values, clock, form.tick, places)


def _separator(file: Path, line: bytes, form: RecordingFormat) -> str:
    separator = form.delimiter or line[len(_NAME) : len(_NAME) + 1].decode(errors="replace")
    if not line.startswith(_NAME.encode()) or not separator or separator.isalnum():
        raise RecordingError(
            f"{file}, line 1",
            "does not start with Name and a separator, as exports of TwinCAT Scope do",
            "export as CSV with its header, or set recording.format in the case",
        )
    if separator == " ":
        raise RecordingError(file, "its columns are separated by blanks", "export with tabulators or semicolons")
    return separator


def _layout(file: Path, lines: list[bytes], form: RecordingFormat) -> tuple[int, list[str], dict[str, int]]:
    """Number of header lines, names of fields, those of clocks `Name`, and positions of the wanted columns."""
    start = (_NAME + form.separator).encode()
    top = next((k for k, line in enumerate(lines) if k and line.startswith(start)), None)
    if top is None:
        raise RecordingError(file, "has no second line that starts with Name", "export it with its header")
    rows = (split(line.decode(errors="replace"), form.separator) for line in lines[top + 1 :])
    filled = ([field.replace(",", ".", 1) for field in row if field.strip()] for row in rows)
    first = next((k for k, row in enumerate(filled, top + 1) if row and all(map(is_number, row))), None)
    if first is None:
        raise RecordingError(file, "has a header but no rows of numbers", "export the recording again")
    names = cells(decoded(file, lines[: top + 1], form)[top], form)
    while names and not names[-1]:  # some exports end each line with a separator
        names.pop()
    positions = select(file, ["" if name == _NAME else name for name in names], form)
    for line in lines[top + 1 : first]:
        if line.startswith((_SYMBOL + form.separator).encode()):
            symbols = cells(line.decode(form.encoding, "replace"), form)
            positions = select(file, [*symbols, *names][: len(names)], form) | positions
    positions.pop(CLOCK, None)
    return first, names, positions


def _filled(block: Block, count: int, delimiter: str) -> Block:
    """The block with all lines of equal length: without EOF, missing fields at the end added, surplus ones removed."""
    first, data = block
    separator, lines = delimiter.encode(), data.split(b"\n")
    rows = sum(1 for line in lines if line.strip(b"\r"))
    if data.count(separator) == rows * (count - 1) and _END not in data:
        return block
    for k, line in enumerate(lines):
        text = line.rstrip(b"\r")
        if text.strip() == _END:
            lines[k] = b""
        elif text:
            missing = count - 1 - text.count(separator)
            lines[k] = text + separator * missing if missing >= 0 else text.removesuffix(separator)
    return first, b"\n".join(lines)


def _present(file: Path, block: Block, column: pa.ChunkedArray) -> Stamps:
    """The stamps of a clock up to its last sample."""
    valid = column.is_valid().to_numpy()
    count = int(valid.sum())
    if not valid[:count].all():
        place = lines_of(block, len(column)).place(int(np.argmin(valid)))
        raise RecordingError(f"{file}, {place}", "a clock has no value but goes on below", "remove the row")
    return np.asarray(column.slice(0, count).to_numpy())


def _groups(stamps: Mapping[str, Stamps]) -> list[tuple[str, ...]]:
    """Wanted columns that share their clock: the same one, or equal ones; their last samples may be missing."""
    groups: dict[str, tuple[str, ...]] = {}
    for ours, clock in stamps.items():
        first = next((other for other in groups if _alike(stamps[other], clock)), ours)
        groups[first] = (*groups.get(first, ()), ours)
    return [*groups.values()]


def _alike(one: Stamps, other: Stamps) -> bool:
    common = min(len(one), len(other))
    return max(len(one), len(other)) - common <= _LATE and np.array_equal(one[:common], other[:common])


def _require_unit(file: Path, stamps: Stamps, form: RecordingFormat) -> None:
    counts_ticks = float(stamps[0]) >= _LEAST_FILETIME
    if counts_ticks != (form.clock_unit == "filetime"):
        right = "filetime" if counts_ticks else "ms"
        raise RecordingError(
            file,
            f"its time stamps, such as {stamps[0]}, are not in {form.clock_unit}",
            f"set recording.clock.unit = {right!r} in the case",
        )


_OVERRUN = b"overrun"
_NUMBER_OF_SAMPLE = "sample number"


def halsampler_tables(file: Path, form: RecordingFormat) -> list[ColumnTable]:
    """Reads a file of LinuxCNC's halsampler; errors as `tables`."""
    assert form.column_names is not None  # the case is checked
    names, numbered = _columns(file, list(form.column_names), form.separator)
    chosen = select(file, names, form)
    tick = form.tick if CLOCK in chosen else form.clock.period
    if numbered:
        chosen.setdefault(CLOCK, 0)
    block = section_of(file, form.header_rows or 0, form.trailing_rows, len(chosen)).text()
    return [table_of(file, _without_overruns(file, block, CLOCK in chosen), names, chosen, form, tick)]


def _columns(file: Path, names: list[str], separator: str) -> tuple[list[str], bool]:
    """Names of all fields of a line, and whether the first is the number of the sample."""
    lines = (line for line in read_head(file) if line.strip() and not line.startswith(_OVERRUN))
    text = next(lines, b"").decode(errors="replace")
    end = [""] if text.endswith(separator) else []
    values = split(text, separator)
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


def _without_overruns(file: Path, block: Block, counted: bool) -> Block:
    """The block with its lines `overrun` blanked; the first line of a file may be one without a loss."""
    first, data = block
    if _OVERRUN not in data:
        return block
    lines = data.split(b"\n")
    for k, line in enumerate(lines):
        if line.strip() != _OVERRUN:
            continue
        number = first + k
        if number > 1 and not counted:
            raise RecordingError(
                f"{file}, line {number}",
                "LinuxCNC lost samples here and does not say how many",
                "record with halsampler -t and a longer queue (depth of the sampler)",
            )
        lines[k] = b""
    return first, b"\n".join(lines)
