"""What is wrong with a line that could not be read: one message with line, column, value and remedy."""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from cases.errors import RecordingError
from identification.formats.blocks import Block
from identification.formats.table import shown

_NUMBER = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*|\s*[+-]?(nan|inf(inity)?)\s*", re.I)
_DECIMAL_COMMAS = re.compile(r"[0-9],[0-9]")


@dataclass(frozen=True, slots=True)
class Dialect:
    """How a text file writes its numbers.

    Args:
        delimiter: between the fields of a line.
        decimal: sign, point or comma.
        missing: fields that stand for no value; without them an empty field is an error.
        encoding: of the text.
    """

    delimiter: str
    decimal: str = "."
    missing: tuple[str, ...] = ()
    encoding: str = "utf-8"

    def split(self, line: str) -> list[str]:
        """The fields of a line."""
        try:
            return next(csv.reader([line], delimiter=self.delimiter), [])
        except csv.Error:
            return line.split(self.delimiter)

    def is_number(self, text: str) -> bool:
        """Whether a field can be read."""
        if text in self.missing:
            return True
        if self.decimal == ",":
            return "." not in text and is_number(text.replace(",", ".", 1))
        return is_number(text)


def is_number(text: str) -> bool:
    """Whether text is a number with a decimal point."""
    return _NUMBER.fullmatch(text) is not None


def explain(
    file: Path, block: Block, names: Sequence[str], wanted: Sequence[int], dialect: Dialect, cause: str
) -> RecordingError:
    """The error for a block that could not be read: its first line that is to blame.

    Args:
        file: where the block is from.
        block: the lines.
        names: of all fields.
        wanted: positions of the fields that must be numbers.
        dialect: of the file.
        cause: what the parser said, for damage that is not understood here.
    """
    for number, raw, ends in _lines(block):
        place = f"{file}, line {number}"
        if not raw.strip(b"\0"):
            return RecordingError(f"{place}: is binary zero, as after a crash while recording; cut the file off there")
        try:
            text = raw.decode(dialect.encoding)
        except UnicodeDecodeError:
            return not_text(place, dialect)
        found = dialect.split(text)
        if len(found) != len(names):
            return RecordingError(
                f"{place}: expected {len(names)} columns, got {len(found)}; {_why(found, names, dialect, text, ends)}"
            )
        for k in wanted:
            if not dialect.is_number(found[k]):
                return RecordingError(f"{place}, {shown(names[k])}: {_not_a_number(found[k], dialect)}")
    reason = shown(cause.splitlines()[0] if cause else "", 120)
    return RecordingError(f"{file}: is not a CSV table: {reason}; correct that line")


def not_text(place: str, dialect: Dialect) -> RecordingError:
    """The error for bytes that the file's encoding does not know."""
    return RecordingError(f"{place}: is not {dialect.encoding.upper()} text; save the file as UTF-8")


def _lines(block: Block) -> Iterator[tuple[int, bytes, bool]]:
    """Number, text and whether it ends with a line break, of each line that is not blank."""
    lines = block.data.split(b"\n")
    for k, line in enumerate(lines):
        if line.rstrip(b"\r"):
            yield block.first_line + k, line.rstrip(b"\r"), k < len(lines) - 1


def _why(found: Sequence[str], names: Sequence[str], dialect: Dialect, text: str, ends: bool) -> str:
    if len(found) < len(names) and not ends:
        return "the file is cut off in its last line: remove that line"
    if len(found) > len(names) and dialect.delimiter == "," and _DECIMAL_COMMAS.search(text):
        return "does it have decimal commas? export with semicolons and set recording.delimiter and recording.decimal"
    if len(found) > len(names) and dialect.delimiter == " " and "  " in text:
        return "there are several blanks between numbers: export with one character between them"
    return "correct or remove the row"


def _not_a_number(text: str, dialect: Dialect) -> str:
    if not text.strip():
        return "is empty where a number is needed; correct or remove the row"
    value = f"{shown(text)!r} is not a number"
    if dialect.decimal == "." and text.count(",") == 1 and is_number(text.replace(",", ".")):
        return f"{value}: it has a decimal comma; set recording.decimal = ',' in the case, or export with points"
    if dialect.decimal == "," and is_number(text):
        return f"{value}: it has a decimal point; set recording.decimal = '.' in the case, or export with commas"
    return f"{value}; correct or remove the row"
