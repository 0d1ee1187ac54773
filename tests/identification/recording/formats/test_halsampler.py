"""What LinuxCNC's halsampler writes; the samples below are its own output (2.9, a sine on pin 0, two more pins)."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from identification.looks.looking import look
from identification.recording.formats.reading import read_tables
from identification.recording.recording import read
from tests.helpers import refused_at
from tests.identification.recording.formats.runs import HEXAPOD, NAMES, Truth, case_with, written

TAGGED = "0 3.877872 0 0 \n1 7.751916 0 0 \n2 11.618310 0 0 \n3 15.473239 0 0 \n"
PLAIN = "overrun\n102.108713 0 0 \n104.238016 0 0 \n106.264448 0 0 \n"
PINS = case_with(format="halsampler", column_names=["ax", "trigger", "unused"], clock={"period_ms": 1.0}).recording
RUN = Truth()


def sampled(numbers: np.ndarray, tagged: bool, first: int = 0) -> str:
    """As halsampler prints: six decimals, a blank behind every value."""
    lines = ("".join(f"{v:f} " for v in row) for row in numbers)
    return "".join(f"{k} {line}\n" if tagged else f"{line}\n" for k, line in enumerate(lines, first))


def test_samples_of_the_original_are_read(tmp_path: Path) -> None:
    (table,) = read_tables(written(tmp_path, TAGGED), PINS)
    np.testing.assert_array_equal(table.values["ax"], [3.877872, 7.751916, 11.61831, 15.473239])
    np.testing.assert_array_equal(table.stamps, [0, 1, 2, 3])
    assert table.tick == 1e-3


def test_an_overrun_at_the_top_is_no_loss(tmp_path: Path) -> None:
    """The samples before the first one that was asked for are reported as lost."""
    (table,) = read_tables(written(tmp_path, PLAIN), PINS)
    np.testing.assert_array_equal(table.stamps, [0, 1, 2])
    assert table.lines.place(0) == "line 2"


@pytest.mark.parametrize("tagged", [False, True])
def test_a_run_is_read_with_names_and_period_of_the_case(tagged: bool, tmp_path: Path) -> None:
    file = written(tmp_path, sampled(RUN.numbers()[:, 1:], tagged, first=500))
    case = case_with(format="halsampler", column_names=NAMES[1:], clock={"period_ms": 1.0})
    recording = read(file, case)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-12)
    np.testing.assert_allclose(recording.drives, RUN.struts, atol=1e-9)
    np.testing.assert_allclose(recording.forces, RUN.forces, atol=1e-6)


def test_a_pin_may_be_the_clock(tmp_path: Path) -> None:
    case = case_with(format="halsampler", column_names=NAMES)
    recording = read(written(tmp_path, sampled(RUN.numbers(), tagged=True)), case)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-12)


def test_numbers_of_samples_show_a_gap(tmp_path: Path) -> None:
    numbers = RUN.numbers()[:, 1:]
    text = sampled(numbers[:20], True) + "overrun\n" + sampled(numbers[20:], True, first=70)
    case = case_with(format="halsampler", column_names=NAMES[1:], clock={"period_ms": 1.0})
    recording = read(written(tmp_path, text), case)
    assert recording.t[20] - recording.t[19] == pytest.approx(51e-3)
    assert recording.step == pytest.approx(1e-3)
    assert recording.lost[19] == 50


WRONG = {
    "lost samples without numbers": (
        sampled(RUN.numbers()[:3, 1:], False) + "overrun\n" + sampled(RUN.numbers()[3:, 1:], False),
        r"line 4: LinuxCNC lost samples here .*; record with halsampler -t",
    ),
    "a pin too many": (sampled(np.ones((3, 15)), False), r"line 1: expected 12 columns, got 15"),
    "a pin too many, and real": (sampled(np.full((3, 13), 0.5), False), r"line 1: expected 12 columns, got 13"),
    "a pin too few": (sampled(np.ones((3, 11)), False), r"line 1: expected 12 columns, got 11"),
    "cut off": (sampled(RUN.numbers()[:, 1:], False)[:-30], r"line 40: expected .* cut off in its last line"),
    "a word": (sampled(RUN.numbers()[:, 1:], False) + "killed" + " 1" * 11 + " \n", r"line 41, l1_mm: 'killed' is"),
    "overruns only": ("overrun\noverrun\n", r"LinuxCNC lost samples"),
    "nan": (
        sampled(np.where(np.arange(12) == 6, np.nan, RUN.numbers()[:, 1:]), False),
        r"line 1, f1_N: is empty, like 40 of the 40 rows",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_damage_is_named_with_its_line(what: str, tmp_path: Path) -> None:
    text, message = WRONG[what]
    file = written(tmp_path, text)
    case = case_with(format="halsampler", column_names=NAMES[1:], clock={"period_ms": 1.0})
    with refused_at(file, message):
        read(file, case)


@pytest.mark.parametrize("tagged", [False, True])
@pytest.mark.parametrize("period", [1.0, 2.0])
def test_names_and_period_in_the_case_are_enough(tagged: bool, period: float, tmp_path: Path) -> None:
    """A blank behind each value says that it is halsampler's, whatever the case says of a format."""
    file = written(tmp_path, sampled(RUN.numbers()[:, 1:], tagged))
    recording = read(file, case_with(column_names=NAMES[1:], clock={"period_ms": period}))
    np.testing.assert_allclose(recording.t, RUN.t * period, atol=1e-12)
    np.testing.assert_allclose(recording.forces, RUN.forces, atol=1e-6)
    with pytest.raises(RecordingError, match=r"is a file of halsampler; .*clock\.period_ms is missing"):
        read(file, case_with(column_names=NAMES[1:]))


def test_look_knows_numbers_of_samples_and_overruns(tmp_path: Path) -> None:
    """What it proposes, with names and the period, reads the run, and lost samples are lost."""
    numbers = RUN.numbers()[:, 1:]
    text = "overrun\n" + sampled(numbers[:20], True, 7) + "overrun\n" + sampled(numbers[20:], True, first=30)
    file = written(tmp_path, text)
    seen = look(file, HEXAPOD)
    assert seen.settings["format"] == "halsampler"
    assert seen.settings["column_names"] == [f"column {k}" for k in range(1, 13)]
    assert "period_ms" in str(seen)
    settings = dict(seen.settings) | {"column_names": NAMES[1:], "clock": {"period_ms": 1.0}}
    recording = read(file, case_with(**settings))
    assert recording.t[20] - recording.t[19] == pytest.approx(1e-3)
    assert int(recording.missing.sum()) == 3
    np.testing.assert_allclose(np.delete(recording.forces, [20, 21, 22], 0), RUN.forces, atol=1e-6)


def test_a_case_may_name_the_number_of_the_sample_too(tmp_path: Path) -> None:
    file = written(tmp_path, sampled(RUN.numbers()[:, 1:], tagged=True))
    case = case_with(format="halsampler", column_names=["column 1", *NAMES[1:]], clock={"period_ms": 1.0})
    recording = read(file, case)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-12)
    np.testing.assert_allclose(recording.forces, RUN.forces, atol=1e-6)
