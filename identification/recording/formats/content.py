"""The text of a file, whatever it is stored as: its first lines, and the lines that hold its table."""

import codecs
import gzip
import io
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from identification.recording.formats.foreign import require_text
from identification.recording.formats.table import free_memory, require_file, unreadable

PART = 1 << 22  # bytes that are read at a time
LONGEST_LINE = 1 << 20  # bytes; a recording of a thousand channels stays far below
_GZIP = b"\x1f\x8b"
_MARKS = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_MOST = 4  # share of the free memory that text may take which is not stored as UTF-8: one over this


@dataclass(frozen=True, slots=True)
class Content:
    """The bytes of a text file, in UTF-8 or an encoding that has the letters of ASCII in common with it."""

    file: Path  # for messages
    start: int = 0  # where the text begins: behind a mark of UTF-8
    data: bytes | None = None  # the text, where the file stores it otherwise; None: its own bytes

    def opened(self) -> BinaryIO:
        """The text as a stream of bytes, positions counted from the start of the file."""
        return self.file.open("rb") if self.data is None else io.BytesIO(self.data)

    def head(self) -> list[bytes]:
        """Its first lines, without line breaks, more than any header has; raises RecordingError where all are blank."""
        try:
            with self.opened() as stream:
                stream.seek(self.start)
                data = stream.read(LONGEST_LINE)
        except OSError as error:
            raise unreadable(self.file, error) from error
        lines = data.split(b"\n")
        if not any(line.strip() for line in lines):
            raise RecordingError(
                place=self.file,
                problem=phrase("blank_lines", "is empty, it has blank lines only"),
                remedy=phrase("record_again", "record again"),
                code=Code.TOO_FEW,
            )
        if len(lines) > 1 and len(data) == LONGEST_LINE:
            lines.pop()  # what was read ends somewhere in this line
        return [line.removesuffix(b"\r") for line in lines]


def content_of(file: Path) -> Content:
    """The text of a file: as it is, in UTF-16 with its mark, compressed with gzip, or with lines as on a Macintosh.

    Raises RecordingError where it cannot be read, or is of a kind that is not text.
    """
    require_file(file)
    try:
        with file.open("rb") as stream:
            begin = stream.read(LONGEST_LINE)
            compressed = begin.startswith(_GZIP)
            if compressed:
                stream.seek(0)
                data = _within(file, _decompressed(file, stream))
                begin = data[:LONGEST_LINE]
            require_text(file, begin)
            mark = next((mark for mark in _MARKS if begin.startswith(mark)), None)
            if mark is not None:
                source: BinaryIO = io.BytesIO(data) if compressed else stream
                source.seek(len(mark))
                text = _within(file, _decoded(file, source, _MARKS[mark]))
                return Content(file, data=_with_line_feeds(text) if _by_returns(text[:LONGEST_LINE]) else text)
            start = len(codecs.BOM_UTF8) if begin.startswith(codecs.BOM_UTF8) else 0
            if _by_returns(begin):
                if not compressed:
                    stream.seek(0)
                    data = _within(file, iter(lambda: stream.read(PART), b""))
                return Content(file, start, _with_line_feeds(data))
    except OSError as error:
        raise unreadable(file, error) from error
    return Content(file, start, data if compressed else None)


def _by_returns(begin: bytes) -> bool:
    """Whether lines end with a carriage return alone, as a Macintosh wrote them and some exports for it still do."""
    return b"\r" in begin and b"\n" not in begin


def _with_line_feeds(data: bytes) -> bytes:
    """The same lines, each of as many bytes, with the end that everybody else writes."""
    return data.replace(b"\r", b"\n")


def _within(file: Path, parts: Iterator[bytes]) -> bytes:
    """All parts; raises RecordingError where they take too much of the free memory."""
    most = free_memory() // _MOST
    data = bytearray()
    for part in parts:
        data += part
        if len(data) > most:
            problem = f"holds more than {most / 1e9:.3g} GB of text, a quarter of the free memory"
            raise RecordingError(
                place=file,
                problem=problem,
                remedy=phrase("cut_or_uncompressed", "cut the run, or save it as UTF-8 without compressing it"),
                code=Code.UNREADABLE,
            )
    return bytes(data)


def _decoded(file: Path, stream: BinaryIO, encoding: str) -> Iterator[bytes]:
    """The rest of a stream in UTF-8."""
    decoder = codecs.getincrementaldecoder(encoding)()
    try:
        for part in iter(lambda: stream.read(PART), b""):
            yield decoder.decode(part).encode()
        yield decoder.decode(b"", final=True).encode()
    except UnicodeError:
        raise RecordingError(
            place=file,
            problem=phrase("damaged_utf16", "is damaged text in UTF-16"),
            remedy=phrase("save_utf8", "save it again, as UTF-8"),
            code=Code.DAMAGED,
        ) from None


def _decompressed(file: Path, stream: BinaryIO) -> Iterator[bytes]:
    """What gzip packed into a stream, in parts."""
    try:
        with gzip.GzipFile(fileobj=stream) as packed:
            yield from iter(lambda: packed.read(PART), b"")
    except EOFError:
        raise RecordingError(
            place=file,
            problem=phrase("gzip_cut", "is a gzip file that is cut off"),
            remedy=phrase("copy_again", "copy it again"),
            code=Code.DAMAGED,
        ) from None
    except (gzip.BadGzipFile, zlib.error):
        raise RecordingError(
            place=file,
            problem=phrase("gzip_damaged", "is a damaged gzip file"),
            remedy=phrase("copy_again", "copy it again"),
            code=Code.DAMAGED,
        ) from None


class Section(NamedTuple):
    """Lines of a text that lie below its header and above its trailing rows, and stay there until they are needed."""

    first: int  # number of its first line, counted from 1
    rows: int  # number of lines
    start: int  # where it starts and ends in the content [byte]
    end: int


Block = tuple[int, bytes]
"""Number of a line, counted from 1, and whole lines from there on; only the last may lack its line break."""


def section_of(content: Content, header_rows: int, trailing_rows: int, last_words: Sequence[bytes] = ()) -> Section:
    """The lines below a header, without trailing rows and blank lines at the end; raises RecordingError.

    Args:
        last_words: words that stand in a line of their own below the rows, and count as blank.
    """
    first, file = header_rows + 1, content.file
    try:
        with content.opened() as stream:
            stream.seek(content.start)
            start = stream.tell()
            for number in range(1, first + 1):
                start = stream.tell()
                if len(stream.readline(LONGEST_LINE)) == LONGEST_LINE:
                    place = f"{file}, line {number}"
                    raise RecordingError(
                        place=place,
                        problem=phrase("line_too_long", "is longer than a million characters"),
                        remedy=phrase("not_csv", "not a CSV table"),
                        code=Code.OUT_OF_RANGE,
                    )
            stream.seek(start)
            breaks = sum(part.count(b"\n") for part in iter(lambda: stream.read(PART), b""))
            size, length, lines, tail = stream.tell(), LONGEST_LINE, b"", b""
            while not lines and len(tail) < size - start:  # more of the end, where all of it is left out
                stream.seek(max(size - length, start))
                tail = stream.read()
                lines, length = _without_end(tail, trailing_rows, last_words), 4 * length
    except OSError as error:
        raise unreadable(file, error) from error
    left_out = tail[len(lines) :]
    count = breaks - left_out.count(b"\n") + bool(lines and not lines.endswith(b"\n"))
    return Section(first, count, start, size - len(left_out))


def _without_end(data: bytes, trailing_rows: int, last_words: Sequence[bytes]) -> bytes:
    """The lines above blank ones at the end and above the last rows that are not blank."""
    end = len(data)
    while end:
        start = data.rfind(b"\n", 0, end - 1) + 1
        line = data[start:end].strip(b" \t\r\n\x1a")
        blank = not line or (trailing_rows == 0 and line in last_words)
        if not blank and trailing_rows == 0:
            break
        trailing_rows -= not blank
        end = start
    return data[:end]


def lines_of(content: Content, section: Section) -> bytes:
    """The lines of a section."""
    with content.opened() as stream:
        stream.seek(section.start)
        return stream.read(section.end - section.start)


def blocks_of(content: Content, section: Section, size: int = PART) -> Iterator[Block]:
    """The lines of a section, some at a time."""
    with content.opened() as stream:
        stream.seek(section.start)
        number, rest, remaining = section.first, b"", section.end - section.start
        while remaining or rest:
            data = rest + stream.read(min(size, remaining))
            remaining = max(0, remaining - size)
            cut = data.rfind(b"\n") + 1 if remaining else len(data)
            if cut:
                yield number, data[:cut]
                number += data.count(b"\n", 0, cut)
            rest = data[cut:]
