"""Whole programs as text, the way they stand in `tests/golden`; a change there is a decision of its own.

`python -m tests.postprocessors.test_golden` writes them anew.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cases.base.units import DEG, MM
from cases.schema import load_case
from identification.motion.curves import FourierMotion
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import StraightMove, unit_profile
from postprocessors.blocks import Blocks, ToHome, Trigger
from postprocessors.dialects.linuxcnc.write import prepare_linuxcnc
from postprocessors.excitation import excitation_program
from tests.postprocessors.changed_case import changed
from tests.postprocessors.programs import HOME, linuxcnc_text, path_through, proof

GOLDEN = Path(__file__).parents[1] / "golden"
UNITS = np.r_[np.full(3, MM), np.full(3, DEG)]
WALK = HOME + UNITS * [[0, 0, 0, 0, 0, 0], [0.0012345, -1, 2.5, 0, 0, 0], [0, -0.000001, 2.5, 1 / 3, -20, 1e-9]]


def one_of_each() -> Blocks:
    """Every kind of block, with numbers that are easily written wrong."""
    path = path_through("walk", np.array([0.0, 0.01, 2.5]), WALK)
    header = ("a header (with parentheses)", "Größe; 20 % weniger")
    blocks = (ToHome(HOME, 0.05), Standstill(HOME, 0.3), Trigger(True), path, Trigger(False), Standstill(HOME, 1e-7))
    return (*header, *blocks)


def excitation() -> Blocks:
    """Two harmonics along y and about the z axis, at rest at the start; tenfold block time to be short."""
    slow = changed(load_case("hexapod"), controller__block_ms=100.0)
    a, b = np.zeros((2, 6)), np.zeros((2, 6))
    a[:, 1], b[:, 5] = (0.02, -0.02), (0.2, -0.1)
    return prepare_linuxcnc(("two harmonics", *excitation_program(FourierMotion(HOME, a, b, 2.0, 1), slow)), slow)


def trapezoids() -> Blocks:
    """Moves whose accelerations step: of the origin, of the angles alone, of all coordinates with a cruise."""
    places = HOME + UNITS * [[0, 0, 0, 0, 0, 0], [120, 0, 60, 0, 0, 0], [120, 0, 60, 5, -12, 0], [0, 200, 0, 0, 0, 15]]
    times = [(0.1, 0.12), (0.15, 0.06), (0.1, 0.3)]
    laws = [unit_profile(0.0, hold, cruise) for hold, cruise in times]
    moves = tuple(StraightMove(a, b, law) for (a, b), law in zip(pairwise(places), laws, strict=True))
    return ("three trapezoids", *excitation_program(Joined(moves), load_case("hexapod")))


PROGRAMS: dict[str, Callable[[], Blocks]] = {
    "one_of_each.ngc": one_of_each,
    "excitation.ngc": excitation,
    "trapezoids.ngc": trapezoids,
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_is_written_as_in_the_golden_file(name: str):
    assert linuxcnc_text(PROGRAMS[name]()) == (GOLDEN / name).read_text(encoding="ascii")


def test_every_golden_file_is_compared():
    assert {file.name for file in GOLDEN.iterdir()} == set(PROGRAMS)


def test_the_golden_excitation_is_proven():
    assert proof((GOLDEN / "excitation.ngc").read_text(encoding="ascii"), load_case("hexapod")).ok


def test_trapezoids_last_as_planned_by_the_law_of_the_controller():
    """Three moves of 0.32, 0.36 and 0.5 s between the pauses with the trigger off."""
    found = proof((GOLDEN / "trapezoids.ngc").read_text(encoding="ascii"), load_case("hexapod"))
    assert found.ok
    assert found.excitation == pytest.approx(0.32 + 0.36 + 0.5, rel=1e-4)


@pytest.mark.linuxcnc
@pytest.mark.parametrize("name", PROGRAMS)
def test_linuxcnc_accepts_the_golden_file(name: str, rs274: Callable):
    commands = rs274((GOLDEN / name).read_text(encoding="ascii"))
    assert "PROGRAM_END" in dict(commands)


if __name__ == "__main__":
    for name, program in PROGRAMS.items():
        (GOLDEN / name).write_text(linuxcnc_text(program()), encoding="ascii")
