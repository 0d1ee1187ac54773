"""Time stamps that are dates, times of day, or both, as hosts and programs of measurement write them."""

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

Nanoseconds = NDArray[np.int64]

TICK = 1e-9  # [s] of what is returned here
_CLOCK = r"(?P<minute>\d{2}):(?P<second>\d{2})(?:[.,:](?P<part>\d{1,12}))?"
_TIME = rf"(?P<hour>\d{{1,2}}):{_CLOCK}(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
_ZONE = r"(?:\s*(?:Z|UTC|GMT|[+-]\d{2}:?(?:\d{2})?))?"
_BETWEEN = r"(?:[T_;]|,?\s+)"
_YEAR_FIRST = r"(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})"
_YEAR_LAST = r"(?P<one>\d{1,2})[-/.](?P<other>\d{1,2})[-/.](?P<year>\d{4}|\d{2})"
_NAMED = r"(?P<day>\d{1,2})\.?[-\s]+(?P<name>\pL{3,9})\.?[-\s]+(?P<year>\d{4})"
_COMPACT = r"(?P<year>\d{4})(?P<month>\d{2})(?P<day>\d{2})T(?P<hour>\d{2}):?(?P<minute>\d{2}):?(?P<second>\d{2})"
_DATES = (_YEAR_FIRST, _YEAR_LAST, _NAMED)
_FORMS = (
    *(f"{date}{_BETWEEN}{_TIME}{_ZONE}" for date in _DATES),
    *(f"{_TIME}{_BETWEEN}{date}" for date in _DATES),
    rf"{_COMPACT}(?:[.,](?P<part>\d{{1,12}}))?{_ZONE}",
    f"{_TIME}{_ZONE}",
    r"(?P<minute>\d{1,2}):(?P<second>\d{2})[.,](?P<part>\d{1,12})",  # as spreadsheets show times of day
)
_MONTHS = (
    ("jan",), ("feb",), ("mar", "mär", "mrz"), ("apr",), ("may", "mai"), ("jun",), ("jul",), ("aug",), ("sep",),
    ("oct", "okt"), ("nov",), ("dec", "dez"),
)  # fmt: skip
_DAY, _HOUR, _MINUTE, _SECOND = 86_400 * 10**9, 3_600 * 10**9, 60 * 10**9, 10**9


def is_stamp(text: str) -> bool:
    """Whether text is a date with a time of day, or a time of day."""
    return (":" in text or "T" in text) and stamps_of(pa.array([text])) is not None


def stamps_of(texts: pa.Array | pa.ChunkedArray) -> Nanoseconds | None:
    """Time stamps in ns, ascending over midnight where they have no date, shape (n,); None where one is none.

    Days and months that could be exchanged are read so that the run is shorter.
    """
    for form in _FORMS:
        fields = _fields(texts, form)
        if len(fields) and fields.null_count == 0:
            return _read(fields)
    return None


def written(stamp: int) -> str:
    """A time stamp in ns as text: a date and time of day, or a time of day alone."""
    text = str(np.datetime64(stamp, "ns")).replace("T", " ").rstrip("0").removesuffix(".")
    return text.removeprefix("1970-01-01 ")


def first_unread(texts: pa.Array | pa.ChunkedArray) -> int:
    """The first text that is not a stamp of the kind of those above it, counted from 0."""
    return max(int(np.argmin(_fields(texts, form).is_valid().to_numpy(zero_copy_only=False))) for form in _FORMS)


def of_day(nanoseconds: Nanoseconds, turn: int = _DAY) -> Nanoseconds:
    """Times of day in ns that go on after midnight; of clocks that begin anew at other turns."""
    midnight = np.diff(nanoseconds, prepend=nanoseconds[:1]) < -turn // 2
    return np.asarray(nanoseconds + turn * np.cumsum(midnight))


def _fields(texts: pa.Array | pa.ChunkedArray, form: str) -> pa.StructArray:
    column = texts.cast(pa.string())
    column = column.combine_chunks() if isinstance(column, pa.ChunkedArray) else column
    return pc.extract_regex(pc.utf8_trim_whitespace(column), f"^(?:{form})$")


def _read(fields: pa.StructArray) -> Nanoseconds | None:
    """The stamps that fields of one form mean; None where they are not dates."""
    names = {field.name for field in fields.type}
    part = pc.utf8_slice_codeunits(pc.utf8_rpad(fields.field("part"), 9, "0"), 0, 9)
    time = _integers(fields, "minute") * _MINUTE + _integers(fields, "second") * _SECOND + _whole(part)
    if "hour" not in names:
        return of_day(time, _HOUR)
    hours = _integers(fields, "hour")
    if "half" in names and (half := np.array(fields.field("half").to_pylist())).any():  # of the day, of 12 hours
        hours = np.where(half == "", hours, hours % 12 + 12 * np.isin(half, ("p", "P")))
    time = time + hours * _HOUR
    if "year" not in names:
        return of_day(time)
    years = _integers(fields, "year")
    years = np.where(years < 100, years + 2000, years)
    if "name" in names:
        orders = [(_months(fields.field("name").to_pylist()), _integers(fields, "day"))]
    elif "one" in names:
        one, other = _integers(fields, "one"), _integers(fields, "other")
        orders = [(other, one), (one, other)]
    else:
        orders = [(_integers(fields, "month"), _integers(fields, "day"))]
    possible = (_days(years, month, day) for month, day in orders)
    stamps = [days * _DAY + time for days in possible if days is not None]
    return min(stamps, key=lambda read: int(np.ptp(read)), default=None)


def _integers(fields: pa.StructArray, name: str) -> Nanoseconds:
    return _whole(fields.field(name))


def _whole(texts: pa.StringArray) -> Nanoseconds:
    return np.asarray(texts.cast(pa.int64()).to_numpy(zero_copy_only=False))


def _months(names: list[str]) -> Nanoseconds:
    """Numbers of months by English or German names; 0 where one is none."""
    number = {name: k for k, group in enumerate(_MONTHS, 1) for name in group}
    return np.array([number.get(name[:3].lower(), 0) for name in names], dtype=np.int64)


def _days(years: Nanoseconds, months: Nanoseconds, days: Nanoseconds) -> Nanoseconds | None:
    """Days since 1970; None where one is not a date."""
    if months.min() < 1 or months.max() > 12 or days.min() < 1 or years.min() < 1700 or years.max() > 2200:
        return None
    first = ((years - 1970) * 12 + months - 1).astype("datetime64[M]")
    if np.any(days > ((first + 1).astype("datetime64[D]") - first.astype("datetime64[D]")).astype(np.int64)):
        return None
    return np.asarray(first.astype("datetime64[D]").astype(np.int64) + days - 1)
