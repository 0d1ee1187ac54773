"""Topics of a bag: what each carries, how often, in which frames, and the channels of those that hexcite reads."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cases.base.units import Array
from identification.recording.formats.ros.bags import AXES, KINDS, Topic, opened

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

_NANOSECOND = 1e-9


@dataclass(frozen=True, slots=True)
class BagTopic:
    """A topic of a bag."""

    name: str
    kind: str  # type of its messages
    messages: int
    what: Topic | None = None  # `joints` or `wrench`; None: hexcite does not read it
    frames: tuple[str, ...] = ()  # frame_id of its messages, the most frequent first
    channels: tuple[str, ...] = ()  # joints, or axes
    t: Array | None = (
        None  # by the stamps in the headers, shape (n,) [s]; since the bag's first message where they have none
    )
    values: Array | None = None  # shape (n, k) [rad, m, N or N m]; NaN where a message lacks a joint
    stamped: bool = True  # whether its headers have stamps

    @property
    def rate(self) -> float | None:
        """Messages per second; None where it cannot be said."""
        if self.t is None or len(self.t) < 2:
            return None
        step = float(np.median(np.diff(np.sort(self.t))))
        return 1.0 / step if step > 0.0 else None

    def to_json(self) -> dict[str, Any]:
        """The topic without its values, for programs."""
        return {
            "name": self.name, "type": self.kind, "messages": self.messages, "rate_Hz": self.rate,
            "read_as": self.what, "frames": list(self.frames), "channels": list(self.channels),
        }  # fmt: skip

    def __str__(self) -> str:
        """One line."""
        parts = [f"{self.messages} messages" + ("" if self.rate is None else f", {self.rate:.4g} a second")]
        parts += [f"frame_id {', '.join(map(repr, self.frames))}"] if self.frames else []
        parts += [", ".join(self.channels)] if self.channels else []
        return f"{self.name} ({self.kind.rpartition('/')[2]}): {'; '.join(parts)}"


def bag_topics(bags: Sequence[Path]) -> tuple[BagTopic, ...]:
    """All topics of bags of one run, those that hexcite reads first; raises RecordingError where one cannot be read."""
    with opened(bags) as (reader, _):
        counts: Counter[tuple[str, str]] = Counter()
        for connection in reader.connections:
            counts[connection.topic, connection.msgtype] += connection.msgcount
        topics = [_topic(reader, name, kind, count) for (name, kind), count in sorted(counts.items())]
    return tuple(sorted(topics, key=lambda topic: (topic.what is None, topic.name)))


def _topic(reader: "AnyReader", name: str, kind: str, count: int) -> BagTopic:
    what = next((what for what, of in KINDS.items() if of == kind), None)
    if what is None or not count:
        return BagTopic(name, kind, count, what)
    frames: Counter[str] = Counter()
    channels: dict[str, None] = {}
    rows, stamps, received = list[dict[str, float]](), list[int](), list[int]()
    for at, message in _messages(reader, name, kind):
        frames[message.header.frame_id] += 1
        stamps.append(int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec))
        received.append(at)
        row = dict(_channels(what, message))
        rows.append(row)
        channels |= dict.fromkeys(row)
    if not rows:  # its index counts some that are not there
        return BagTopic(name, kind, 0, what)
    stamped = len({*stamps}) > 1 or len(stamps) == 1
    times = np.array(stamps if stamped else received, dtype=np.int64)
    values = np.array([[row.get(channel, np.nan) for channel in channels] for row in rows])
    return BagTopic(
        name, kind, count, what, tuple(frame for frame, _ in frames.most_common() if frame), tuple(channels),
        (times - times[0]) * _NANOSECOND, values, stamped,
    )  # fmt: skip


def _messages(reader: "AnyReader", topic: str, kind: str) -> Iterator[tuple[int, Any]]:
    """Times of receipt [ns], and messages."""
    connections = [c for c in reader.connections if c.topic == topic and c.msgtype == kind]
    for connection, at, raw in reader.messages(connections=connections):
        yield at, reader.deserialize(raw, connection.msgtype)


def _channels(what: Topic, message: Any) -> Iterator[tuple[str, float]]:
    """Names and values of the channels in a message."""
    if what == "joints":
        names: Sequence[str] = message.name
        yield from zip(map(str, names), map(float, message.position), strict=False)
        return
    vectors = message.wrench.force, message.wrench.torque
    yield from zip(AXES, (float(getattr(v, axis)) for v in vectors for axis in "xyz"), strict=True)
