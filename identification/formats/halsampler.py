"""Output of LinuxCNC's `halsampler`: a line a sample, values separated by one blank, no names, no time.

Seen in the source (src/hal/components/sampler_usr.c) and in files that LinuxCNC 2.9 wrote for us: every value is
followed by one blank, the last too; reals have six decimals, whatever their size; with `-t` the number of the sample
comes first; a line `overrun` stands where the number is not the expected one, as at the top of a file that was not
the sampler's first. Numbers count the samples that were kept, not the cycles: when the queue was full, 2.9 lost two
hundred samples without a trace in number or `overrun`. Record a counter or the time as a pin of its own where that
matters, and look at the pin `sampler.N.overruns`.

The case names the columns in the order of the pins and gives the period of the thread.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from cases.errors import RecordingError
from cases.recording import RecordingFormat
from identification.formats.delimited import rows_of
from identification.formats.header import select
from identification.formats.table import Table
from identification.formats.text import Block, Dialect, read_blocks, read_head

_OVERRUN = b"overrun"
_NUMBER_OF_SAMPLE = "sample number"


def tables(file: Path, form: RecordingFormat) -> Iterator[Table]:
    """Reads a file batch by batch; see `delimited.tables`."""
    assert form.column_names is not None  # the case is checked
    dialect = Dialect(form.delimiter or " ", form.decimal or ".")
    names, numbered = _columns(file, list(form.column_names), dialect)
    chosen = select(file, names, form)
    tick = form.clock.period if chosen.clock is None else form.tick
    if chosen.clock is None and numbered:
        chosen = replace(chosen, clock=0)
    lines = read_blocks(file, form.header_rows or 0, form.trailing_rows)
    blocks = (_without_overruns(file, block, chosen.clock is not None) for block in lines)
    yield from rows_of(file, (b for b in blocks if b.data.strip()), names, chosen, dialect, tick)


def _columns(file: Path, names: list[str], dialect: Dialect) -> tuple[list[str], bool]:
    """Names of all fields of a line, and whether the first is the number of the sample."""
    lines = (line for line in read_head(file) if line.strip() and not line.startswith(_OVERRUN))
    text = next(lines, b"").decode(errors="replace")
    end = [""] if text.endswith(dialect.delimiter) else []
    values = dialect.split(text)
    found = len(values) - len(end)
    if found == len(names):
        return [*names, *end], False
    if found == len(names) + 1 and values[0].isdecimal():
        return [_NUMBER_OF_SAMPLE, *names, *end], True
    raise RecordingError(
        f"{file}: has {found} values in a line, where recording.column_names lists {len(names)}; list one name for "
        "each pin of the sampler"
    )


def _without_overruns(file: Path, block: Block, counted: bool) -> Block:
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
                f"{file}, line {number}: LinuxCNC lost samples here and does not say how many; record with "
                "halsampler -t and a longer queue (depth of the sampler)"
            )
        lines[k] = b""
    return Block(block.first_line, b"\n".join(lines))
