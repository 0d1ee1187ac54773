"""What the feed word means to SINUMERIK and TwinCAT: the plan's time comes back, another feed is another time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import ProgramError
from cases.base.units import DEG, MM
from identification.motion.moves import StraightMove
from postprocessors.blocks import TimedPath, ToHome
from postprocessors.proof.homing import predicted
from postprocessors.reading import Timed, Untimed
from tests.postprocessors.other_dialects import (
    BOTH,
    CASE,
    LINES_CASE,
    SINUMERIK,
    TWINCAT,
    Typed,
    smooth_points,
    text_of,
)
from tests.postprocessors.programs import HOME, poses

typed_dialects = pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)


def path_duration(typed: Typed, body: str) -> float:
    part = next(p for p in typed.parts(body) if isinstance(p, Timed))
    return part.points.duration


def last_feed(typed: Typed, body: str) -> tuple[float | None, bool]:
    part = [p for p in typed.parts(body) if isinstance(p, Untimed)][-1]
    return part.feed, part.linear


@given(seconds=st.floats(1e-3, 0.2))
def test_g93_is_one_over_minutes_to_sinumerik(seconds: float):
    lines = [f"G1 X{x} A2={x} F{60 / seconds:.12f}" for x in (0.1, 7.0)]
    assert path_duration(SINUMERIK, SINUMERIK.timed(lines)) == pytest.approx(2 * seconds, rel=1e-9)


@given(seconds=st.floats(1e-3, 0.2))
def test_g93_is_seconds_to_twincat(seconds: float):
    lines = [f"G1 X{x} A{x} F{seconds:.12f}" for x in (0.1, 7.0)]
    assert path_duration(TWINCAT, TWINCAT.timed(lines)) == pytest.approx(2 * seconds, rel=1e-9)


@typed_dialects
@given(feed=st.floats(1.0, 6000.0), x=st.floats(1.0, 100.0), a=st.floats(0.0, 10.0))
def test_feed_per_minute_counts_the_way_of_x_y_z(typed: Typed, feed: float, x: float, a: float):
    value, linear = last_feed(typed, f"G1 G60 X{x:.6f} Y3 {typed.angle}{a:.6f} F{feed:.6f}")
    assert value == pytest.approx(feed * MM / 60, rel=1e-5)
    assert linear


@typed_dialects
def test_where_only_angles_move_the_feed_counts_degrees_and_must_be_told_so(typed: Typed):
    move = f"G1 G60 {typed.angle}10 F3000"
    with pytest.raises(ProgramError, match=r"F counts A, B, C .*after #?FGROUP ?[(\[]A,B,C[)\]]"):
        typed.parts(move)
    group = "FGROUP(A,B,C)" if typed is SINUMERIK else "#FGROUP [A,B,C]"
    value, linear = last_feed(typed, f"{group}\n{move}")
    assert value == pytest.approx(3000 * DEG / 60)
    assert not linear
    with pytest.raises(ProgramError, match=r"F counts X, Y, Z .*after"):
        typed.parts(f"{group}\n{move}\nG1 G60 X1")


@typed_dialects
def test_another_feed_is_another_time(typed: Typed):
    lines = smooth_points(typed, "X", 2.0)
    faster = [*lines[:7], typed.point(0.04, lines[7].split()[1]), *lines[8:]]
    assert path_duration(typed, typed.timed(lines)) == pytest.approx(1.0, rel=1e-7)
    assert path_duration(typed, typed.timed(faster)) == pytest.approx(0.99, rel=1e-7)


@typed_dialects
@given(end=poses.filter(lambda p: np.abs(p - HOME).max() > 1e-3), slower=st.floats(1.0, 20.0))
def test_the_feed_of_a_move_gives_it_the_planned_time_under_the_controllers_law(
    typed: Typed, end: np.ndarray, slower: float
):
    limits = CASE.limits.motion
    fastest = StraightMove.fastest(HOME, end, limits.rate, limits.acceleration, limits.jerk)
    move = StraightMove(HOME, end, fastest.profile.slowed(1.0 / slower))
    text = text_of(typed, (ToHome(HOME, 0.05), move))
    reading = typed.read(text)
    guarantees = typed.language.guarantees(reading, CASE)
    run = predicted(reading.stretches[-1], guarantees)
    # of the shortest moves the rounding of places to 0.1 um is a larger share than that of the feed
    rounded = 1e-5 + 1e-7 / np.abs((end - HOME)[:3]).max(initial=1e-3)
    assert run.duration == pytest.approx(move.duration, rel=rounded)
    stretch = typed.read(_with_a_third_of_the_last_feed(text)).stretches[-1]
    again = predicted(stretch, guarantees)
    assert again.duration >= 3 * stretch.length / reading.stretches[-1].feed * (1 - 1e-5)


def _with_a_third_of_the_last_feed(text: str) -> str:
    lines = text.splitlines()
    k = max(k for k, line in enumerate(lines) if line.startswith(("G1 ", "G01 ")))
    words, _, feed = lines[k].rpartition("F")
    lines[k] = f"{words}F{float(feed) / 3:.12f}"
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("speed", [1.0, 0.1])
@pytest.mark.parametrize(
    ("typed", "case"), [(SINUMERIK, CASE), (SINUMERIK, LINES_CASE), (TWINCAT, CASE)], ids=["poly", "lines", "twincat"]
)
def test_the_time_of_a_plan_comes_back_from_the_words(typed: Typed, case, speed: float):
    from planner.families.fourier import FourierFamily
    from postprocessors.excitation import excitation_program

    motion = FourierFamily(2, 1.0, 1, HOME, np.full(6, 0.05)).motion(np.random.default_rng(0).normal(size=18) / 30)
    program = excitation_program(motion, case, speed)
    read = [s for s in typed.read(text_of(typed, program, case), case).stretches if isinstance(s, Timed)]
    planned = [b.times[-1] for b in program if isinstance(b, TimedPath)]
    assert [s.points.duration for s in read] == pytest.approx(planned, rel=1e-7)
    excitation = next(s for s in read if s.trigger)
    assert excitation.points.duration == pytest.approx(motion.duration / speed, rel=1e-7)
    t = np.linspace(0.0, motion.duration, 777)
    off = np.abs(
        excitation.points.at(np.minimum(t / speed, excitation.points.duration)).coordinates - motion.at(t).coordinates
    )
    assert off[:, :3].max() < 2e-6
    assert off[:, 3:].max() < 2e-5
