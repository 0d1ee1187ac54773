"""Traces of a SINUMERIK as text: nothing about them is guessed, the case states it.

The layouts are those that public programs read (see the reader's docstring), not files of our own.
"""

from pathlib import Path

import numpy as np
import pytest

from cases.recording_format import BAR_FORCES, STRUTS
from identification.recording import read
from tests.identification.formats.runs import Truth, case_with, csv, rows, written

RUN = Truth(step=2e-3)
SIGNALS = [f"+/Nck/!SD/nckServoDataActPos1stEnc32 [u1; {k}]" for k in range(1, 7)]
SIGNALS += [f"+/Channel/!RP/rpa [u1; {k}]" for k in range(1, 7)]
COLUMNS = {"t_s": "time"} | dict(zip([*STRUTS, *BAR_FORCES], SIGNALS, strict=True))


@pytest.mark.parametrize("unit", ["s", "ms"])
def test_one_line_of_names_and_a_time_column(unit: str, tmp_path: Path) -> None:
    file = written(tmp_path, csv(RUN.numbers(tick={"s": 1.0, "ms": 1e-3}[unit]), ["time", *SIGNALS]))
    case = case_with(
        format="sinumerik-trace", delimiter=",", decimal=".", header_rows=1, columns=COLUMNS, clock={"unit": unit}
    )
    recording = read(file, case)
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.struts, RUN.struts, rtol=1e-8)
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
    np.testing.assert_allclose(recording.struts, RUN.struts, rtol=1e-8)
