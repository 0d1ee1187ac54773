"""The log of a run."""

from typing import Any

import numpy as np
import pytest

from postprocessors.execute import ControllerLog
from tests.postprocessors.execute.runs import log_of


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("poses", np.zeros((4, 6)), r"poses has shape \(4, 6\), expected \(5, 6\)"),
        ("drives", np.array([[1.0] * 6] * 4 + [[np.nan] * 6]), "drives is not finite in row 5"),
        ("trigger", np.zeros((5, 1), dtype=bool), r"trigger has shape \(5, 1\)"),
        ("lines", np.zeros(0, dtype=int), "holds no cycle"),
        ("period", 0.0, "period is 0.0 s"),
    ],
)
def test_a_log_that_can_be_made_is_whole(name: str, value: Any, said: str) -> None:
    good = log_of([0, 1, 1, 2, 0])
    values = {key: getattr(good, key) for key in ("controller", "period", "drives", "poses", "trigger", "lines")}
    with pytest.raises(ValueError, match=said):
        ControllerLog(**(values | {name: value}))


def test_a_log_cannot_be_changed() -> None:
    log = log_of([0, 1])
    with pytest.raises(ValueError, match="read-only"):
        log.poses[0, 0] = 1.0
    np.testing.assert_allclose(log.time, [0.0, 1e-3])
