"""Bodies of a chain that touch wherever its joints stand."""

import numpy as np
import pytest
from pydantic import ValidationError

from cases.chain import Chain, Joint
from cases.machine import Frame, Tool
from identification.limits.chain import body_clearances, chain_frames
from identification.machines.always_touching import always_touching
from identification.motion.motion import Motion


def ball(name: str, x: float, radius: float = 50.0) -> Tool:
    return Tool(name=name, from_mm=(x, 0.0, 0.0), to_mm=(x, 0.0, 0.0), radius_mm=radius)


def joint(name: str, *bodies: Tool, kind: str = "continuous") -> Joint:
    """About z, in one place with the others."""
    ends = {"position_mm": (0.0, 400.0)} if kind == "prismatic" else {}
    return Joint(name=name, kind=kind, axis=(0.0, 0.0, 1.0), bodies=bodies, **ends)


@pytest.mark.parametrize(
    ("first", "last", "touching"),
    [(0.0, 0.0, True), (0.0, 90.0, True), (0.0, 110.0, False), (60.0, 60.0, False)],
)
def test_balls_on_one_axis_touch_always_or_not(first: float, last: float, touching: bool):
    """The farthest that two balls of 50 mm come apart is the sum of their distances from the axis."""
    joints = (joint("a", ball("one", first)), joint("b", ball("between", 0.0)), joint("c", ball("other", last)))
    assert always_touching(Chain(joints=joints)) == ((("one", "other"),) if touching else ())


def test_what_slides_out_of_another_does_not_touch_it_always():
    joints = (joint("a", ball("one", 0.0)), joint("b"), joint("c", ball("other", 0.0), kind="prismatic"))
    assert always_touching(Chain(joints=joints)) == ()


def test_a_tool_and_what_stands_count_too():
    joints = (joint("a"), joint("b"))
    sensor = Frame(origin_mm=(30.0, 0.0, 0.0))
    chain = Chain(joints=joints, sensor=sensor, base=(ball("foot", 0.0),), tool=(ball("tip", 0.0),))
    assert always_touching(chain) == (("foot", "tip"),)


def test_pairs_that_may_touch_are_not_kept_apart():
    joints = (joint("a", ball("one", 0.0)), joint("b"), joint("c", ball("other", 0.0)))
    still = np.zeros((2, 3))
    motion = Motion(np.arange(2.0), *[still] * 4)

    def pairs(chain: Chain) -> set[str]:
        return {
            label for each in body_clearances(motion.t, chain_frames(motion, chain), chain) for label in each.labels
        }

    assert pairs(Chain(joints=joints)) == {"one, other"}
    assert pairs(Chain(joints=joints, may_touch=(("other", "one"),))) == set()
    with pytest.raises(ValidationError, match="may_touch names third"):
        Chain(joints=joints, may_touch=(("one", "third"),))
