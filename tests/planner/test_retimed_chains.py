"""Motions of chains at another pace: limits of five, six and seven joints are satisfied, and none is left unused."""

from itertools import pairwise

import numpy as np
import pytest

from identification.limits.proof import prove
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove
from planner.retiming import by_controller
from tests.chains import chain_case
from tests.helpers import few

SEED = 5


@pytest.mark.parametrize("joints", few(5, 6, 7))
def test_moves_of_joints_last_whole_cycles_and_are_as_fast_as_one_joint_can_be(joints: int):
    case = chain_case(joints)
    home, box = case.need_motion("a test")
    draw = np.random.default_rng(SEED)
    places = home + np.vstack([draw.uniform(*(0.2 * box.coordinates)) for _ in range(3)])
    slow = Joined(tuple(
        StraightMove.fastest(a, b, 0.5 * box.rate, 0.25 * box.acceleration, 0.125 * box.jerk)
        for a, b in pairwise(places)
    ))  # fmt: skip
    found = by_controller(slow, case, "moves")
    assert found.duration == pytest.approx(slow.duration / 2, rel=0.03)
    for part, planned in zip(found.parts, slow.parts, strict=True):
        assert part.duration / case.controller.cycle == pytest.approx(round(part.duration / case.controller.cycle))
        assert part.at([part.duration]).coordinates[0] == pytest.approx(
            planned.at([planned.duration]).coordinates[0], abs=1e-12
        )
        used = prove(part, case).checks
        assert max(c.ratio for c in used if "angle" not in c.name and "distance" not in c.name) <= 1.0
        assert max(c.ratio for c in used if str(c.of) in KINETIC) > 0.97


KINETIC = {
    *(f"angular {word}" for word in ("velocity", "acceleration", "jerk")), "velocity", "acceleration", "jerk",
}  # fmt: skip
