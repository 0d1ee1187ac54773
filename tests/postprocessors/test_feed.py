"""What the feed word means to LinuxCNC: one over minutes in G93, mm/min of XYZ or degrees/min of ABC alone in G94."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.units import DEG, MM
from cases.schema import Case, load_case
from postprocessors.reading import Timed, Untimed
from tests.postprocessors.programs import HEAD, parts, proof, read_linuxcnc, there_and_back, timed, typed

CASE = load_case("hexapod")


def last_move(body: str) -> Untimed:
    last = read_linuxcnc(typed(body), "p.ngc").stretches[-1]
    assert isinstance(last, Untimed)
    return last


def duration(body: str) -> float:
    last = parts(typed(body), CASE)[-1]
    return last.points.duration if isinstance(last, Timed) else last.length / last.feed


@given(seconds=st.floats(1e-3, 100.0))
def test_in_inverse_time_a_block_takes_60_over_f_seconds_whatever_its_length(seconds: float):
    for way in (0.1, 7.0):
        assert duration(timed([f"G1 X{way} A{way} F{60 / seconds:.12f}"])) == pytest.approx(seconds, rel=1e-9)


@given(feed=st.floats(1.0, 6000.0), x=st.floats(1.0, 100.0), a=st.floats(0.0, 10.0))
def test_feed_per_minute_counts_the_way_of_x_y_z_and_lets_a_b_c_come_along(feed: float, x: float, a: float):
    way = np.hypot(x, 3.0)
    assert duration(f"G1 X{x:.6f} Y3 A{a:.6f} F{feed:.6f}") == pytest.approx(60 * way / feed, rel=1e-5)


@given(feed=st.floats(1.0, 3000.0), a=st.floats(1.0, 15.0))
def test_feed_per_minute_counts_degrees_where_only_a_b_c_move(feed: float, a: float):
    way = np.hypot(a, 4.0)
    assert duration(f"G1 A{a:.6f} B4 F{feed:.6f}") == pytest.approx(60 * way / feed, rel=1e-5)


@pytest.mark.parametrize("x", ["0.00000005", "0.0000002", "0.0000005", "0.00001"])
def test_reader_and_judge_agree_from_where_on_x_y_z_count_as_moving(x: str, hexapod_case: Case):
    """The interpreter counts X, Y and Z from 1e-7 mm on: then ABC have to keep up, however far they go."""
    move = parts(typed(f"G1 X{x} A10 F3000"), hexapod_case)[-1]
    assert isinstance(move, Untimed)
    moves = float(x) > 1e-7
    seconds = float(x) / 3000 * 60 if moves else 10 / 3000 * 60
    assert move.length / move.feed == pytest.approx(seconds, rel=1e-6)


def test_another_feed_is_another_time():
    lines = there_and_back()
    faster = [*lines[:7], lines[7].replace("F1200.000000", "F1300"), *lines[8:]]
    assert duration(timed(lines)) - duration(timed(faster)) == pytest.approx(60 / 1200 - 60 / 1300)


def test_a_feed_per_minute_stays_until_it_is_changed_and_is_gone_after_a_timed_path():
    assert last_move("G1 X1 F600\nX2").feed == pytest.approx(600 * MM / 60)
    assert last_move(f"{timed(['G1 X1 F6'])}\nG1 X2 F60").feed == pytest.approx(60 * MM / 60)
    assert last_move("G1 A1 F600").feed == pytest.approx(600 * DEG / 60)


def test_a_rapid_ignores_the_feed_and_runs_at_the_limits(hexapod_case: Case):
    rapid = last_move("G0 X100 F1")
    assert rapid.feed is None
    v, a = hexapod_case.limits.motion.rate[0], hexapod_case.limits.motion.acceleration[0]
    went = proof(typed("G0 X100 F1"), hexapod_case)
    assert went.duration == pytest.approx(0.1 / v + v / a)
    assert went.limits.to_json()["velocity, untimed moves"]["status"] == "enforced by controller"


def test_the_first_feed_counts_in_millimetres_whatever_moves():
    """Nobody knows where the machine stood; home is reached along X, Y and Z."""
    assert read_linuxcnc(f"{HEAD}M2\n", "p.ngc").stretches[0].feed == pytest.approx(3000 * MM / 60)
