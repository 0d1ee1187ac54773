"""Traces of a SINUMERIK: sessions as SINUMERIK Operate saves them, and tables of text, whose layout the case states.

The layouts are those of a genuine session and of public programs (see the reader's docstring), not files of our own.
"""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from identification.looks.looking import look
from identification.recording.recording import read
from tests.helpers import refused_at
from tests.identification.recording.formats.runs import HEXAPOD, Truth, case_with, csv, rows, written

RUN = Truth(step=2e-3)
SIGNALS = [f"+/Nck/!SD/nckServoDataActPos1stEnc32 [u1; {k}]" for k in range(1, 7)]
SIGNALS += [f"+/Channel/!RP/rpa [u1; {k}]" for k in range(1, 7)]
COLUMNS = {"t_s": "time"} | dict(zip([*STRUTS, *BAR_FORCES], SIGNALS, strict=True))
HELD = RUN.forces[np.arange(RUN.count) // 2 * 2]  # forces in the interval of the interpolator, every second one
ROWS = np.column_stack([RUN.t, RUN.struts * 1e3, HELD])


def sparse(separator: str = ",") -> list[str]:
    """Rows in which a value stands where it is not the one above."""
    lines = [rows(ROWS[:1], separator)[0]]
    for above, row in pairwise(ROWS):
        fields = rows(row[None], separator)[0].split(separator)
        changed = [True, *(row[1:] != above[1:])]
        lines.append(separator.join(f if there else "" for f, there in zip(fields, changed, strict=True)))
    return lines


def session(lines: list[str], frames: int = 1, mark: str = "") -> str:
    """A saved session: signals, then records with the values that have changed."""
    about = [
        f'<signal key="s{k}" name="{name}" domain="NCU_1" description="R[{k}]"/>' for k, name in enumerate(SIGNALS, 1)
    ]
    signals = [
        f'<dataSignal id="f{k}" key="s{k}" name="{name}" interval="0.002" datapointCount="{len(lines)}"/>'
        for k, name in enumerate(SIGNALS, 1)
    ]
    records = []
    for line in lines:
        time, *values = line.split(",")
        entries = (f'f{k}="{value}"' for k, value in enumerate(values, 1) if value)
        records.append(f'<rec time="{time}" {" ".join(entries)}/>')
    frame = ["<dataFrame>", '<frameHeader dropOuts="0"/>', *signals, *records, "</dataFrame>"]
    return "\n".join(
        [
            f'{mark}<?xml version="1.0" encoding="utf-8" ?>', "<!--written by a control-->",
            '<traceSession version="01.00.03.02">', "<traceCaptureSetup_V20>", "<signalSettings>", *about,
            "</signalSettings>", "</traceCaptureSetup_V20>", "<traceData>", *frame * frames, "</traceData>",
            "</traceSession>",
        ]
    )  # fmt: skip


def require_the_run(recording: Any) -> None:
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, HELD, rtol=1e-8)
    assert recording.missing is None


@pytest.mark.parametrize("unit", ["s", "ms"])
def test_one_line_of_names_and_a_time_column(unit: str, tmp_path: Path) -> None:
    file = written(tmp_path, csv(RUN.numbers(tick={"s": 1.0, "ms": 1e-3}[unit]), ["time", *SIGNALS]))
    case = case_with(
        format="sinumerik-trace", delimiter=",", decimal=".", header_rows=1, columns=COLUMNS, clock={"unit": unit}
    )
    recording = read(file, case)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)


def test_signals_listed_above_the_numbers_and_rows_below(tmp_path: Path) -> None:
    header = ["Trace", "2026-11-01", *(f"Signal {k}; {name}" for k, name in enumerate(SIGNALS)), ""]
    text = "\n".join([*header, *rows(RUN.numbers(tick=1e-3), ";", ","), "Trigger; 17", "END"])
    case = case_with(
        format="sinumerik-trace", delimiter=";", decimal=",", header_rows=len(header), trailing_rows=2,
        column_names=["t", *SIGNALS], columns=COLUMNS | {"t_s": "t"}, clock={"unit": "ms"},
    )  # fmt: skip
    recording = read(written(tmp_path, text), case)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)


@pytest.mark.parametrize("says", ["format", "nothing"])
def test_an_empty_field_of_a_trace_holds_the_last_value(says: str, tmp_path: Path) -> None:
    """The names of the signals say that it is a trace, whether the case does or not."""
    file = written(tmp_path, "\n".join([",".join(["time", *SIGNALS]), *sparse()]))
    stated = {"format": "sinumerik-trace", "delimiter": ",", "decimal": ".", "header_rows": 1, "clock": {"unit": "s"}}
    require_the_run(read(file, case_with(columns=COLUMNS, **(stated if says == "format" else {}))))
    with pytest.raises(RecordingError, match=r"is empty, like 20 of the 40 rows .*recording\.empty = .*'hold'"):
        read(file, case_with(columns=COLUMNS, empty="missing"))


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_session_is_read_without_a_word_on_its_layout(mark: str, encoding: str, tmp_path: Path) -> None:
    file = written(tmp_path, session(sparse(), mark=mark * (encoding == "utf-8")).encode(encoding), "run.xml")
    recording = read(file, case_with(columns=COLUMNS))
    require_the_run(recording)
    assert recording.lines.place(16) == "record 17"
    seen = look(file, HEXAPOD)
    assert [c.name for c in seen.columns] == ["time", *SIGNALS]
    assert seen.rate == pytest.approx(500.0)


WHOLE = session(sparse())
BOMB = '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>\n<traceSession>'
WRONG = {
    "cut off": (WHOLE[: len(WHOLE) // 2], r"line \d+: is damaged XML .*; save the trace again"),
    "without data": (WHOLE.replace("dataSignal", "signal_"), r"without data"),
    "without records": (session([]), r"signals but no records"),
    "a word for a number": (WHOLE.replace('f7="', 'f7="x', 1), r"record 1, .*rpa \[u1; 1\]: 'x.*' is not a number"),
    "no time": (WHOLE.replace('<rec time="', '<rec tim="', 1), r"record 1, time: '' is not a number"),
    "two recordings": (session(sparse(), frames=2), r"record 41.*time must increase"),
    "a document that grows": (WHOLE.replace("<traceSession", BOMB + "<traceSession", 1), r"line \d+: is damaged XML"),
    "another document": ("<?xml version='1.0'?>\n<project>\n<a b='1'/></project>", r"none of the columns"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_damaged_session_is_named_with_its_place(what: str, tmp_path: Path) -> None:
    text, message = WRONG[what]
    file = written(tmp_path, text, "run.xml")
    with refused_at(file, message):
        read(file, case_with(columns=COLUMNS))
