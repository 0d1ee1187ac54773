"""Traces that controllers write as text: CSV exports of the TwinCAT 3 Scope, and files of LinuxCNC's halsampler.

TwinCAT: a header of channels, then columns of values, each group with its own clock. Verified with genuine exports of
Scope 3.4.3145 (test data of github CagtayFabry/pytcs) and Beckhoff's description (infosys.beckhoff.com, TE13xx,
"Export to csv"): a second line that starts with `Name` lists the channels, and each `Name` in it stands above a clock.
Where a channel has ended, its fields are a blank, or missing at the end of the line; a line `EOF` may follow. Not
verified: Full Timestamp, marker tables and trigger information (switch them off), other versions.

SINUMERIK traces are read as other text is (`text.tables`): exports differ, and the case states in what.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa

from cases.errors import RecordingError
from cases.recording_format import CLOCK, RecordingFormat
from identification.formats.table import Block, ColumnTable, Stamps, is_number, lines_of, split
from identification.formats.text import cells, decoded, parse, read_head, section_of, select, table_of, without

_NAME, _END = "Name", "EOF"
# FILETIME of the year 2000 in its own units; stamps in ms stay below for four million years.
_LEAST_FILETIME = 1.26e17
_LATE = 2  # samples by which the last of channels with one clock may differ


def scope_tables(file: Path, form: RecordingFormat) -> Iterator[ColumnTable]:
    """Reads a file: one table for each clock; raises RecordingError with the place and the remedy."""
    lines = read_head(file)
    form = form.model_copy(update={"delimiter": form.delimiter or lines[0][4:5].decode(errors="replace") or "\t"})
    header_rows, names = _layout(file, lines, form)
    positions = select(file, ["" if name == _NAME else name for name in names], form)
    positions.pop(CLOCK, None)
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
        if len(clock):  # else it is a channel that was not recorded
            if (float(clock[0]) >= _LEAST_FILETIME) != (form.clock_unit == "filetime"):
                problem = f"its time stamps, such as {clock[0]}, are not in {form.clock_unit}"
                raise RecordingError(file, problem, "set recording.clock.unit in the case: 'ms' or 'filetime'")
            values = {ours: columns[positions[ours]].to_numpy()[: len(clock)] for ours in group}
            yield ColumnTable(str(file), form, channels, values, clock, form.tick, places)


def _layout(file: Path, lines: list[bytes], form: RecordingFormat) -> tuple[int, list[str]]:
    """Number of header lines, and names of fields, those of clocks `Name`."""
    tops = [k for k, line in enumerate(lines) if line.startswith((_NAME + form.separator).encode())]
    top = tops[1] if len(tops) > 1 and not tops[0] else len(lines)
    rows = (split(line.decode(errors="replace"), form.separator) for line in lines[top + 1 :])
    filled = ([field.replace(",", ".", 1) for field in row if field.strip()] for row in rows)
    first = next((k for k, row in enumerate(filled) if row and all(map(is_number, row))), None)
    if first is None:
        raise RecordingError(
            file,
            "has no two lines that start with Name and a separator, and rows of numbers below, as exports of TwinCAT "
            "Scope have",
            "export it as CSV with its header, or set recording.format in the case",
        )
    names = cells(decoded(file, lines[: top + 1], form)[-1], form)
    while names and not names[-1]:  # some exports end each line with a separator
        names.pop()
    return top + 1 + first, names


def _filled(block: Block, count: int, delimiter: str) -> Block:
    """The block with all lines of equal length: without EOF, missing fields at the end added, surplus ones removed."""
    first, data = block
    separator, lines = delimiter.encode(), data.split(b"\n")
    for k, line in enumerate(lines):
        text = line.rstrip(b"\r")
        if text.strip() == _END.encode():
            lines[k] = b""
        elif text and (missing := count - 1 - text.count(separator)):
            lines[k] = text + separator * missing if missing > 0 else text.removesuffix(separator)
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


_OVERRUN = b"overrun"


def halsampler_tables(file: Path, form: RecordingFormat) -> list[ColumnTable]:
    """Reads a file of LinuxCNC's halsampler, with or without numbers of samples; errors as `tables`."""
    assert form.column_names is not None  # the case is checked
    head = next((line for line in read_head(file) if line.strip() and not line.startswith(_OVERRUN)), b"")
    values = head.decode(errors="replace").split()
    numbered = len(values) == len(form.column_names) + 1 and values[0].isdecimal()
    names = [*["sample number"] * numbered, *form.column_names, *[""] * head.endswith(b" ")]
    chosen = select(file, names, form)
    tick = form.tick if CLOCK in chosen else form.clock.period
    if numbered:
        chosen.setdefault(CLOCK, 0)
    first, data = section_of(file, form.header_rows or 0, form.trailing_rows, len(chosen)).text()
    lines = data.split(b"\n")
    overruns = [k for k, line in enumerate(lines) if line.strip() == _OVERRUN]
    if overruns[-1:] > [0] and CLOCK not in chosen:  # one at the top is not a loss
        raise RecordingError(
            f"{file}, line {first + overruns[-1]}",
            "LinuxCNC lost samples here and does not say how many",
            "record with halsampler -t and a longer queue (depth of the sampler)",
        )
    for k in overruns:
        lines[k] = b""
    return [table_of(file, (first, b"\n".join(lines)), names, chosen, form, tick)]
