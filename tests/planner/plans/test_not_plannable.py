"""What cannot be planned is refused before anybody is told that planning begins, and nothing is written."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from cases.base.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.estimation.criteria import box_middle
from identification.limits.proof import prove
from identification.motion.motion import Standstill
from planner.families.fourier import FourierFamily
from planner.families.settings import Fourier, PointToPoint
from planner.plans.making import require_plannable
from planner.request import Request
from planner.search.feasibility import keep_limits, remedy
from tests.helpers import examples, one_line
from tests.hexcite.command_line import call, refused
from tests.postprocessors.changed_case import changed
from tests.random_start import random_start

BEHIND_HOME = {"name": "vice", "x_mm": [-30.0, 30.0], "y_mm": [-30.0, 30.0], "z_mm": [880.0, 920.0]}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--model", "11"), ("model 11", "choose 0, 1")),
        (("--model", "-1"), ("model -1",)),
        (("--payload", "6"), ("payloads.weights", "are 5", "6 cannot be mounted")),
        (("--payload", "-1"), ("'-1'", "neither a number of payloads nor a range", "0-5")),
        (("--payload", "3-9"), ("payloads.weights", "9 cannot be mounted", "choose 0 to 5")),
        (("--payload", "4-2"), ("payloads 4-2 are not a range",)),
        (("--payload", "some"), ("some", "give 2, or 0-5")),
        (
            ("--family", "fourier", "--period", "0.1", "--duration", "0.1"),
            ("period 0.1 s is too short", "50 Hz", "20 Hz", "--period 0.25"),
        ),
        (
            ("--family", "fourier", "--duration", "0.1"),
            ("period 0.1 s is too short", "50 Hz", "20 Hz", "--duration 0.25 or more"),
        ),
        (
            ("--family", "fourier", "--period", "0.2"),
            ("period 0.2 s is too short", "25 Hz", "20 Hz", "--period 0.25 or more"),
        ),
        (
            ("--family", "fourier", "--period", "5"),
            ("duration 12 s is not a whole number of periods of 5 s", "choose 10 s"),
        ),
        (("--duration", "0"), ("duration 0 s", "choose about 12 s")),
        (("--family", "ptp", "--duration", "0.5"), ("too short for 8 moves", "choose at least 0.8 s")),
        (
            ("--family", "ptp", "--moves", "40", "--duration", "2.4"),
            ("too short for 40", "4 s, or fewer --moves"),
        ),
        (("--family", "spline", "--duration", "1"), ("too short for a spline", "2 s")),
        (("--for", "fanuc"), ("controller 'fanuc' is unknown", "choose virtual, linuxcnc, sinumerik")),
        (
            ("--for", "linuxcnc"),
            ("limits.motion", "jerk", "linuxcnc does not limit", "--without jerk", "--for virtual"),
        ),
        (("--without", "jerk"), ("none is named", "--for linuxcnc", "leave --without out")),
        (("--without", "jerk", "--for", "sinumerik"), ("sinumerik limits the jerk", "leave it out")),
        (("--without", "velocity", "--for", "linuxcnc"), ("'velocity'", "choose jerk")),
        (("--without", "jerk", "--family", "fourier"), ("--without does nothing", "--family ptp")),
        (("--for", "linuxcnc", "--family", "spline"), ("--for does nothing", "spline", "leave it out", "--family ptp")),
        (
            ("--for", "linuxcnc", "--without", "jerk", "--duration", "0.04"),
            ("too short for 8 moves", "at least 0.048 s"),
        ),
        (("--family", "manual", "--duration", "8"), ("--duration does nothing with --family manual", "leave it out")),
        (("--family", "manual", "--starts", "3"), ("--starts does nothing", "fourier, ptp, spline")),
        (("--family", "ptp", "--order", "5"), ("--order does nothing with --family ptp", "choose --family fourier")),
        (("--family", "ptp", "--sequence", "s.toml"), ("--sequence does nothing", "manual")),
        (("--family", "fourier", "--moves", "12"), ("--moves does nothing with --family fourier", "ptp")),
        (("--knots", "60", "--moves", "20"), ("does nothing with --family", "leave it out")),
        (("--family", "manual", "--sequence", "none.toml"), ("none.toml", "cannot be read", "TOML file of steps")),
        (("--family", "manual", "--sequence", "none.csv"), ("none.csv", "cannot be read", "CSV of poses")),
        (("--family", "manual", "--sequence", "."), ("cannot be read (Is a directory)", "TOML file of steps")),
    ],
)
def test_a_wrong_request_is_refused_before_planning_begins(
    arguments: tuple[str, ...], words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """`refused` asserts that nothing stands on standard output, not even that planning begins."""
    monkeypatch.chdir(tmp_path)
    line = refused("plan", "hexapod", *arguments)
    for word in words:
        assert word in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["", "title = 3", "title = 't'\nsteps = []", "x_mm = [", "\x00"])
def test_a_sequence_that_is_none_is_refused_before_planning_begins(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(text)
    answer = call("plan", "hexapod", "--family", "manual", "--sequence", "s.toml")
    assert (answer.code, answer.out) == (1, "")
    assert all(line.startswith("hexcite: s.toml") for line in answer.err.splitlines())
    assert [p.name for p in tmp_path.iterdir()] == ["s.toml"]


def test_a_step_that_is_none_is_one_problem(tmp_path: Path):
    (tmp_path / "s.toml").write_text("title = 't'\nsteps = [{ x_mm = 50.0, speed = 3.0 }]\n")
    line = refused("plan", "hexapod", "--family", "manual", "--sequence", tmp_path / "s.toml")
    assert "s.toml: steps[1].speed: 3.0: input should be less than or equal to 1" in line


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "strut_length_mm = [720.0, 1460.0]",
            "strut_length_mm = [1100.0, 1460.0]",
            (
                "reaches 1039 mm, limit 1100",
                "widen limits.motion.strut_length_mm and workspace.strut_length_mm or move",
            ),
        ),
        ("z_mm = 900.0", "z_mm = 2900.0", ("strut length", "reaches 2946 mm", "limit 1460", "move home")),
        ("range_N = 5000.0", "range_N = 100.0", ("sensor force", "5 payloads", "limit 80", "sensors.range_N")),
        (
            "[limits.motion]",
            '[[workspace.keep_out]]\nname = "vice"\nx_mm = [-30.0, 30.0]\ny_mm = [-30.0, 30.0]\n'
            "z_mm = [880.0, 920.0]\n\n[limits.motion]",
            ("vice", "origin"),
        ),
    ],
)
def test_limits_that_forbid_even_to_stand_are_named_before_planning_begins(
    old: str, new: str, words: tuple[str, ...], hexapod_file: Path
):
    hexapod_file.write_text(hexapod_file.read_text().replace(old, new, 1))
    line = refused("plan", hexapod_file, "-o", hexapod_file.parent / "plan")
    for word in words:
        assert word in line
    assert not (hexapod_file.parent / "plan").exists()


def test_a_box_around_the_start_is_to_be_made_smaller(hexapod_case: Case):
    case = changed(hexapod_case, workspace__keep_out=[BEHIND_HOME])
    with pytest.raises(InfeasiblePlan, match=r"distance from vice \(origin\) .*workspace\.keep_out") as caught:
        require_plannable(Request(), case)
    one_line(caught.value)


def test_every_limit_has_a_remedy_that_names_keys_of_the_case(hexapod_case: Case):
    case = changed(hexapod_case, workspace__keep_out=[BEHIND_HOME])
    checks = prove(Standstill(case.machine.home.vector, 1.0), case, 1.0).checks
    assert len(checks) == 17
    for check in checks:
        for key in re.findall(r"[a-z_.]*[a-z]_[a-zA-Z0-9_]+|limits\.motion", remedy(check, hexapod_case)):
            *tables, last = key.split(".")
            place: object = case
            for table in tables:
                place = getattr(place, table)
            assert not tables or hasattr(place, last), key
        assert re.search(r"workspace\.|limits\.motion|sensors\.", remedy(check, hexapod_case))


def test_moves_need_their_controller_cycles(hexapod_case: Case):
    case = changed(hexapod_case, controller__cycle_ms=50.0)
    words = r"12 s is too short for 40 moves: .* each takes 0.6 s; choose at least 24 s, or fewer moves"
    with pytest.raises(HexciteError, match=words) as caught:
        require_plannable(Request(PointToPoint()), case)
    one_line(caught.value)
    require_plannable(Request(PointToPoint(moves=40), duration=24.0), case)
    require_plannable(Request(PointToPoint(moves=20)), case)


def test_moves_need_the_time_in_which_accelerations_rise(hexapod_case: Case):
    """At 100 m/s^3 it takes 0.03 s to 3 m/s^2, at 200 rad/s^3 0.025 s to 5 rad/s^2; a move rises and falls twice."""
    request = Request(PointToPoint(moves=40), duration=4.0)
    require_plannable(request, hexapod_case)
    softer = changed(
        hexapod_case, limits__motion__jerk_m_s3=[50.0] * 3, limits__motion__angular_jerk_rad_s3=[100.0] * 3
    )
    with pytest.raises(HexciteError, match=r"\b4 s .*40 moves: .*0\.2 s; .*at least 8 s, .*fewer moves") as caught:
        require_plannable(request, softer)
    one_line(caught.value)


def test_what_no_filter_holds_back_may_have_any_period(hexapod_case: Case):
    require_plannable(Request(Fourier(period=0.25), duration=0.25), hexapod_case)
    case = changed(hexapod_case, recording__filter_cutoff_Hz=10.0)
    with pytest.raises(HexciteError, match=r"order 5 .*20 Hz, .*up to 5 Hz"):
        require_plannable(Request(Fourier(period=0.25), duration=0.25), case)


def test_a_motion_is_drawn_back_out_of_a_small_box_close_to_its_middle(hexapod_case: Case):
    """A distance does not shrink with the motion: what the share of the limit suggests is far too little."""
    near = {"name": "post", "x_mm": [5.0, 900.0], "y_mm": [-900.0, 900.0], "z_mm": [905.0, 2000.0]}
    case = changed(hexapod_case, workspace__keep_out=[near])
    middle, half = box_middle(case)
    family = FourierFamily(2, 3.0, 1, middle, half)
    some = random_start(family, np.random.default_rng(0), lambda unknowns: float(abs(unknowns).max()))
    assert not prove(family.motion(some), case, 1000.0).kept
    kept, _ = keep_limits(case, family, some, 1000.0)
    assert prove(family.motion(kept), case, 1000.0).kept
    assert abs(kept).max() > 1e-6


NUMBERS = st.one_of(
    st.integers(-(10**30), 10**30).map(str),
    st.floats(width=64).map(repr),
    st.sampled_from(["", " ", "0", "-0", "1e309", "-1", "inf", "nan", "0x10", "1_0", "½", "五", "1,5", "--", "None"]),
)
WORDS = st.one_of(
    st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=12),
    st.sampled_from(["m=", "m=1", "m=1kg=2", "=kg", "m=nankg", "m=infkg", "m=1e-0kg"]),
)
# Each value alone would keep the command from starting: what is accepted must not set two processors to work.
STOPPED = ("plan", "hexapod", "--payload", "99")


@given(
    option=st.sampled_from(
        ["--duration", "--order", "--period", "--starts", "--seed", "--model", "--moves", "--knots"]
    ),
    value=NUMBERS,
    family=st.sampled_from(["fourier", "ptp", "spline", "manual"]),
)
@example("--duration", "-inf", "fourier")
@example("--duration", "-inf", "ptp")
@example("--duration", "-inf", "spline")
@example("--duration", "inf", "spline")
@example("--period", "1e-320", "fourier")
@example("--seed", "1" + "0" * 400, "ptp")
@settings(max_examples=examples(25), derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_number_for_any_option_is_taken_or_refused_in_one_line(option: str, value: str, family: str):
    answer = call(*STOPPED, "--family", family, f"{option}={value}")
    assert answer.out == ""
    if answer.code == 2:
        assert option in answer.err
        assert "Traceback" not in answer.err
    else:
        answer.refusal()


@given(option=st.sampled_from(["--criterion", "--family", "--sequence", "--output"]), value=WORDS)
@settings(max_examples=examples(25), derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_any_word_for_any_option_is_taken_or_refused_in_one_line(option: str, value: str):
    answer = call(*STOPPED, f"{option}={value}")
    assert answer.out == ""
    answer.refusal()


@given(
    command=st.sampled_from([("poses", "hexapod", "--model", "9"), ("bound", "hexapod", "--model", "11")]),
    option=st.sampled_from(["--count", "--candidates", "--seed", "--model", "--time-limit"]),
    value=NUMBERS,
)
@settings(max_examples=examples(20), derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_poses_and_bound_refuse_likewise(command: tuple[str, ...], option: str, value: str):
    arguments = [command[0], "ft_wrist", *command[2:]] if option == "--model" else [*command]
    answer = call(*arguments, f"{option}={value}")
    assert answer.out == ""
    assert answer.code in (1, 2)
    if answer.code == 1:
        answer.refusal()
    assert "Traceback" not in answer.err
