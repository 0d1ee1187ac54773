"""The machines that the planner is measured on are valid, differ, and can be drawn anew."""

from pathlib import Path

import pytest

from cases.loading import load_case
from planner.infeasible import require_rest
from tests.bench.machines.description import case_of, reachable, write_machine
from tests.bench.machines.designed import DESIGNED
from tests.bench.machines.drawn import HOME, drawn, of_poses


@pytest.mark.parametrize("name", DESIGNED)
def test_a_designed_machine_is_a_case_that_can_stand_still(name: str, tmp_path: Path):
    case = load_case(str(write_machine(tmp_path, name, DESIGNED[name])))
    assert case == case_of(name, DESIGNED[name])
    require_rest(case)
    assert of_poses(case, case.machine.home.vector[None])[0] < HOME


def test_more_than_half_of_the_boxes_are_not_reachable_as_a_whole():
    shares = [reachable(case_of(name, hexapod), 1000).struts for name, hexapod in DESIGNED.items()]
    assert len(shares) >= 12
    assert min(shares) >= 0.05
    assert sum(share <= 0.7 for share in shares) >= len(shares) / 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_a_drawn_machine_is_a_case_whose_home_is_within_reach(seed: int, tmp_path: Path):
    hexapod = drawn(seed)
    case = load_case(str(write_machine(tmp_path, f"drawn_{seed}", hexapod)))
    require_rest(case)
    assert of_poses(case, case.machine.home.vector[None])[0] <= HOME
    assert drawn(seed) == hexapod
    assert drawn(seed + 1) != hexapod
