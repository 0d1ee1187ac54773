"""What a program lasts, as the control rounds its text, is what was planned: every dialect, every family of motions."""

import re
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import ProgramError
from cases.base.units import DEG, MM
from cases.schema import Case
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.motion.moves import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.blocks import block_motions
from postprocessors.dialects.joint_trajectory.write import FIRST
from postprocessors.excitation import excitation_program
from postprocessors.program import dialect
from postprocessors.proof.homing import predicted
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Untimed
from postprocessors.writing import proven_program
from tests.helpers import examples, polynomials_of
from tests.postprocessors.joint_walks import robot, walk
from tests.postprocessors.other_dialects import CASE, LINES_CASE, SINUMERIK, TWINCAT, Typed
from tests.postprocessors.programs import HOME
from tests.postprocessors.test_own_axes_of_vendors import CASE as TABLE

ACCEPTED = (
    "velocity", "acceleration", "jerk", "strut velocity", "strut acceleration", "sensor force", "sensor moment",
    "joint torque", "joint force",
)  # fmt: skip
SHARE = 5e-3  # of the planned duration
ROBOT = robot()
OF_POSES = {"linuxcnc": CASE, "sinumerik": CASE, "sinumerik lines": LINES_CASE, "twincat": CASE}
OF_AXES = {"linuxcnc": TABLE, "sinumerik": TABLE, "twincat": TABLE, "urscript": ROBOT}
EVERY = {**OF_POSES, **{f"{name}, own axes": case for name, case in OF_AXES.items()}, "setpoints": CASE}


def excited(name: str, motion: Trajectory) -> float:
    """What the proof of the written program says the motion with its trigger on lasts [s]."""
    case, language = EVERY[name], dialect(re.split("[ ,]", name)[0])
    program = proven_program(motion, case, language, f"p{language.suffix}", (), accepted=ACCEPTED)
    return program.proof.excitation


@st.composite
def steps(draw: st.DrawFn, case: Case) -> tuple[StraightMove, ...]:
    """Moves of which one coordinate moves by what is worth a move, the others by anything: also too little."""
    home, limits = case.need_motion("a test")
    share = [0.5 * limit for limit in (limits.rate, limits.acceleration, limits.jerk)]
    unit, pose, moves = np.where(limits.turns, DEG, MM), home, []
    for _ in range(draw(st.integers(1, 4))):
        ways = 10.0 ** np.array(draw(st.lists(st.floats(-8.0, 0.0), min_size=len(unit), max_size=len(unit))))
        leading = draw(st.integers(0, len(unit) - 1))
        ways[leading] = draw(st.floats(0.2, 8.0))
        signs = np.array(draw(st.lists(st.sampled_from([-1.0, 0.0, 1.0]), min_size=len(unit), max_size=len(unit))))
        signs[leading] = -1.0 if pose[leading] > home[leading] else 1.0
        end = pose + signs * ways * unit
        moves.append(StraightMove.fastest(pose, end, *share))
        pose = end
    return tuple(moves)


@pytest.mark.parametrize("name", [name for name in EVERY if name != "setpoints"])
@settings(max_examples=examples(10))
@given(data=st.data())
def test_moves_last_as_planned_whatever_rounding_makes_of_their_small_coordinates(name: str, data: st.DataObject):
    """The time law of the controller is the plan's: trapezoids where it has no limit of jerk."""
    moves = data.draw(steps(EVERY[name]))
    case, language = EVERY[name], dialect(re.split("[ ,]", name)[0])
    program = proven_program(Joined(moves), case, language, f"p{language.suffix}", (), accepted=ACCEPTED)
    read = [p for p in program.reading.stretches if isinstance(p, Untimed) and p.trigger]
    assert len(read) == len(moves)
    for move, part in zip(moves, read, strict=True):
        found = predicted(part, program.guarantees)
        assert found.duration == pytest.approx(move.duration, rel=SHARE)
        assert part.feed is None or part.feed * 60 / (MM if part.linear else DEG) >= 1e-3


def fourier(seed: int) -> Trajectory:
    half = np.array([0.02, 0.02, 0.01, 0.05, 0.05, 0.05])
    unknowns = np.random.default_rng(seed).normal(size=18)
    return FourierFamily(2, 3.0, 1, HOME, half).motion(0.3 * unknowns / np.abs(unknowns).sum())


def spline(seed: int) -> Trajectory:
    moves = tuple(_walk(np.random.default_rng(seed)))
    return polynomials_of(moves)


def _walk(draw: np.random.Generator) -> list[StraightMove]:
    limits = CASE.limits.motion
    share = [0.4 * limit for limit in (limits.rate, limits.acceleration, limits.jerk)]
    places = [HOME, *(HOME + draw.uniform(-0.2, 0.2, (2, 6)) * limits.coordinates[1]), HOME]
    return [StraightMove.fastest(a, b, *share) for a, b in pairwise(places)]


@pytest.mark.first(5)
@pytest.mark.parametrize("motion", [fourier, spline])
@pytest.mark.parametrize("name", [*OF_POSES, "setpoints"])
def test_paths_last_as_planned(name: str, motion: Callable[[int], Trajectory]):
    planned = motion(1)
    assert excited(name, planned) == pytest.approx(planned.duration, rel=SHARE)


def test_a_joint_trajectory_lasts_as_all_its_parts_and_the_rest_at_home_before_them():
    program = proven_program(walk(ROBOT), ROBOT, dialect("ros2"), "p.yaml", ())
    parts = sum(part.duration for part, _ in block_motions(excitation_program(walk(ROBOT), ROBOT)))
    planned = parts + ROBOT.controller.settle_s + FIRST
    assert program.proof.duration == pytest.approx(planned, rel=SHARE)


@pytest.mark.parametrize("name", list(OF_POSES))
def test_repeated_poses_are_measured_again_without_a_move(name: str):
    """Poses that a control cannot tell apart, and one that differs by a rounding of its position alone."""
    limits = CASE.limits.motion
    share = [0.9 * limit for limit in (limits.rate, limits.acceleration, limits.jerk)]
    pose = HOME + np.r_[0.05, 0.04, 0.0, 0.1, -0.1, 0.1]
    same, turned = pose + 1e-9, pose + np.r_[1e-8, 0.0, 0.0, -0.2, 0.0, 0.0]
    places = [HOME, pose, same, turned]
    parts: list[Trajectory] = []
    for a, b in pairwise(places):
        parts += [StraightMove.fastest(a, b, *share), Standstill(b, 0.5, 1.0)]
    case, language = OF_POSES[name], dialect(name.split(" ")[0])
    program = proven_program(Joined(tuple(parts)), case, language, f"p{language.suffix}", (), accepted=ACCEPTED)
    reading = program.reading
    assert len(reading.measured_poses) == 3
    moves = [p for p in reading.stretches if isinstance(p, Untimed) and p.within is None]
    assert len(moves) == 3  # there, turned, back home
    assert not moves[1].linear
    assert predicted(moves[1], program.guarantees).duration == pytest.approx(parts[4].duration, rel=SHARE)


@pytest.mark.parametrize(("typed", "exact"), [(SINUMERIK, ""), (TWINCAT, "G60 ")])
def test_which_axes_a_feed_counts_is_decided_as_the_control_rounds(typed: Typed, exact: str):
    """A way of X that rounds to nothing leaves F to the angles: 10 degrees at 600 deg/min; FGROUP must say so."""
    rounded = 0.0004 if typed is SINUMERIK else 0.00004
    turn = f"G1 {exact}X{rounded:.5f} {typed.angle}10 F600"
    group = ("FGROUP(A,B,C)" if typed is SINUMERIK else "#FGROUP [A,B,C]") + "\n"
    with pytest.raises(ProgramError, match="F counts A, B, C in this move only after"):
        typed.read(typed.text(turn))
    move = typed.parts(group + turn)[-1]
    assert not move.linear
    assert move.feed == pytest.approx(np.radians(10.0))
    seen = typed.parts(f"G1 {exact}X{10 * rounded:.6f} {typed.angle}10 F600")[-1]
    assert seen.linear
    assert seen.length == pytest.approx((0.004 if typed is SINUMERIK else 0.0004) * MM, rel=1e-6)


@pytest.mark.parametrize(("typed", "exact"), [(SINUMERIK, ""), (TWINCAT, "G60 ")])
def test_a_feed_that_a_control_rounds_to_nothing_is_refused(typed: Typed, exact: str):
    with pytest.raises(ProgramError, match=r"F0\.0000005|F5e-07"):
        typed.read(typed.text(f"G1 {exact}X1 F0.0000005"))
    assert prove_program(typed.read(typed.text(f"G1 {exact}X0.01 F0.1")), typed.language.guarantees(typed.read(
        typed.text("")), CASE)).ok  # fmt: skip
