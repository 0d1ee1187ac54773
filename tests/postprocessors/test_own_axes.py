"""LinuxCNC programs of a machine whose axes are its joints: the law of mixed moves, and what is refused."""

import re
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import HexciteError, ProgramError
from cases.schema import load_case
from postprocessors.program import dialect
from postprocessors.proof.homing import predicted
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Untimed
from postprocessors.writing import proven_program
from tests.helpers import one_line, polynomials_of
from tests.postprocessors.controllers.runs import run_text
from tests.postprocessors.joint_walks import ROBOT, walk

CASE = load_case("five_axis_table")
LINUXCNC = dialect("linuxcnc")
LANGUAGE = LINUXCNC
TEXT = proven_program(
    walk(CASE, jerk=False), CASE, LINUXCNC, "walk.ngc", ("a walk",), accepted=("jerk",)
).content.decode()
HEAD = "G17 G21 G40 G49 G54 G80 G90 G91.1 G94\nG92.1\nG61.1\nG1 X0 Y0 Z0 A0 C0 F500\n"


def judged(text: str):
    reading = LANGUAGE.read(text.encode(), "walk.ngc", CASE)
    return prove_program(reading, LANGUAGE.guarantees(reading, CASE))


def durations(text: str) -> list[float]:
    reading = LANGUAGE.read(text.encode(), "walk.ngc", CASE)
    guarantees = LANGUAGE.guarantees(reading, CASE)
    moves = [part for part in reading.stretches if isinstance(part, Untimed) and part.start is not None]
    moves = [part for part in moves if part.within is None]
    return [predicted(part, guarantees).duration for part in moves]


def by_hand(way: dict[str, float], feed: float) -> float:
    """T = 1/s' + s'/s'', or 2/sqrt(s''), with s' and s'' the least that an axis or the feed leaves of the way."""
    names = CASE.chain.names
    units = np.where(CASE.limits.motion.turns, np.pi / 180, 1e-3)
    d = np.array([abs(way.get(name, 0.0)) for name in names]) * units
    lengths = [way[name] for name in "XYZ" if way.get(name)]
    counted = np.linalg.norm(lengths or [way[name] for name in "AC" if way.get(name)])
    moves = d > 0.0
    speed = min(feed / 60 / counted, (CASE.limits.motion.rate[moves] / d[moves]).min())
    acceleration = (CASE.limits.motion.acceleration[moves] / d[moves]).min()
    return 1 / speed + speed / acceleration if speed**2 < acceleration else 2 / np.sqrt(acceleration)


@pytest.mark.parametrize(
    ("way", "feed"),
    [
        ({"X": 90.0}, 6000.0),  # by the feed
        ({"X": 90.0, "A": 30.0}, 60000.0),  # by X
        ({"X": 2.0, "A": 50.0}, 6000.0),  # by A, though F counts X
        ({"A": 50.0, "C": 120.0}, 1500.0),  # F counts degrees
        ({"X": 80.0, "Y": 60.0, "A": 20.0, "C": 90.0}, 1200.0),  # F counts the length of X and Y
        ({"C": 3.0}, 1e5),  # too short for the speed
    ],
)
def test_mixed_moves_take_the_time_of_the_measured_law(way: dict[str, float], feed: float) -> None:
    words = " ".join(f"{name}{value:g}" for name, value in way.items())
    text = f"{HEAD}G1 {words} F{feed:g}\nM2\n"
    assert durations(text) == pytest.approx([by_hand(way, feed)], rel=1e-9)


def test_the_written_moves_last_as_long_as_planned() -> None:
    planned = [part.duration for part in walk(CASE, jerk=False).parts]
    found = durations(TEXT)
    assert found[1:-1] == pytest.approx(planned, rel=1e-6)  # the first and the last are the way there and back


def test_who_answers_for_what() -> None:
    proof = judged(TEXT)
    assert proof.ok
    assert proof.relies_on == ("jerk",)
    status = {str(c.of): str(c.status) for c in proof.limits.checks}
    for name in ("position", "angle", "joint position", "joint angle", "velocity", "angular velocity"):
        assert status[name] == "proven"
    assert status["angular acceleration, untimed moves"] == "enforced by controller"
    assert status["sensor force, untimed moves"] == status["sensor moment, untimed moves"] == "proven"


REFUSED = {
    "a blend": ("G61.1", "G64 P0.01", "G64 is not read here"),
    "a time": ("G61.1", "G61.1\nG93", "G93 is not read here"),
    "an arc": ("G1 X", "G2 I5 X", "G2 is not read here"),
    "an axis that is not there": ("A-", "B-", "is not read here"),
    "an axis that is not taken home": (" C0 F", " F", "not there for certain in C"),
    "all axes home at once": ("G1 X0 Y0 Z0 F", "G1 X0 Y0 Z0 A0 C0 F", "not there for certain in X Y Z A C"),
    "no check of an axis": (
        "o105 if [abs[#<_c>",
        "o105 if [abs[#<_b>",
        "a second check of B, or B is not an axis here",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cuts_corners_is_refused(what: str) -> None:
    old, new, words = REFUSED[what]
    assert old in TEXT
    with pytest.raises(ProgramError, match=words) as caught:
        judged(TEXT.replace(old, new, 1))
    one_line(caught.value)


@pytest.mark.parametrize(
    ("pattern", "new", "limit"),
    [(r"X[-\d.]+", "X140", "position"), (r" A[-\d.]+", " A115", "angle"), (r"C[-\d.]+", "C300", "angle")],
)
def test_a_move_beyond_the_box_is_a_violation(pattern: str, new: str, limit: str) -> None:
    lines = TEXT.splitlines()
    last = max(k for k, line in enumerate(lines[: lines.index("M65 P0")]) if line.startswith("G1"))
    lines[last] = re.sub(pattern, new, lines[last])
    proof = judged("\n".join(lines) + "\n")
    assert any(limit in v.name and v.line in (last + 1, last + 2) for v in proof.violations)


@pytest.mark.parametrize(("words", "limit"), [("X0 Y0 Z0", "jerk"), ("A0 C0", "angular jerk")])
def test_a_move_home_that_is_too_fast_for_a_step_within_a_cycle_is_a_violation(words: str, limit: str) -> None:
    feed = float(re.search(rf"{words} F([\d.]+)", TEXT)[1])
    proof = judged(TEXT.replace(f"{words} F{feed:g}", f"{words} F{1.2 * feed:g}", 1))
    assert [v.name for v in proof.violations] == [f"{limit} (to home, at most)"]


def test_a_first_move_from_anywhere_that_is_too_fast_whatever_its_feed_counts() -> None:
    _, limits = CASE.need_motion("a test")
    body = "G21 G90 G94 G40 G49 G54\nG92.1 G61.1\nG1 X0 Y0 Z0 A0 C0 F{}\nM2\n"
    most = CASE.controller.safe_share * float((limits.rate / np.where(limits.turns, np.pi / 180, 1e-3)).min()) * 60
    assert judged(body.format(most)).ok
    assert any("feed to home" in v.name for v in judged(body.format(1.1 * most)).violations)


def test_paths_are_refused_by_the_writer() -> None:
    path = polynomials_of(walk(CASE, 3).parts)
    with pytest.raises(HexciteError, match="corners") as caught:
        proven_program(path, CASE, LINUXCNC, "walk.ngc", ())
    one_line(caught.value)


@pytest.mark.linuxcnc
def test_linuxcnc_executes_the_law_within_two_cycles_a_move(tmp_path: Path) -> None:
    file = tmp_path / "walk.ngc"
    file.write_text(TEXT)
    log = run_text(file, CASE)
    reading = LANGUAGE.read(TEXT.encode(), "walk.ngc", CASE)
    guarantees = LANGUAGE.guarantees(reading, CASE)
    moved = np.append(np.any(np.diff(log.poses, axis=0) != 0.0, axis=1), False)
    home, limits = CASE.need_motion("a test")
    np.testing.assert_allclose(log.poses[[0, -1]], [home, home], atol=1e-9)
    for part in reading.stretches:
        if not isinstance(part, Untimed) or part.within is not None:
            continue
        rows = np.flatnonzero(moved & (log.lines == part.line))
        first = int(rows[0]) - 1  # the first cycle of a motion shows the line before it
        motion = predicted(part, guarantees)
        taken = (rows[-1] + 1 - first) * log.period
        assert abs(taken - motion.duration) <= 2 * log.period
        t = np.arange(len(rows)) * log.period
        off = log.poses[first : first + len(rows)] - motion.at(t).coordinates
        assert np.all(np.abs(off) <= 1.5 * log.period * limits.rate)  # within a cycle and a half of its time
    np.testing.assert_allclose(log.drives[1:], log.poses[:-1], atol=2.0 * log.period * limits.rate.max())


def test_joints_that_are_no_axes_are_named() -> None:
    with pytest.raises(ProgramError, match=r"joint base turns and is not an axis of LinuxCNC; name those") as caught:
        proven_program(walk(ROBOT, jerk=False), ROBOT, LINUXCNC, "walk.ngc", ())
    one_line(caught.value)
