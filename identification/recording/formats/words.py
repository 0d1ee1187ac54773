"""How text writes values: numbers with either decimal sign, the two states of a switch, and words for no value."""

import csv
import re
from math import isfinite, nan

from cases.recording_format import FileFormat

_NUMBER = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eEdD][+-]?[0-9]+)?\s*|\s*[+-]?(nan|inf(inity)?)\s*", re.I)
_TOUCHED = re.compile(r"(\.[0-9]*(?:[eEdD][+-]?[0-9]+)?)-")  # a number that ends where the sign of another stands
_FORTRAN = str.maketrans("dD", "ee")  # its double precision has exponents such as 1.5D+03

# What a C library of Microsoft's prints for what is not a number; the zeros are those of its precision.
_MICROSOFT = tuple(
    f"{sign}1{decimal}#{word}{'0' * zeros}"
    for sign in ("", "-")
    for decimal in ".,"
    for word in ("QNAN", "SNAN", "IND", "INF")
    for zeros in range(7)
)
EMPTY = ("", " ")
MISSING = (
    *EMPTY, "-", "--", "---", "#N/A", "#NV", "N/A", "n/a", "NA", "null", "NULL", "None", "none", "(None)", "No Data",
    "#NUM!", "#ZAHL!", "#VALUE!", "#WERT!", "#DIV/0!", *_MICROSOFT,
)  # fmt: skip
"""Fields that stand for no value, beside `nan`."""

_ON, _OFF = ("true", "wahr", "on", "ein", "high", "yes", "ja"), ("false", "falsch", "off", "aus", "low", "no", "nein")
ON = (*(form for word in _ON for form in (word, word.upper(), word.capitalize())), "1")
OFF = (*(form for word in _OFF for form in (word, word.upper(), word.capitalize())), "0")
"""The states of a switch."""

_MISSING, _SWITCHES = frozenset(MISSING), frozenset((*_ON, *_OFF))


def split(line: str, separator: str) -> list[str]:
    """The fields of a line."""
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        return line.split(separator)


def aligned_fields(line: str, count: int) -> list[str]:
    """The fields of a line of aligned columns; a number that fills its column touches the negative one behind it.

    Args:
        count: fields of the table; a line that has as many is left as it is.
    """
    fields = line.split()
    if len(fields) >= count:
        return fields
    apart = [part for field in fields for part in _TOUCHED.sub(r"\1 -", field).split()]
    return apart if len(apart) == count and all(map(is_number, apart)) else fields


def is_missing(text: str) -> bool:
    """Whether a field stands for no value."""
    return text.strip() in _MISSING


def is_switch(text: str) -> bool:
    """Whether a field is a state of a switch in words."""
    return text.strip().lower() in _SWITCHES


def is_number(text: str) -> bool:
    """Whether text is a number with a decimal point."""
    return _NUMBER.fullmatch(text) is not None


def number_of(text: str) -> float | None:
    """The number that text writes with either decimal sign; None where it is none, or not finite."""
    plain = text.replace(",", ".", 1)
    value = (
        float(plain.lower().translate(_FORTRAN) if plain.strip()[-1:].isdigit() else plain) if is_number(plain) else nan
    )
    return value if isfinite(value) else None


def is_value(text: str, form: FileFormat) -> bool:
    """Whether a field is a number, or stands for none."""
    if is_missing(text):
        return True
    if form.decimal == ",":
        return "." not in text and is_number(text.replace(",", ".", 1))
    return is_number(text)


def regular(text: str, form: FileFormat, switch: bool) -> str | None:
    """A field as a number that every reader knows, `nan` for no value; None where it is neither.

    Args:
        switch: whether it may be a state in words: 1 for on, 0 for off.
    """
    word = text.strip()
    if word in EMPTY:
        return ""
    if word in _MISSING:
        return "nan"
    if is_value(word, form):
        return word.translate(_FORTRAN) if word[-1:].isdigit() else word
    if switch and word.lower() in _SWITCHES:
        return "1" if word.lower() in _ON else "0"
    return None
