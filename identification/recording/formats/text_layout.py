"""Where a text has its table: its sections, the fields of its rows, and which of them are columns of ours."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cases.base.errors import Code, RecordingError
from cases.base.phrases import Phrase, phrase
from cases.recording_format import CLOCK, COLUMNS, FileFormat
from identification.recording.formats.content import Section
from identification.recording.formats.table import listed, shown
from identification.recording.formats.words import aligned_fields, split

_REMARKS = (b"#", b"%", b"//")  # how a line begins that is a remark among rows
_TYPICAL = ("t_s", "l1_mm", "q1_mm", "x_mm", "r11", "ax", "f1_N", "fx_N")


@dataclass(frozen=True, slots=True)
class Field:
    """A field of each row."""

    name: str  # as the file calls it; empty where it does not
    also: tuple[str, ...] = ()  # other names that the file has for it
    unit: str = ""  # as a row of units has it
    clock: int | None = None  # position of the field with its time stamps, where the format says which
    step: float | None = None  # time between its rows, where the format states that [s]


@dataclass(frozen=True, slots=True)
class Layout:
    """Where a text has its table, and what the fields of its rows are."""

    form: FileFormat  # how the case describes it; separator, decimal sign and encoding are those of the text
    fields: tuple[Field, ...]
    sections: tuple[Section, ...]  # the rows; several where headers stand between them
    names_row: int = 0  # line that names the fields, counted from 1; 0: none does
    starts: tuple[float, ...] = (0.0,)  # what the stamps of each section count from [s]
    tick: float = 1.0  # duration of a unit of the stamps [s]
    period: float | None = None  # time between rows where no field is a clock [s]; None: there is no clock
    aligned: bool = False  # any number of blanks between two fields
    uneven: bool = False  # rows end with the last channel that goes on
    remarks: bool = False  # text may follow behind the last field
    no_rows: tuple[bytes, ...] = ()  # words that stand in a line of their own and are not a row
    hold: bool = False  # whether a field that is empty has its last value
    apart: bool = False  # whether rows of several clocks stand among each other, and fields of the others are empty
    header: tuple[str, ...] = ()  # the lines above the rows

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns, without those of clocks."""
        clocks = {field.clock for field in self.fields}
        return tuple(field.name for k, field in enumerate(self.fields) if field.name and k not in clocks)

    def label(self, position: int) -> str:
        """What a message calls a field."""
        timed = [field.name for field in self.fields if field.clock == position and field.name]
        return f"time of {timed[0]}" if timed else self.fields[position].name or f"column {position + 1}"

    def split(self, line: str) -> list[str]:
        """The fields of a line."""
        return aligned_fields(line, len(self.fields)) if self.aligned else split(line, self.form.separator)

    def is_no_row(self, line: bytes) -> bool:
        """Whether a line is blank, holds nothing but a word that is not a row, or a remark."""
        blanks = b" \t\r" if self.aligned else b" \t\r".replace(self.form.separator.encode(), b"")
        word = line.strip(blanks)
        if not word or word in self.no_rows:
            return True
        return word.startswith(_REMARKS) and len(self.split(word.decode("latin-1"))) != len(self.fields)


def cells(line: str, form: FileFormat) -> list[str]:
    """Fields of a header line."""
    return [name.strip() for name in split(line, form.separator)]


def decoded(file: Path, lines: Sequence[bytes], form: FileFormat) -> list[str]:
    """Header lines as text; raises RecordingError where one is not."""
    try:
        return [line.decode(form.encoding) for line in lines]
    except UnicodeDecodeError:
        raise not_text(file, form) from None


def select(file: Path, fields: Sequence[Field], form: FileFormat) -> dict[str, int]:
    """Our columns among those of a file, each with its position; raises RecordingError where one is there twice."""
    positions, mapped = {}, set(form.columns.values())
    clocks = {field.clock for field in fields} - {None}
    for ours in COLUMNS:
        theirs = form.file_name(ours)
        if theirs in mapped and ours not in form.columns:
            continue  # the case gives the column of that name another meaning
        if ours == CLOCK and clocks:
            continue  # the format says which it is
        places = [k for k, field in enumerate(fields) if field.name == theirs and k not in clocks]
        places = places or [k for k, field in enumerate(fields) if theirs in field.also and k not in clocks]
        if len(places) > 1:
            others = [name for k in places for name in fields[k].also[:1]]
            remedy = f"use their other names, such as {listed(others)}" if others else "rename or remove one"
            often = "twice" if len(places) == 2 else f"{len(places)} times"
            raise RecordingError(
                place=file, problem=f"column {shown(theirs)} is there {often}", remedy=remedy, code=Code.WRONG_KIND
            )
        if places:
            positions[ours] = places[0]
    return positions


def without(names: Iterable[str], form: FileFormat, wanted: Sequence[str] = _TYPICAL) -> Phrase:
    """What to say of a file with columns of some names that has none of those, by our names, that are wanted."""
    names = tuple(names)
    columns = listed(name for name in map(form.file_name, wanted) if name not in names)  # a clock alone is not enough
    return phrase(
        "none_of_columns",
        "none of the columns {columns}; it has {there}: name them so or map them in [recording.columns], or state "
        "separator and header in [recording] of the case, as hexcite look proposes",
        columns=columns,
        there=listed(names),
    )


def not_text(place: Path | str, form: FileFormat) -> RecordingError:
    """The error for what is not text in the stated encoding."""
    return RecordingError(
        place=place,
        problem=phrase("not_this_text", "is not {encoding} text", encoding=form.encoding.upper()),
        remedy=phrase("save_file_utf8", "save the file as UTF-8"),
        code=Code.UNREADABLE,
    )
