"""What LinuxCNC's halsampler prints: rows of numbers with a blank behind each, and `overrun` where samples were lost.

With its option -t the number of the sample stands first, which shows how many were lost. Verified with the sampler of
LinuxCNC 2.9 (src/hal/components/sampler_usr.c).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import CLOCK, COLUMNS, FileFormat
from identification.recording.formats import text
from identification.recording.formats.content import Content, blocks_of, section_of
from identification.recording.formats.recorders.plain import SAMPLE
from identification.recording.formats.table import ColumnTable
from identification.recording.formats.text_layout import Field, Layout
from identification.recording.formats.words import is_number

_OVERRUN = b"overrun"
NUMBER = "sample number"


def knows(head: Sequence[bytes], form: FileFormat) -> bool:
    """Whether a file is from halsampler: rows of numbers alone, each with a blank behind it."""
    lines = [line for line in head[:SAMPLE] if line.strip() and line.strip() != _OVERRUN]
    return form.delimiter is None and len(lines) > 1 and all(map(_is_sample, lines))


def _is_sample(line: bytes) -> bool:
    text = line.decode("latin-1")
    fields = text.split(" ")
    return fields[-1] == "" and len(fields) > 1 and all(map(is_number, fields[:-1]))


def layout(content: Content, head: Sequence[bytes], form: FileFormat) -> Layout:
    """The layout of a file, with or without numbers of samples; names come from the case."""
    above = form.header_rows or 0
    lines = [line.strip() for line in head[above:] if line.strip()][:SAMPLE]
    samples = [line.decode(errors="replace").split() for line in lines if line != _OVERRUN]
    width = len(samples[0]) if samples else 0
    names = list(form.column_names or ())
    numbered = is_numbered(lines) or (bool(samples) and len(names) == width - 1 and samples[0][0].isdecimal())
    if not names:
        names = [f"column {k}" for k in range(1, width + 1 - numbered)]
    if numbered and len(names) == width - 1:
        names = [NUMBER, *names]
    elif numbered and names[0] not in (*form.columns.values(), *COLUMNS):
        names[0] = NUMBER  # the case names it too
    counted = names[:1] == [NUMBER] and form.file_name(CLOCK) not in names
    period = form.clock.period
    return Layout(
        form=form.model_copy(update={"delimiter": " "}),
        fields=tuple(Field(name, clock=0 if counted and k else None) for k, name in enumerate(names)),
        sections=(section_of(content, above, form.trailing_rows),),
        tick=period or 1.0 if counted else form.tick,
        period=period,
        aligned=True,
        no_rows=(_OVERRUN,),
    )


def is_numbered(lines: Sequence[bytes]) -> bool:
    """Whether rows begin with the number of their sample, which grows by one unless some were lost in between."""
    firsts = [None if line == _OVERRUN else line.split()[0] for line in lines]
    pairs = [(a, b) for a, b in pairwise(firsts) if a is not None and b is not None]
    whole = all(first is None or first.isdigit() for first in firsts)
    return whole and bool(pairs) and all(int(b) - int(a) == 1 for a, b in pairs)


def tables(
    content: Content, layout: Layout, chosen: Mapping[str, int], switches: Iterable[str]
) -> Iterator[ColumnTable]:
    """As `text.tables`; raises RecordingError too where samples were lost and nothing says how many."""
    if CLOCK not in chosen and all(field.clock is None for field in layout.fields):
        for section in layout.sections:
            lines = (
                (number, line.strip())
                for first, data in blocks_of(content, section)
                if _OVERRUN in data
                for number, line in enumerate(data.split(b"\n"), first)
            )
            lost = [number for number, line in lines if line == _OVERRUN and number > section.first]
            if lost:  # one at the top is not a loss
                raise RecordingError(
                    place=f"{content.file}, line {lost[-1]}",
                    problem=phrase("linuxcnc_lost", "LinuxCNC lost samples here and does not say how many"),
                    remedy=phrase(
                        "longer_queue", "record with halsampler -t and a longer queue (depth of the sampler)"
                    ),
                    code=Code.DAMAGED,
                )
    for table in text.tables(content, layout, chosen, switches):
        yield replace(table, stamped=CLOCK in chosen)  # numbers of samples count periods
