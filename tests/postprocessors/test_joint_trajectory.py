"""ROS 2 joint trajectories: read by PyYAML and interpolated by SciPy, they are the planned motion."""

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from cases.base.errors import CaseError, ProgramError
from cases.schema import load_case
from cases.tables import built_in_cases
from identification.limits.limit import LimitKind
from identification.motion.motion import Joined, Motion
from identification.motion.moves import StraightMove, unit_profile
from postprocessors.dialects.joint_trajectory.read import _NUMBER, _name
from postprocessors.dialects.joint_trajectory.write import CLOSEST
from postprocessors.program import Program, dialect
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Timed
from postprocessors.writing import proven_program
from tests.helpers import examples, few, one_line, polynomials_of
from tests.postprocessors.changed_case import changed
from tests.postprocessors.joint_walks import ROBOT, walk

LANGUAGE = dialect("ros2")


class Swing:
    """A smooth motion, not a polynomial: sin^4 in all joints, at rest at both ends up to the third derivative."""

    duration = 3.0

    def at(self, t: np.ndarray) -> Motion:
        time = np.asarray(t, dtype=float)
        home, box = ROBOT.need_motion("a test")
        w, size = np.pi / self.duration, 0.3 * box.coordinates[1]
        s, c = np.sin(w * time), np.cos(w * time)
        orders = [s**4, 4 * w * s**3 * c, w**2 * (12 * s**2 * c**2 - 4 * s**4), w**3 * (24 * s * c**3 - 40 * s**3 * c)]
        pose, *others = (o[:, None] * size for o in orders)
        return Motion(time, home + pose, *others)


def written(motion, speed: float = 1.0) -> Program:
    return proven_program(motion, ROBOT, dialect("ros2"), "walk.yaml", ("a walk",), speed)


def message(program: Program) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Times, shape (n,), and position, rate, acceleration, shape (n, 3, joints), as PyYAML reads them."""
    data = yaml.safe_load(program.content)
    points = data["points"]
    times = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in points]
    values = [[p[key] for key in ("positions", "velocities", "accelerations")] for p in points]
    return np.array(times), np.array(values), data["joint_names"]


MOVES = Joined(walk(ROBOT).parts)
MOTIONS = {"moves": MOVES, "spline": polynomials_of(walk(ROBOT).parts), "swing": Swing()}


@cache
def written_motion(name: str, speed: float = 1.0) -> Program:
    return written(MOTIONS[name], speed)


@cache
def moves_text() -> str:
    return written_motion("moves").content.decode()


def judged(text: str):
    reading = LANGUAGE.read(text.encode(), "walk.yaml", ROBOT)
    return prove_program(reading, LANGUAGE.guarantees(reading, ROBOT))


SPEEDS = few(("moves", 1.0), ("swing", 0.3), ("spline", 1.0), ("swing", 1.0), kept=2)


@pytest.mark.first(1)
@pytest.mark.parametrize(("name", "speed"), SPEEDS)
def test_between_its_points_the_message_is_the_planned_motion(name: str, speed: float) -> None:
    motion: Any = MOTIONS[name]
    times, values, names = message(written_motion(name, speed))
    assert names == list(ROBOT.chain.names)
    made = BPoly.from_derivatives(times, values)
    starts = times[(values[:, 1:] == 0.0).all(axis=(1, 2))]
    settle = ROBOT.controller.settle_s
    begin = max(  # the last standstill at its first pose after which there is time for it
        s for s in starts if s + settle + motion.duration / speed <= times[-1] + 1e-6
        and np.abs(made(s) - motion.at(np.zeros(1)).coordinates[0]).max() < 1e-9
        and np.abs(starts - s - settle).min() < 1e-6
    )  # fmt: skip
    t = np.linspace(0.0, motion.duration, 3001)
    at = begin + settle + t / speed
    planned = motion.at(t)
    np.testing.assert_allclose(made(at), planned.coordinates, atol=1e-6)
    np.testing.assert_allclose(made(at, 1), planned.rates * speed, atol=1e-4)
    np.testing.assert_allclose(made(at, 2), planned.accelerations * speed**2, atol=0.03)
    jerk = np.abs(made(np.linspace(times[0], times[-1], 20_001)[1:-1], 3)).max(axis=0)
    assert np.all(jerk <= ROBOT.limits.motion.jerk)


@pytest.mark.repeats
@pytest.mark.parametrize("name", few("moves", "spline", "swing"))
def test_what_is_read_is_what_scipy_makes_of_the_message(name: str) -> None:
    program = written_motion(name)
    times, values, _ = message(program)
    made = BPoly.from_derivatives(times, values)
    clock = 0.0
    for part in program.reading.stretches:
        if not isinstance(part, Timed):
            clock += part.duration
            continue
        t = np.linspace(0.0, part.points.duration, 500)[1:-1]
        motion = part.points.at(t)
        for order, found in enumerate((motion.coordinates, motion.rates, motion.accelerations)):
            np.testing.assert_allclose(found, made(clock + t, order), atol=1e-9 * 100**order)
        clock += part.points.duration


def test_everything_is_proven_and_nothing_needs_to_be_accepted() -> None:
    proof = written_motion("moves").proof
    assert {str(c.status) for c in proof.limits.checks} == {"proven"}
    assert proof.relies_on == ()
    assert {"angular jerk", "sensor force", "sensor moment"} <= {str(c.of) for c in proof.limits.checks}


def test_accelerations_that_step_have_no_place_in_it() -> None:
    with pytest.raises(ProgramError) as caught:
        written(walk(ROBOT, jerk=False))
    one_line(caught.value)


@cache
def point() -> str:
    """A point in the middle of the message, four lines."""
    text = moves_text()
    return re.search(r"- positions:.*\n.*\n.*\n.*\n", text[len(text) // 2 :])[0]


def row() -> str:
    return point().split("\n")[0]


REFUSED = {
    "another joint": (
        lambda: ('["base",', '["foot",'),
        "'joint_names: ..foot.* where `joint_names: .base, .*` is expected",
    ),
    "another last joint": (
        lambda: ('"wrist_3"]', '"flange"]'),
        "'joint_names: .*, .flange..' where `joint_names: .base, ",
    ),
    "joints in another order": (
        lambda: ('"base", "shoulder"', '"shoulder", "base"'),
        "where `joint_names: .base, shoulder, .*` is expected",
    ),
    "no points": (lambda: ("points:", "point:"), "`points:` is expected"),
    "another key": (lambda: ("- positions", "- position"), "is expected"),
    "five numbers": (lambda: (row(), re.sub(r", [-\d.]+\]", "]", row())), "6 plain numbers.*is expected"),
    "no number": (
        lambda: (row(), row().replace("[", "[.nan, ").replace(", 0.", ", ", 1)),
        "6 plain numbers.*is expected",
    ),
    "no accelerations": (lambda: ("\n".join(point().split("\n")[2:3]) + "\n", ""), "is expected|not complete"),
    "time standing": (lambda: (point(), point() + point()), r"must come after [\d.]+ s"),
    "a time of text": (lambda: ("sec: 4,", "sec: four,"), "time_from_start: {sec"),
    "too many nanoseconds": (lambda: ("nanosec: 300000000}", "nanosec: 9999999999}"), "time_from_start: {sec"),
    "a jump at the start": (lambda: ("sec: 3, nanosec: 0", "sec: 0, nanosec: 0"), "must come after 0 s"),
    "cut off": (lambda: (moves_text()[-200:], ""), "not complete|is expected"),
    "not YAML at all": (lambda: ("joint_names", "G1 X0"), "is expected"),
}  # a text, and what is put in its place


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_understood_is_refused(what: str) -> None:
    edit, words = REFUSED[what]
    old, new = edit()
    assert old in moves_text()
    with pytest.raises(ProgramError, match=words) as caught:
        judged(moves_text().replace(old, new, 1))
    one_line(caught.value)


def test_an_end_in_motion_is_refused() -> None:
    lines = moves_text().splitlines(keepends=True)
    last = max(k for k, line in enumerate(lines) if "velocities" in line)
    lines[last] = lines[last].replace("0.000000000", "0.100000000", 1)
    with pytest.raises(ProgramError, match="rest if it is the first or last"):
        judged("".join(lines))


def test_a_point_that_was_moved_is_a_violation_in_its_line() -> None:
    """A thousandth of a radian off, 17 ms from its neighbours: nothing that the controller would refuse."""
    first = float(re.search(r"\[([-\d.]+)", row())[1])
    moved = row().replace(f"[{first:.12f}", f"[{first + 1e-3:.12f}")
    text = moves_text().replace(row(), moved, 1)
    line = 1 + text[: text.index(moved)].count("\n")
    proof = judged(text)
    assert not proof.ok
    assert min(abs(v.line - line) for v in proof.violations) <= 4


@pytest.mark.repeats
def test_less_time_between_points_is_a_violation() -> None:
    def halved(match: re.Match[str]) -> str:
        nanoseconds = (int(match[1]) * 10**9 + int(match[2])) // 2
        return f"sec: {nanoseconds // 10**9}, nanosec: {nanoseconds % 10**9}"

    assert not judged(re.sub(r"sec: (\d+), nanosec: (\d+)", halved, moves_text())).ok


def test_a_case_without_a_chain_is_refused() -> None:
    with pytest.raises(CaseError, match=r"machine: is a hexapod.* choose another dialect"):
        LANGUAGE.read(moves_text().encode(), "walk.yaml", load_case("hexapod"))


@cache
def short() -> str:
    return written(walk(ROBOT, 1)).content.decode()


NUMBERS = st.one_of(
    st.integers(-999, 999).map(str),
    st.floats(-999, 999).map(str),
    st.from_regex(r"[+-]?[0-9]{1,3}(\.[0-9]{0,3})?([eE][+-]?[0-9]{1,2})?", fullmatch=True),
    st.sampled_from(
        ["010", "-007", "00", "1_000", "0x10", "0b1", "1:30", "1e5", "1.0e5", ".5", "-.5", "0o17", "1.", "~"]
    ),
)


@given(text=NUMBERS)
@settings(max_examples=examples(300))
def test_a_number_is_refused_or_is_the_same_to_every_reader_of_yaml(text: str) -> None:
    """PyYAML reads YAML 1.1; what is a number of the same value to YAML 1.2 is that to Python, too."""
    pattern = re.compile(_NUMBER)
    if pattern.fullmatch(text) is None:
        return
    read = yaml.safe_load(f"[{text}]")[0]
    assert isinstance(read, int | float)
    assert float(read) == float(text)


@pytest.mark.parametrize("text", ["010", "-007", "1_000", "0x10", "1e5", "1.0e5", "-.5", "1:30", "+", "."])
def test_what_readers_of_yaml_take_differently_is_refused(text: str) -> None:
    lines = moves_text().splitlines(keepends=True)
    last = max(k for k, line in enumerate(lines) if "accelerations" in line)
    lines[last] = lines[last].replace("0.000000000000", text, 1)
    with pytest.raises(ProgramError, match="without leading zeros"):
        judged("".join(lines))


@pytest.mark.parametrize("zero", ["sec: 03, nanosec: 0}", "sec: 3, nanosec: 00}"])
def test_times_with_leading_zeros_are_refused(zero: str) -> None:
    with pytest.raises(ProgramError, match="whole numbers without leading zeros"):
        judged(moves_text().replace("sec: 3, nanosec: 0}", zero, 1))


@pytest.mark.parametrize(
    ("name", "plain"), [("on", False), ("NO", False), ("true", False), ("joint_1", True), ("a-b.c", True)]
)
def test_a_name_without_quotes_is_read_where_it_is_a_text_to_every_reader(name: str, plain: bool) -> None:
    pattern = _name(name)
    assert bool(re.fullmatch(pattern, name)) == plain == isinstance(yaml.safe_load(f"[{name}]")[0], str)
    assert re.fullmatch(pattern, f"'{name}'")
    assert re.fullmatch(pattern, f'"{name}"')


# Points: far enough apart, and from wherever the robot stands

SHORT = [
    (0.05, 0.1, 3e-6),
    (0.05, 1e-6, 0.1),
    (0.05, 0.1, 1.5e-3),
    (0.05, 1e-3, 1e-3),
    (0.05, 0.0, 0.0),
    (0.003, 0.0, 1e-9),
]


@pytest.mark.parametrize("times", SHORT)
def test_a_phase_without_room_goes_to_those_beside_it(times: tuple[float, float, float]) -> None:
    law = unit_profile(*times)._replace(acceleration=1.7)
    longer = law.without_short_phases(CLOSEST)
    way, duration = (law.at([law.duration])[0][0], law.duration)
    assert all(phase >= CLOSEST or phase == 0.0 for phase in longer.lengths)
    assert longer.duration == pytest.approx(duration, rel=1e-12)
    assert longer.at([duration])[0][0] == pytest.approx(way, rel=1e-9)
    assert longer.jerk <= law.jerk * (1 + 1e-12)
    given_away = sum(p for p in law.lengths if p < CLOSEST) / duration
    assert longer.peak_velocity <= law.peak_velocity * (1 + given_away)
    assert longer.acceleration <= law.acceleration * (1 + 4 * given_away)


def test_moves_with_phases_of_microseconds_are_written_and_proven() -> None:
    """A solver leaves phases that it wants to be absent some microseconds."""
    home, box = ROBOT.need_motion("a test")
    most = [0.998 * limit for limit in (box.rate, box.acceleration, box.jerk)]
    places = [home + np.full(6, size) for size in (0.0, 0.2, 0.05, 0.0)]
    moves = [StraightMove.fastest(a, b, *most) for a, b in pairwise(places)]
    laws = [unit_profile(tj, th, tc + 3e-6) for _, tj, th, tc in (move.profile for move in moves)]
    parts = [replace(move, profile=law) for move, law in zip(moves, laws, strict=True)]
    assert all(0.0 < part.profile.cruise_time < 1e-5 for part in parts)
    program = written(Joined(tuple(parts)))
    times, _, _ = message(program)
    assert np.diff(times).min() >= CLOSEST - 1e-9
    assert program.proof.ok
    assert max(c.ratio for c in program.proof.limits.checks if c.kind is LimitKind.ANGULAR_JERK) <= 0.9985


@pytest.mark.first(1)
@pytest.mark.parametrize("block", few(20.0, 3.0, 1.0, kept=1))
def test_points_are_never_closer_than_they_can_be(block: float) -> None:
    case = changed(ROBOT, controller__block_ms=block, controller__settle_s=0.001)
    program = proven_program(walk(ROBOT, 1), case, LANGUAGE, "walk.yaml", ("a walk",))
    assert np.diff(message(program)[0]).min() >= CLOSEST - 1e-9


def test_a_timed_piece_that_is_too_short_is_refused_without_a_word_of_other_controllers() -> None:
    lines = moves_text().splitlines(keepends=True)
    k = next(k for k, line in enumerate(lines) if "sec: 4" in line)
    seconds, nanoseconds = map(int, re.search(r"sec: (\d+), nanosec: (\d+)", lines[k - 4]).groups())
    lines[k] = f"  time_from_start: {{sec: {seconds}, nanosec: {nanoseconds + 1000}}}\n"
    with pytest.raises(
        ProgramError, match=r"takes 0\.001 ms; joint_trajectory_controller .*; leave out points"
    ) as caught:
        judged("".join(lines))
    assert not re.search("SINUMERIK|LinuxCNC|TwinCAT|G94|poly", str(caught.value))


@pytest.mark.parametrize(("degrees", "ok"), [(0.05, True), (10.0, True), (300.0, False)])
def test_the_way_to_a_first_point_away_from_home_is_judged(degrees: float, ok: bool) -> None:
    """It takes the 3 s that the message states: 300 deg in that time are too fast for the robot."""
    text = shifted(degrees)
    assert judged(text).ok is ok


def test_a_first_point_that_is_reached_at_once_is_a_violation_there() -> None:
    text = shifted(10.0).replace("sec: 3, nanosec: 0}", "sec: 0, nanosec: 20000000}", 1)
    proof = judged(text)
    assert not proof.ok
    assert {v.line for v in proof.violations if v.time < 0.02} == {1 + text[: text.index("- positions")].count("\n")}


def shifted(degrees: float) -> str:
    """A program that takes the last joint of the robot to another place than home, and stays there."""
    home = [*ROBOT.chain.home[:-1], ROBOT.chain.home[-1] + np.radians(degrees)]
    zeros = ", ".join(["0.0"] * len(home))
    lines = [f"joint_names: [{', '.join(ROBOT.chain.names)}]", "points:"]
    for sec in (3, 4):
        lines += [f"- positions: [{', '.join(f'{v:.12f}' for v in home)}]", f"  velocities: [{zeros}]"]
        lines += [f"  accelerations: [{zeros}]", f"  time_from_start: {{sec: {sec}, nanosec: 0}}"]
    return "\n".join(lines) + "\n"


@pytest.mark.slow
@settings(max_examples=examples(25), deadline=None, derandomize=True)
@given(st.integers(0, 999_999), st.integers(1, 12), st.sampled_from(["", "0", ",", "[", "}", "\n", "#", "e", "-"]))
def test_a_damaged_message_is_refused_in_one_line_or_judged(start: int, length: int, put: str) -> None:
    text = short()
    start %= len(text)
    try:
        judged(text[:start] + put + text[start + length :])
    except ProgramError as error:
        one_line(error)


def test_names_of_joints_in_any_letters_come_back(tmp_path: Path) -> None:
    """The message stays plain ASCII; every reader of YAML finds the names, `true` as a text too."""
    names = ("Gelenk_ä1", "关节2", "сустав3", "ж", "é5", "true")
    text = built_in_cases()["ur10_wrist"].read_text(encoding="utf-8")
    for ours, theirs in zip(("base", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3"), names, strict=True):
        text = text.replace(f'"{ours}"', f'"{theirs}"')
    file = tmp_path / "case.toml"
    file.write_text(text, encoding="utf-8")
    case = load_case(file)
    program = proven_program(MOVES, case, dialect("ros2"), "walk.yaml", ("a walk",), 1.0)
    assert program.content.isascii()
    assert message(program)[2] == [*names]
    assert prove_program(program.reading, program.guarantees).ok
