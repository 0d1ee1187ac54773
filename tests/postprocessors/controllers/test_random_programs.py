"""What is proven is what LinuxCNC executes: poses over time of random programs that are read and proven."""

import pytest

from postprocessors.controllers.linuxcnc.session import run_linuxcnc
from tests.postprocessors.random_programs import CASES, differences, one_after_the_other


@pytest.mark.first(1)
@pytest.mark.linuxcnc
@pytest.mark.parametrize("name", CASES)
def test_ten_random_programs_are_executed_as_proven(name: str):
    program = one_after_the_other(range(10), CASES[name])
    assert differences(program, run_linuxcnc(program, CASES[name])) == []
