"""Bags and Parquet files, damaged: `look` and the reader answer, or refuse in a line.

A base is a short run as rosbags or pyarrow write it. What is damaged is what stands in it (messages lost, doubled, of
odd stamps, names, lengths, numbers; columns of any type) before it is written, or bytes of its files afterwards.
"""

import random
import shutil
from collections.abc import Callable, Sequence
from datetime import date, timedelta
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.rosbag2 import StoragePlugin

from tests.bench.reliability.looked import as_proposed, as_stated
from tests.bench.reliability.tally import Tally, tallied
from tests.chains import ROBOT
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth
from tests.identification.recording.formats.test_ros import EPOCH, JOINTS, WRENCH, header, make, run, state, write

Message = tuple[str, int, Any]

LASTS = 60_000_000  # [ns] of a bag
STAMPS = (0, 1, -1, 10**9, EPOCH - 10**9, EPOCH + 10**12, 2**31 * 10**9 - 1, -(2**31) * 10**9)  # [ns]
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, 1e308, -1e308, 5e-324, 1e6)
WORDS = ("", "world", "ft_sensor", "a\nb", "\x1b[31m", "\u202e", "é", "x" * 3000, "base", "finger", "../..", "{}")


def _bytes_damaged(content: bytes, draw: random.Random) -> bytes:
    """The file cut, or with bytes lost, changed, doubled or put at another place."""
    at, size = draw.randrange(len(content) + 1), int(2 ** draw.uniform(0.0, 12.0))
    match draw.randrange(6):
        case 0:
            return content[:at]
        case 1:
            return content[:at] + content[at + size :]
        case 2:
            noise = bytes(draw.choices(range(256), k=min(size, 64)))
            return content[:at] + noise + content[at + len(noise) :]
        case 3:
            bit = bytes([content[at] ^ 1 << draw.randrange(8)]) if at < len(content) else b""
            return content[:at] + bit + content[at + 1 :]
        case 4:
            return content[:at] + content[at : at + size] * 2 + content[at + size :]
        case _:
            there = draw.randrange(len(content) + 1)
            return content[:at] + content[there : there + size] + content[at + size :]


@cache
def _messages() -> tuple[Message, ...]:
    return tuple(m for m in run() if m[1] < EPOCH + LASTS)


def _stamp(message: Any) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def _stamped(message: Any, stamp: int, frame: str | None = None) -> Any:
    """A message with another stamp, and another frame if one is given."""
    head = header(stamp, message.header.frame_id if frame is None else frame)
    fields = {name: getattr(message, name) for name in vars(message) if name not in ("header", "__msgtype__")}
    return make(message.__msgtype__, header=head, **fields)


def _changed(message: Any, draw: random.Random) -> Any:
    """A message with one number, name, length, stamp or frame changed."""
    kind = draw.randrange(4)
    if kind == 0:
        late = int(draw.choice([-1, 1]) * 10 ** draw.uniform(3, 12))
        return _stamped(message, draw.choice([draw.choice(STAMPS), max(0, _stamp(message) + late)]))
    if kind == 1:
        return _stamped(message, _stamp(message), draw.choice(WORDS))
    if message.__msgtype__.endswith("WrenchStamped"):
        part = draw.choice(["force", "torque"])
        vector = getattr(message.wrench, part)
        numbers = {axis: getattr(vector, axis) for axis in "xyz"} | {draw.choice("xyz"): draw.choice(NUMBERS)}
        vectors = {name: getattr(message.wrench, name) for name in ("force", "torque")}
        vectors[part] = make("geometry_msgs/msg/Vector3", **numbers)
        return make(message.__msgtype__, header=message.header, wrench=make("geometry_msgs/msg/Wrench", **vectors))
    names, positions = list(message.name), list(message.position)
    k = draw.randrange(len(names))
    match draw.randrange(5):
        case 0:
            positions[k] = draw.choice(NUMBERS)
        case 1:
            del names[k]
        case 2:
            del positions[k]
        case 3:
            names[k] = draw.choice([*WORDS, *names])
        case _:
            names, positions = draw.choice([([], []), (names * 2, positions * 2), (names, [])])
    return state(_stamp(message), names, positions)


def _messages_damaged(messages: Sequence[Message], draw: random.Random) -> list[Message]:
    """Some messages lost, doubled, exchanged, changed, late, or on another topic."""
    found = list(messages)
    share = draw.choice([0.01, 0.05, 0.5, 1.0])
    chosen = {k for k in range(len(found)) if draw.random() < share} or {draw.randrange(len(found))}
    topic = draw.choice([JOINTS, WRENCH, "/other", None])  # None: any
    chosen = {k for k in chosen if topic is None or found[k][0] == topic} or {draw.randrange(len(found))}
    match draw.randrange(6):
        case 0:
            return [m for k, m in enumerate(found) if k not in chosen]
        case 1:
            return found + [found[k] for k in chosen]
        case 2:
            order = sorted(chosen)
            draw.shuffle(order)
            for k, other in zip(sorted(chosen), order, strict=True):
                found[k] = (found[k][0], messages[other][1], found[k][2])
            return found
        case 3:
            return [(t + draw.choice(["", "_2", "/é"]) if k in chosen else t, r, m)
                    for k, (t, r, m) in enumerate(found)]  # fmt: skip
        case 4:
            odd = draw.choice([0, 1, EPOCH, 2**62])
            return [(t, odd if k in chosen else r, m) for k, (t, r, m) in enumerate(found)]
        case _:
            same = random.Random(draw.random())
            one = same.getstate()
            for k in chosen:
                if draw.random() < 0.5:
                    same.setstate(one)  # the same change in many messages
                found[k] = (*found[k][:2], _changed(found[k][2], same))
            return found


def tally_of_bags(seeds: range, folder: Path) -> Tally:
    """Damaged bags of ROS 2, of messages that are odd or of files that are."""

    def one(seed: int, tally: Tally) -> None:
        draw, bag = random.Random(seed), folder / "bag"
        shutil.rmtree(bag, ignore_errors=True)
        messages: list[Message] = list(_messages())
        for _ in range(draw.choice([0, 1, 1, 2, 3])):
            messages = _messages_damaged(messages, draw) if messages else messages
        stored = draw.choice(list(StoragePlugin))
        write(bag, messages, stored)
        file = bag
        for part in sorted(bag.iterdir()):
            if draw.random() < 0.25:
                part.write_bytes(_bytes_damaged(part.read_bytes(), draw))
            if draw.random() < 0.02:
                part.unlink()
            elif part.suffix != ".yaml" and draw.random() < 0.2:
                file = part
        for tried in (as_stated, as_proposed):
            tried(file, ROBOT, stored.name, seed, tally, place=bag)

    return tallied("bags", seeds, one)


def _column(values: np.ndarray, draw: random.Random) -> Any:
    """A column of another type, or with values that are none."""
    count = len(values)
    kinds: tuple[Callable[[], Any], ...] = (
        lambda: pa.array(values.astype(draw.choice(["float32", "float16", "int8", "int64", "uint16", "bool"]))),
        lambda: pa.array([None if draw.random() < 0.3 else float(v) for v in values], pa.float64()),
        lambda: pa.array([draw.choice(NUMBERS) if draw.random() < 0.1 else float(v) for v in values]),
        lambda: pa.nulls(count, draw.choice([pa.null(), pa.float64(), pa.string()])),
        lambda: pa.array([str(v) if draw.random() < 0.9 else draw.choice(WORDS) for v in values]),
        lambda: pa.array([Decimal(f"{v:.3f}") for v in values], pa.decimal128(18, 3)),
        lambda: pa.array((1e9 * values).astype("int64"), pa.int64()).cast(
            pa.timestamp("ns", tz=draw.choice([None, "UTC", "Europe/Berlin"]))
        ),
        lambda: pa.array((1e6 * values).astype("int64"), pa.int64()).cast(pa.duration("us")),
        lambda: pa.array([date(2024, 3, 5) + timedelta(days=int(min(abs(v), 1e5))) for v in values]),
        lambda: pa.array([[float(v)] * draw.randrange(3) for v in values]),
        lambda: pa.array([{"a": float(v)} for v in values]),
        lambda: pa.array([str(v) for v in values]).dictionary_encode(),
        lambda: pa.array([str(v).encode() for v in values], pa.binary()),
        lambda: pa.array(values[:: draw.choice([-1, 1])] * 10.0 ** draw.randint(-9, 9)),
    )
    with np.errstate(all="ignore"):
        return draw.choice(kinds)()


def _table(draw: random.Random) -> Any:
    """A run as a table whose columns are changed, renamed, doubled, exchanged or left out."""
    numbers = Truth().numbers()[: draw.choice([0, 1, 2, 12, None, None, None])]
    columns: list[tuple[str, Any]] = [(name, pa.array(numbers[:, k])) for k, name in enumerate(NAMES)]
    for _ in range(draw.choice([0, 1, 1, 2, 4])):
        k = draw.randrange(len(columns))
        name, values = columns[k]
        match draw.randrange(6):
            case 0:
                del columns[k]
            case 1:
                columns.insert(draw.randrange(len(columns) + 1), (draw.choice([name, *WORDS]), values))
            case 2:
                columns[k] = (draw.choice([*WORDS, *NAMES, name.upper(), name.replace("_", " [") + "]"]), values)
            case _:
                columns[k] = (name, _column(numbers[:, NAMES.index(name) if name in NAMES else 0], draw))
    return pa.Table.from_arrays([values for _, values in columns], names=[name for name, _ in columns])


def tally_of_parquet(seeds: range, folder: Path) -> Tally:
    """Damaged Parquet files: columns that are odd, or bytes."""
    file = folder / "run.parquet"

    def one(seed: int, tally: Tally) -> None:
        draw = random.Random(seed)
        table = _table(draw)
        groups = draw.choice([None, 1, 3])
        pq.write_table(table, file, row_group_size=groups, compression=draw.choice(["none", "snappy", "zstd", "gzip"]))
        for _ in range(draw.choice([0, 0, 1, 3])):
            file.write_bytes(_bytes_damaged(file.read_bytes(), draw))
        for tried in (as_stated, as_proposed):
            tried(file, HEXAPOD, "Parquet", seed, tally)

    return tallied("Parquet files", seeds, one)
