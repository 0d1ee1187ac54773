"""Values are shown to the second digit of their standard deviation, and nothing is lost by it."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from identification.texts import carries_rods, parameter_words, std_text, two_digits, value_text, with_deviation


@pytest.mark.parametrize(
    ("value", "std", "shown"),
    [
        (31.8263431, 0.0023064, ("31.8263", "0.0023")),
        (4.36047e-05, 0.000250, ("0.00004", "0.00025")),
        (-0.00078, 0.0144, ("-0.001", "0.014")),
        (-0.0001, 0.0144, ("0.000", "0.014")),  # no minus before nothing
        (10.3394, 0.0996, ("10.34", "0.10")),
        (12345.678, 230.0, ("12346", "230")),
        (93.1, 0.0, ("93.1", "0.0")),
        (93.1, nan, ("93.1", "nan")),
        (93.1, inf, ("93.1", "inf")),
        (2.5e-12, 1.2e-13, ("2.5e-12", "1.2e-13")),
    ],
)
def test_values_end_where_their_deviation_does(value: float, std: float, shown: tuple[str, str]) -> None:
    assert (value_text(value, std), std_text(std)) == shown


def test_values_are_rounded_to_two_digits_of_their_deviation() -> None:
    assert with_deviation(0.77256, 0.634) == "0.77 ± 0.63"
    assert with_deviation(31.8834, 0.0571) == "31.883 ± 0.057"
    assert with_deviation(131.88, 12.3) == "132 ± 12"


@given(value=st.floats(-1e4, 1e4), std=st.floats(1e-7, 1e2))
def test_what_is_left_out_is_far_below_the_deviation(value: float, std: float) -> None:
    assert abs(float(value_text(value, std)) - value) <= 0.0501 * std + 1e-9
    assert float(std_text(std)) == pytest.approx(std, rel=0.0501)


def test_a_body_that_carries_rods_is_called_so():
    """Sensors at the drives cannot tell a rod's mass from a point mass in its platform joint."""
    at_drives, at_platform = ("m", "zC", "IC12", "h", "k", "d"), ("m", "zC", "IC12", "mu_1", "h_1", "k_1", "d_1")
    assert carries_rods(at_drives)
    assert not carries_rods(at_platform)
    assert not carries_rods(("m", "zC", "f_q0_1"))
    assert parameter_words("m", True) == "mass, platform with rods (m)"
    assert parameter_words("IC12", True) == "inertia xy, platform with rods (IC12)"
    assert parameter_words("f_q0_2", True) == "offset of channel 2 (f_q0_2)"
    assert parameter_words("h", True) == "first moment of a rod (h)"
    assert parameter_words("h_3") == "first moment of a rod, strut 3 (h_3)"
    assert parameter_words("tP") == "Coulomb friction of a platform joint (tP)"


@pytest.mark.parametrize(
    ("value", "shown"), [(0.034, "0.034"), (7.0, "7"), (12.3, "12"), (99.7, "100"), (102.0, "102"), (5120.4, "5120")]
)
def test_large_numbers_have_no_exponent(value: float, shown: str) -> None:
    assert two_digits(value) == shown
