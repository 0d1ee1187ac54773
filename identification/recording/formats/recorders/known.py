"""The formats of text that are known: each is a value, and a new one is a file and a line here.

One description of each serves the reader, which asks for the columns that a case names, and `look`, which asks for all.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import CLOCK, TRIGGER, WRENCH, FileFormat, FormatName
from identification.recording.formats import text
from identification.recording.formats.content import Content, content_of
from identification.recording.formats.recorders import halsampler, lvm, plain, scope, sinumerik
from identification.recording.formats.ros.frames import FRAME, require_frame
from identification.recording.formats.table import MOST_MISSING, ColumnTable
from identification.recording.formats.text_layout import Layout, select, without
from identification.recording.formats.text_numbers import first_of


@dataclass(frozen=True, slots=True)
class TextFormat:
    """A way in which a program writes tables of numbers as text."""

    name: FormatName
    knows: Callable[[Sequence[bytes], FileFormat], bool]
    """Whether a file is of this format, by its first lines; what the case states of it may speak against it."""
    layout: Callable[[Content, Sequence[bytes], FileFormat], Layout]
    """Where its table is and what its fields are; raises RecordingError."""
    tables: Callable[[Content, Layout, Mapping[str, int], Iterable[str]], Iterator[ColumnTable]] = text.tables
    """The numbers, one table for each clock; raises RecordingError."""
    marked: bool = True
    """Whether its first line says what it is, so that no other format can be meant."""
    guessed: bool = False
    """Whether the case has to state the layout of its files, which can be guessed."""


FORMATS = (
    TextFormat("lvm", lvm.knows, lvm.layout),
    TextFormat("twincat-scope", scope.knows, scope.layout),
    TextFormat("sinumerik-trace", sinumerik.is_session, sinumerik.session_layout, sinumerik.session_tables),
    TextFormat("sinumerik-trace", sinumerik.knows, sinumerik.layout, marked=False, guessed=True),
    TextFormat("halsampler", halsampler.knows, halsampler.layout, halsampler.tables, marked=False),
    TextFormat("csv", lambda head, form: True, plain.layout, marked=False, guessed=True),
)


def format_of(head: Sequence[bytes], form: FileFormat) -> TextFormat:
    """The format of a file, by its first lines; any table of text is `csv`."""
    return next(known for known in FORMATS if known.knows(head, form))


def read(file: Path, form: FileFormat) -> Iterator[ColumnTable]:
    """The tables of a text file, one for each clock; raises RecordingError with the place and the remedy."""
    content = content_of(file)
    text_format, layout = described(content, form)
    chosen = select(file, layout.fields, layout.form)
    if not chosen.keys() - {CLOCK}:
        if form.column_names is None and text_format.name == "csv" and plain.is_headless(layout.names):
            place = f"{file}, line {layout.names_row}"
            raise RecordingError(
                place=place,
                problem=phrase("numbers_for_names", "holds numbers where names should be"),
                remedy=phrase("list_names", "list names in recording.column_names, as hexcite look does"),
                code=Code.WRONG_KIND,
            )
        raise RecordingError(place=file, problem=without(layout.names, layout.form), code=Code.MISSING)
    if chosen.keys() & set(WRENCH):
        for k, field in enumerate(layout.fields):
            if field.name.endswith(FRAME):
                require_frame(file, first_of(content, layout, k), form)
    for table in text_format.tables(content, layout, chosen, (TRIGGER,)):
        _require_values(table)
        yield table


def _require_values(table: ColumnTable) -> None:
    """Raises RecordingError where most fields of a column are empty."""
    for ours, column in table.values.items():
        missing = np.isnan(column)
        if (count := np.count_nonzero(missing)) > MOST_MISSING * len(column):
            problem = (
                f"is empty, like {count} of the {len(column)} rows of this column, more than {100 * MOST_MISSING:g} %"
            )
            remedy = "record again, or give a file of its own to what is sampled less often"
            if count < len(column):
                values = (
                    "set recording.empty = 'apart' if rows of several topics or recorders stand among each other, "
                    "'hold' if a value stands there only where it has changed"
                )
                remedy = f"{values}; else {remedy}"
            raise RecordingError(
                place=table.place(int(np.argmax(missing)), ours), problem=problem, remedy=remedy, code=Code.MISSING
            )


def described(content: Content, form: FileFormat) -> tuple[TextFormat, Layout]:
    """The format and the layout of a file: what its lines say themselves, unless the case states something else."""
    head = content.head()
    form_of_kind = format_of(head, form)
    stated = (
        form_of_kind
        if form_of_kind.name == form.format
        else next(k for k in reversed(FORMATS) if k.name == form.format)
    )
    if form_of_kind is not stated and (form_of_kind.marked or stated.name == "csv"):
        try:
            layout = form_of_kind.layout(content, head, _as(form, form_of_kind.name))
        except RecordingError:
            if stated.name == "csv" and _says_where(form):
                return stated, stated.layout(content, head, form)
            raise
        if _agrees(form, layout, form_of_kind):
            if not (form_of_kind.marked or form_of_kind.guessed):
                _require_complete(content.file, layout.form)
            return form_of_kind, layout
    return stated, stated.layout(content, head, form)


def _as(form: FileFormat, name: FormatName) -> FileFormat:
    return form.model_copy(update={"format": name})


def _says_where(form: FileFormat) -> bool:
    """Whether a case states where a table of text has its rows and names."""
    return form.header_rows is not None or form.column_names is not None


def _agrees(form: FileFormat, layout: Layout, known: TextFormat) -> bool:
    """Whether what a case states of a file is what its format says: files that were read as plain text still are."""
    if form.format != "csv":
        return True
    if form.column_names is not None and known.name != "halsampler":
        return False
    header_rows = layout.sections[0].first - 1 if layout.sections else 0
    stated = (
        (form.header_rows, header_rows),
        (form.names_row or form.header_rows, layout.names_row),
        (form.delimiter, layout.form.delimiter),
        (form.decimal, layout.form.decimal or "."),
    )
    return all(ours in (None, theirs) for ours, theirs in stated)


def _require_complete(file: Path, form: FileFormat) -> None:
    """Raises RecordingError where the case lacks what files of a format do not say."""
    try:
        type(form).model_validate(form.model_dump(exclude_none=True))
    except ValidationError as error:
        problem = str(error.errors()[0]["msg"]).removeprefix("Value error, ")
        raise RecordingError(
            place=file,
            problem=f"is a file of {form.format}",
            remedy=f"in [recording] of the case {problem}",
            code=Code.WRONG_KIND,
        ) from None
