"""The table [recording] of a case: what a file's writer leaves open is stated, and checked."""

from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import CaseError
from cases.recording_format import COLUMNS
from cases.schema import Case, load_case
from tests.cases.editing import edited
from tests.helpers import one_line

DRIVES = "drives = { sign = [1, 1, 1, 1, 1, 1], offset_mm = [0, 0, 0, 0, 0, 0]"
TURN = "mounting = [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]]"
HAL = 'format = "halsampler"'
SCOPE = 'format = "twincat-scope"'
TRACE = 'format = "sinumerik-trace"\ndelimiter = ";"\ndecimal = ","\nheader_rows = 3\nclock = { unit = "ms" }'


def with_recording(folder: Path, lines: str) -> Case:
    return load_case(edited(folder, "[recording]\n", f"[recording]\n{lines}\n"))


def test_what_is_not_stated_is_as_hexcite_writes_it(hexapod_case: Case) -> None:
    form = hexapod_case.recording
    assert form.format == "csv"
    assert form.clock_unit == "s"
    assert form.tick == 1.0
    assert [form.file_name(c) for c in COLUMNS] == list(COLUMNS)
    units = {"t_s": 1.0, "l3_mm": 1e-3, "x_mm": 1e-3, "f6_N": 1.0, "mz_Nm": 1.0, "r11": 1.0}
    assert {c: form.factor(c) for c in units} == units
    assert form.factor("a_deg") == np.pi / 180.0


@pytest.mark.parametrize(("unit", "tick"), [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("filetime", 1e-7)])
def test_a_unit_of_the_clock_is_a_time(unit: str, tick: float, tmp_path: Path) -> None:
    assert with_recording(tmp_path, f'clock = {{ unit = "{unit}", period_ms = 2.0 }}').recording.tick == tick


def test_the_scope_counts_milliseconds_unless_the_case_says_otherwise(tmp_path: Path) -> None:
    assert with_recording(tmp_path, f'{SCOPE}\ndecimal = ","').recording.clock_unit == "ms"


def test_a_column_has_the_unit_of_its_group(tmp_path: Path) -> None:
    form = with_recording(tmp_path, 'units = { struts = "m", forces = "kN", angles = "rad" }').recording
    columns = ("l1_mm", "f3_N", "fx_N", "mx_Nm", "b_deg", "x_mm")
    assert [form.factor(c) for c in columns] == [1.0, 1e3, 1e3, 1.0, 1.0, 1e-3]


def test_drives_and_accelerometer_are_in_si(tmp_path: Path) -> None:
    drives = "drives = { order = [2, 1, 3, 4, 5, 6], sign = [1, -1, 1, 1, 1, 1], offset_mm = [1, 2, 3, 4, 5, 6] }"
    form = with_recording(tmp_path, f"{drives}\naccelerometer = {{ scale_m_s2 = 9.8, {TURN} }}").recording
    assert form.drives.index == [1, 0, 2, 3, 4, 5]
    np.testing.assert_allclose(form.drives.offset, [0.001, 0.002, 0.003, 0.004, 0.005, 0.006])
    np.testing.assert_allclose(form.accelerometer.matrix @ [1.0, 2.0, 3.0], [-19.6, 29.4, -9.8])


def test_a_complete_trace_is_accepted(tmp_path: Path) -> None:
    assert with_recording(tmp_path, TRACE).recording.header_rows == 3


# mistake -> lines of [recording], key, what the message says
MISTAKES: dict[str, tuple[str, str, str]] = {
    "unknown format": ('format = "excel"', "recording.format", "'excel': .*'csv', 'halsampler', 'twincat-scope'"),
    "unknown column": ('columns = { l7_mm = "x" }', "recording", "'l7_mm' is none of our columns; they are t_s, l1_mm"),
    "one column for two": ('columns = { l1_mm = "x", l2_mm = "x" }', "recording", "maps 'x' to two of our columns"),
    "a maker": ('orientation = "KUKA"', "recording", "'KUKA' is not known; KUKA A B C: 'zyx intrinsic'"),
    "an order alone": ('orientation = "xyz"', "recording", "'xyz' is not known; give an order of three"),
    "scale of no column": ("scale = { F1 = 2.0 }", "recording", "scale: 'F1' is none of our columns of numbers"),
    "scale that makes all equal": ("scale = { f1_N = 0.0 }", "recording", "scale.f1_N is 0"),
    "offset of the clock": ("offset = { t_s = 1.0 }", "recording", "offset: 't_s' is none of our columns of numbers"),
    "time that runs back": ("scale = { t_s = -1.0 }", "recording", "scale.t_s is below 0"),
    "unit of nothing": ('units = { strut = "m" }', "recording.units.strut", "'struts', 'drives'"),
    "unit of another kind": ('units = { struts = "N" }', "recording", "units.struts = 'N' is not known; give mm, m"),
    "two characters between numbers": ('delimiter = ";;"', "recording.delimiter", "';;': is not one character"),
    "a letter between numbers": ('delimiter = "x"', "recording.delimiter", "'x': is not one character"),
    "another decimal sign": ('decimal = "\'"', "recording.decimal", "'.' or ','"),
    "header rows below zero": ("header_rows = -1", "recording.header_rows", "-1: .*greater than or equal to 0"),
    "half a header row": ("header_rows = 1.5", "recording.header_rows", "1.5: "),
    "names below the header": ("header_rows = 2\nnames_row = 3", "recording", "names_row = 3 is not among .* = 2 "),
    "unknown clock": ('clock = { unit = "day" }', "recording.clock.unit", "'day': .*'s', 'ms', 'us', 'ns', 'f"),
    "period of nothing": ("clock = { period_ms = 0.0 }", "recording.clock.period_ms", "0.0: .*greater than 0"),
    "shift of nothing": ("clock = { offset_s = { strut = 1.0 } }", "recording.clock.offset_s.strut", "strut"),
    "sampler without names": (HAL, "recording", "column_names is missing; files of halsampler"),
    "sampler without period": (f'{HAL}\ncolumn_names = ["l1_mm"]', "recording", "clock.period_ms is missing; fi"),
    "trace without delimiter": (TRACE.replace('delimiter = ";"\n', ""), "recording", "delimiter is missing; files"),
    "trace without decimal sign": (TRACE.replace('decimal = ","\n', ""), "recording", "decimal is missing; files"),
    "trace without header rows": (TRACE.replace("header_rows = 3\n", ""), "recording", "header_rows is missing; f"),
    "trace without clock": (TRACE.split("clock")[0], "recording", "clock.unit is missing; files of sinumerik-trace"),
    "drives without sign": ("drives = { offset_mm = [0, 0, 0, 0, 0, 0] }", "recording.drives.sign", "is missing"),
    "a drive twice": (f"{DRIVES}, order = [1, 1, 3, 4, 5, 6] }}", "recording.drives", "does not name each of the "),
    "five drives": (f"{DRIVES}, order = [1, 2, 3, 4, 5] }}", "recording.drives.order", "is missing|has 5 entries"),
    "a sign that scales": (f"{DRIVES.replace('[1,', '[2,')} }}", "recording.drives", "may hold 1 and -1 only"),
    "mounting that mirrors": (
        f"accelerometer = {{ scale_m_s2 = 9.8, {TURN.replace('-1.0, 0.0]', '1.0, 0.0]', 1)} }}",
        "recording.accelerometer",
        "mounting is not a rotation .off by 2",
    ),
    "accelerometer without scale": (f"accelerometer = {{ {TURN} }}", "recording.accelerometer.scale_m_s2", "missing"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_its_key(mistake: str, tmp_path: Path) -> None:
    lines, key, says = MISTAKES[mistake]
    with pytest.raises(CaseError, match=says) as caught:
        with_recording(tmp_path, lines)
    assert one_line(caught.value).startswith(f"{tmp_path / 'case.toml'}: {key}")
