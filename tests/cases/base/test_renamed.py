"""Code that was written for an earlier version runs, and is told today's names."""

import inspect
from dataclasses import replace

import numpy as np
import pytest

import hexcite as hx
from cases.schema import load_case
from identification.motion.motion import Motion, Standstill

DRIVES, FORCES = np.full((3, 6), 0.5), np.ones((3, 6))
STILL = np.zeros((1, 6))


def test_a_recording_is_made_and_asked_by_the_names_of_0_2() -> None:
    with pytest.warns(DeprecationWarning, match="Recording.struts is called drives today") as caught:
        run = hx.Recording("run", None, **{"struts": DRIVES, "rotations": None, "forces": FORCES, "trigger": None})
    assert {each.filename for each in caught} == {__file__}
    np.testing.assert_array_equal(run.drives, DRIVES)
    with pytest.warns(DeprecationWarning, match="drives"):
        np.testing.assert_array_equal(getattr(run, "struts"), DRIVES)  # noqa: B009 (type checkers know it no more)


def test_a_field_is_replaced_by_its_earlier_name() -> None:
    run = hx.Recording("run", None, DRIVES, None, FORCES, None)
    with pytest.warns(DeprecationWarning, match="drives"):
        longer = replace(run, **{"struts": 2.0 * DRIVES})
    np.testing.assert_array_equal(longer.drives, 2.0 * DRIVES)


def test_motions_standstills_and_boxes_are_asked_by_the_names_of_0_2() -> None:
    boxes = [load_case(name).need_motion("a test")[1] for name in ("hexapod", "ur10_wrist")]
    for thing in (Motion(np.zeros(1), STILL, STILL, STILL, STILL), Standstill(STILL[0], 0.1), *boxes):
        with pytest.warns(DeprecationWarning, match=f"{type(thing).__name__}.pose is called coordinates today"):
            np.testing.assert_array_equal(getattr(thing, "pose"), thing.coordinates)  # noqa: B009


def test_help_and_refusals_know_todays_names_alone() -> None:
    assert "drives" in inspect.signature(hx.Recording).parameters
    assert "struts" not in inspect.signature(hx.Recording).parameters
    with pytest.raises(TypeError, match="legs"):
        hx.Recording("run", None, **{"legs": DRIVES, "forces": FORCES})
