"""Numbers in programs: plain decimals as RS-274 wants them."""

import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cases.base.units import DEG, MM
from identification.motion.motion import Standstill
from postprocessors.blocks import Blocks, ToHome
from tests.postprocessors.programs import HOME, linuxcnc_text, path_through, programs

PLAIN = re.compile(r"-?(0|[1-9]\d*)(\.\d*[1-9])?")


def words(text: str) -> list[tuple[str, str]]:
    """Letter and number of every word outside comments and checks of home."""
    lines = [line for line in re.sub(r"\(.*?\)", "", text).splitlines() if not line.startswith("o1")]
    return [(w[0], w[1:]) for line in lines for w in line.split()]


@given(program=programs())
def test_every_number_is_a_plain_decimal_without_exponent_comma_negative_zero_or_trailing_zeros(
    program: Blocks,
):
    for letter, number in words(linuxcnc_text(program)):
        assert letter in "GMXYZABCFPQ"
        assert PLAIN.fullmatch(number), letter + number
        assert number != "-0"


@given(
    exponent=st.integers(-300, 5),
    mantissa=st.floats(-9.9, 9.9),
    axis=st.integers(0, 5),
    seconds=st.floats(0.0, 1e6, exclude_min=True),
)
def test_a_pose_and_a_dwell_are_written_to_their_last_decimal(
    exponent: int, mantissa: float, axis: int, seconds: float
):
    pose = HOME.copy()
    pose[axis] = mantissa * 10.0**exponent
    text = linuxcnc_text((ToHome(pose, 0.05), Standstill(pose, seconds)))
    number = float(dict(words(text))["XYZABC"[axis]])
    unit, decimals = (MM, 5) if axis < 3 else (DEG, 6)
    assert abs(number - pose[axis] / unit) <= 0.5 * 10.0**-decimals * (1 + 1e-9) + abs(number) * 1e-15
    assert abs(float(dict(words(text))["P"]) - seconds) <= 0.5e-6 * (1 + 1e-9) + seconds * 1e-15


def test_a_coordinate_that_rounds_to_nothing_is_zero_not_negative_zero():
    tiny = HOME + np.array([-1e-12, 1e-12, 0.0, -1e-12, 1e-12, 0.0])
    path = path_through("tiny", np.array([0.0, 0.1]), np.vstack([HOME, tiny]))
    assert "G1 X0 Y0 Z900 A0 B0 C0 F600" in linuxcnc_text((path,)).splitlines()
