"""What cannot be planned is refused before anything is computed, with the value and a remedy."""

import re
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases.base.errors import HexciteError
from cases.schema import Case
from identification.estimation.criteria import Criterion
from planner.families.settings import USUAL_PERIOD, Fourier, PointToPoint, Spline, family_class
from planner.request import PoseRequest, Request
from tests.helpers import one_line


def requested(family: str, settings: dict[str, Any]) -> Request:
    own = {name: settings[name] for name in ("order", "period", "moves", "knots") if name in settings}
    return Request(family_class(family)(**own), **{k: v for k, v in settings.items() if k not in own})


def test_an_unknown_family_is_named_with_those_that_are_known():
    with pytest.raises(HexciteError, match=r"family 'chirp'.*choose manual, fourier, ptp, spline"):
        family_class("chirp")


@pytest.mark.parametrize(
    ("setting", "value", "words"),
    [
        ("criterion", "E", "criterion 'E' is unknown; choose A, D, K, N"),
        ("order", 0, "order 0 is outside 1 to 7"),
        ("order", 50, "order 50 is outside 1 to 7"),
        ("period", 0.0, "period 0 is outside 0.01 to 600; choose about 2 s"),
        ("period", -3.0, "period -3"),
        ("period", float("nan"), "period nan"),
        ("period", float("inf"), "period inf"),
        ("duration", 0.0, "duration 0 s is not positive; choose about 12 s"),
        ("duration", -12.0, "duration -12 s is not positive"),
        ("duration", float("nan"), "duration nan s"),
        ("duration", float("inf"), "duration inf s"),
        ("duration", float("-inf"), "duration -inf s is not at most 600 s"),
        ("period", 1e-320, "outside 0.01 to 600; choose about 2 s"),
        ("duration", 3e9, "duration 3e+09 s"),
        ("starts", 0, "0 starts; choose starts 1 to 1000"),
        ("starts", 1001, "1001 starts"),
        ("seed", -1, "seed -1 is negative; choose 0 or more"),
    ],
)
def test_a_setting_outside_its_range_is_named_with_its_value(setting: str, value: object, words: str):
    with pytest.raises(HexciteError, match=re.escape(words)) as caught:
        requested("fourier", {setting: value})
    one_line(caught.value)


@pytest.mark.parametrize(
    ("duration", "chosen"), [(10.0, "choose 9 s"), (1.0, "choose 3 s"), (0.0, "choose 3 s"), (-12.0, "choose 3 s")]
)
def test_the_duration_is_a_whole_number_of_stated_periods(duration: float, chosen: str):
    with pytest.raises(HexciteError, match=f"{duration:g} s .*periods of 3 s; {chosen}") as caught:
        Request(Fourier(period=3.0), duration=duration)
    one_line(caught.value)


@given(duration=st.floats(0.1, 600.0), order=st.integers(1, 7))
def test_a_period_that_is_not_stated_fits_any_duration(duration: float, order: int):
    family = Fourier(order=order)
    Request(family, duration)
    period = family.base_period(duration)
    periods = round(duration / period)
    assert periods * period == pytest.approx(duration, rel=1e-12)
    assert periods == family.fewest or abs(period / USUAL_PERIOD - 1.0) <= 1 / 4
    Request(Fourier(order=order, period=period), duration)


def test_order_1_needs_two_periods_for_it_is_led_in_and_out_of_over_one():
    Request(Fourier(order=1, period=3.0), duration=6.0)
    with pytest.raises(HexciteError, match=r"order 1.* two.*duration 6\b"):
        Request(Fourier(order=1, period=3.0), duration=3.0)


def test_a_whole_number_of_periods_may_be_a_rounded_one():
    Request(Fourier(period=0.1), duration=0.3)  # 0.3 / 0.1 is 2.9999999999999996
    Request(Fourier(period=0.7), duration=4.9)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"moves": 7}, "moves 7 is outside 8 to 64"),
        ({"moves": 65}, "moves 65 is outside 8 to 64"),
        ({"duration": float("nan")}, "duration nan s"),
        ({"duration": -1.0}, "duration -1 s is not positive"),
    ],
)
def test_moves_and_their_duration_must_fit(settings: dict[str, float], words: str):
    with pytest.raises(HexciteError, match=re.escape(words)) as caught:
        requested("ptp", settings)
    one_line(caught.value)


@pytest.mark.parametrize(("duration", "moves"), [(2.4, 8), (6.0, 20), (12.0, 40), (60.0, 64)])
def test_moves_that_are_not_stated_fit_the_duration(duration: float, moves: int, hexapod_case: Case):
    assert PointToPoint().count(hexapod_case, duration) == moves


@pytest.mark.parametrize(("duration", "knots"), [(2.0, 20), (12.0, 120), (60.0, 150)])
def test_knots_that_are_not_stated_fit_the_duration(duration: float, knots: int):
    Request(Spline(), duration)
    assert Spline().intervals(duration) == knots


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"knots": 19}, "knots 19 is outside 20 to 150"),
        ({"knots": 151}, "knots 151"),
        ({"duration": 0.5}, "duration 0.5 s is too short for a spline"),
        ({"duration": float("nan")}, "duration nan s"),
    ],
)
def test_a_spline_and_its_duration_must_fit(settings: dict[str, float], words: str):
    with pytest.raises(HexciteError, match=re.escape(words)) as caught:
        requested("spline", settings)
    one_line(caught.value)


@pytest.mark.parametrize("request_of", [Request, PoseRequest])
def test_a_letter_will_do_for_a_criterion(request_of: type[Request] | type[PoseRequest]):
    assert all(request_of(criterion=str(letter)).criterion is letter for letter in Criterion)
