"""Both planners of LinuxCNC 2.10: which law moves have, which limits are kept, what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError
from ruckig import InputParameter, Ruckig, Trajectory

from cases.base.errors import Code, FileProblem, HexciteError, ProgramError
from cases.schema import Case, load_case
from identification.limits.limit import LimitKind, Status
from planner.controller_limits import controlled, steps_of
from postprocessors.controllers.linuxcnc.configuration import ini_text
from postprocessors.controllers.linuxcnc.machine_ini import require_same_machine
from postprocessors.controllers.linuxcnc.session import require_planner
from postprocessors.dialects.linuxcnc.promises import guarantees_of_linuxcnc, linuxcnc_guarantees
from postprocessors.dialects.linuxcnc.read import read_linuxcnc
from postprocessors.proof.homing import predicted
from postprocessors.proof.proof import prove_program
from postprocessors.reading import Reading, Untimed
from tests.postprocessors.changed_case import changed

WIDE = 400_000.0  # [mm/s^3] above the root of the sum of squares of the axes' limits of the hexapod, 100 m/s^3 each
HOME = (0.0, 0.0, 900.0, 0.0, 0.0, 0.0)
START = "G8 G17 G21 G40 G49 G54 G80 G90 G91.1 G94\nG92.1\nG61.1\nM50 P0\nG1 X0 Y0 Z900 A0 B0 C0 F600\n"


def with_planner(case: Case, jerk: float | None) -> Case:
    """The case for the planner with a limit of jerk along the path [mm/s^3], or for the one of trapezoids."""
    stated = {"acceleration_headroom": case.controller.linuxcnc.acceleration_headroom}
    own = {"planner": "trapezoidal"} if jerk is None else {"planner": "s_curve", "max_linear_jerk_mm_s3": jerk}
    return changed(case, controller__linuxcnc=stated | own)


@pytest.fixture(scope="module")
def smooth() -> Case:
    return with_planner(load_case("hexapod"), WIDE)


def program(moves: str, case: Case) -> Reading:
    return read_linuxcnc(f"{START}M62 P0\n{moves}M65 P0\nM2\n".encode("ascii"), "p.ngc", case)


def of_linuxcnc_2_10(way: NDArray[np.float64], feed: float, case: Case, path_jerk: float) -> float:
    """Duration of a move in words of LinuxCNC's source: lengths in mm, angles in degrees, ruckig along the path.

    The length is that of X, Y, Z, of A, B, C where these alone move; each axis' limit counts by its share of it.
    """
    box = case.limits.motion
    units = np.array([1e3] * 3 + [np.degrees(1.0)] * 3)
    moving = way > 1e-9
    length = float(np.linalg.norm(way[:3])) or float(np.linalg.norm(way[3:]))
    v, a, j = (
        float(np.min(limit[moving] * units[moving] / way[moving])) * length
        for limit in (box.rate, box.acceleration, box.jerk)
    )
    request, answer = InputParameter(1), Trajectory(1)
    request.current_position, request.target_position = [0.0], [length]
    request.max_velocity, request.max_acceleration = [min(v, feed)], [a]
    request.max_jerk = [min(j, path_jerk)]
    Ruckig(1).calculate(request, answer)
    return float(answer.duration)


@given(
    way=st.tuples(*[st.integers(-200, 200)] * 3, *[st.integers(-15, 15)] * 3).filter(any),
    feed=st.sampled_from([600, 6000, 60000]),
    jerk=st.sampled_from([2000.0, 100_000.0, WIDE]),
)
def test_a_move_takes_the_time_that_the_source_of_2_10_gives_it(way: tuple[int, ...], feed: int, jerk: float) -> None:
    case = with_planner(load_case("hexapod"), jerk)
    ends = " ".join(f"{axis}{home + d:g}" for axis, home, d in zip("XYZABC", HOME, way, strict=True))
    reading = program(f"G1 {ends} F{feed}\n", case)
    move = next(part for part in reading.stretches if isinstance(part, Untimed) and part.trigger)
    guarantees = linuxcnc_guarantees(reading, case)
    motion = predicted(move, guarantees)
    assert motion is not None
    expected = of_linuxcnc_2_10(np.abs(np.array(way, dtype=float)), feed / 60.0, case, jerk)
    assert motion.duration == pytest.approx(expected, rel=1e-6)


def test_jerk_is_enforced_and_struts_are_not_known_to_be(smooth: Case) -> None:
    """Under trapezoids it is the other way round: no jerk is kept, struts follow from a law that was measured."""
    proofs = {}
    for case in (smooth, with_planner(smooth, None)):
        reading = program("G1 X80 Y40 Z950 A5 F60000\nG1 X0 Y0 Z900 A0 F60000\n", case)
        proofs[case.controller.linuxcnc.planner] = prove_program(reading, linuxcnc_guarantees(reading, case))
    status = {
        planner: {check.kind.family: check.status for check in proof.limits.checks if check.of.move == "untimed moves"}
        for planner, proof in proofs.items()
    }
    assert status["s_curve"][LimitKind.JERK] is Status.ENFORCED
    assert status["s_curve"][LimitKind.STRUT_ACCELERATION] is Status.NOT_ENFORCED
    assert status["trapezoidal"][LimitKind.JERK] is Status.NOT_ENFORCED
    assert status["trapezoidal"][LimitKind.STRUT_ACCELERATION] is Status.FOLLOWS
    assert any("no program was tried" in remark for remark in proofs["s_curve"].remarks)
    assert proofs["s_curve"].duration > proofs["trapezoidal"].duration


def test_jerk_along_the_path_stays_below_its_limit(smooth: Case) -> None:
    """10 m/s^3 along the path, with axes that may 100: the jerks of X, Y and Z together are 10 m/s^3."""
    case = with_planner(smooth, 10_000.0)
    reading = program("G1 X80 Y40 Z950 A5 F60000\n", case)
    move = next(part for part in reading.stretches if isinstance(part, Untimed) and part.trigger)
    motion = predicted(move, linuxcnc_guarantees(reading, case))
    assert motion is not None
    jerks = motion.at(np.linspace(0.0, motion.duration, 2001)).jerks[:, :3]
    assert np.linalg.norm(jerks, axis=1).max() == pytest.approx(10.0, rel=1e-6)


@pytest.mark.parametrize(
    ("moves", "line"),
    [("G64 P1 Q0\nG93 G1 X5 F20\nG94 G61.1\n", 8), ("G3 X0 Y0 I50 J0 F600\n", 7)],
    ids=["blocks in time", "an arc"],
)
def test_what_the_planner_makes_in_a_way_that_is_not_known_is_refused(moves: str, line: int, smooth: Case) -> None:
    reading = program(moves, smooth)
    with pytest.raises(ProgramError, match="s_curve") as caught:
        linuxcnc_guarantees(reading, smooth)
    assert caught.value.code is Code.NOT_SUPPORTED
    assert f"line {line}" in str(caught.value)
    linuxcnc_guarantees(reading, with_planner(smooth, None))
    with pytest.raises(HexciteError, match="s_curve"):
        guarantees_of_linuxcnc(smooth, timed=True)


def test_plans_keep_jerk_and_leave_the_path_room(smooth: Case) -> None:
    """Three coordinates at their limits together stay below the limit along the path, which then never binds."""
    plain = with_planner(smooth, None)
    assert steps_of(smooth, "linuxcnc") == 0.0 < steps_of(plain, "linuxcnc")
    assert controlled(smooth, "linuxcnc")[0] is smooth
    narrow = controlled(with_planner(smooth, 100_000.0), "linuxcnc")[0].limits.motion
    assert np.linalg.norm(narrow.jerk[:3]) == pytest.approx(100.0)
    np.testing.assert_array_equal(narrow.jerk[3:], smooth.limits.motion.jerk[3:])


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"planner": "s_curve"}, "MAX_LINEAR_JERK"),
        ({"planner": "s_curve", "max_linear_jerk_mm_s3": 0.5}, "max_linear_jerk_mm_s3"),
        ({"max_linear_jerk_mm_s3": 100.0}, "s_curve"),
    ],
)
def test_a_planner_and_its_jerk_are_stated_together(settings: dict[str, Any], words: str) -> None:
    case = load_case("hexapod")
    with pytest.raises(ValidationError, match=words):
        changed(case, controller__linuxcnc={"acceleration_headroom": 1.0} | settings)


def test_the_linuxcnc_that_is_installed_must_have_the_planner(smooth: Case) -> None:
    require_planner(smooth, (2, 10))
    require_planner(smooth, (3, 0))
    require_planner(with_planner(smooth, None), (2, 9))
    with pytest.raises(HexciteError, match=r"2\.9.*2\.10.*virtual") as caught:
        require_planner(smooth, (2, 9))
    assert caught.value.code is Code.NOT_INSTALLED


def ini(tmp_path: Path, case: Case, *changes: tuple[str, str]) -> Path:
    """The INI file that is made for a case, with other text in some places."""
    text = ini_text(case, 1.0, box=False)
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    file = tmp_path / "machine.ini"
    file.write_text(text, encoding="ascii")
    return file


@pytest.mark.parametrize("jerk", [WIDE, None])
def test_the_ini_that_is_made_for_a_case_is_that_of_its_machine(jerk: float | None, tmp_path: Path) -> None:
    case = with_planner(load_case("hexapod"), jerk)
    require_same_machine(ini(tmp_path, case), case, timed=False)
    assert ("PLANNER_TYPE = 1" in ini_text(case, 1.0)) == (jerk is not None)


CONTRADICTIONS: dict[str, tuple[tuple[str, str], tuple[str, ...]]] = {
    "the other planner": (("PLANNER_TYPE = 1", "PLANNER_TYPE = 0"), ("PLANNER_TYPE = 0", "PLANNER_TYPE = 1")),
    "no planner": (("PLANNER_TYPE = 1\n", ""), ("PLANNER_TYPE = 0",)),
    "an unknown planner": (("PLANNER_TYPE = 1", "PLANNER_TYPE = 2"), ("PLANNER_TYPE = 2",)),
    "trapezoids below 1 mm/s^3": (("MAX_LINEAR_JERK = 400000.0", "MAX_LINEAR_JERK = 0.5\n#"), ("PLANNER_TYPE = 0",)),
    "another jerk": (("MAX_LINEAR_JERK = 400000.0", "MAX_LINEAR_JERK = 500000.0"), ("500000", "400000")),
    "no jerk of an axis": (("MAX_JERK = ", "LEAST_JERK = "), ("[AXIS_X]MAX_JERK", "missing", "100000")),
    "a quicker axis": (("MAX_ACCELERATION = 6000.0", "MAX_ACCELERATION = 9000.0"), ("9000", "6000")),
    "not a number": (("PLANNER_TYPE = 1", "PLANNER_TYPE = 1 # S"), ("PLANNER_TYPE", "not a number")),
    "unknown units": (("LINEAR_UNITS = mm", "LINEAR_UNITS = cm"), ("LINEAR_UNITS", "inch")),
}


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_an_ini_that_contradicts_the_case_is_refused_with_line_and_values(
    name: str, tmp_path: Path, smooth: Case
) -> None:
    change, words = CONTRADICTIONS[name]
    file = ini(tmp_path, smooth, change)
    with pytest.raises(FileProblem) as caught:
        require_same_machine(file, smooth, timed=False)
    assert all(word in str(caught.value) for word in words)
    assert str(file) in str(caught.value)


def test_limited_jerk_contradicts_a_case_of_trapezoids(tmp_path: Path, smooth: Case) -> None:
    with pytest.raises(FileProblem, match=r"line \d+: LinuxCNC runs limited jerk.*trapezoids") as caught:
        require_same_machine(ini(tmp_path, smooth), with_planner(smooth, None), timed=False)
    assert caught.value.code is Code.CONTRADICTION


def test_an_ini_is_read_as_linuxcnc_reads_it(tmp_path: Path, smooth: Case) -> None:
    """Of a key that stands twice the first counts; files are included; a machine in inches has its limits in inches."""
    (tmp_path / "more.inc").write_text("[TRAJ]\nPLANNER_TYPE = \\\n1\n; PLANNER_TYPE = 0\n", encoding="ascii")
    file = ini(tmp_path, smooth, ("[EMC]", "#INCLUDE more.inc\n[EMC]"), ("PLANNER_TYPE = 1", "PLANNER_TYPE = 0"))
    require_same_machine(file, smooth, timed=False)
    inches = ini(tmp_path, smooth, ("LINEAR_UNITS = mm", "LINEAR_UNITS = inch"))
    with pytest.raises(FileProblem, match="MAX_LINEAR_JERK"):  # 25.4 times as much
        require_same_machine(inches, smooth, timed=False)


def test_a_knob_beyond_100_percent_contradicts_a_case_in_which_it_ends_there(tmp_path: Path, smooth: Case) -> None:
    settings = smooth.controller.model_copy(update={"most_override_percent": 100.0})
    ending = smooth.model_copy(update={"controller": settings})
    with pytest.raises(FileProblem, match=r"MAX_FEED_OVERRIDE = 1\.2.*100 %"):
        require_same_machine(ini(tmp_path, ending), ending, timed=False)
    require_same_machine(
        ini(tmp_path, ending, ("MAX_FEED_OVERRIDE = 1.2", "MAX_FEED_OVERRIDE = 1")), ending, timed=False
    )


def test_acceleration_limits_of_dense_paths_are_those_of_their_headroom(tmp_path: Path) -> None:
    case = with_planner(load_case("hexapod"), None)
    wide = tmp_path / "wide.ini"
    wide.write_text(ini_text(case, case.controller.linuxcnc.acceleration_headroom), encoding="ascii")
    require_same_machine(wide, case, timed=True)
    with pytest.raises(FileProblem, match="MAX_ACCELERATION"):
        require_same_machine(wide, case, timed=False)


def test_a_path_jerk_without_end_is_none(smooth: Case) -> None:
    plain = guarantees_of_linuxcnc(with_planner(smooth, None), timed=False)
    assert plain.path_jerk == (math.inf, math.inf)
    assert guarantees_of_linuxcnc(smooth, timed=False).path_jerk == (WIDE * 1e-3, math.radians(WIDE))
