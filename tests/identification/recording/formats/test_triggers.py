"""A trigger is a switch, a voltage, or a bit; one that never switches marks nothing."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from identification.identify import identify
from identification.recording.recording import Recording, read
from tests.helpers import one_line, tells
from tests.identification.recording.formats.loaded_hexapod import MASS, run
from tests.identification.recording.formats.runs import NAMES, Truth, case_with, csv, written

RUN = Truth()
ON = (np.arange(RUN.count) >= 10) & (np.arange(RUN.count) < 30)


def recorded(values: np.ndarray, folder: Path, **keys: object) -> Recording:
    text = csv(np.column_stack([RUN.numbers(), values]), [*NAMES, "bits" if keys else "trigger"])
    return read(written(folder, text), case_with(**keys))


@pytest.mark.parametrize("level", [0.0, 1.0, 24.0, 65535.0])
def test_a_trigger_that_never_switches_marks_nothing_and_says_so(level: float, tmp_path: Path) -> None:
    recording = recorded(np.full(RUN.count, level), tmp_path)
    assert recording.trigger is None
    (said,) = map(str, recording.findings)
    assert tells(said, "never switches", f"{level:g}")


@pytest.mark.parametrize("level", [0.0, 24.0])
def test_the_noise_of_a_voltage_is_no_switch(level: float, tmp_path: Path) -> None:
    noise = 0.03 * np.random.default_rng(0).normal(size=RUN.count)
    assert recorded(level + noise, tmp_path).trigger is None
    np.testing.assert_array_equal(recorded(24.0 * ON + noise, tmp_path).trigger, ON)


@pytest.mark.parametrize("level", [-1.0, -24.0])
def test_a_level_below_0_is_on(level: float, tmp_path: Path) -> None:
    """Languages whose TRUE has all bits set write -1."""
    np.testing.assert_array_equal(recorded(level * ON, tmp_path).trigger, ON)


def test_a_voltage_of_two_steps_of_its_converter_that_stays_high_is_no_switch(tmp_path: Path) -> None:
    assert recorded(np.where(np.arange(RUN.count) % 2, 24.02, 23.97), tmp_path).trigger is None


def test_a_bit_of_a_bit_field_is_a_trigger(tmp_path: Path) -> None:
    """Bit 0 is the program's, bit 8 a gripper's that is on, bit 3 something else that switches."""
    other = 8.0 * (np.arange(RUN.count) % 7 == 3)
    recording = recorded(256.0 + ON + other, tmp_path, trigger={"column": "bits", "bit": 0})
    np.testing.assert_array_equal(recording.trigger, ON)


def test_the_only_bit_that_changes_needs_no_key(tmp_path: Path) -> None:
    recording = recorded(256.0 + 4.0 * ON, tmp_path)
    np.testing.assert_array_equal(recording.trigger, ON)
    (said,) = map(str, recording.findings)
    assert tells(said, "bit 2")


def test_of_several_bits_the_message_says_which_change(tmp_path: Path) -> None:
    other = 8.0 * (np.arange(RUN.count) % 7 == 3)
    with pytest.raises(
        RecordingError, match=r"is not a level of a switch; .*bits 0, 3 change.*recording\.trigger"
    ) as caught:
        recorded(256.0 + ON + other, tmp_path)
    one_line(caught.value)


def test_a_voltage_has_no_bits(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"bits: 0\.5 has no bits; leave recording\.trigger\.bit out"):
        recorded(0.5 * ON, tmp_path, trigger={"column": "bits", "bit": 0})


T = np.arange(1001) * 0.004
MOTION = (T > 0.3) & (T < 3.7)


@pytest.mark.parametrize(
    "on",
    [
        ~MOTION,
        (T > 0.01) & (T < 0.04),
        ((T > 0.01) & (T < 0.04)) | ((T > 3.95) & (T < 3.98)),
        ((T > 0.3) & (T < 0.33)) | ((T > 3.7) & (T < 3.72)),
    ],
    ids=["off in motion", "pulse before", "pulses before and after", "pulses within"],
)
def test_a_trigger_that_is_on_without_the_motion_marks_nothing_and_the_motion_is_evaluated(
    on: np.ndarray, tmp_path: Path
) -> None:
    """Inputs that are active low and pulses at both ends are as usual as a switch that stays on."""
    truth = run(T)
    text = csv(np.column_stack([T, truth.struts * 1e3, truth.forces, on]), [*NAMES, "trigger"])
    result = identify(read(written(tmp_path, text), case_with()), case_with())
    assert abs(result["m"].value - MASS) < 4.0 * result["m"].reported
    (said,) = (f for f in result.findings if f.kind == "window")
    assert said.severity == "warning"
    assert tells(said.sentence, "trigger", f"{on.sum() * 0.004:.2g} s")
    assert not any("record until the machine rests" in warning for warning in result.warnings)
