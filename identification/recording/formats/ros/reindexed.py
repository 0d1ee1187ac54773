"""Bags of ROS 1 whose index is missing, as a recorder that was stopped hard leaves them: read record by record.

`rosbag record` writes the index last; until then the file is called `.bag.active`, and its header says 0 where the
index is. Messages and connections stand in the file all the same (format 2.0 of ROS bags).
"""

import bz2
import mmap
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

SUFFIXES = (".bag", ".active")  # of bags of ROS 1, in lower case
_MARK = b"#ROSBAG V2.0\n"
_MESSAGE, _HEADER, _CHUNK, _CONNECTION = 2, 3, 5, 7  # op of a record
_MOST_CHUNK = 1 << 30  # bytes of one, unpacked


class _Record(NamedTuple):
    op: int
    fields: Mapping[str, bytes]
    data: bytes


def readable(bag: Path, folder: Path) -> Path:
    """The bag itself, or a copy of it in a folder, with an index and a name that readers of bags know.

    Raises ValueError, struct.error or OSError where its records are damaged.
    """
    if bag.suffix.lower() not in SUFFIXES or not bag.is_file():
        return bag
    if bag.suffix == SUFFIXES[0] and _indexed(bag):
        return bag
    file = folder / f"{len([*folder.iterdir()])}.bag"
    _write(bag, file)
    return file


def _indexed(bag: Path) -> bool:
    with bag.open("rb") as stream:
        start = stream.read(4096)  # the first record is as long
    first = next(_records(start[len(_MARK) :]), None) if start.startswith(_MARK) else None
    return first is None or first.op != _HEADER or any(first.fields.get("index_pos", b"?"))


def _write(bag: Path, file: Path) -> None:
    """Writes all messages of a bag, in their order in it, into one with an index."""
    from rosbags.rosbag1 import Writer

    connections = {}
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
                    writer.write(connections[number], seconds * 10**9 + nanoseconds, data)


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
