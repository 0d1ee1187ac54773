"""Targets: the shortest motion that meets them, or one line that says what can be reached."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from cases.errors import HexciteError, InfeasiblePlan, Interrupted
from cases.schema import Case
from planner.families.settings import Fourier, Manual, PointToPoint, Spline, family_class
from planner.library import shortest_plan
from planner.request import Request, parse_targets
from tests.helpers import one_line, tells


@dataclass(frozen=True)
class Found:
    """A stand-in for a plan."""

    request: Request
    predicted_std: dict[str, float]
    interrupted: bool = False

    @property
    def motion(self) -> SimpleNamespace:
        return SimpleNamespace(duration=self.request.duration)


def planner_with(rate: float, stopped: int = 0, failing: int = 0, by: type[BaseException] = Interrupted):
    """A stand-in whose motions gain information at a constant rate: std = rate / sqrt(duration).

    Ctrl-C ends the plan of number `stopped`; the plan of number `failing` ends in an exception.
    """
    asked: list[float] = []

    def make(request: Request) -> Found:
        asked.append(request.duration)
        if len(asked) == failing:
            raise by("no start led anywhere")
        worse = 2.0 if len(asked) == stopped else 1.0  # it would have gone on
        return Found(request, {"m": worse * rate / np.sqrt(request.duration), "zC": 1e-6}, len(asked) == stopped)

    return make, asked


def test_the_shortest_duration_that_meets_the_target_is_found_in_few_plans(hexapod_case: Case):
    make, asked = planner_with(0.1)
    plan = shortest_plan(Request(PointToPoint(), targets=("m=0.05kg", "zC=1mm")), hexapod_case, make)
    assert 4.0 <= plan.motion.duration < 4.2  # 0.1 / sqrt(4) = 0.05
    assert len(asked) <= 3
    assert plan.request.family.count(hexapod_case, plan.request.duration) == 14  # as many a second as in 12 s


def test_a_fourier_motion_lasts_whole_periods_where_one_is_stated(hexapod_case: Case):
    make, _ = planner_with(0.1)
    request = Request(Fourier(), targets=("m=0.05kg",))
    assert shortest_plan(replace(request, family=Fourier(period=3.0)), hexapod_case, make).motion.duration == 6.0
    assert 4.0 <= shortest_plan(request, hexapod_case, make).motion.duration < 4.2


def test_a_target_out_of_reach_says_what_is_reached_and_how_long_would_do(hexapod_case: Case):
    make, asked = planner_with(0.1)
    with pytest.raises(InfeasiblePlan) as caught:
        shortest_plan(Request(Spline(), targets=("m=10g",)), hexapod_case, make)
    message = one_line(caught.value)
    assert tells(message, "m=10g", "12 s", "28.9 g", "allow duration 104")
    assert asked == [12.0]


def test_the_duration_that_would_do_is_one_that_the_family_can_have(hexapod_case: Case):
    with pytest.raises(InfeasiblePlan, match=r"allow duration 105 .*target"):  # 35 periods of 3 s
        shortest_plan(Request(Fourier(period=3.0), targets=("m=10g",)), hexapod_case, planner_with(0.1)[0])


def test_a_target_that_no_motion_can_meet_is_called_so(hexapod_case: Case):
    with pytest.raises(InfeasiblePlan) as caught:
        shortest_plan(Request(PointToPoint(), targets=("m=1g",)), hexapod_case, planner_with(0.1)[0])
    message = one_line(caught.value)
    assert "28.9 g" in message
    assert tells(message, "600 s", "set a wider target")


def test_ctrl_c_in_a_shorter_plan_keeps_the_one_that_meets_the_targets(hexapod_case: Case):
    request = Request(PointToPoint(), targets=("m=0.05kg",))
    for make, asked in (planner_with(0.1, stopped=2), planner_with(0.1, failing=2)):
        plan = shortest_plan(request, hexapod_case, make)
        assert plan.motion.duration == 12.0
        assert plan.interrupted
        assert len(asked) == 2  # nothing is begun after it


def test_ctrl_c_before_the_targets_are_met_says_so_and_nothing_of_reach(hexapod_case: Case):
    request = Request(PointToPoint(), targets=("m=0.05kg",))
    with pytest.raises(Interrupted, match=r"0\.0577 kg, not m=0\.05kg.*nothing was written"):
        shortest_plan(request, hexapod_case, planner_with(0.1, stopped=1)[0])


def test_a_duration_in_which_nothing_is_found_is_too_short_and_no_reason_to_give_up(hexapod_case: Case):
    request = Request(PointToPoint(), targets=("m=0.05kg",))
    plan = shortest_plan(request, hexapod_case, planner_with(0.1, failing=2, by=InfeasiblePlan)[0])
    assert 4.0 < plan.motion.duration < 12.0


@pytest.mark.parametrize("family", ["ptp", "spline"])
def test_the_command_that_would_do_is_whole(family: str, hexapod_case: Case):
    with pytest.raises(InfeasiblePlan, match=r"allow duration 104 .*target"):
        shortest_plan(Request(family_class(family)(), targets=("m=10g",)), hexapod_case, planner_with(0.1)[0])


@pytest.mark.parametrize(
    ("word", "words"),
    [
        ("m", "is not understood; write target m=0.05kg"),
        ("m=0.05", "has no unit; give kg or g"),
        ("mass=0.05kg", "mass is not a parameter of model 9; choose from m, xC"),
        ("m=0.05mm", "unit mm does not fit m; give kg or g"),
        ("zC=3kg", "unit kg does not fit zC; give m or mm or um"),
        ("m=0kg", "is not one positive number"),
        ("m=-1kg", "is not one positive number"),
        ("m=1.2.3kg", "is not understood"),
        ("m=1e400kg", "is not one positive number"),
        ("", "is not understood"),
    ],
)
def test_a_target_that_makes_no_sense_is_refused_by_name(word: str, words: str, hexapod_case: Case):
    with pytest.raises(HexciteError) as caught:
        parse_targets((word,), hexapod_case, 9)
    assert words in one_line(caught.value)


def test_a_target_that_is_given_twice_is_refused(hexapod_case: Case):
    with pytest.raises(HexciteError, match=r"m=20g: m .*twice"):
        parse_targets(("m=10g", "zC=1mm", "m=20g"), hexapod_case, 9)


def test_units_are_turned_into_si(hexapod_case: Case):
    words = ("m=50g", "zC=0.3mm", "IC11=0.02kgm2", "IC33=0.02 kg m^2", "k0=2N/m", "k1=3Nm/m", "f_q0_1=1e-1N")
    found = {t.name: t.value for t in parse_targets(words, hexapod_case, 9)}
    expected = {"m": 0.05, "zC": 3e-4, "IC11": 0.02, "IC33": 0.02, "k0": 2.0, "k1": 3.0, "f_q0_1": 0.1}
    assert found == pytest.approx(expected)


def test_hand_made_motions_have_no_targets():
    with pytest.raises(HexciteError, match=r"targets .*family.*optimised"):
        Request(Manual(), targets=("m=0.05kg",))
