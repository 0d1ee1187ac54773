"""Every kind of motion becomes a proven program of SINUMERIK, TwinCAT and set points; their files are recognised."""

import numpy as np
import pytest

from cases.base.errors import ProgramError
from identification.motion.motion import Joined, Standstill
from identification.motion.moves import Plane, StraightMove, fastest_circle
from planner.families.fourier import FourierFamily
from postprocessors.program import DIALECTS, dialect, dialect_of_file
from postprocessors.writing import proven_program
from tests.helpers import few, jerked
from tests.postprocessors.changed_case import changed
from tests.postprocessors.other_dialects import CASE
from tests.postprocessors.programs import HOME
from tests.postprocessors.test_polynomials import spline

LIMITS = [0.9 * v for v in (CASE.limits.motion.rate, CASE.limits.motion.acceleration, CASE.limits.motion.jerk)]
FAR = HOME + np.r_[0.05, -0.03, 0.02, 0.1, -0.05, 0.1]
OUTSIDE = HOME + np.r_[0.28, 0.0, 0.0, 0.0, 0.0, 0.0]  # of the motion box, inside the workspace


def moves():
    there, back = StraightMove.fastest(HOME, FAR, *LIMITS), StraightMove.fastest(FAR, HOME, *LIMITS)
    return Joined((there, Standstill(FAR, 0.2), back))


def poses():
    there, back = StraightMove.fastest(HOME, OUTSIDE, *LIMITS), StraightMove.fastest(OUTSIDE, HOME, *LIMITS)
    return Joined((there, Standstill(OUTSIDE, 0.1, 0.3), back))


MOTIONS = {
    "fourier": lambda: FourierFamily(2, 1.0, 1, HOME, np.full(6, 0.05)).motion(
        np.random.default_rng(0).normal(size=18) / 30
    ),
    "moves": moves,
    "spline": lambda: spline(5).slowed(0.3),
    "spline of full jerk": lambda: jerked(0.998 * CASE.limits.motion.jerk * [1, 0, 0, 1, 0, 0], 0.04),
    "circle": lambda: fastest_circle(
        HOME, Plane.XY, HOME[:2] + np.array([0.05, 0.0]), 2 * np.pi, *[0.5 * v for v in LIMITS]
    ),
    "poses": poses,
}
FORMS = {"sinumerik": ".mpf", "twincat": ".nc", "setpoints": ".csv"}


@pytest.mark.first(9)
@pytest.mark.parametrize("speed", few(0.4, 1.0))
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_is_written_and_proven(name: str, form: str, speed: float):
    motion = MOTIONS[name]()
    written = proven_program(motion, CASE, dialect(form), f"p{FORMS[form]}", ("a note",), speed)
    enforced = {"setpoints": "proven", "sinumerik": "proven; SINUMERIK enforces", "twincat": "proven; TwinCAT enforces"}
    assert written.proof.verdict.partition(":")[0] == enforced[form]
    if name == "poses":
        return  # its trigger is on in standstill alone
    pauses = 0.2 * (1 - 1 / speed) if name == "moves" else 0.0  # standstills are as long at any speed
    assert written.proof.excitation + (0.2 if name == "moves" else 0.0) == pytest.approx(
        motion.duration / speed + pauses, rel=1e-3, abs=3e-3
    )


def test_outside_the_motion_box_a_table_may_position_but_not_excite():
    language = dialect("setpoints")
    excitation = Joined(poses().parts[::2])
    program = proven_program(poses(), CASE, language, "p", ())
    assert program.proof.ok
    with pytest.raises(ProgramError, match=r"position \(x\) reaches .* limit 250"):
        proven_program(excitation, CASE, language, "p", ())


def test_a_limit_that_the_case_does_not_promise_needs_to_be_accepted():
    nobody = changed(CASE, controller__sinumerik__controller_keeps=())
    language = dialect("sinumerik")
    with pytest.raises(ProgramError, match=r"SINUMERIK .*jerk.*accept"):
        proven_program(moves(), nobody, language, "p", ())
    every = ("acceleration", "jerk", "strut velocity", "strut acceleration", "velocity", "sensor force")
    assert "nobody enforces" in proven_program(moves(), nobody, language, "p", (), accepted=every).proof.verdict


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("a.MPF", "sinumerik"),
        ("a.nc", "twincat"),
        ("a.cnc", "twincat"),
        ("a.csv", "setpoints"),
    ],
)
def test_files_are_recognised_by_their_endings(file: str, name: str):
    assert dialect_of_file(file) is DIALECTS[name]
