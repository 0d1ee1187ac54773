"""LabVIEW measurement files (LVM): a header of the file, then one or more segments, each with its header and rows.

By National Instruments' specification (ni.com, "Specification for the LabVIEW Measurement File") and files of LabVIEW
(github ladisk/lvm_read). `X_Columns` says which times there are: `One` for all channels, `Multi` for each, or `No`,
where the first field of a row is empty and `Delta_X` is the time between rows. A comment may follow each row.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from fractions import Fraction

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import FileFormat
from identification.recording.formats.content import Content, Section
from identification.recording.formats.text_layout import Field, Layout
from identification.recording.formats.words import number_of, split

_MARK, _END, _X = b"LabVIEW Measurement", b"***End_of_Header***", "X_Value"
_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}


def knows(head: Sequence[bytes], form: FileFormat) -> bool:
    """Whether a file begins as LabVIEW measurement files do."""
    del form
    return head[0].startswith(_MARK)


def layout(content: Content, head: Sequence[bytes], form: FileFormat) -> Layout:
    """The layout of a file; raises RecordingError where its header is not complete, or its segments differ."""
    separator = form.delimiter or _separator(head)
    segments = [*_segments(content, separator)]
    if not segments or not segments[0].names:
        problem = "has no line ***End_of_Header*** with names and rows below it, as LabVIEW measurement files have"
        raise RecordingError(
            place=content.file,
            problem=problem,
            remedy=phrase("lvm_header", "write it again with one header at least"),
            code=Code.DAMAGED,
        )
    first, names = segments[0], segments[0].names
    other = next((s for s in segments if s.names != names), None)
    if other is not None:
        place = f"{content.file}, line {other.names_row}"
        raise RecordingError(
            place=place,
            problem=phrase("lvm_other_channels", "names other channels than the segment above"),
            remedy=phrase("lvm_segments", "give each segment as a file of its own"),
            code=Code.WRONG_KIND,
        )
    general = {row[0]: row[1] for line in head for row in [_words(line, separator)] if len(row) > 1}
    columns = general.get("X_Columns", "One").lower()
    row = first.first
    if columns == "no" and names[0] == _X and row[:1] != ("",):
        names = names[1:]  # the first field is left out too
    clocks = [] if columns == "no" else [k for k, name in enumerate(names) if name == _X]
    shift = len(first.names) - len(names)
    fields = []
    for k, name in enumerate(names):
        label, step = (_said(first, key, k + shift) for key in ("Y_Unit_Label", "Delta_X"))
        clock = max((c for c in clocks if c < k), default=None)
        if clock is None and name != _X and not clocks and step:
            fields.append(Field(name, unit=label, step=number_of(step)))
        else:
            fields.append(Field(name, unit=label, clock=clock))
    decimal = form.decimal or general.get("Decimal_Separator", "")
    if decimal not in (".", ","):
        decimal = "," if separator != "," and any("," in field for field in row) else "."
    return Layout(
        form=form.model_copy(update={"delimiter": separator, "decimal": decimal}),
        fields=tuple(fields),
        sections=tuple(segment.section for segment in segments),
        names_row=first.names_row,
        starts=tuple(_starts(content, segments, clocks[0] if clocks else None)),
        uneven=True,
        remarks=True,
    )


@dataclass(frozen=True, slots=True)
class _Segment:
    """The header of a segment, and where its rows are."""

    about: Mapping[str, Sequence[str]]  # what each line of the header says: key -> the fields of that line
    names: tuple[str, ...]
    section: Section
    first: tuple[str, ...]  # fields of its first row; empty where there are no rows
    last: tuple[str, ...]

    @property
    def names_row(self) -> int:
        """Line of the names, counted from 1."""
        return self.section.first - 1


def _segments(content: Content, separator: str) -> Iterator[_Segment]:
    """The segments of a file that have rows; each line that ends a header is followed by names, and these by rows."""
    header: list[bytes] = []
    names: bytes | None = None  # line of the names; None: a header goes on
    first, last, section = b"", b"", Section(0, 0, 0, 0)
    with content.opened() as stream:
        stream.seek(content.start)
        at = content.start
        for number, line in enumerate(stream, 1):
            at += len(line)
            if names is None:
                if header and header[-1].startswith(_END):
                    names, section, first = line, Section(number + 1, 0, at, at), b""
                else:
                    header.append(line)
            elif line[:1].isalpha() or line[:1] == b"*":  # a row begins with a number, or with nothing
                if section.rows:
                    yield _segment(header, names, section, first, last, separator)
                header, names = [line], None
            elif line.strip():
                first, last = first or line, line
                section = section._replace(rows=number + 1 - section.first, end=at)
        if names is not None and section.rows:
            yield _segment(header, names, section, first, last, separator)


def _separator(head: Sequence[bytes]) -> str:
    """The character between two fields, which the header names."""
    for line in head:
        for separator in _SEPARATORS.values():
            row = _words(line, separator)
            if row[0] == "Separator" and len(row) > 1:
                return _SEPARATORS.get(row[1].lower(), separator)
    return "\t"


def _words(line: bytes, separator: str) -> list[str]:
    """The fields of a line, at least one."""
    try:
        text = line.decode()
    except UnicodeDecodeError:
        text = line.decode("cp1252", "replace")
    return [field.strip() for field in split(text.rstrip("\r\n"), separator)] or [""]


def _segment(
    header: Sequence[bytes], names: bytes, section: Section, first: bytes, last: bytes, separator: str
) -> _Segment:
    about = {row[0]: row for row in (_words(line, separator) for line in header)}
    words = [tuple(_words(line, separator)) for line in (names, first, last)]
    return _Segment(about, words[0], section, words[1], words[2])


def _said(segment: _Segment, key: str, position: int) -> str:
    """What a line of a segment's header says of a field."""
    row = segment.about.get(key, ())
    return row[position] if position < len(row) else ""


def _starts(content: Content, segments: Sequence[_Segment], clock: int | None) -> Iterator[float]:
    """What the times of each segment count from [s]: they go on from one to the next, or begin anew at its date.

    Args:
        clock: the field that holds times; None: rows are at equal steps.
    """
    start, end = 0.0, -1.0
    for segment in segments:
        if clock is None:
            begin = next((x for x in map(number_of, segment.about.get("X0", ())[1:]) if x is not None), 0.0)
            step = next((x for x in map(number_of, segment.about.get("Delta_X", ())[1:]) if x is not None), 0.0)
            ends = begin, begin + step * (segment.section.rows - 1)
        else:
            begin = 0.0
            times = [number_of(row[clock]) if clock < len(row) else None for row in (segment.first, segment.last)]
            ends = (times[0] or 0.0, times[1] or 0.0)
        if start + ends[0] <= end:  # times begin anew
            date, origin = _date(segment), _date(segments[0])
            if date is None or origin is None or (later := float(date - origin)) + ends[0] <= end:
                place = f"{content.file}, line {segment.section.first}"
                problem = "the times of this segment begin anew, and no date in its header says when"
                raise RecordingError(
                    place=place,
                    problem=problem,
                    remedy=phrase("lvm_segments", "give each segment as a file of its own"),
                    code=Code.WRONG_KIND,
                )
            start = later
        end = start + ends[1]
        yield start + begin


def _date(segment: _Segment) -> Fraction | None:
    """When a segment begins, in seconds from some moment; None where its header does not say it."""
    day, time = (_said(segment, key, 1) for key in ("Date", "Time"))
    clock, _, rest = time.replace(",", ".").partition(".")
    try:
        begin = datetime.strptime(f"{day} {clock}", "%Y/%m/%d %H:%M:%S")
        return Fraction(int((begin - datetime(2000, 1, 1)).total_seconds())) + Fraction(f"0.{rest or 0}")
    except ValueError:
        return None
