"""A log whose timed paths took longer than the program says is noticed, and which path it was."""

import numpy as np
import pytest

from postprocessors.execute import ControllerLog, moving_windows, path_words, slowest_path
from tests.helpers import tells
from tests.postprocessors.programs import FIRST, read_linuxcnc, there_and_back, timed, typed

READING = read_linuxcnc(typed(f"{timed(there_and_back(20, seconds=0.1))}\nG4 P1\n{timed(there_and_back(10))}"), "p.ngc")
ONE, OTHER = FIRST + 2, FIRST + 2 + 20 + 2 + 1 + 2  # lines at which the two paths begin


def log(cycles_a_block: int, in_the_other: int) -> ControllerLog:
    """A log of two paths whose blocks take so many cycles each, in lines as the controller reports them."""
    lines = np.concatenate(
        [
            np.zeros(10),
            np.repeat(np.arange(ONE, ONE + 20), cycles_a_block),
            np.zeros(1000),
            np.repeat(np.arange(OTHER, OTHER + 10), in_the_other),
        ]
    ).astype(int)
    still = np.zeros((len(lines), 6))
    return ControllerLog("test", 1e-3, still, still, np.zeros(len(lines), dtype=bool), lines)


def test_paths_that_kept_their_time_are_not_mentioned():
    assert slowest_path(READING, log(100, 50)) is None
    assert slowest_path(READING, log(101, 52)) is None


def test_the_path_that_was_most_late_is_named_with_both_times():
    late = slowest_path(READING, log(110, 90))
    assert late is not None
    assert late == (OTHER + 9, pytest.approx(0.5), pytest.approx(0.9))
    assert tells(path_words(*late), "0.900 s", "0.500 s")
    assert slowest_path(READING, log(130, 50))[0] == ONE + 19


def test_a_window_of_the_trigger_counts_from_the_first_movement_to_the_last():
    """Ten cycles of waiting at each end are the computer's; a window at standstill is a measurement and stays."""
    on = np.zeros(100, dtype=bool)
    on[10:50] = on[70:90] = True
    struts = np.ones((100, 6))
    struts[20:41] += np.linspace(0.0, 1e-3, 21)[:, None]
    struts[41:] = struts[40]
    assert moving_windows(on, struts, 1e-3) == pytest.approx(np.array([[0.020, 0.040], [0.070, 0.090]]))
