"""What is wrong with a text file that cannot be read: its first line that is to blame, the value and the remedy."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from cases.errors import RecordingError
from cases.recording_format import RecordingFormat
from identification.formats.table import Block, is_number, is_value, listed, shown, split

_DECIMAL_COMMAS = re.compile(r"[0-9],[0-9]")
_TYPICAL = ("t_s", "l1_mm", "q1_mm", "x_mm", "r11", "ax", "f1_N", "fx_N")


def without(names: Iterable[str], form: RecordingFormat, wanted: Sequence[str] = _TYPICAL) -> str:
    """What to say of a file with columns of some names that has none of those, by our names, that are wanted."""
    columns = listed(map(form.file_name, wanted))
    remedy = "name them so, or state names, separator and header in [recording] of the case, as hexcite look proposes"
    return f"none of the columns {columns}; it has {listed(names)}: {remedy}"


def explain(
    file: Path, block: Block, names: Sequence[str], wanted: Sequence[int], form: RecordingFormat, cause: str
) -> RecordingError:
    """The error for lines that could not be read: the first that is to blame.

    `wanted` are positions of fields that must be numbers; `cause` is what the parser said of other damage.
    """
    first, data = block
    last = first + data.count(b"\n")
    for number, line in enumerate(data.split(b"\n"), first):
        place, raw = f"{file}, line {number}", line.rstrip(b"\r")
        if not raw:
            continue
        if not raw.strip(b"\0"):
            return RecordingError(place, "is binary zero, as after a crash while recording", "cut the file off there")
        try:
            text = raw.decode(form.encoding)
        except UnicodeDecodeError:
            return not_text(place, form)
        fields = split(text, form.separator)
        if len(fields) != len(names):
            remedy = _remedy(len(fields), len(names), form.separator, text, number < last)
            return RecordingError(place, f"expected {len(names)} columns, got {len(fields)}", remedy)
        for k in wanted:
            if not is_value(fields[k], form):
                return RecordingError(f"{place}, {shown(names[k])}", _not_a_number(fields[k], form))
    reason = shown(cause.splitlines()[0] if cause else "", 120)
    return RecordingError(file, f"is not a CSV table: {reason}", "correct that line")


def not_text(place: str, form: RecordingFormat) -> RecordingError:
    """The error for bytes that the file's encoding does not know."""
    return RecordingError(place, f"is not {form.encoding.upper()} text", "save the file as UTF-8")


def _remedy(count: int, wanted: int, separator: str, text: str, ends: bool) -> str:
    """What to do about a line of so many fields where so many are wanted."""
    if count < wanted and not ends:
        return "the file is cut off in its last line: remove that line"
    if count > wanted and separator == "," and _DECIMAL_COMMAS.search(text):
        return "does it have decimal commas? export with semicolons and set recording.delimiter and recording.decimal"
    if count > wanted and separator == " " and "  " in text:
        return "there are several blanks between numbers: export with one character between them"
    return "correct or remove the row"


def _not_a_number(text: str, form: RecordingFormat) -> str:
    if not text.strip():
        return "is empty where a number is needed; correct or remove the row"
    value = f"{shown(text)!r} is not a number"
    if form.decimal != "," and text.count(",") == 1 and is_number(text.replace(",", ".")):
        return f"{value}: it has a decimal comma; set recording.decimal = ',' in the case, or export with points"
    if form.decimal == "," and is_number(text):
        return f"{value}: it has a decimal point; set recording.decimal = '.' in the case, or export with commas"
    return f"{value}; correct or remove the row"
