"""The names of a text file's columns: found, matched with ours, and where they are not, the likely reason."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cases.errors import RecordingError
from cases.recording_format import CLOCK, COLUMNS, RecordingFormat
from identification.formats.table import listed, shown
from identification.formats.text import TextFormat, not_text

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabulators", " ": "blanks", "|": "vertical bars"}
_SEARCHED_LINES = 50  # no export known to us has a longer header
_TYPICAL = ("t_s", "l1_mm", "q1_mm", "x_mm", "r11", "ax", "f1_N", "fx_N")


@dataclass(frozen=True, slots=True)
class ColumnChoice:
    """Which of a file's columns are ours."""

    values: dict[str, int]  # our column name -> position in the file
    clock: int | None  # position of the time stamps


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


def select(file: Path, names: Sequence[str], form: RecordingFormat) -> ColumnChoice:
    """Our columns among those of a file.

    Raises:
        RecordingError: one of ours is there twice.
    """
    positions = {}
    for ours in COLUMNS:
        theirs = form.file_name(ours)
        if names.count(theirs) > 1:
            raise RecordingError(file, f"column {shown(theirs)} is there twice", "rename or remove one")
        if theirs in names:
            positions[ours] = names.index(theirs)
    return ColumnChoice({k: p for k, p in positions.items() if k != CLOCK}, positions.get(CLOCK))


def require_known(file: Path, names: Sequence[str], lines: Sequence[bytes], form: RecordingFormat, row: int) -> None:
    """Raises RecordingError unless some of the names are ours; looks for ours elsewhere in the header.

    Args:
        file: file for the message.
        names: found in line `row`.
        lines: the first lines of the file.
        row: line in which the names were sought, counted from 1.
    """
    ours = {form.file_name(c) for c in COLUMNS}
    if ours & set(names):
        return
    expected = form.delimiter or ","
    for k, line in enumerate(lines[:_SEARCHED_LINES], 1):
        for separator, word in _SEPARATORS.items():
            found = {c.strip() for c in TextFormat(separator).split(line.decode(form.encoding, "replace"))}
            if not (found & ours) or len(found) < 2:
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
