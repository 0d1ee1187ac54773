"""The structure matrix (2) of a sensor frame."""

import numpy as np
import pytest

from cases.schema import load_case
from cases.sensors import SensorFrame
from tests.identification.point_masses import wrench_of_bars

FRAME = load_case("hexapod").sensor_frame


def test_columns_are_what_a_newton_in_each_bar_does_to_the_platform() -> None:
    matrix = FRAME.structure
    for k in range(6):
        np.testing.assert_allclose(matrix[:, k], wrench_of_bars(FRAME.bars, np.eye(6)[k]), atol=1e-15)


def test_a_force_may_be_carried_along_its_bar() -> None:
    """The moment of a bar's force is the same about its lower and its upper point."""
    bars = FRAME.bars
    direction = FRAME.structure[:3].T
    np.testing.assert_allclose(
        np.cross(bars.lower.points, direction), np.cross(bars.upper.points, direction), atol=1e-15
    )


def test_reversing_the_bars_reverses_the_forces() -> None:
    reversed_frame = SensorFrame.model_validate(
        {"bars": {"lower": FRAME.bars.upper.model_dump(), "upper": FRAME.bars.lower.model_dump()}}
    )
    np.testing.assert_allclose(reversed_frame.structure, -FRAME.structure, atol=1e-15)


def test_equal_forces_push_along_the_axis_of_a_frame_with_three_equal_pairs() -> None:
    np.testing.assert_allclose(np.delete(FRAME.structure @ np.ones(6), 2), 0.0, atol=1e-14)


@pytest.mark.parametrize(("sense", "sign"), [("load_on_sensor", -1.0), ("sensor_on_load", 1.0)])
def test_a_transducer_measures_force_and_moment_themselves(sense: str, sign: float) -> None:
    frame = SensorFrame.model_validate({"transducer": {"sense": sense}})
    np.testing.assert_array_equal(frame.structure, sign * np.eye(6))
