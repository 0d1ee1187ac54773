"""Bags of ROS 2 and ROS 1, written by rosbags: topics with clocks of their own, jitter, losses, joints in any order."""

import sqlite3
import sys
from collections.abc import Sequence
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import apsw
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import ReaderError, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import hexcite as hx
from cases.base.errors import RecordingError
from cases.schema import Case
from identification.identify import identify
from identification.looks.looking import look
from identification.recording.recording import read
from tests.chains import ROBOT, swing, swung_forces
from tests.helpers import answer, examples, one_line, refused_at
from tests.hexcite.command_line import call

TYPES, OLD_TYPES = get_typestore(Stores.ROS2_HUMBLE), get_typestore(Stores.ROS1_NOETIC)
EPOCH = 1_700_000_000 * 10**9
JOINTS, WRENCH = "/joint_states", "/ft/wrench_raw"
NAMES = tuple(joint.name for joint in ROBOT.chain.joints)


def make(kind: str, **fields: Any) -> Any:
    return TYPES.types[kind](**fields)


def header(stamp: int, frame: str = "ft_sensor") -> Any:
    time = make("builtin_interfaces/msg/Time", sec=int(stamp // 10**9), nanosec=int(stamp % 10**9))
    return make("std_msgs/msg/Header", stamp=time, frame_id=frame)


def state(stamp: int, names: Sequence[str], positions: Sequence[float]) -> Any:
    none = np.zeros(0)
    values = {"position": np.array(positions, dtype=float), "velocity": none, "effort": none}
    return make("sensor_msgs/msg/JointState", header=header(stamp, ""), name=list(names), **values)


def wrench(stamp: int, values: Sequence[float], frame: str = "ft_sensor") -> Any:
    force, torque = (make("geometry_msgs/msg/Vector3", **dict(zip("xyz", map(float, v), strict=True)))
                     for v in (values[:3], values[3:]))  # fmt: skip
    return make("geometry_msgs/msg/WrenchStamped", header=header(stamp, frame), wrench=make(
        "geometry_msgs/msg/Wrench", force=force, torque=torque))  # fmt: skip


def write(bag: Path, messages: Sequence[tuple[str, int, Any]], stored: StoragePlugin = StoragePlugin.SQLITE3) -> Path:
    """A bag of messages of some topics: topic, time of receipt [ns], message."""
    with Writer(bag, version=9, storage_plugin=stored) as writer:
        topics = {}
        for topic, received, message in sorted(messages, key=lambda m: m[1]):
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(topics[topic], received, TYPES.serialize_cdr(message, kind))
    return bag


def as_old(message: Any) -> Any:
    """A message of ROS 2 as one of ROS 1, whose headers count."""
    if not hasattr(message, "__msgtype__"):
        return message
    fields = {name: as_old(getattr(message, name)) for name in vars(message) if name != "__msgtype__"}
    extra = {"seq": 0} if message.__msgtype__ == "std_msgs/msg/Header" else {}
    return OLD_TYPES.types[message.__msgtype__](**fields, **extra)


def write_old(
    file: Path, messages: Sequence[tuple[str, int, Any]], packed: Writer1.CompressionFormat | None = None
) -> Path:
    """The bag of ROS 1 of the same messages."""
    writer = Writer1(file)
    if packed is not None:
        writer.set_compression(packed)
    with writer:
        topics = {}
        for topic, received, message in sorted(messages, key=lambda m: m[1]):
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, kind, typestore=OLD_TYPES)
            writer.write(topics[topic], received, OLD_TYPES.serialize_ros1(as_old(message), kind))
    return file


@cache
def run(
    jitter: float = 3e-4, lost: float = 0.01, seed: int = 0, more_kg: float = 0.0
) -> tuple[tuple[str, int, Any], ...]:
    """Joints at 250 a second with late stamps and losses, in changing order, a gripper's between; forces at 1000."""
    draw = np.random.default_rng(seed)
    messages: list[tuple[str, int, Any]] = []
    for k, (now, q) in enumerate(zip(at := np.arange(0.0, 8.0, 0.004), swing(at)[0], strict=True)):
        stamp = EPOCH + int(1e9 * (now + jitter * draw.exponential()))
        order = draw.permutation(6)
        if draw.random() >= lost:
            names = [NAMES[i] for i in order]
            messages.append((JOINTS, stamp + 100_000, state(stamp, names, q[order])))
        if k % 10 == 0:
            messages.append((JOINTS, stamp + 150_000, state(stamp, ["finger"], [0.01])))
    read_at = np.arange(-0.2, 8.3, 1e-3) + 0.0002
    forces = swung_forces(read_at, more_kg) + draw.normal(size=(len(read_at), 6)) * ([0.3] * 3 + [0.01] * 3)
    for now, values in zip(read_at, forces, strict=True):
        stamp = EPOCH + int(1e9 * now)
        messages.append((WRENCH, stamp + 200_000, wrench(stamp, values)))
    return tuple(messages)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("run") / "bag", run())


@pytest.mark.first(1)
@pytest.mark.parametrize("stored", StoragePlugin)
def test_a_bag_of_a_robot_is_identified(stored: StoragePlugin, tmp_path: Path) -> None:
    """Two clocks, stamps up to milliseconds late, lost messages: deviations hold all the same."""
    recording = read(write(tmp_path / "bag", run(), stored), ROBOT)
    assert recording.others[0].drives is not None
    result = identify(recording, ROBOT)
    truth = ROBOT.need_simulation("a test").parameters
    for name, true in (("m", truth.body.mass_kg), ("zC", 0.086), ("xC", 0.004), ("f_q0_1", 3.2), ("f_q0_6", 0.12)):
        found = result[name]
        assert abs(found.value - true) < 4.0 * found.reported, name
    assert result["m"].reported < 0.005


def test_both_clocks_run_evenly_and_lost_messages_are_missing(tmp_path: Path) -> None:
    recording = read(write(tmp_path / "bag", run(lost=0.02)), ROBOT)
    (joints,) = recording.others
    assert np.diff(recording.t) == pytest.approx(1e-3, abs=1e-6)
    assert np.diff(joints.t) == pytest.approx(4e-3, abs=1e-5)
    assert 20 < joints.missing.sum() < 60
    assert recording.drives is None
    assert recording.motion is joints  # with its own times
    drawn = [axes.get_xlim() for axes in hx.plot(recording).axes]
    assert drawn[0] == pytest.approx((joints.t[0], joints.t[-1]), abs=0.5)
    there = ~joints.missing
    assert there[0]
    np.testing.assert_allclose(joints.drives[there], swing(0.004 * np.arange(len(there)))[0][there], atol=1e-12)


REFUSED = {
    "no wrench": (
        lambda: [m for m in run() if m[0] != WRENCH],
        r"no messages WrenchStamped; its topics are /joint_sta",
    ),
    "two wrenches": (
        lambda: [*run(), ("/ft/filtered", EPOCH, wrench(EPOCH, [0.0] * 6))],
        r'several topics of WrenchStamped: /ft/filtered, /ft/wrench_raw; set recording.ros.wrench = "/ft/filtered"',
    ),
    "a joint": (
        lambda: [(t, r, m) for t, r, m in run() if t == WRENCH or m.name == ["finger"]],
        r"/joint_states: no message has all of base, .*; its joints are finger; map .*recording.columns",
    ),
    "frames": (
        lambda: [*run(), (WRENCH, EPOCH, wrench(EPOCH, [0.0] * 6, "tool"))],
        r"in several frames: ft_sensor, to",
    ),
    "no stamps": (
        lambda: [(t, r, m if t == WRENCH else state(0, m.name, m.position)) for t, r, m in run(lost=0.0)],
        r"headers have no stamps",
    ),
}


@pytest.mark.first(2)
@pytest.mark.parametrize("what", REFUSED)
def test_a_bag_that_cannot_be_used_is_named_with_its_topic(what: str, tmp_path: Path) -> None:
    messages, reason = REFUSED[what]
    bag = write(tmp_path / "bag", messages())
    with refused_at(bag, reason):
        read(bag, ROBOT)


def without_time() -> list[tuple[str, int, Any]]:
    """The run of a driver that leaves the stamps of its wrenches at 1 s."""
    return [
        (t, r, m if t == JOINTS else make(m.__msgtype__, header=header(10**9), wrench=m.wrench)) for t, r, m in run()
    ]


def test_headers_without_time_are_named_and_the_time_of_receipt_is_taken_where_it_is_stated(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", without_time())
    with pytest.raises(RecordingError, match=r'no stamps of use.*recording\.ros\.time = "receipt"') as caught:
        read(bag, ROBOT)
    one_line(caught.value)
    recording = read(bag, with_recording(ros={"time": "receipt"}))
    assert recording.step == pytest.approx(1e-3, rel=1e-4)


def test_a_wrench_in_a_frame_that_stands_is_named_and_read_only_where_the_case_says_so(tmp_path: Path) -> None:
    def renamed(message: Any) -> Any:
        stamp = message.header.stamp
        return make(
            message.__msgtype__, header=header(stamp.sec * 10**9 + stamp.nanosec, "base"), wrench=message.wrench
        )

    messages = [(t, r, m if t == JOINTS else renamed(m)) for t, r, m in run()]
    bag = write(tmp_path / "bag", messages)
    with pytest.raises(RecordingError, match=r'in the frame base.*axes of the sensor.*ros\.frame = "base"') as caught:
        read(bag, ROBOT)
    one_line(caught.value)
    assert read(bag, with_recording(ros={"frame": "base"})).rows == 8500


def test_a_wrench_in_another_frame_than_the_stated_one_is_named_with_both(bag: Path) -> None:
    """The wrenches of the bag are in `ft_sensor`."""
    other = with_recording(ros={"frame": "tool0"})
    with pytest.raises(RecordingError, match=r"frame ft_sensor; that of the sensor is tool0") as caught:
        read(bag, other)
    assert one_line(caught.value).startswith(f"{bag}, {WRENCH}")
    assert any("ft_sensor" in odd and "tool0" in odd for odd in look(bag, other).odd)
    assert read(bag, with_recording(ros={"frame": "/ft_sensor"})).rows == read(bag, ROBOT).rows


def test_of_several_wrenches_look_proposes_the_one_in_the_stated_frame(tmp_path: Path) -> None:
    messages = [*run(), *(("/ft/raw", r, wrench(r, [0.0] * 6, "tool0")) for t, r, m in run() if t == WRENCH)]
    bag = write(tmp_path / "bag", messages)
    for frame, topic in (("ft_sensor", WRENCH), ("tool0", "/ft/raw")):
        assert look(bag, with_recording(ros={"frame": frame})).settings["ros"]["wrench"] == topic


def with_recording(**keys: Any) -> Case:
    data = ROBOT.model_dump(exclude_none=True)
    data["recording"] |= keys
    return Case.model_validate(data)


def test_topics_and_names_are_those_of_the_case(tmp_path: Path) -> None:
    """A filtered topic beside the raw one, and joints under the driver's names."""
    said = {name: f"{name}_joint" for name in NAMES}
    messages = [
        (t, r, m if t == WRENCH else state(m.header.stamp.sec * 10**9 + m.header.stamp.nanosec,
                                           [said.get(n, n) for n in m.name], m.position))
        for t, r, m in run()
    ]  # fmt: skip
    messages += [("/ft/filtered", r, m) for t, r, m in messages if t == WRENCH]
    bag = write(tmp_path / "bag", messages)
    columns = {f"q{k + 1}_deg": said[name] for k, name in enumerate(NAMES)}
    recording = read(bag, with_recording(columns=columns, ros={"wrench": WRENCH}))
    assert recording.source.endswith(WRENCH)
    found = look(bag, ROBOT)
    assert found.settings["columns"] == columns
    assert found.settings["ros"]["wrench"] == WRENCH  # its name says raw; the other is named too
    assert any("/ft/filtered" in odd for odd in found.odd)
    assert found.reads


def test_names_and_units_of_a_table_are_not_those_of_a_bag(bag: Path) -> None:
    """A case that look completed for a CSV of the same robot reads the bag, too."""
    columns = {f"q{k + 1}_deg": f"joint {k + 1}" for k in range(len(NAMES))}
    case = with_recording(columns=columns, units={"joints": "deg", "forces": "kN"})
    np.testing.assert_array_equal(read(bag, case).forces, read(bag, ROBOT).forces)
    np.testing.assert_array_equal(read(bag, case).others[0].drives, read(bag, ROBOT).others[0].drives)
    assert look(bag, case).reads


def test_look_shows_topics_with_rates_frames_and_channels(bag: Path, tmp_path: Path) -> None:
    answer = call("look", bag, "--case", "ur10_wrist", "-o", tmp_path / "look.svg", "--json").json()
    assert answer["reads"]
    topics = {topic["name"]: topic for topic in answer["topics"]}
    assert topics["/joint_states"]["read_as"] == "joints"
    assert set(topics["/joint_states"]["channels"]) >= set(NAMES)
    assert topics[WRENCH]["frames"] == ["ft_sensor"]
    assert topics[WRENCH]["rate_Hz"] == pytest.approx(1000.0, rel=1e-3)
    assert {c["meaning"] for c in answer["columns"]} >= {"q1_deg", "fx_N", "mz_Nm"}
    assert Path(answer["picture"]).read_text().lstrip().startswith("<?xml")
    assert "name the robot" in " ".join(look(bag).odd)  # nobody knows the order of the joints


def test_the_file_in_the_folder_is_the_bag(bag: Path) -> None:
    (file,) = bag.glob("*.db3")
    np.testing.assert_array_equal(read(file, ROBOT).forces, read(bag, ROBOT).forces)


@pytest.mark.first(1)
@pytest.mark.parametrize("stored", StoragePlugin)
def test_a_bag_whose_metadata_is_missing_is_read_from_its_file(stored: StoragePlugin, tmp_path: Path) -> None:
    """A recorder that is stopped hard leaves the messages and no metadata.yaml."""
    bag = write(tmp_path / "bag", run(), stored)
    whole = read(bag, ROBOT)
    (bag / "metadata.yaml").unlink()
    (file,) = bag.iterdir()
    for path in (bag, file):
        np.testing.assert_array_equal(read(path, ROBOT).forces, whole.forces)
        assert look(path, ROBOT).reads


@pytest.mark.first(2)
@pytest.mark.parametrize("packed", [None, *Writer1.CompressionFormat])
def test_a_bag_of_ros_1_is_read(packed: Writer1.CompressionFormat | None, tmp_path: Path) -> None:
    short = [m for m in run() if m[1] < EPOCH + 2 * 10**9]
    bag, old = write(tmp_path / "bag", short), write_old(tmp_path / "run.bag", short, packed)
    for theirs, ours in zip(
        (one := read(old, ROBOT), *one.others), (two := read(bag, ROBOT), *two.others), strict=True
    ):
        np.testing.assert_array_equal(theirs.t, ours.t)
    np.testing.assert_array_equal(one.forces, two.forces)
    np.testing.assert_array_equal(one.others[0].drives, two.others[0].drives)
    found = look(old, ROBOT)
    assert found.problem is None
    assert {topic.name: topic.frames for topic in found.topics} == {JOINTS: (), WRENCH: ("ft_sensor",)}


SPLIT = EPOCH + 4 * 10**9


@pytest.mark.first(1)
@pytest.mark.parametrize("old", [True, False])
def test_bags_of_a_recorder_that_splits_them_are_one_run(old: bool, bag: Path, tmp_path: Path) -> None:
    """Also where a topic has a recorder of its own."""
    parts = {
        "split": ([m for m in run() if m[1] < SPLIT], [m for m in run() if m[1] >= SPLIT]),
        "alone": ([m for m in run() if m[0] == WRENCH], [m for m in run() if m[0] == JOINTS]),
    }
    whole = read(bag, ROBOT)
    for name, messages in parts.items():
        bags = [
            write_old(tmp_path / f"{name}_{k}.bag", part) if old else write(tmp_path / f"{name}_{k}", part)
            for k, part in enumerate(messages)
        ]
        recording = read(bags[::-1], ROBOT)
        np.testing.assert_array_equal(recording.forces, whole.forces)
        np.testing.assert_array_equal(recording.others[0].drives, whole.others[0].drives)
        assert recording.paths == tuple(bags[::-1])
        assert look(bags, ROBOT).reads


@pytest.mark.first(1)
@pytest.mark.parametrize("packed", [None, Writer1.CompressionFormat.BZ2])
def test_a_bag_that_was_cut_is_read_up_to_the_cut(packed: Writer1.CompressionFormat | None, tmp_path: Path) -> None:
    """Its header points to an index that is no longer there, or no longer whole."""
    whole = write_old(tmp_path / "run.bag", run(), packed)
    content, samples = whole.read_bytes(), len(read(whole, ROBOT).forces)
    index = content.index(b"index_pos=") + len("index_pos=")
    begins = int.from_bytes(content[index : index + 8], "little")
    cut = tmp_path / "cut.bag"
    for ends, least, most in ((len(content) - 30, 1.0, 1.0), (begins + 10, 1.0, 1.0), (begins * 7 // 10, 0.2, 0.9)):
        cut.write_bytes(content[:ends])
        found = read(cut, ROBOT)
        told = next(f.quantity["bag_without_index"] for f in found.findings if "bag_without_index" in f.quantity)
        assert told["cut"]
        assert least * samples <= len(found.forces) <= most * samples
        assert told["seconds"] == pytest.approx(len(found.forces) * found.step, abs=0.1)
    cut.write_bytes(content[: index + 200])
    with refused_at(cut, "is a damaged bag"):
        read(cut, ROBOT)


def test_bags_of_two_runs_are_not_one(tmp_path: Path) -> None:
    first = [m for m in run() if m[1] < EPOCH + 10**9]
    later = [(t, r + 60 * 10**9, m) for t, r, m in first]
    bags = [write_old(tmp_path / f"{k}.bag", messages) for k, messages in enumerate((first, later, first))]
    for other, words in ((bags[1], r"begins 5\d\.\d s after .*0\.bag ends"), (bags[2], "recorded while .*0.bag was")):
        with refused_at(other, words):
            read([bags[0], other], ROBOT)


@pytest.mark.first(1)
@pytest.mark.parametrize("packed", [None, Writer1.CompressionFormat.LZ4, Writer1.CompressionFormat.BZ2])
def test_a_bag_of_ros_1_without_index_is_read_record_by_record(
    packed: Writer1.CompressionFormat | None, tmp_path: Path
) -> None:
    """What is left of a recorder that was stopped hard: under the name it had meanwhile, cut within a record."""
    whole = write_old(tmp_path / "run.bag", run(), packed)
    content = whole.read_bytes()
    index = content.index(b"index_pos=") + len("index_pos=")
    begins = int.from_bytes(content[index : index + 8], "little")
    active = tmp_path / "run.bag.active"
    active.write_bytes(content[:index] + bytes(8) + content[index + 8 : begins + 20])
    (tmp_path / "RUN.BAG").write_bytes(content)
    for file, said in ((active, 1), (tmp_path / "RUN.BAG", 0)):
        found, looked = read(file, ROBOT), look(file, ROBOT)
        np.testing.assert_array_equal(found.forces, read(whole, ROBOT).forces)
        assert looked.problem is None
        told = [f.quantity["bag_without_index"] for f in found.findings if "bag_without_index" in f.quantity]
        assert len(told) == said
        assert sum("index is missing" in each for each in looked.repairs) == said
        assert all(each["cut"] for each in told)
    for damage in (content[:index] + bytes(8) + b"x" * 40, content[:30]):
        active.write_bytes(damage)
        with refused_at(active, "holds no message"):
            read(active, ROBOT)
    with refused_at(write_old(tmp_path / "none.bag", []), "holds no message"):
        read(tmp_path / "none.bag", ROBOT)


@pytest.mark.repeats
@pytest.mark.parametrize("commanded", [True, False])
def test_a_payload_of_two_bags_forces_and_a_tare(commanded: bool, tmp_path: Path) -> None:
    """Of ROS 1, by the command and by the library; what is compared are the masses that were carried."""
    empty, loaded = (write_old(tmp_path / f"{kg}.bag", run(seed=kg, more_kg=kg)) for kg in (0, 2))
    if commanded:
        m = call("payload", empty, loaded, "--case", "ur10_wrist", "--json").json()["parameters"]["m"]
        value, reported = m["value"], max(m["std"], m["std_robust"])
    else:
        m = hx.payload(hx.Recording.load(empty, ROBOT), hx.Recording.load(loaded, ROBOT))["m"]
        value, reported = m.value, m.reported
    assert abs(value - 2.0) < 4.0 * reported < 0.02
    if not commanded:
        return
    result, standing = tmp_path / "result", [m for m in run() if m[1] < EPOCH + 4 * 10**8]
    call("identify", loaded, "--case", "ur10_wrist", "-o", result)
    forces = call("force", empty, "--parameters", result, "-o", tmp_path / "force.csv", "--json").json()
    t = np.arange(-0.2, 8.3, 1e-3)
    missed = np.sqrt(np.mean((swung_forces(t, 2.0) - swung_forces(t)) ** 2, axis=0))
    np.testing.assert_allclose([*forces["rms"].values()], missed, rtol=0.1)  # at other instants
    still = write_old(tmp_path / "still.bag", standing)
    tared = call("tare", still, "--parameters", result, "-o", tmp_path / "tared", "--json").json()
    assert tared["tared_with"] == str(still)


def test_a_topic_whose_messages_are_lost_is_named_though_the_index_counts_them(tmp_path: Path) -> None:
    bag = write(tmp_path / "bag", [m for m in run() if m[1] < EPOCH + 10**8])
    with closing(sqlite3.connect(next(bag.glob("*.db3")))) as base:
        base.execute("delete from messages where topic_id in (select id from topics where name = ?)", (WRENCH,))
        base.commit()
    with refused_at(bag, f"{WRENCH}: holds none of the messages"):
        read(bag, ROBOT)
    assert not look(bag, ROBOT).reads


@pytest.mark.parametrize("error", [ReaderError("Chunk checksum mismatch."), apsw.CorruptError("malformed")])
def test_a_bag_that_is_damaged_inside_is_named_in_a_line(
    error: Exception, bag: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chunks have checksums, which rosbags checks where they are read, not where the bag is opened."""

    def damaged(*_: Any, **__: Any) -> Any:
        raise error

    monkeypatch.setattr("rosbags.highlevel.AnyReader.messages", damaged)
    for call_it in (lambda: read(bag, ROBOT), lambda: look(bag, ROBOT)):
        with refused_at(bag, rf"damaged bag \({error}"):
            call_it()


def test_without_rosbags_one_line_says_what_to_install(bag: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(RecordingError, match=r"pip install 'hexcite\[ros\]'"):
        read(bag, ROBOT)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[StoragePlugin, Path]:
    folder = tmp_path_factory.mktemp("bags")
    short = [m for m in run() if m[1] < EPOCH + 3 * 10**8]
    return {stored: write(folder / stored.name, short, stored) for stored in StoragePlugin}


@pytest.fixture(scope="module")
def whole_old(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    file = tmp_path_factory.mktemp("bags") / "run.bag"
    return write_old(file, [m for m in run() if m[1] < EPOCH + 3 * 10**8]).read_bytes()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(20))
@given(place=st.floats(0.0, 1.0), noise=st.binary(min_size=1, max_size=40), cut=st.booleans())
def test_a_damaged_bag_of_ros_1_gives_a_run_or_one_line(
    place: float, noise: bytes, cut: bool, whole_old: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    bag, at = tmp_path_factory.mktemp("damaged") / "run.bag", int(place * len(whole_old))
    bag.write_bytes(whole_old[:at] if cut else whole_old[:at] + noise + whole_old[at + len(noise) :])
    recording = answer(lambda: read(bag, ROBOT), str(bag))
    assert recording is None or np.isfinite(recording.forces).all()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=examples(20))
@given(
    stored=st.sampled_from(StoragePlugin), which=st.booleans(), place=st.floats(0.0, 1.0),
    noise=st.binary(min_size=1, max_size=40), cut=st.booleans(),
)  # fmt: skip
def test_a_damaged_bag_gives_a_run_or_one_line(
    stored: StoragePlugin, which: bool, place: float, noise: bytes, cut: bool, whole: dict[StoragePlugin, Path],
    tmp_path_factory: pytest.TempPathFactory,
) -> None:  # fmt: skip
    bag = tmp_path_factory.mktemp("damaged") / "bag"
    bag.mkdir()
    damaged = "metadata.yaml" if which else next(f.name for f in whole[stored].iterdir() if f.suffix != ".yaml")
    for file in whole[stored].iterdir():
        content = file.read_bytes()
        at = int(place * len(content))
        if file.name == damaged:
            content = content[:at] if cut else content[:at] + noise + content[at + len(noise) :]
        (bag / file.name).write_bytes(content)
    recording = answer(lambda: read(bag, ROBOT), str(bag))
    assert recording is None or np.isfinite(recording.forces).all()
