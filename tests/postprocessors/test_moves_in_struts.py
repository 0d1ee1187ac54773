"""Point-to-point moves straight in the struts: only on request, checked along the path that they really take."""

import numpy as np
import pytest

from cases.errors import HexciteError, ProgramError
from identification.hexapod import Hexapod
from identification.limits import prove
from identification.motion import Joined, Standstill
from identification.trajectories.profile import StraightMove, fastest_profile
from identification.trajectories.strut_move import StrutMove
from postprocessors.composing import excitation_program, straight_in_struts
from postprocessors.dialects import DIALECTS
from postprocessors.execute.virtual import run_virtual
from postprocessors.program import Dwell, NeutralProgram, ToHome
from postprocessors.proving.predicted import predicted
from postprocessors.proving.stretches import Untimed, stretches
from postprocessors.wording import strut_feed_of
from postprocessors.writing import proven_program
from tests.postprocessors.changed_case import changed
from tests.postprocessors.independent import strut_lengths
from tests.postprocessors.other_dialects import BOTH, CASE, SINUMERIK, TWINCAT, Typed, text_of
from tests.postprocessors.programs import HOME
from tests.postprocessors.test_dialects_of_plans import moves

ACCEPT = ("acceleration", "jerk", "sensor force", "velocity")
FAR = HOME + np.r_[0.2, -0.15, 0.03, 0.1, -0.1, 0.15]
BOX = CASE.limits.motion


def move(typed: Typed, words: str, seconds: float) -> str:
    """A typed move straight in the struts."""
    words = words.replace("A", typed.angle)
    if typed is TWINCAT:
        return f"#PTP ON\nG93\nG1 G60 {words} F{seconds}\n#PTP OFF\nG94"
    return f"PTP G93 G1 {words} F{60 / seconds}\nCP G94"


def without_drives(typed: Typed):
    data = CASE.model_dump(exclude_none=True)
    del data["controller"][typed.name]["ptp"]
    return type(CASE).model_validate(data)


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_a_typed_move_is_read_with_its_path_and_its_time(typed: Typed):
    part = typed.parts(move(typed, "X200 Y-150", 1.5))[-1]
    assert isinstance(part, Untimed)
    assert part.in_struts
    assert part.feed == pytest.approx(1 / 1.5)
    guarantees = typed.language.guarantees(typed.read(typed.text(move(typed, "X200 Y-150", 1.5))), CASE)
    motion = predicted(part, BOX, guarantees)
    assert isinstance(motion, StrutMove)
    assert motion.profile.peak_velocity == pytest.approx(1 / 1.5)
    struts = strut_lengths(motion.at(np.linspace(0.0, motion.duration, 50)).pose, CASE)
    way = struts[-1] - struts[0]
    share = (struts - struts[0]) @ way / (way @ way)
    np.testing.assert_allclose(struts, struts[0] + share[:, None] * way, atol=1e-9)


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_plans_become_such_moves_on_request_only(typed: Typed):
    plain = text_of(typed, excitation_program(moves(), CASE, ()))
    assert "PTP" not in plain
    written = proven_program(moves(), CASE, typed.language, "p", (), accepted=ACCEPT, in_struts=True)
    assert written.proof.ok
    assert written.content.decode().count("PTP ON" if typed is TWINCAT else "PTP G93") == 2
    planned = moves().duration
    assert written.proof.excitation >= (planned - 0.2) * (1 - 1e-6)  # a standstill counts as none


@pytest.mark.parametrize("speed", [1.0, 0.1])
def test_the_feed_keeps_rates_and_accelerations_and_the_planned_time(speed: float):
    planned = StraightMove.fastest(HOME, FAR, BOX.rate, BOX.acceleration, BOX.jerk)
    planned = StraightMove(planned.start, planned.end, planned.profile.slowed(speed))
    guarantees = TWINCAT.language.guarantees(TWINCAT.read(TWINCAT.text("")), CASE)
    share = strut_feed_of(planned, BOX, guarantees)
    part = Untimed(1, HOME, FAR, share, True, None, False, in_struts=True)
    motion = predicted(part, BOX, guarantees)
    assert motion.duration >= planned.duration * (1 - 1e-6)
    report = prove(motion, CASE, 10_000.0).to_json()
    used = max(report[k]["ratio"] for k in ("velocity", "angular velocity", "acceleration", "angular acceleration"))
    assert used <= 1.0
    # Nothing is given away: it lasts as long as planned, or a limit is used.
    assert motion.duration == pytest.approx(planned.duration, rel=1e-4) or used > 0.99


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_a_box_that_only_the_bent_path_enters_is_found(typed: Typed):
    """The way from x = -200 to 200 mm rises in the struts; straight in the coordinates it does not."""
    start, end = (HOME + np.array([x, 0.0, 0.0, 0.0, 0.0, 0.0]) for x in (-0.2, 0.2))
    guarantees = typed.language.guarantees(typed.read(typed.text("")), CASE)
    bent = predicted(Untimed(1, start, end, 1.0, True, None, False, in_struts=True), BOX, guarantees)
    z = bent.along(np.linspace(0.0, 1.0, 101))[0][:, 2]
    low, high = sorted([z[50] * 1e3 - 0.2 * abs(z[50] - 0.9) * 1e3, z[50] * 1e3 + 5.0])
    assert not low <= 900.0 <= high
    box = {"name": "post", "x_mm": [-20.0, 20.0], "y_mm": [-20.0, 20.0], "z_mm": [low, high]}
    case = changed(CASE, workspace__keep_out=[box])
    before = "G1 G60 X-200 F3000" if typed is TWINCAT else "G1 X-200 F3000"
    after = "G1 G60 X200 F3000" if typed is TWINCAT else "G1 X200 F3000"
    assert typed.proof(typed.text(f"{before}\n{after}"), case).ok
    proof = typed.proof(typed.text(f"{before}\n{move(typed, 'X200', 3.0)}"), case)
    assert not proof.ok
    assert "post" in proof.violations[0].sentence()
    assert typed.text("").count("\n") < proof.violations[0].line + 3


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_nobody_enforces_the_platforms_accelerations_in_them(typed: Typed):
    proof = typed.proof(typed.text(move(typed, "X50", 1.0)))
    assert proof.relies_on == ("acceleration", "jerk", "sensor force")
    status = {name: str(entry["status"]) for name, entry in proof.limits.to_json().items()}
    assert status["velocity"] == "proven"
    assert status["acceleration, untimed moves"] == "NOT enforced"
    assert status["strut acceleration, untimed moves"] == "enforced by controller"
    with pytest.raises(ProgramError, match=r"does not enforce acceleration, jerk, sensor force"):
        proof.require_accepted(())


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_a_feed_that_would_pass_a_rate_is_a_violation(typed: Typed):
    proof = typed.proof(typed.text(move(typed, "X200", 0.2)))
    assert "velocity (x)" in proof.violations[0].sentence()


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_a_case_without_drives_refuses_them(typed: Typed):
    case = without_drives(typed)
    with pytest.raises(ProgramError, match=rf"drives are not known; add controller\.{typed.name}\.ptp"):
        typed.read(typed.text(move(typed, "X50", 1.0)), case)
    with pytest.raises(
        ProgramError, match=r"p: the settings of .* have no ptp table; add it, or leave out --ptp-struts"
    ):
        proven_program(moves(), case, typed.language, "p", (), accepted=ACCEPT, in_struts=True)


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_a_rapid_is_as_fast_as_the_drives_and_leaves_the_platforms_rates_to_nobody(typed: Typed):
    body = "#PTP ON\nG0 G60 X100\n#PTP OFF" if typed is TWINCAT else "PTP G0 X100\nCP"
    (part,) = (p for p in typed.parts(body) if isinstance(p, Untimed) and p.in_struts)
    assert part.feed is None
    drives = CASE.controller.twincat.ptp
    guarantees = typed.language.guarantees(typed.read(typed.text(body)), CASE)
    motion = predicted(part, BOX, guarantees)
    law = fastest_profile(
        motion.strut_way, drives.strut_velocity_m_s, drives.strut_acceleration_m_s2, drives.strut_jerk_m_s3
    )
    assert motion.duration == pytest.approx(law.duration)
    assert typed.proof(typed.text(body)).relies_on == ("velocity", "acceleration", "jerk", "sensor force")


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_where_f_is_not_known_to_be_a_time_moves_are_rapids(typed: Typed):
    ptp = {**getattr(CASE.controller, typed.name).ptp.model_dump(), "feed": "rapid"}
    case = changed(CASE, **{f"controller__{typed.name}__ptp": ptp})
    written = proven_program(moves(), case, typed.language, "p", (), accepted=ACCEPT, in_struts=True)
    found = [p for p in stretches(written.reading) if isinstance(p, Untimed) and p.in_struts]
    assert len(found) == 2
    assert all(p.feed is None for p in found)
    assert "velocity" in written.proof.relies_on
    with pytest.raises(ProgramError, match="rapids cannot be slowed"):
        proven_program(moves(), case, typed.language, "p", (), 0.1, ACCEPT, in_struts=True)
    with pytest.raises(ProgramError, match=rf"controller\.{typed.name}\.ptp\.feed says"):
        typed.read(typed.text(move(typed, "X50", 1.0)), case)


def test_drives_beyond_the_limits_of_the_struts_are_no_case():
    with pytest.raises(ValueError, match=r"controller\.twincat\.ptp\.strut_velocity_m_s = 2 is above"):
        changed(CASE, controller__twincat__ptp={**CASE.controller.twincat.ptp.model_dump(), "strut_velocity_m_s": 2.0})


@pytest.mark.parametrize("name", ["linuxcnc", "setpoints"])
def test_languages_without_such_moves_say_so(name: str):
    with pytest.raises(HexciteError, match="straight in the struts"):
        proven_program(moves(), CASE, DIALECTS[name].load(), "p", (), in_struts=True)


def test_a_plan_without_point_to_point_moves_has_none_to_change():
    with pytest.raises(HexciteError, match="no point-to-point moves"):
        straight_in_struts(NeutralProgram((), (ToHome(HOME, 0.05), Dwell(1.0))))


WRONG = {
    TWINCAT: {
        "#PTP ON\nG1 G60 X5 F100": "G93 and F, the block's time in seconds",
        "#PTP ON\nG93\nG1 X5 F1": "write G60",
        "#PTP ON\nG93\nG2 G60 X5 I2.5 F1": "an arc",
        "#PTP ON\n#SPLINE TYPE AKIMA": "write #PTP OFF before",
        "#PTP ON": "under #PTP ON; write #PTP OFF before",
        "#TRAFO OFF\n#PTP ON": "error 21527",
    },
    SINUMERIK: {
        "PTP G1 X5 F100": "G93 and F = 60",
        "PTP G64 G93 G1 X5 F60": "write G60",
        "PTP G93 G2 X5 I2.5 F60": "write CP before",
        "PTPG0": "write PTP",
        "TRAFOOF\nPTP": "write TRAORI",
        "PTP G93 G1 X5 F60 STAT=0": "a hexapod has one",
    },
}


@pytest.mark.parametrize(("typed", "body"), [(t, body) for t, bodies in WRONG.items() for body in bodies])
def test_what_is_not_understood_under_ptp_is_refused(typed: Typed, body: str):
    with pytest.raises(ProgramError, match=WRONG[typed][body].replace("(", r"\(")):
        typed.read(typed.text(body))


@pytest.mark.parametrize("typed", BOTH, ids=lambda t: t.name)
def test_the_virtual_controller_moves_the_struts_straight(typed: Typed):
    written = proven_program(moves(), CASE, typed.language, "p", (), accepted=ACCEPT, in_struts=True)
    executed = run_virtual(written.reading, CASE, typed.language.guarantees(written.reading, CASE))
    ((start, end),) = executed.trigger
    assert end - start == pytest.approx(written.proof.excitation + 0.2, rel=1e-3)
    pause = next(p for p in moves().parts if isinstance(p, Standstill))
    struts = executed.execution.struts(np.linspace(start, (start + end - pause.duration) / 2 - 1e-3, 200))
    first, last = Hexapod.of(CASE).strut_lengths(np.vstack([moves().parts[0].start, moves().parts[0].end]))
    way = last - first
    share = (struts - first) @ way / (way @ way)
    np.testing.assert_allclose(struts, first + share[:, None] * way, atol=1e-8)
    assert isinstance(moves(), Joined)
