"""The log of a run."""

import numpy as np

from tests.postprocessors.execute.runs import log_of


def test_time_counts_cycles_from_the_first_row() -> None:
    np.testing.assert_allclose(log_of([0, 1]).time, [0.0, 1e-3])
