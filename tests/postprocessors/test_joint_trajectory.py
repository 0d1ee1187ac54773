"""ROS 2 joint trajectories: read by PyYAML and interpolated by SciPy, they are the planned motion."""

import re
from functools import cache

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from cases.errors import CaseError, ProgramError
from cases.schema import load_case
from identification.motion import Joined, Motion
from postprocessors.dialects import Program, dialect
from postprocessors.proving.proof import prove_program
from postprocessors.reading import Timed
from postprocessors.writing import proven_program
from tests.helpers import few, one_line, polynomials_of
from tests.postprocessors.joint_walks import ROBOT, walk

LANGUAGE = dialect("ros2")


class Swing:
    """A smooth motion, not a polynomial: sin^4 in all joints, at rest at both ends up to the third derivative."""

    duration = 3.0

    def at(self, t: np.ndarray) -> Motion:
        time = np.asarray(t, dtype=float)
        home, box = ROBOT.need_motion("a test")
        w, size = np.pi / self.duration, 0.3 * box.pose[1]
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


@pytest.mark.parametrize(("name", "speed"), SPEEDS)
def test_between_its_points_the_message_is_the_planned_motion(name: str, speed: float) -> None:
    motion = MOTIONS[name]
    times, values, names = message(written_motion(name, speed))
    assert names == list(ROBOT.chain.names)
    made = BPoly.from_derivatives(times, values)
    starts = times[(values[:, 1:] == 0.0).all(axis=(1, 2))]
    begin = min(starts, key=lambda s: np.abs(made(s) - motion.at(np.zeros(1)).pose[0]).max())
    settle = ROBOT.controller.settle_s
    t = np.linspace(0.0, motion.duration, 3001)
    at = begin + settle + t / speed
    planned = motion.at(t)
    np.testing.assert_allclose(made(at), planned.pose, atol=1e-6)
    np.testing.assert_allclose(made(at, 1), planned.rates * speed, atol=1e-4)
    np.testing.assert_allclose(made(at, 2), planned.accelerations * speed**2, atol=0.03)
    jerk = np.abs(made(np.linspace(times[0], times[-1], 20_001)[1:-1], 3)).max(axis=0)
    assert np.all(jerk <= ROBOT.limits.motion.jerk)


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
        for order, found in enumerate((motion.pose, motion.rates, motion.accelerations)):
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
    "another joint": (lambda: ("[base,", "[foot,"), "'joint_names: .foot.* where `joint_names: .base, .*` is expected"),
    "another last joint": (lambda: ("wrist_3]", "flange]"), "'joint_names: .*, flange.' where `joint_names: .base, "),
    "joints in another order": (
        lambda: ("base, shoulder", "shoulder, base"),
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
    "a time of text": (lambda: ("sec: 1,", "sec: one,"), "time_from_start: {sec"),
    "too many nanoseconds": (lambda: ("nanosec: 20000000}", "nanosec: 9999999999}"), "time_from_start: {sec"),
    "a jump at the start": (lambda: ("sec: 0, nanosec: 20000000", "sec: 0, nanosec: 0"), "must come after 0 s"),
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
    moved = row().replace(f"[{first:.9f}", f"[{first + 1e-3:.9f}")
    text = moves_text().replace(row(), moved, 1)
    line = 1 + text[: text.index(moved)].count("\n")
    proof = judged(text)
    assert not proof.ok
    assert min(abs(v.line - line) for v in proof.violations) <= 4


def test_less_time_between_points_is_a_violation() -> None:
    def halved(match: re.Match[str]) -> str:
        nanoseconds = (int(match[1]) * 10**9 + int(match[2])) // 2
        return f"sec: {nanoseconds // 10**9}, nanosec: {nanoseconds % 10**9}"

    assert not judged(re.sub(r"sec: (\d+), nanosec: (\d+)", halved, moves_text())).ok


def test_a_case_without_a_chain_is_refused() -> None:
    with pytest.raises(CaseError, match=r"machine\.chain: is missing"):
        LANGUAGE.read(moves_text().encode(), "walk.yaml", load_case("hexapod"))


@cache
def short() -> str:
    return written(walk(ROBOT, 1)).content.decode()


@pytest.mark.slow
@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 999_999), st.integers(1, 12), st.sampled_from(["", "0", ",", "[", "}", "\n", "#", "e", "-"]))
def test_a_damaged_message_is_refused_in_one_line_or_judged(start: int, length: int, put: str) -> None:
    text = short()
    start %= len(text)
    try:
        judged(text[:start] + put + text[start + length :])
    except ProgramError as error:
        one_line(error)
