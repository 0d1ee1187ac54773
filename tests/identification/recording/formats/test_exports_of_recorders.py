"""Runs as recorders of force/torque sensors and controllers export them: the proposal reads what was recorded."""

from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import RecordingFormat
from cases.schema import Case
from identification.looks.looking import look
from identification.recording.formats.stated_rates import stated_step
from identification.recording.recording import Recording, read
from tests.helpers import one_line
from tests.mistaken.machines import run

ROWS = 400
BEGIN = datetime(2025, 11, 4, 1, 12, 9, tzinfo=UTC)
UNITS = [*["deg"] * 6, *["N"] * 3, *["Nm"] * 3]


@cache
def whole() -> Recording:
    return run("ur10_wrist", 3).recording


def blank_case() -> Case:
    """The robot's case, which says nothing of its recordings."""
    case = run("ur10_wrist", 3).case
    return case.model_copy(update={"recording": RecordingFormat.model_validate({"filter_cutoff_Hz": 20.0})})


def parts() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], joints [deg] and forces [N, N m]."""
    some = whole()
    assert some.t is not None
    assert some.drives is not None
    return some.t[:ROWS], np.degrees(some.drives[:ROWS]), some.forces[:ROWS]


def rows(*columns: np.ndarray, separator: str, decimal: str = ".", form: str = "%.7f") -> str:
    table = np.column_stack(columns)
    lines = (separator.join(form % value for value in row) for row in table)
    return "\n".join(line.replace(".", decimal) if decimal != "." else line for line in lines) + "\n"


def numbered(pattern: str) -> list[str]:
    return [pattern.replace("#", str(k)) for k in range(1, 7)]


def rtde_of_a_host() -> str:
    t, joints, forces = parts()
    names = ["pc_ts", "runtime_state", *(f"q_{k}" for k in range(6)), *(f"tcpf_{k}" for k in range(6))]
    state = np.full(ROWS, 2.0)
    return ",".join(names) + "\n" + rows(t + 1.76e9, state, np.radians(joints), forces, separator=",")


def datagrams() -> str:
    """Stamps of a host in ISO 8601, with and without a fraction, and numbers of datagrams."""
    t, joints, forces = parts()
    names = ["pc_time_iso", "rdt_sequence", "status", *numbered("J#_deg")]
    names += ["Fx_N", "Fy_N", "Fz_N", "Tx_Nm", "Ty_Nm", "Tz_Nm"]
    stamps = [(BEGIN + timedelta(seconds=float(s))).isoformat() for s in t]
    numbers = rows(np.arange(ROWS), np.zeros(ROWS), joints, forces, separator=",").splitlines()
    return ",".join(names) + "\n" + "\n".join(map(",".join, zip(stamps, numbers, strict=True))) + "\n"


def german_words() -> str:
    t, joints, forces = parts()
    names = ["Zeit  1 - Standardmessrate [s]", *numbered("Gelenk # [°]")]
    names += ["Kraft X [N]", "Kraft Y [N]", "Kraft Z [N]", "Moment X [N·m]", "Moment Y [N·m]", "Moment Z [N·m]"]
    head = "MESSDATEI_40\nStartzeit:\t27.11.2025 09:12:33\nAnzahl Kanäle:\t13\n\n"
    return head + "\t".join(names) + "\n" + rows(t, joints, forces, separator="\t", decimal=",")


def units_behind_a_keyword() -> str:
    """Keywords with their values, units and names in lines of their own, as memory recorders write them."""
    t, joints, forces = parts()
    names = ["TIME", *numbered("J#"), "FX", "FY", "FZ", "MX", "MY", "MZ"]
    quoted = ",".join(f'"{name}"' for name in names)
    units = ",".join(f'"{unit}"' for unit in ["S", *UNITS])
    head = f'"COMMENT",\n"8807"\n"INTERVAL",\n2.0E-03\n"VERT_UNITS",{units}\n"SIGNAL",\n{quoted}\n"DATA"\n'
    return head + rows(t, joints, forces, separator=", ", form="%+.7E")


def step_in_the_header() -> str:
    _, joints, forces = parts()
    names = [*numbered("Winkel_#"), "Fx", "Fy", "Fz", "Mx", "My", "Mz"]
    head = f"Abtastzeit;0,002;s\n{';'.join(names)}\n{';'.join(UNITS)}\n"
    return head + rows(joints, forces, separator=";", decimal=",")


def units_behind_in() -> str:
    t, joints, forces = parts()
    names = ["Zeit in ms", *numbered("Achse A# in Grad"), "Fx in N", "Fy in N", "Fz in N"]
    names += ["Mx in Nm", "My in Nm", "Mz in Nm"]
    return ";".join(names) + "\n" + rows(1e3 * t, joints, forces, separator=";", decimal=",")


def parts_of_units() -> str:
    """Time in tenths of a millisecond: read as milliseconds, it would be ten times too long."""
    t, joints, forces = parts()
    names = ["t [0.1 ms]", *numbered("J#_deg"), "Fx [mN]", "Fy [mN]", "Fz [mN]", "Mx [mNm]", "My [mNm]", "Mz [mNm]"]
    return ",".join(names) + "\n" + rows(1e4 * t, joints, 1e3 * forces, separator=",")


def ticks_under_a_strange_name() -> str:
    """Ticks of 100 ns since 1601 in a column whose name says nothing of time."""
    t, joints, forces = parts()
    stamps = [f"{134_000_000_000_000_000 + round(1e7 * s)}" for s in t]
    numbers = rows(joints, forces, separator=",").splitlines()
    names = ["Name", *numbered("J#_deg"), "Fx_N", "Fy_N", "Fz_N", "Tx_Nm", "Ty_Nm", "Tz_Nm"]
    return ",".join(names) + "\n" + "\n".join(map(",".join, zip(stamps, numbers, strict=True))) + "\n"


@pytest.mark.parametrize(
    "written",
    [
        rtde_of_a_host, datagrams, german_words, units_behind_a_keyword, step_in_the_header, units_behind_in,
        parts_of_units, ticks_under_a_strange_name,
    ],
)  # fmt: skip
def test_the_proposal_reads_what_was_recorded(written: object, tmp_path: Path) -> None:
    assert callable(written)
    file, case = tmp_path / "run.txt", blank_case()
    file.write_text(written(), encoding="cp1252" if written is german_words else "utf-8")
    found = look(file, case)
    assert found.reads, found.odd
    form = RecordingFormat.model_validate(dict(found.settings))
    again = read(file, case.model_copy(update={"recording": form}))
    t, joints, forces = parts()
    assert again.t is not None
    assert again.drives is not None
    np.testing.assert_allclose(again.t, t, atol=2e-6)
    np.testing.assert_allclose(np.degrees(again.drives), joints, atol=1e-5)
    np.testing.assert_allclose(again.forces, forces, atol=1e-5)
    assert found.rate == pytest.approx(500.0, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "begin", "step", "key"),
    [
        ("Row", 1.0, 1.0, "recording.clock.period_ms"),  # numbers of rows are not a time
        ("datenum", 739_960.25, 0.002 / 86_400.0, "recording.clock.unit"),  # days
    ],
)
def test_numbers_that_rise_evenly_are_named_beside_the_missing_clock(
    name: str, begin: float, step: float, key: str, tmp_path: Path
) -> None:
    _, joints, forces = parts()
    names = [name, *numbered("J#_deg"), "Fx_N", "Fy_N", "Fz_N", "Tx_Nm", "Ty_Nm", "Tz_Nm"]
    stamps = begin + step * np.arange(ROWS)
    file = tmp_path / "run.csv"
    file.write_text(",".join(names) + "\n" + rows(stamps, joints, forces, separator=",", form="%.12f"))
    (said,) = (sentence for sentence in look(file, blank_case()).odd if repr(name) in sentence)
    assert key in said
    if key == "recording.clock.period_ms":
        form: dict[str, Any] = {"columns": {}, "clock": {"period_ms": 2.0}}
    else:  # what it says is done
        form = {"columns": {"t_s": name}, "clock": {"unit": "d"}}
    own = blank_case().model_copy(update={"recording": RecordingFormat.model_validate(form)})
    settings = dict(look(file, own).settings)
    again = read(file, own.model_copy(update={"recording": RecordingFormat.model_validate(settings)}))
    assert again.step == pytest.approx(0.002, rel=1e-4)


def test_a_force_that_a_controller_computes_is_said_to_be_no_reading(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    file.write_text(rtde_of_a_host())
    assert any("tcpf_0 is not a reading of the sensor" in said for said in look(file, blank_case()).odd)


def test_a_rate_in_the_header_contradicts_a_clock_of_another_unit(tmp_path: Path) -> None:
    """The header says 500 Hz; stamps in ms that are named s are 2 s apart, or, in tenths of a ms, 20 ms."""
    t, joints, forces = parts()
    names = ["t [ms]", *numbered("J#_deg"), "Fx [N]", "Fy [N]", "Fz [N]", "Mx [Nm]", "My [Nm]", "Mz [Nm]"]
    file = tmp_path / "run.txt"
    file.write_text("Sample rate: 500 Hz\n" + "\t".join(names) + "\n" + rows(1e4 * t, joints, forces, separator="\t"))
    (said,) = [line for line in look(file, blank_case()).odd if "the header says" in line]
    assert "50 rows a second" in said
    assert "500 Hz" in said


@pytest.mark.parametrize(
    ("line", "period"),
    [
        ("Sample rate: 500 Hz", 2e-3), ("Sampling rate [Hz]: 500", 2e-3), ("Abtastrate;2,5;kHz", 4e-4),
        ("Abtastzeit;0,002;s", 2e-3), ("Sample interval (ms)\t4", 4e-3), ("Sampling Period (us),125", 1.25e-4),
        ("Messrate = 1000 Hz", 1e-3), ("scan rate 1000 1/s", 1e-3), ("Sample rate: 500", None),
        ("Samples: 500 Hz", None), ("Sample time: 12:30:05", None), ("sample rate 0 Hz", None),
    ],
)  # fmt: skip
def test_a_step_is_read_with_its_unit_only(line: str, period: float | None) -> None:
    found = stated_step(["Test 3", line])
    assert (found is None) if period is None else found is not None and found.period == pytest.approx(period)


def test_headers_that_state_two_steps_say_nothing() -> None:
    assert stated_step(["Sample rate: 500 Hz", "Sample rate: 1 kHz"]) is None


def test_text_of_another_encoding_is_refused_in_words(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    file.write_bytes("時間[s],モーメントx[Nm]\n0.0,1.0\n0.1,1.1\n0.2,1.3\n".encode("shift_jis"))
    with pytest.raises(RecordingError, match=r"UTF-8") as caught:
        look(file, blank_case())
    one_line(caught.value)
