"""What the proof of a program says: which limit, where, how far, and who answers for it."""

import numpy as np
import pytest

from cases.base.errors import ProgramError
from cases.schema import Case
from postprocessors.proof.proof import ProgramProof
from tests.helpers import one_line, tells
from tests.postprocessors.changed_case import changed
from tests.postprocessors.programs import HEAD, proof, small_excitation, there_and_back, timed, typed

PATH = timed(there_and_back())


def status(result: ProgramProof, name: str) -> str:
    return result.limits.to_json()[name]["status"]


def test_a_planned_program_is_proven_and_counts_its_time(hexapod_case: Case):
    result = proof(small_excitation(hexapod_case, period=0.6), hexapod_case)
    assert result.ok
    result.require()
    assert result.excitation == pytest.approx(0.6)
    assert 0.84 < max(c.ratio for c in result.limits.checks if c.binding and c.name != "feed to home") < 0.86


@pytest.mark.parametrize(
    ("line", "name", "worst", "limit"),
    [
        ("G1 X260 F3000", "position (x)", 260, 250),
        ("G1 Y-250.1 F3000", "position (y)", -250.1, -250),
        ("G1 Z790 F3000", "position (z)", -110, -100),
        ("G1 A21 F3000", "angle (a)", 21, 20),
        ("G1 B-20.5 F3000", "angle (b)", -20.5, -20),
        ("G1 X100 F37000", "velocity (x)", 616.67, 600),
        ("G1 C15 F4000", "angular velocity (c)", 66.667, 60),
    ],
)
def test_a_passed_limit_is_named_with_axis_value_limit_and_line(
    line: str, name: str, worst: float, limit: float, hexapod_case: Case
):
    result = proof(typed(f"M64 P0\n{line}"), hexapod_case)
    (violation,) = [v for v in result.violations if v.name == name]
    assert violation.line == 5
    assert (violation.worst, violation.limit) == pytest.approx((worst, limit), rel=1e-4)
    remedy = "slow down or change the move" if "velocity" in name else "change the move"
    with pytest.raises(ValueError, match=rf"p.ngc, line 5: .*[0-9]; {remedy}$"):
        result.require()


def test_positioning_keeps_the_workspace_and_an_excitation_the_narrower_box(hexapod_case: Case):
    assert proof(typed("G1 X280 Z780 F3000"), hexapod_case).ok
    assert not proof(typed("M64 P0\nG1 X280 Z780 F3000"), hexapod_case).ok
    (violation,) = proof(typed("G1 Y-310 F3000"), hexapod_case).violations
    assert (violation.name, violation.limit) == ("workspace position (y)", pytest.approx(-300))


def test_a_box_to_keep_out_of_is_named_with_the_part_that_enters_it(hexapod_case: Case):
    """The platform's joints stand 250 mm from its origin, at 42 and 138 degrees among others."""
    post = {"name": "post", "x_mm": [250.0, 300.0], "y_mm": [150.0, 200.0], "z_mm": [0.0, 950.0]}
    guarded = changed(hexapod_case, workspace__keep_out=[post])
    assert proof(typed("G1 X50 F3000"), guarded).ok
    (violation,) = proof(typed("G1 X70 F3000"), guarded).violations
    assert violation.name == "distance from post (joint 1)"
    assert violation.worst == pytest.approx(250 - 70 - 250 * np.cos(np.radians(42)), abs=0.05)
    assert violation.ratio > 1.0


def test_a_strut_that_would_have_to_be_too_long_is_named(hexapod_case: Case):
    narrow = changed(hexapod_case, limits__motion__strut_length_mm=[900.0, 1100.0])
    result = proof(typed("G1 X200 F3000"), narrow)
    assert [str(v.of) for v in result.violations] == ["strut length"]


def test_the_worst_violation_comes_first(hexapod_case: Case):
    result = proof(typed("M64 P0\nG1 X260 F3000\nG1 X0 A40 F3000"), hexapod_case)
    ratios = [v.ratio for v in result.violations]
    assert ratios == sorted(ratios, reverse=True)
    assert result.violations[0].name == "angle (a)"


@pytest.mark.parametrize("feed", ["36000.5", "36001", "36010"])
def test_a_value_just_above_its_limit_is_not_printed_as_if_it_were_the_limit(feed: str, hexapod_case: Case):
    (violation,) = proof(typed(f"G1 X100 F{feed}"), hexapod_case).violations
    value = violation.sentence().split("reaches ")[1].split(" ")[0]
    assert float(value) > 600


def test_geometry_and_rates_of_timed_paths_are_proven_but_not_what_linuxcnc_makes_of_their_time(hexapod_case: Case):
    """With the headroom that keeps their time its planner accelerates between the blocks as hard as it may."""
    limits = proof(typed(PATH), hexapod_case).limits.to_json()
    for name in ("position", "velocity", "strut length", "strut velocity"):
        assert limits[name]["status"] == "proven"
        assert 0.0 < limits[name]["ratio"] < 1.0
    for name in ("acceleration", "jerk", "strut acceleration", "sensor force"):
        assert limits[name]["status"] == "NOT enforced"
        assert 0.0 < limits[name]["ratio"] < 1.0


def test_what_nobody_enforces_has_to_be_accepted_by_name(hexapod_case: Case):
    result = proof(typed(PATH), hexapod_case)
    assert result.ok
    assert result.relies_on == ("acceleration", "jerk", "strut acceleration", "sensor force")
    assert tells(result.verdict, "LinuxCNC enforces: velocity, strut velocity;", "nobody enforces: ")
    # on the way home, at 25 times the acceleration of the case
    assert "EXCEEDED" in result.verdict
    for limit in ("acceleration", "jerk", "strut acceleration"):
        assert f"{limit} (more than ten times)" in result.verdict
    result.require_accepted(["jerk", "Strut-Acceleration", "acceleration", "sensor-force"])
    with pytest.raises(
        ProgramError, match=r"LinuxCNC .*jerk, strut acceleration.*accept jerk,strut-acceleration\b"
    ) as open_:
        result.require_accepted(["acceleration", "sensor force"])
    assert tells(one_line(open_.value), "jerk (more than ten times)", "strut acceleration (more than ten times)")
    with pytest.raises(ProgramError) as caught:
        result.require_accepted([])
    one_line(caught.value)


def test_accepting_what_nobody_enforces_does_not_accept_what_the_text_itself_passes(hexapod_case: Case):
    fast = proof(typed(timed(there_and_back(size=60.0))), hexapod_case)
    with pytest.raises(ProgramError, match=r"(acceleration|jerk) .*reaches"):
        fast.require_accepted(["acceleration", "jerk", "strut acceleration", "sensor force"])


@pytest.mark.parametrize("body", ["G1 X5 F3000", "G0 X5"])
def test_what_the_controller_times_itself_is_not_called_proven(body: str, hexapod_case: Case):
    """LinuxCNC limits accelerations of axes, beside timed paths far above the case; jerk and struts not."""
    result = proof(typed(f"{body}\nG1 X0 F3000\n{PATH}"), hexapod_case)
    for name in ("acceleration", "angular acceleration", "jerk", "angular jerk", "strut acceleration"):
        assert status(result, f"{name}, untimed moves") == "NOT enforced"
    assert result.limits.to_json()["acceleration, untimed moves"]["ratio"] > 10
    assert result.ok


@pytest.mark.parametrize("body", ["G1 X5 F3000", "G0 X5"])
def test_without_timed_blocks_linuxcnc_gets_the_limits_of_the_case_and_keeps_accelerations(
    body: str, hexapod_case: Case
):
    result = proof(typed(body), hexapod_case)
    assert status(result, "acceleration, untimed moves") == "enforced by controller"
    assert status(result, "strut acceleration, untimed moves") == "follows from what the controller enforces"
    assert status(result, "jerk, untimed moves") == "NOT enforced"
    assert result.limits.to_json()["acceleration, untimed moves"]["ratio"] == pytest.approx(1.0)
    assert "acceleration" not in result.limits.to_json()
    assert result.relies_on == ("jerk", "strut acceleration")  # the latter on the way home from anywhere


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            timed([*there_and_back(), "G1 X0.02 F62000"]),
            r"line 26: the timed block takes 0.967\d* ms; LinuxCNC keeps times of 1 to 250 m",
        ),
        (timed([*there_and_back(), "G1 X0.02 F239"]), r"line 26: the timed block takes 251\.\d+ ms; LinuxCNC"),
    ],
)
def test_a_timed_block_that_the_controller_cannot_time_is_refused(body: str, words: str, hexapod_case: Case):
    with pytest.raises(ProgramError, match=words) as caught:
        proof(typed(body), hexapod_case)
    one_line(caught.value)


def test_the_untimed_way_home_does_not_hide_what_a_timed_path_reaches(hexapod_case: Case):
    alone = proof(typed(PATH), hexapod_case).limits.to_json()
    assert alone["acceleration"]["worst"] == pytest.approx(0.04, rel=0.5)
    assert alone["acceleration, way home"]["status"] == "NOT enforced"


def test_the_feed_home_is_held_to_the_velocity_limits_whatever_its_direction(hexapod_case: Case):
    fast = typed("", head=HEAD.replace("F3000", "F37000"))
    (violation,) = proof(fast, hexapod_case).violations
    assert (violation.line, violation.name) == (3, "feed to home")


@pytest.mark.parametrize("name", ["angular velocity", "strut velocity"])
def test_what_turns_on_the_way_home_from_an_unknown_pose_is_not_called_proven(name: str, hexapod_case: Case):
    """At a feed that counts X, Y and Z, A, B and C follow as fast as they have to: only the controller limits them."""
    limits = proof(typed(""), hexapod_case).limits.to_json()
    assert [v["status"] for k, v in limits.items() if k.startswith(name) and v["status"] == "proven"] == []
