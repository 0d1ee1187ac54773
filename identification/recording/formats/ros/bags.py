"""Bags of ROS 2 and ROS 1: files that hold numbers as numbers.

A bag has positions of joints and readings of a force/torque sensor in two topics, each with a clock of its own:
`sensor_msgs/JointState` and `geometry_msgs/WrenchStamped`, in SI units (REP 103), by the stamps in their headers. A
host gives these, so that they jitter: samples are taken to be at equal steps, on the straight line through the stamps.
Joints go by name, for their order differs between messages; messages of other joints on the topic are skipped.
"""

import struct
from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from cases.base.errors import Code, RecordingError
from cases.base.phrases import phrase
from cases.recording_format import CLOCK, WRENCH, Clock, FileFormat
from cases.schema import Case
from identification.finding import Finding
from identification.recording.formats.ros.frames import require_frame
from identification.recording.formats.ros.reindexed import SUFFIXES, readable
from identification.recording.formats.table import ColumnTable, Lines, listed, shown

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

STAMP = "header.stamp"
AXES = tuple(f"{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz")
Topic = Literal["joints", "wrench"]
KINDS: dict[Topic, str] = {
    "joints": "sensor_msgs/msg/JointState",
    "wrench": "geometry_msgs/msg/WrenchStamped",
}


def bag_format(bags: Sequence[Path], form: FileFormat, case: Case) -> FileFormat:
    """What columns of bags of a run are called: joints as in the case, unless `columns` of the form has other names.

    Names that are those of another file, such as a table of the same robot, are not the bag's: where it has the joints
    of the case instead, neither these names nor units and scales beside them count.
    """
    joints = {} if case.chain is None else dict(zip(case.chain.columns, case.chain.names, strict=True))
    stated = {ours: form.columns[ours] for ours in joints if ours in form.columns}
    if stated and _has_joints(bags, form, stated.values(), joints.values()):
        stated, form = {}, form.model_copy(update={"units": {}, "scale": {}, "offset": {}})
    columns = joints | stated | dict(zip(WRENCH, AXES, strict=True)) | {CLOCK: STAMP}
    units = {"joints": "rad", "drives": "m"} | form.units
    clock = Clock(unit="ns", offset_s=form.clock.offset_s)
    return form.model_copy(update={"format": "csv", "columns": columns, "units": units, "clock": clock})


_FIRST = 200  # messages that show which joints a topic has


def _has_joints(bags: Sequence[Path], form: FileFormat, stated: Iterable[str], own: Iterable[str]) -> bool:
    """Whether bags have all joints by their own names, and not those that are stated."""
    try:
        with opened(bags) as (reader, _):
            topic = topic_of(place_of(bags), reader, "joints", form.ros.get("joints"))
            names = {str(name) for _, message in islice(_messages(reader, topic), _FIRST) for name in message.name}
    except RecordingError:
        return False  # whoever reads it says what is wrong
    return names.issuperset(own) and not names.issuperset(stated)


def bag_tables(bags: Sequence[Path], form: FileFormat) -> Iterator[ColumnTable]:
    """Reads bags of one run in the format of `bag_format`: a table of each topic; raises RecordingError.

    A recorder that splits its bag continues a topic in the next one; two recorders have a topic each.
    """
    bag = place_of(bags)
    with opened(bags) as (reader, findings):
        joints, wrench = (topic_of(bag, reader, what, form.ros.get(what)) for what in KINDS)
        for topic in (joints, wrench):
            _require_one_run(reader, bags, topic)
        theirs = [form.file_name(ours) for ours in form.columns if ours not in (*WRENCH, CLOCK)]
        received = form.ros.get("time") == "receipt"
        positions = _positions(reader, joints, theirs, received)
        if (table := _table(f"{bag}, {joints}", theirs, positions, form)) is None:
            raise RecordingError(
                place=f"{bag}, {joints}",
                problem=f"no message has all of {listed(theirs)}; its joints are {listed(joint_names(reader, joints))}",
                remedy="map their names in [recording.columns] of the case, such as q1_deg",
                code=Code.MISSING,
            )
        yield replace(table, findings=findings)
        if (table := _table(f"{bag}, {wrench}", AXES, _readings(bag, reader, wrench, form), form)) is None:
            problem = "holds none of the messages that the bag's index counts"
            raise RecordingError(
                place=f"{bag}, {wrench}",
                problem=problem,
                remedy=_copy_or_reindex(bags),
                code=Code.DAMAGED,
            )
        yield table


_SPLIT = (-0.1, 1.0)  # least and most time from the end of a bag to the next one of a recorder that splits it [s]


def _require_one_run(reader: "AnyReader", bags: Sequence[Path], topic: str) -> None:
    """Raises RecordingError where bags with the same topic do not continue each other, as those of two runs."""
    parts: list[tuple[int, int, str]] = []
    names = iter(bags)
    for part in reader.readers:  # in the order of the bags
        bag = next(names)
        if any(connection.topic == topic and connection.msgcount for connection in part.connections):
            parts.append((part.start_time, part.end_time, str(bag)))
    parts.sort()
    for (_, ends, first), (begins, _, second) in pairwise(parts):
        gap = 1e-9 * (begins - ends)
        if _SPLIT[0] <= gap <= _SPLIT[1]:
            continue
        when = f"begins {gap:.3g} s after {first} ends" if gap > 0.0 else f"was recorded while {first} was"
        raise RecordingError(
            place=f"{second}, {topic}",
            problem=f"{when}, with the same topic: these are not parts of one run",
            remedy="give the bags of one run, each once",
            code=Code.CONTRADICTION,
        )


def place_of(bags: Sequence[Path]) -> str:
    """How messages name bags of one run."""
    return ", ".join(map(str, bags))


def _copy_or_reindex(bags: Sequence[Path]) -> str:
    """The remedy for bags that are damaged, by the tool of the ROS that wrote them."""
    if all(bag.suffix.lower() in SUFFIXES for bag in bags):
        return phrase("copy_or_reindex_ros1", "copy it again, or run rosbag reindex")
    if all(bag.suffix.lower() == ".mcap" for bag in bags):
        return phrase("copy_or_recover", "copy it again, or run mcap recover FILE -o WHOLE.mcap")
    return phrase("copy_or_reindex", "copy it again, or run ros2 bag reindex")


class Opened(NamedTuple):
    """Bags of one run, read as one."""

    reader: "AnyReader"
    findings: tuple[Finding, ...]  # what was missing in them


@contextmanager
def opened(bags: Sequence[Path]) -> Iterator[Opened]:
    """The bags of one run, whose damages become one line each."""
    bag = place_of(bags)
    try:
        import apsw  # by which rosbags reads SQLite
        from rosbags import rosbag1, rosbag2
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.serde import SerdeError
        from rosbags.typesys import Stores, TypesysError, get_typestore
    except ModuleNotFoundError:
        raise RecordingError(
            place=bag,
            problem=phrase("rosbags_needed", "is a ROS bag, which rosbags reads"),
            remedy=phrase("install_ros", "pip install 'hexcite[ros]'"),
            code=Code.NOT_INSTALLED,
        ) from None
    import sqlite3

    damaged = (AnyReaderError, OSError, EOFError, ValueError, LookupError, AttributeError, TypeError, AssertionError)
    inside = (rosbag1.ReaderError, rosbag1.WriterError, rosbag2.ReaderError, SerdeError, TypesysError, apsw.Error)
    try:
        with TemporaryDirectory() as folder:
            readables = [readable(bag, Path(folder)) for bag in bags]
            files = [each.file for each in readables]
            with AnyReader(files, default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
                yield Opened(reader, tuple(finding for each in readables for finding in each.findings))
    except (*damaged, *inside, ArithmeticError, MemoryError, struct.error, sqlite3.Error) as error:
        if isinstance(error, RecordingError):
            raise
        reason = shown(" ".join(str(error).split()) or type(error).__name__, 120)
        raise RecordingError(
            place=bag,
            problem=phrase("bag_damaged", "is a damaged bag ({reason})", reason=reason),
            remedy=_copy_or_reindex(bags),
            code=Code.DAMAGED,
        ) from error


def topics_of(reader: "AnyReader", what: Topic) -> list[str]:
    """Topics that carry such messages, `joints` or `wrench`."""
    return sorted({c.topic for c in reader.connections if c.msgtype == KINDS[what] and c.msgcount})


def topic_of(bag: str, reader: "AnyReader", what: Topic, stated: str | None) -> str:
    """The topic that is stated, or the only one of its kind; raises RecordingError where there are none or several."""
    possible = topics_of(reader, what)
    if stated in possible or (stated is None and len(possible) == 1):
        return stated or possible[0]
    kind = KINDS[what].rpartition("/")[2]
    if not reader.connections:
        raise RecordingError(
            place=bag,
            problem=phrase("empty_bag", "holds no message"),
            remedy=phrase("record_again", "record again"),
            code=Code.TOO_FEW,
        )
    if not possible:
        every = listed(sorted({f"{c.topic} ({c.msgtype.rpartition('/')[2]})" for c in reader.connections}))
        raise RecordingError(
            place=bag,
            problem=phrase("no_messages", "has no messages {kind}; its topics are {topics}", kind=kind, topics=every),
            remedy=phrase("record_topic", "record such a topic too"),
            code=Code.MISSING,
        )
    reason = f"has no topic {stated} of {kind}" if stated else f"has several topics of {kind}: {listed(possible)}"
    raise RecordingError(
        place=bag,
        problem=reason,
        remedy=f'set recording.ros.{what} = "{shown(possible[0])}" in the case',
        code=Code.CONTRADICTION,
    )


def _positions(
    reader: "AnyReader", topic: str, joints: Sequence[str], received: bool
) -> Iterator[tuple[int, list[float]]]:
    """Stamps [ns], and positions of some joints [rad or m], of messages that have all of them."""
    for stamp, message in _messages(reader, topic, received):
        place = {name: k for k, name in enumerate(message.name) if k < len(message.position)}
        if joints and all(joint in place for joint in joints):
            yield stamp, [message.position[place[joint]] for joint in joints]


def _readings(bag: str, reader: "AnyReader", topic: str, form: FileFormat) -> Iterator[tuple[int, list[float]]]:
    """Stamps [ns], and forces and moments [N, N m]; raises RecordingError where their frame changes or is not the
    sensor's.
    """
    frame = None
    for stamp, message in _messages(reader, topic, form.ros.get("time") == "receipt"):
        if frame is None:
            require_frame(f"{bag}, {topic}", message.header.frame_id, form)
        if (frame := frame or message.header.frame_id) != message.header.frame_id:
            names = f"{frame}, {message.header.frame_id}"
            raise RecordingError(
                place=f"{bag}, {topic}",
                problem=f"is in several frames: {names}",
                remedy="record the sensor's own topic",
                code=Code.CONTRADICTION,
            )
        vectors = message.wrench.force, message.wrench.torque
        yield stamp, [getattr(vector, axis) for vector in vectors for axis in "xyz"]


def joint_names(reader: "AnyReader", topic: str) -> tuple[str, ...]:
    """The joints of the message of a topic that has most."""
    return max((tuple(map(str, message.name)) for _, message in _messages(reader, topic)), key=len, default=())


def _messages(reader: "AnyReader", topic: str, received: bool = False) -> Iterator[tuple[int, Any]]:
    """Stamps in the headers, or of receipt [ns], and messages."""
    connections = [c for c in reader.connections if c.topic == topic]
    for connection, receipt, raw in reader.messages(connections=connections):
        message: Any = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        yield receipt if received else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec), message


def _table(
    source: str, names: Sequence[str], samples: Iterator[tuple[int, list[float]]], form: FileFormat
) -> ColumnTable | None:
    """The samples in the order of their stamps. None: there are none."""
    at, numbers = array("q"), array("d")
    for stamp, values in samples:
        at.append(stamp)
        numbers.extend(values)
    if not at:
        return None
    order = np.argsort(at, kind="stable")
    stamps, rows = np.array(at)[order], np.array(numbers).reshape(-1, len(names))[order]
    if len(stamps) > 1 and len(np.unique(stamps)) < len(stamps) / 2:
        problem = "its headers have no stamps of use: most of them are alike"
        remedy = 'take the time of receipt: state recording.ros.time = "receipt" in the case'
        raise RecordingError(place=source, problem=problem, remedy=remedy, code=Code.WRONG_KIND)
    ours, lines = {form.file_name(column): column for column in form.columns}, Lines(1, word="message")
    columns = {ours[name]: np.ascontiguousarray(rows[:, k]) for k, name in enumerate(names)}
    return ColumnTable(source, form, (STAMP, *names), columns, stamps, form.tick, lines, True)
