"""Topics of ROS exported as text: rows of two topics among each other, stamps in two columns, rows without names."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.schema import Case
from cases.tables import built_in_cases
from identification.looks.looking import look
from identification.recording.formats.ros.echoed import echoed_names
from identification.recording.recording import Recording, read
from tests.chains import ROBOT, swing, swung_forces
from tests.helpers import one_line, refused_at
from tests.hexcite.command_line import call

NAMES = tuple(joint.name for joint in ROBOT.chain.joints)
AXES = tuple(f"{kind}/{axis}" for kind in ("force", "torque") for axis in "xyz")
EPOCH = 1_700_000_000
JOINTS_AT, FORCES_AT = np.arange(0.0, 4.0, 0.004), np.arange(0.0, 4.0, 0.002) + 0.0007


def numbers(values: Sequence[float]) -> list[str]:
    return [f"{v:.9g}" for v in values]


def written(file: Path, rows: Sequence[Sequence[str]]) -> Path:
    file.write_text("".join(",".join(row) + "\n" for row in rows), encoding="utf-8")
    return file


def joined(folder: Path) -> Path:
    """As PlotJuggler exports two topics: a row for each stamp of either, and nothing in the fields of the other."""
    head = ["__time", *(f"/joint_states/{name}/position" for name in NAMES), *(f"/ft/wrench/{axis}" for axis in AXES)]
    of_joints = [(t, [*numbers(q), *[""] * 6]) for t, q in zip(JOINTS_AT, swing(JOINTS_AT)[0], strict=True)]
    of_forces = [(t, [*[""] * 6, *numbers(f)]) for t, f in zip(FORCES_AT, swung_forces(FORCES_AT), strict=True)]
    rows = sorted([*of_joints, *of_forces], key=lambda row: row[0])
    return written(folder / "joined.csv", [head, *([f"{EPOCH + t:.6f}", *row] for t, row in rows)])


def stamp(t: float) -> list[str]:
    """Seconds and nanoseconds, as headers have them."""
    ns = round(t * 1e9)
    return [str(EPOCH + ns // 10**9), str(ns % 10**9)]


def in_two_columns(folder: Path) -> Path:
    head = ["stamp_sec", "stamp_nanosec", *NAMES, *(axis.replace("/", "_") for axis in AXES)]
    rows = zip(JOINTS_AT, swing(JOINTS_AT)[0], swung_forces(JOINTS_AT), strict=True)
    return written(folder / "stamps.csv", [head, *([*stamp(t), *numbers([*q, *f])] for t, q, f in rows)])


def echoed(folder: Path) -> list[Path]:
    """As `ros2 topic echo --csv` prints a topic: without a line of names."""
    joints = [
        [*stamp(t), "", *NAMES, *numbers(q), *["0.0"] * 12] for t, q in zip(JOINTS_AT, swing(JOINTS_AT)[0], strict=True)
    ]
    forces = [[*stamp(t), "ft_sensor", *numbers(f)] for t, f in zip(FORCES_AT, swung_forces(FORCES_AT), strict=True)]
    return [written(folder / "joints.csv", joints), written(folder / "wrench.csv", forces)]


def test_frames_of_echoed_wrenches_are_those_of_the_case(tmp_path: Path) -> None:
    case = proposed_for(files := echoed(tmp_path))
    for frame, there in (("tool0", False), ("ft_sensor", True)):
        stated = case.model_copy(update={"recording": case.recording.model_copy(update={"ros": {"frame": frame}})})
        if there:
            assert len(read(files, stated).forces)
        else:
            with refused_at(files[1], "frame ft_sensor; that of the sensor is tool0"):
                read(files, stated)


def require_the_run(run: Recording) -> None:
    """Positions and forces at the instants when they were sampled."""
    at = run.t - run.t[0]
    np.testing.assert_allclose(run.drives, swing(at)[0], atol=2e-5)
    np.testing.assert_allclose(run.forces, swung_forces(at), atol=0.02)


def proposed_for(files: Path | list[Path]) -> Case:
    """The robot's case with the table that a look at the files proposes."""
    seen = look(files, ROBOT)
    assert seen.problem is None, seen.problem
    return Case.model_validate({**ROBOT.model_dump(), "recording": seen.settings})


def test_rows_of_two_topics_among_each_other_are_two_clocks(tmp_path: Path) -> None:
    """Held over, positions would stand still for a row, and jump."""
    file = joined(tmp_path)
    case = proposed_for(file)
    assert case.recording.empty == "apart"
    assert case.recording.rate_Hz == pytest.approx(500.0, rel=0.01)
    run = read(file, case)
    forces_at = run.t
    assert np.median(np.diff(forces_at)) == pytest.approx(0.002, rel=1e-3)
    np.testing.assert_allclose(run.forces, swung_forces(forces_at + FORCES_AT[0] - forces_at[0]), atol=1e-4)


def test_a_value_that_is_held_is_not_taken_for_another_clock(tmp_path: Path) -> None:
    """One that stands only where it has changed keeps no company, and comes in the first row."""
    q, f = swing(JOINTS_AT)[0], swung_forces(JOINTS_AT)
    override = ["100" if k % 50 == 0 else "" for k in range(len(q))]
    head = ["time", *NAMES, *(axis.replace("/", "_") for axis in AXES), "override"]
    rows = [[f"{t:.6f}", *numbers([*a, *b]), o] for t, a, b, o in zip(JOINTS_AT, q, f, override, strict=True)]
    assert look(written(tmp_path / "held.csv", [head, *rows]), ROBOT).settings["empty"] == "hold"


def test_stamps_in_two_columns_are_one_clock(tmp_path: Path) -> None:
    file = in_two_columns(tmp_path)
    case = proposed_for(file)
    assert case.recording.clock.nanoseconds == "stamp_nanosec"
    require_the_run(read(file, case))


def test_what_echo_prints_is_read_without_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where the look puts its pictures
    files = echoed(tmp_path)
    case = proposed_for(files)
    assert case.recording.rate_Hz == pytest.approx(500.0, rel=0.01)  # of the forces, not of the joints
    run = read(files, case)
    assert run.forces is not None
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "case.toml").write_text(built_in_cases()["ur10_wrist"].read_text(encoding="utf-8"), encoding="utf-8")
    call("look", *files, "--case", folder, "--write", folder, "--overwrite")
    answer = call("identify", *files, "--case", folder, "-o", tmp_path / "result", "--json").json()
    mass = ROBOT.need_simulation("a test").parameters.body.mass_kg
    assert answer["parameters"]["m"]["value"] == pytest.approx(mass, abs=0.005)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (("stamp_nanosec", "stamp_nsec"), ("stamp_nanosec", "stamp_nsec", "recording.clock.nanoseconds")),
        ((",4000000,", ",1000000000,"), ("line 3", "1e+09", "recording.clock")),
        ((",4000000,", ",-5,"), ("line 3", "-5")),
    ],
)
def test_a_clock_in_two_columns_that_is_none_is_named(
    damage: tuple[str, str], words: tuple[str, ...], tmp_path: Path
) -> None:
    file = in_two_columns(tmp_path)
    case = proposed_for(file)
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace(*damage, 1), encoding="utf-8")
    with pytest.raises(RecordingError) as caught:
        read(file, case)
    line = one_line(caught.value)
    for word in words:
        assert word in line


def test_only_messages_are_taken_for_such(tmp_path: Path) -> None:
    """Rows of a recorder that begin with whole numbers have no frame, no joints, or another number of values."""
    row = ["17", "4000000", "tool0", *["0.5"] * 6]
    assert echoed_names([row, row]) is not None
    for other in (
        [["17", "4000000", "3", *["0.5"] * 6]],
        [["17", "1000000000", "tool0", *["0.5"] * 6]],
        [["17.5", "4000000", "tool0", *["0.5"] * 6]],
        [["17", "4000000", "tool0", *["0.5"] * 5]],
        [row, [*row[:2], "tool1", *row[3:]]],
        [row, row[:-1]],
        [["17", "1", "", "a", "b", "0.1", "0.2", "0.3"]],
        [["17", "1", "", "a", "b", "0.1", "0.2"], ["17", "2", "", "b", "a", "0.1", "0.2"]],
        [],
    ):
        assert echoed_names(other) is None, other
