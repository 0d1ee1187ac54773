"""Text, read into blocks and written again, is the same text; golden programs stand as whole files."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.units import DEG, MM
from cases.schema import Case
from identification.motion.motion import Standstill, TimedPoints
from identification.motion.moves import CircularMove, Plane, StraightMove, fastest_circle
from postprocessors.blocks import Blocks, TimedPath, ToHome, Trigger
from postprocessors.dialects.sinumerik.read import LONGEST_LINE
from postprocessors.proof.homing import predicted
from postprocessors.reading import Timed, Untimed
from postprocessors.same_motion import off_the_plan
from tests.postprocessors.changed_case import changed
from tests.postprocessors.other_dialects import (
    CASE,
    LINES_CASE,
    LINUXCNC,
    SINUMERIK,
    TWINCAT,
    Typed,
    program_of,
    text_of,
    without_comments,
)
from tests.postprocessors.programs import HOME, path_through, poses
from tests.postprocessors.reported import Pause, Switch, reports

GOLDEN = Path(__file__).parents[1] / "golden_dialects"
HSC_CASE = changed(CASE, controller__twincat__path="hsc", controller__twincat__angle_sign_b=1)
CONTOUR_CASE = changed(CASE, controller__twincat__path="contour")
AXES_CASE = changed(
    CASE,
    controller__sinumerik__orientation_words=("A", "B", "C"),
    controller__sinumerik__transformation="TRAORI(2)",
    controller__sinumerik__poly_degree=3,
)
VARIANTS = {  # with golden files here; LinuxCNC's are in tests/golden
    "poly": (SINUMERIK, CASE),
    "lines": (SINUMERIK, LINES_CASE),
    "axes": (SINUMERIK, AXES_CASE),
    "akima": (TWINCAT, CASE),
    "hsc": (TWINCAT, HSC_CASE),
    "contour": (TWINCAT, CONTOUR_CASE),
}
variants = pytest.mark.parametrize(("typed", "case"), VARIANTS.values(), ids=VARIANTS)
EVERY = {"linuxcnc": (LINUXCNC, CASE)} | VARIANTS
every = pytest.mark.parametrize(("typed", "case"), EVERY.values(), ids=EVERY)
HALF_A_STEP = np.r_[np.full(3, 0.5e-5 * MM), np.full(3, 0.5e-6 * DEG)] * (1 + 1e-6)


def a_path(start: np.ndarray, seed: int, count: int) -> TimedPath:
    """Smooth enough for POLY blocks: a quintic spline through a small random walk, from rest to rest."""
    draw = np.random.default_rng(seed)
    points = start + np.vstack([np.zeros(6), np.cumsum(draw.normal(size=(count, 6)), axis=0) * 1e-4])
    times = np.linspace(0.0, 0.05 * count, count + 1)
    source = TimedPoints.through(times, points)
    return TimedPath("walk", times, points, source)


@st.composite
def programs(draw: st.DrawFn) -> Blocks:
    """Home, then moves, arcs, paths, dwells and triggers in any order."""
    limits = CASE.limits.motion
    share = [0.8 * limits.rate, 0.8 * limits.acceleration, 0.8 * limits.jerk]
    blocks: list[Any] = [ToHome(HOME, draw(st.floats(1e-3, 0.5)))]
    pose = HOME
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(["move", "turn", "arc", "path"]))
        if kind in ("move", "turn"):
            end = np.round(draw(poses.filter(lambda p: np.abs(p[3:]).max() > 1e-2)), 6)
            end = np.r_[pose[:3], end[3:]] if kind == "turn" else end
            if np.abs(end - pose).max() < 1e-3:
                continue
            blocks.append(StraightMove.fastest(pose, end, *share))
        elif kind == "arc":
            plane, angle = draw(st.sampled_from(list(Plane))), draw(st.sampled_from([-1.5, 0.7, 3.5, 2 * np.pi]))
            first, second, _ = plane.axes
            centre = pose[[first, second]] + [0.02, 0.01]
            blocks.append(fastest_circle(pose, plane, centre, angle, *share))
        else:
            blocks.append(a_path(pose, draw(st.integers(0, 1000)), draw(st.integers(3, 6))))
        last = blocks[-1]
        pose = last.poses[-1] if isinstance(last, TimedPath) else last.end
        pause = Standstill(pose, round(draw(st.floats(0.01, 3.0)), 6))
        blocks += [pause, Trigger(draw(st.booleans())), Standstill(pose, 0.1)]
    return ("random", draw(st.text(max_size=80)), *blocks)


@every
@given(program=programs())
def test_blocks_read_back_as_they_were_meant(typed: Typed, case: Case, program: Blocks):
    text = text_of(typed, program, case)
    reading = typed.read(text, case)
    meant = [b for b in program[1:] if isinstance(b, StraightMove | CircularMove | TimedPath)]
    read = [s for s in reading.stretches if isinstance(s, Timed) or (isinstance(s, Untimed) and s.within is None)]
    assert len(read) == len(meant)
    for block, stretch in zip(meant, read, strict=True):
        if isinstance(block, TimedPath):
            assert isinstance(stretch, Timed)
            off = np.abs(stretch.points.at(np.minimum(block.times, stretch.points.duration)).coordinates - block.poses)
            assert stretch.points.duration == pytest.approx(block.times[-1], rel=1e-8)
            assert np.all(off <= HALF_A_STEP + np.repeat([1e-6, 1e-5], 3))
        else:
            assert np.all(np.abs(stretch.end - block.end) <= off_the_plan(typed.language.guarantees(reading, case)))
            assert (stretch.arc is not None) == isinstance(block, CircularMove)
    others = [b for b in program if isinstance(b, Standstill | Trigger)]
    events = [e for e in reports(typed.read, text, case) if isinstance(e, Pause | Switch)]
    found = {
        Standstill: [b.duration for b in others if isinstance(b, Standstill)],
        Trigger: [b.on for b in others if isinstance(b, Trigger)],
    }
    assert [e.duration for e in events if isinstance(e, Pause)] == pytest.approx(found[Standstill], abs=1e-6)
    assert [e.on for e in events if isinstance(e, Switch)] == found[Trigger]


def durations(typed: Typed, text: str, case: Case) -> list[float]:
    """Of the moves that the controller times [s]."""
    reading = typed.read(text, case)
    guarantees = typed.language.guarantees(reading, case)
    parts = [p for p in reading.stretches if isinstance(p, Untimed)]
    moves = [predicted(p, guarantees) for p in parts]
    return [m.duration for m in moves if m is not None]


@every
@given(program=programs())
def test_text_read_and_written_again_is_the_same_text(typed: Typed, case: Case, program: Blocks):
    """But for ends of arcs, which follow from angles, and feeds that a trapezoid never reaches: it takes as long."""
    text = text_of(typed, program, case)
    again = text_of(typed, program_of(text, typed, case), case)
    # An arc behind a move begins at a rounded place, half a micrometre off: its angle is that much another.
    assert durations(typed, again, case) == pytest.approx(durations(typed, text, case), rel=3e-5)
    for line, written in zip(without_comments(text), without_comments(again), strict=True):
        if re.search(r"G0?[23] ", line):  # its end turns with the rounding of its start
            numbers = [[float(n) for n in re.findall(r"[A-Z]=?(-?[\d.]+)", words)] for words in (line, written)]
            feed = 1e-5 if typed is not LINUXCNC else 1.0
            rounding = 1e-3 if typed is SINUMERIK else 1e-4  # what the control rounds places to, in mm
            assert numbers[1][:-1] == pytest.approx(numbers[0][:-1], rel=1e-5, abs=rounding)
            assert numbers[1][-1] == pytest.approx(numbers[0][-1], rel=feed)
        elif typed is LINUXCNC and "G1 " in line:
            numbers = [[float(n) for n in re.findall(r"[A-Z](-?[\d.]+)", part)] for part in (written, line)]
            assert numbers[0][:-1] == pytest.approx(numbers[1][:-1], rel=0.0, abs=2e-5)  # beside ends of arcs
            assert numbers[0][-1] >= numbers[1][-1] * (1 - 1e-5)
        else:
            assert written == line


@pytest.mark.first(2)
@every
def test_a_full_circle_behind_a_path_stays_one(typed: Typed, case: Case):
    """Paths end on more digits than a control tells apart: a circle from there ends on the same ones."""
    limits = CASE.limits.motion
    share = [0.8 * limits.rate, 0.8 * limits.acceleration, 0.8 * limits.jerk]
    for seed in range(40):
        path = a_path(HOME, seed, 6)
        end = path.poses[-1] + np.r_[np.zeros(3), 0.04, -0.3, -0.2]
        turn = StraightMove.fastest(path.poses[-1], end, *share)
        circle = fastest_circle(end, Plane.ZX, end[[2, 0]] + [0.02, 0.01], 2 * np.pi, *share)
        pauses = [Standstill(pose, 0.3) for pose in (path.poses[-1], end, end)]
        program = ("full", ToHome(HOME, 0.1), path, pauses[0], turn, pauses[1], circle, pauses[2])
        text = text_of(typed, program, case)
        again = text_of(typed, program_of(text, typed, case), case)
        assert durations(typed, again, case) == pytest.approx(durations(typed, text, case), rel=3e-5)


@variants
@given(program=programs())
def test_lines_and_characters_are_those_that_the_controller_takes(typed: Typed, case: Case, program: Blocks):
    text = text_of(typed, program, case)
    assert text.isascii()
    assert '"' not in re.sub(r'#MSG \["[^"]*"\]|MSG\("[^"]*"\)|SETAL\(65000,"[^"]*"\)', "", text)
    assert max(map(len, text.splitlines())) <= LONGEST_LINE


def golden_program() -> Blocks:
    """Every kind of block, with numbers that are easily written wrong."""
    limits = CASE.limits.motion
    share = [0.8 * limits.rate, 0.8 * limits.acceleration, 0.8 * limits.jerk]
    end = HOME + np.r_[np.array([0.0012345, -1, 2.5]) * MM, np.array([1 / 3, -20, 1e-7]) * DEG]
    turned = np.r_[end[:3], np.array([0, 5, -5]) * DEG]
    arc = fastest_circle(turned, Plane.ZX, turned[[2, 0]] + [0.03, 0.0], -1.0, *share)
    return (
        'a header (with parentheses), "quotes" and; a semicolon',
        "Größe; 20 % weniger",
        ToHome(HOME, 0.05),
        Standstill(HOME, 0.3),
        Trigger(True),
        StraightMove.fastest(HOME, end, *share),
        StraightMove.fastest(end, turned, *share),
        arc,
        a_path(arc.end, 1, 4),
        Trigger(False),
        Standstill(HOME, 1e-6),
    )


SUFFIX = {"sinumerik": "mpf", "twincat": "nc"}


@variants
def test_a_program_is_written_as_in_the_golden_file(typed: Typed, case: Case):
    name = next(n for n, v in VARIANTS.items() if v == (typed, case))
    file = GOLDEN / f"{name}.{SUFFIX[typed.name]}"
    assert text_of(typed, golden_program(), case) == file.read_text(encoding="ascii")


def test_every_golden_file_is_compared():
    assert {f.name for f in GOLDEN.iterdir()} == {f"{n}.{SUFFIX[t.name]}" for n, (t, _) in VARIANTS.items()}


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for name, (typed, case) in VARIANTS.items():
        (GOLDEN / f"{name}.{SUFFIX[typed.name]}").write_text(text_of(typed, golden_program(), case), encoding="ascii")


def test_the_times_of_many_blocks_add_up_to_that_of_the_path():
    """9.570850467829537 s in 1190 equal blocks: rounded one by one they would be 0.6 us short."""
    times = np.linspace(0.0, 9.570850467829537, 1191)
    path = path_through("slow", times, HOME + np.sin(times / times[-1] * np.pi)[:, None] ** 4 * 1e-3)
    text = text_of(TWINCAT, (ToHome(HOME, 0.05), path))
    steps = [float(found) for found in re.findall(r"^G01 .* F([0-9.]+)$", text, re.MULTILINE)][2:]  # behind home
    assert len(steps) == 1190
    assert sum(steps) == pytest.approx(times[-1], abs=1e-9)
