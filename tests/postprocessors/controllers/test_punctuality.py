"""A window of the trigger counts from the first movement to the last."""

import numpy as np
import pytest

from postprocessors.controllers.executed_run import moving_windows


def test_a_window_of_the_trigger_counts_from_the_first_movement_to_the_last():
    """Ten cycles of waiting at each end are the computer's; a window at standstill is a measurement and stays."""
    on = np.zeros(100, dtype=bool)
    on[10:50] = on[70:90] = True
    struts = np.ones((100, 6))
    struts[20:41] += np.linspace(0.0, 1e-3, 21)[:, None]
    struts[41:] = struts[40]
    assert moving_windows(on, struts, 1e-3) == pytest.approx(np.array([[0.020, 0.040], [0.070, 0.090]]))
