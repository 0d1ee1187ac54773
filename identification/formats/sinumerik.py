"""SINUMERIK traces exported as text: like `csv`, with every property that differs between exports stated by the case.

No export of our own was at hand and no manual that describes the file was found. What public programs that read such
files show (searched November 2026): SINUMERIK Operate saves a trace session as XML (`traceSession/traceData/dataFrame`
with `dataSignal` and `rec`, three programs agree), which is not read here: export it as text. One group of programs
reads CSV with commas and points, one line of names, a first column `time` in seconds and names such as
`+/Nck/!SD/nckServoDataActPos1stEnc32 [u1; 1]`; another reads files whose names stand above the numbers, one line a
signal, so that there are more header lines than signals. Delimiter, decimal sign, header rows and the clock's unit
therefore have no default here; header rows, times in ms from the first sample and trailing rows are read as the case
says, and `column_names` names the columns where the header has no single line of names. Unverified: whether any export
repeats the time for each signal, or leaves fields empty where signals have different cycles; empty fields are
refused with their line.
"""

from collections.abc import Iterator
from pathlib import Path

from cases.recording import RecordingFormat
from identification.formats import delimited
from identification.formats.table import Table


def tables(file: Path, form: RecordingFormat) -> Iterator[Table]:
    """Reads a file batch by batch; see `delimited.tables`."""
    return delimited.tables(file, form)
