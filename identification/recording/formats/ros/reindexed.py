"""Bags of ROS 1 whose index is missing, as a recorder that was stopped or a copy that was cut leaves them.

`rosbag record` writes the index last; until then the file is called `.bag.active`, and its header says 0 where the
index is. Messages and connections stand in the file all the same (format 2.0 of ROS bags): they are read record by
record. A file that was cut has a header that points behind its end.
"""

import bz2
import mmap
import struct
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from cases.base.phrases import phrase
from identification.finding import Finding, Kind, note

SUFFIXES = (".bag", ".active")  # of bags of ROS 1, in lower case
_MARK = b"#ROSBAG V2.0\n"
_MESSAGE, _HEADER, _CHUNK, _CONNECTION = 2, 3, 5, 7  # op of a record
_MOST_CHUNK = 1 << 30  # bytes of one, unpacked


class _Record(NamedTuple):
    op: int
    fields: Mapping[str, bytes]
    data: bytes


class Readable(NamedTuple):
    """A bag that readers of bags can read."""

    file: Path
    findings: tuple[Finding, ...] = ()  # what was missing in it


def readable(bag: Path, folder: Path) -> Readable:
    """The bag itself, or a copy of it in a folder, with an index and a name that readers of bags know.

    Raises ValueError, struct.error or OSError where its records are damaged.
    """
    if bag.suffix.lower() not in SUFFIXES or not bag.is_file():
        return Readable(bag)
    indexed = _indexed(bag)
    if bag.suffix == SUFFIXES[0] and indexed:
        return Readable(bag)
    file = folder / f"{len([*folder.iterdir()])}.bag"
    cut, seconds = _write(bag, file)
    return Readable(file, () if indexed else (_without_index(bag, cut, seconds),))


def _without_index(bag: Path, cut: bool, seconds: float) -> Finding:
    sentence = (
        phrase(
            "bag_cut",
            "{bag}: the index is missing and the file is cut off: its messages were read one by one, to {seconds} s "
            "after the first; what was recorded later is lost",
            bag=str(bag),
            seconds=f"{seconds:.2f}",
        )
        if cut
        else phrase(
            "bag_without_index",
            "{bag}: the index is missing, as where a recorder is stopped hard: its messages were read one by one, to "
            "{seconds} s after the first",
            bag=str(bag),
            seconds=f"{seconds:.2f}",
        )
    )
    return note(Kind.FORMAT, sentence, bag_without_index={"cut": cut, "seconds": seconds})


def _indexed(bag: Path) -> bool:
    """Whether a bag has all records of the index that its header points to; of another file, whether it has no header
    that says so.
    """
    with bag.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        if content[: len(_MARK)] != _MARK:
            return True
        header = next(_records(content, len(_MARK)), None)
        if header is None or header.op != _HEADER:
            return True
        begins, connections, chunks = (
            int.from_bytes(header.fields.get(key, b""), "little") for key in ("index_pos", "conn_count", "chunk_count")
        )
        if not begins:
            return False
        index = islice(_records(content, begins), connections + chunks)
        return sum(1 for _ in index) == connections + chunks


def _write(bag: Path, file: Path) -> tuple[bool, float]:
    """Writes all messages of a bag, in their order in it, into one with an index.

    Returns:
        whether the bag ends within a record; time from its first to its last message [s].
    """
    from rosbags.rosbag1 import Writer

    connections, times = {}, list[int]()
    with bag.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
        if content[: len(_MARK)] != _MARK:
            raise ValueError("it is not of version 2.0")
        with Writer(file) as writer:
            for op, fields, data in _unpacked(content):
                number = fields.get("conn", b"")
                if op == _CONNECTION and number not in connections:
                    about = dict(_fields(data))
                    connections[number] = writer.add_connection(
                        fields["topic"].decode(),
                        about["type"].decode().replace("/", "/msg/", 1),
                        msgdef=about["message_definition"].decode(),
                        md5sum=about["md5sum"].decode(),
                        callerid=f"connection {int.from_bytes(number, 'little')}",  # which tells equal ones apart
                    )
                elif op == _MESSAGE and number in connections:
                    seconds, nanoseconds = struct.unpack("<II", fields["time"])
                    times.append(seconds * 10**9 + nanoseconds)
                    writer.write(connections[number], times[-1], data)
        return _end(content) < len(content), 1e-9 * (max(times) - min(times)) if times else 0.0


def _unpacked(content: mmap.mmap) -> Iterator[_Record]:
    """Records of a file, those inside chunks in their place. A chunk that was being written has no end yet: its records
    follow it.
    """
    for record in _records(content, len(_MARK)):
        if record.op != _CHUNK:
            yield record
            continue
        if int.from_bytes(record.fields["size"], "little") > _MOST_CHUNK:
            raise ValueError("a chunk says that it is larger than 1 GB")
        yield from _records(_unpack(record.fields["compression"], record.data))


def _unpack(compression: bytes, data: bytes) -> bytes:
    if compression == b"none" or not data:
        return data
    if compression == b"bz2":
        return bz2.decompress(data)
    if compression != b"lz4":
        raise ValueError(f"its chunks are compressed by {compression.decode(errors='replace')[:20]}")
    import lz4.frame  # type: ignore[import-untyped]

    try:
        unpacked: bytes = lz4.frame.decompress(data)
    except RuntimeError as error:
        raise ValueError(str(error)) from None
    return unpacked


def _records(content: bytes | mmap.mmap, at: int = 0) -> Iterator[_Record]:
    """Records from a place on, up to one that is cut off."""
    while (named := _sized(content, at)) is not None and (held := _sized(content, named[1])) is not None:
        fields = dict(_fields(named[0]))
        yield _Record(int.from_bytes(fields.get("op", b""), "little"), fields, held[0])
        at = held[1]


def _end(content: mmap.mmap) -> int:
    """Where the last whole record of a bag ends."""
    at = len(_MARK)
    while (named := _sized(content, at)) is not None and (held := _sized(content, named[1])) is not None:
        at = held[1]
    return at


def _fields(header: bytes) -> Iterator[tuple[str, bytes]]:
    at = 0
    while (entry := _sized(header, at)) is not None:
        name, _, value = entry[0].partition(b"=")
        yield name.decode(), value
        at = entry[1]


def _sized(content: bytes | mmap.mmap, at: int) -> tuple[bytes, int] | None:
    """Bytes behind their number (4 bytes), and where they end; None where the content ends before."""
    if at + 4 > len(content):
        return None
    end = at + 4 + int.from_bytes(content[at : at + 4], "little")
    return None if end > len(content) else (content[at + 4 : end], end)
