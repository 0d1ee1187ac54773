"""Point-to-point moves, arcs and splines: written, read back, timed as planned, accepted by LinuxCNC's interpreter."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.base.errors import ProgramError
from cases.schema import Case, load_case
from identification.motion.curves import PolynomialMotion
from identification.motion.motion import Joined
from identification.motion.moves import CircularMove, Plane, StraightMove, fastest_circle
from postprocessors.dialects.linuxcnc.promises import linuxcnc_guarantees
from postprocessors.excitation import excitation_program
from postprocessors.program import dialect
from postprocessors.proof.homing import predicted
from postprocessors.reading import Timed, Untimed
from postprocessors.writing import proven_program
from tests.helpers import examples, jerked
from tests.postprocessors.programs import HOME, RANGE, linuxcnc_text, read_linuxcnc

CASE = load_case("hexapod")
BOX = CASE.limits.motion
SLOW = [0.6 * limit for limit in (BOX.rate, BOX.acceleration, BOX.jerk)]
ACCEPTED = ("jerk", "strut acceleration", "strut velocity", "sensor force")
LINUXCNC = dialect("linuxcnc")


@st.composite
def motions(draw: st.DrawFn) -> Joined:
    """Straight moves and arcs in any order, well inside the box."""
    parts: list[Any] = []
    pose = HOME.copy()
    for kind in draw(st.lists(st.sampled_from("saaf"), min_size=1, max_size=5)):
        if kind == "s":
            share = np.array(draw(st.tuples(*(st.floats(-0.4, 0.4) for _ in range(6)))))
            end = np.round(HOME + share * RANGE, 6)
            if np.abs(end - pose).max() > 1e-3:
                parts.append(StraightMove.fastest(pose, end, *SLOW))
        else:
            plane, radius = draw(st.sampled_from(list(Plane))), draw(st.floats(0.004, 0.012))
            side, turn = draw(st.floats(0.0, 6.28)), draw(st.floats(0.1, 6.2)) * draw(st.sampled_from([-1.0, 1.0]))
            angle = np.copysign(2 * np.pi, turn) if kind == "f" else turn
            first, second, _ = plane.axes
            centre = pose[[first, second]] + radius * np.array([np.cos(side), np.sin(side)])
            parts.append(fastest_circle(pose, plane, centre, angle, *SLOW))
        pose = parts[-1].end if parts else pose
    return Joined(tuple(parts) or (StraightMove.fastest(HOME, HOME + 0.01, *SLOW),))


def moves_of(text: str) -> list[Untimed]:
    return [s for s in read_linuxcnc(text, "p.ngc").stretches if isinstance(s, Untimed) and s.trigger]


@settings(max_examples=examples(15))
@given(motion=motions())
def test_moves_read_back_end_turn_and_last_as_planned(motion: Joined):
    text = linuxcnc_text(excitation_program(motion, CASE))
    reading = read_linuxcnc(text, "p.ngc")
    found = moves_of(text)
    assert len(found) == len(motion.parts)
    parts: Any = motion.parts  # moves, straight or on a circle
    for part, stretch in zip(parts, found, strict=True):
        assert np.all(np.abs(stretch.end - part.end) < 1e-8)
        assert (stretch.arc is not None) == isinstance(part, CircularMove)
        if stretch.arc is not None:
            plane, _, angle = stretch.arc
            assert plane is part.plane
            assert angle == pytest.approx(part.angle, abs=2e-5)
        ran = predicted(stretch, linuxcnc_guarantees(reading, CASE))
        assert ran.duration == pytest.approx(part.duration, rel=2e-3)


@settings(max_examples=examples(15))
@given(motion=motions())
def test_a_written_program_is_proven_but_for_what_linuxcnc_does_not_know(motion: Joined):
    written = proven_program(motion, CASE, LINUXCNC, "p.ngc", ("random",), 1.0, ACCEPTED)
    limits = written.proof.limits.to_json()
    assert limits["acceleration, untimed moves"]["status"] == "enforced by controller"
    assert limits["jerk, untimed moves"]["status"] == "NOT enforced"
    assert "acceleration" not in written.proof.relies_on


@pytest.mark.linuxcnc
def test_linuxcnc_accepts_random_moves_and_turns_them_as_far(rs274: Callable):
    @settings(max_examples=examples(12), deadline=None)
    @given(motion=motions())
    def accepted(motion: Joined) -> None:
        text = linuxcnc_text(excitation_program(motion, CASE))
        commands = rs274(text)
        assert not isinstance(commands, str), commands
        arcs = [numbers for name, numbers in commands if name == "ARC_FEED"]
        turns = [s for s in read_linuxcnc(text, "p.ngc").stretches if isinstance(s, Untimed) and s.arc]
        assert len(arcs) == len(turns)
        for numbers, turn in zip(arcs, turns, strict=True):
            plane, centre, angle = turn.arc
            assert numbers[:2] == pytest.approx(turn.end[list(plane.axes[:2])] * 1e3, abs=1e-3)
            assert numbers[2:4] == pytest.approx(centre * 1e3, abs=1e-3)
            assert np.sign(numbers[4]) == np.sign(angle)

    accepted()


def test_a_slowed_program_takes_the_same_way_longer(hexapod_case: Case):
    motion = Joined((StraightMove.fastest(HOME, HOME + 0.02, *SLOW),))
    durations = []
    for speed in (1.0, 0.1):
        written = proven_program(motion, hexapod_case, LINUXCNC, "p.ngc", (), speed, ACCEPTED)
        durations.append(written.proof.excitation)
    assert durations[1] == pytest.approx(10 * durations[0], rel=1e-3)


def test_a_spline_that_uses_the_whole_jerk_limit_is_proven_though_blocks_are_finer_than_its_knots(hexapod_case: Case):
    motion = jerked(0.998 * BOX.jerk * [1, 0, 0, 1, 0, 0], 0.04)
    accepted = ("acceleration", *ACCEPTED)
    proof = proven_program(motion, hexapod_case, LINUXCNC, "p.ngc", (), accepted=accepted).proof
    assert proof.limits.to_json()["jerk"]["ratio"] == pytest.approx(0.998, abs=2e-3)
    faster = jerked(1.01 * BOX.jerk * [1, 0, 0, 1, 0, 0], 0.04)
    with pytest.raises(ProgramError, match="jerk"):
        proven_program(faster, hexapod_case, LINUXCNC, "p.ngc", (), accepted=accepted)


def test_a_spline_becomes_a_timed_path_of_its_own_duration(hexapod_case: Case):
    c = np.zeros((6, 6))
    c[0] = HOME
    c[3:, 0] = 0.02 * np.array([10.0, -15.0, 6.0])
    text = linuxcnc_text(excitation_program(PolynomialMotion.of_pieces([(c, 1.0)]), hexapod_case))
    (path,) = (s for s in read_linuxcnc(text, "p.ngc").stretches if isinstance(s, Timed) and s.trigger)
    assert path.points.duration == pytest.approx(1.0)
    t = np.linspace(0.0, 1.0, 50)
    assert (
        np.abs(path.points.at(t).coordinates[:, 0] - c[0, 0] - 0.02 * (10 * t**3 - 15 * t**4 + 6 * t**5)).max() < 1e-6
    )
