"""What is written reads back as what was meant: poses, times, dwells and the trigger."""

import numpy as np
import pytest
from hypothesis import given

from cases.base.units import DEG, MINUTE, MM
from cases.schema import Case, load_case
from identification.motion.motion import Standstill
from postprocessors.blocks import Blocks, TimedPath, ToHome, Trigger
from postprocessors.dialects.linuxcnc.read import LONGEST_LINE
from postprocessors.excitation import excitation_program
from postprocessors.reading import Still, Timed, Untimed
from tests.postprocessors.programs import HOME, linuxcnc_text, programs, read_linuxcnc
from tests.postprocessors.reported import Pause, Switch, reports

HALF_A_STEP = np.r_[np.full(3, 0.5e-5 * MM), np.full(3, 0.5e-6 * DEG)] * (1 + 1e-6)
CASE = load_case("hexapod")


@given(program=programs())
def test_paths_read_back_with_their_poses_and_times_up_to_the_last_decimal(program: Blocks):
    read = [s for s in read_linuxcnc(linuxcnc_text(program), "p.ngc").stretches if isinstance(s, Timed)]
    paths = [block for block in program if isinstance(block, TimedPath)]
    assert len(read) == len(paths)
    for path, stretch in zip(paths, read, strict=True):
        assert np.all(np.abs(stretch.points.poses - path.poses) <= HALF_A_STEP)
        steps = np.diff(path.times)
        half_a_feed_step = 0.5e-6 * steps**2 / MINUTE  # F = 60 / T has six decimals
        assert np.all(np.abs(np.diff(stretch.points.times) - steps) <= half_a_feed_step * (1 + 1e-6) + 1e-12)


@given(program=programs())
def test_dwells_and_trigger_read_back_in_their_order(program: Blocks):
    events = reports(read_linuxcnc, linuxcnc_text(program), "p.ngc")
    others = [b for b in program if isinstance(b, Standstill | Trigger)]
    before_motion = [isinstance(after, TimedPath) for after in (*program[1:], None)]
    at_once = [not (b.on and moves) for b, moves in zip(program, before_motion, strict=True) if isinstance(b, Trigger)]
    read = [e for e in events if isinstance(e, Pause | Switch)]
    assert len(read) == len(others)
    for block, event in zip(others, read, strict=True):
        if isinstance(block, Standstill):
            assert abs(event.duration - block.duration) <= 0.5e-6 * (1 + 1e-6)
        else:
            assert (event.on, event.at_once) == (block.on, at_once.pop(0))


@given(program=programs())
def test_home_is_checked_first_and_what_is_left_taken_out_at_a_crawl(program: Blocks):
    """No faster than a step up and down within a cycle of 1 ms may be, first what slides, then what turns."""
    reading = read_linuxcnc(linuxcnc_text(program), "p.ngc")
    home, limits = next(block for block in program if not isinstance(block, str)), CASE.limits.motion
    assert isinstance(home, ToHome)
    assert np.all(np.abs(reading.checked[0] - HOME) <= HALF_A_STEP)
    assert reading.checked[1] == pytest.approx(np.r_[np.full(3, 0.01 * MM), np.full(3, 0.01 * DEG)])
    slide, turn = reading.stretches[:2]
    for move, own, most in ((slide, slice(3), home.feed), (turn, slice(3, 6), np.inf)):
        assert isinstance(move, Untimed)
        assert np.all(np.abs(move.end - HOME) <= HALF_A_STEP)
        assert np.flatnonzero(move.within).tolist() == list(range(6)[own])
        most = min(most, float(limits.jerk[own].min()) * 1e-6 / 2)
        assert 0.89 * most < move.feed <= most * (1 + 1e-9)


@given(program=programs())
def test_lines_keep_the_length_that_the_controller_reads(program: Blocks):
    assert max(map(len, linuxcnc_text(program).splitlines())) <= LONGEST_LINE


def test_an_excitation_begins_and_ends_at_home_and_has_the_trigger_on_just_while_it_runs(hexapod_case: Case):
    from planner.families.fourier import FourierFamily

    motion = FourierFamily(2, 3.0, 1, HOME, np.full(6, 0.05)).motion(np.random.default_rng(0).normal(size=18) / 9)
    text = linuxcnc_text(excitation_program(motion, hexapod_case))
    read = read_linuxcnc(text, "p.ngc").stretches
    approach, excitation, back = (s for s in read if isinstance(s, Timed))
    assert [approach.trigger, excitation.trigger, back.trigger] == [False, True, False]
    assert np.allclose(approach.points.poses[0], HOME)
    assert np.allclose(back.points.poses[-1], HOME, atol=1e-9)
    assert abs(excitation.points.duration - motion.duration) < 1e-7
    settle = [s.duration for s in read if isinstance(s, Still)]
    assert settle == [hexapod_case.controller.settle_s] * 2
