"""LabVIEW measurement files, in the layouts that LabVIEW writes: one, no or many time columns, comments, segments."""

from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from cases.base.errors import RecordingError
from cases.recording_format import BAR_FORCES, STRUTS
from identification.looks.looking import look
from identification.recording.recording import Recording, read
from tests.helpers import one_line, refused_at
from tests.identification.recording.formats.runs import HEXAPOD, Truth, case_with, number, written

RUN = Truth(step=2e-3)
NAMES = [*(f"Strut {k}" for k in range(1, 7)), *(f"Force {k}" for k in range(1, 7))]
COLUMNS = dict(zip([*STRUTS, *BAR_FORCES], NAMES, strict=True))
CASE = case_with(columns=COLUMNS)
BEGAN = datetime(2024, 3, 5, 23, 59, 59)


@dataclass(frozen=True)
class Written:
    """How LabVIEW is set to write."""

    columns: str = "One"
    separator: str = "\t"
    decimal: str = "."
    comment: str = ""  # behind the first row
    segments: int = 1
    absolute: bool = True  # whether each segment has its date, and its times begin anew
    decimal_stated: bool = True

    def text(self, run: Truth = RUN) -> str:
        d = self.separator
        lines = [
            f"LabVIEW Measurement{d}", f"Writer_Version{d}2", f"Reader_Version{d}2",
            f"Separator{d}{'Tab' if d == chr(9) else 'Comma'}",
            f"Multi_Headings{d}{'No' if self.segments == 1 else 'Yes'}",
            *[f"Decimal_Separator{d}{self.decimal}"] * self.decimal_stated,
            f"X_Columns{d}{self.columns}", f"Time_Pref{d}Absolute", f"***End_of_Header***{d}", d,
        ]  # fmt: skip
        multi = self.columns == "Multi"
        for rows in np.array_split(np.arange(run.count), self.segments):
            began = BEGAN + timedelta(seconds=run.step * float(rows[0]))
            about = {
                "Channels": ["12"], "Samples": [str(len(rows))] * 12, "Date": [began.strftime("%Y/%m/%d")] * 12,
                "Time": [began.strftime("%H:%M:%S") + self.decimal + f"{began.microsecond:06d}0000000"] * 12,
                "Y_Unit_Label": ["mm"] * 6 + ["N"] * 6, "X_Dimension": ["Time"] * 12,
                "X0": [number(0.0 if self.absolute else run.step * float(rows[0]), self.decimal)] * 12,
                "Delta_X": [number(run.step, self.decimal)] * 12,
            }  # fmt: skip
            for key, cells in about.items():
                if key not in ("Date", "Time") or self.absolute:
                    lines.append(
                        d.join([key, *((cells[0], *(x for c in cells[1:] for x in ("", c))) if multi else cells)])
                    )
            lines.append(f"***End_of_Header***{d}")
            channels = [x for name in NAMES for x in ("X_Value", name)] if multi else ["X_Value", *NAMES]
            lines.append(d.join([*channels, "Comment"]))
            for k in rows:
                x = number(run.t[k] - (run.t[rows[0]] if self.absolute else 0.0), self.decimal)
                values = [number(v, self.decimal) for v in (*run.struts[k] * 1e3, *run.forces[k])]
                fields = [f for v in values for f in (x, v)] if multi else [x if self.columns == "One" else "", *values]
                lines.append(d.join([*fields, *[self.comment] * int(bool(self.comment) and k == rows[0])]))
            lines.append("")
        return "\n".join(lines) + "\n"


WRITTEN = {
    "one time column": Written(),
    "no time column": Written(columns="No"),
    "a time column each": Written(columns="Multi"),
    "commas between fields": Written(separator=","),
    "decimal commas": Written(decimal=","),
    "decimal commas that the header does not state": Written(decimal=",", decimal_stated=False, columns="No"),
    "a comment": Written(comment="start, by hand"),
    "a comment and a time column each": Written(comment="start", columns="Multi"),
    "segments with a date each": Written(segments=4),
    "segments without times": Written(segments=3, columns="No", decimal=","),
    "segments whose times go on": Written(segments=3, absolute=False),
    "segments with a time column each": Written(segments=2, columns="Multi"),
}


def require_the_run(recording: Recording) -> None:
    np.testing.assert_allclose(recording.t, RUN.t, atol=1e-9)
    np.testing.assert_allclose(recording.drives, RUN.struts, rtol=1e-8)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)


@pytest.mark.parametrize("how", WRITTEN)
def test_a_file_is_read_without_a_word_on_its_layout(how: str, tmp_path: Path) -> None:
    file = written(tmp_path, WRITTEN[how].text(), "run.lvm")
    require_the_run(read(file, CASE))
    seen = look(file, HEXAPOD)
    assert seen.reads, seen.odd
    assert seen.rate == pytest.approx(500.0)
    assert {c.ours for c in seen.columns} >= {*COLUMNS, "t_s"}
    require_the_run(read(file, case_with(**seen.settings)))


def test_what_the_case_states_by_hand_of_an_older_version_reads_the_same_run(tmp_path: Path) -> None:
    lines = Written().text().splitlines()
    row = next(k for k, line in enumerate(lines, 1) if line.startswith("X_Value"))
    file = written(tmp_path, "\n".join(lines), "run.lvm")
    by_header = {"delimiter": "\t", "header_rows": row, "columns": COLUMNS | {"t_s": "X_Value"}}
    require_the_run(read(file, case_with(**by_header)))
    by_names = {"delimiter": "\t", "header_rows": row, "column_names": ["x", *NAMES], "columns": COLUMNS | {"t_s": "x"}}
    require_the_run(read(file, case_with(**by_names)))


@pytest.mark.parametrize("segments", [1, 3])
def test_a_damage_is_named_with_its_line(segments: int, tmp_path: Path) -> None:
    lines = Written(segments=segments).text().splitlines()
    starts = [k for k, line in enumerate(lines) if line.startswith("X_Value")]
    at = starts[-1] + 3
    lines[at] = lines[at].replace("\t", "\tx", 1)
    with pytest.raises(RecordingError, match=rf"line {at + 1}, Strut 1: 'x.*' is not a number"):
        read(written(tmp_path, "\n".join(lines), "run.lvm"), CASE)


WRONG = {
    "no header": ("LabVIEW Measurement\t\n0\t1\t2\n", r"no line \*\*\*End_of_Header\*\*\*"),
    "no rows": (Written().text().split("0.002")[0].rsplit("X_Value", 1)[0] + "X_Value\tStrut 1\tComment\n", r"no line"),
    "times that begin anew without a date": (
        "\n".join(line for line in Written(segments=3).text().splitlines() if not line.startswith(("Date", "Time\t"))),
        r"line \d+: the times of this segment begin anew, and no date .*; give each segment as a file",
    ),
    "segments of other channels": (
        Written(segments=2).text()[::-1].replace("Force 6"[::-1], "Force 7"[::-1], 1)[::-1],
        r"line \d+: names other channels than the segment above",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_read_is_named(what: str, tmp_path: Path) -> None:
    text, message = WRONG[what]
    file = written(tmp_path, text, "run.lvm")
    for call in (lambda: read(file, CASE), lambda: look(file, HEXAPOD)):
        with refused_at(file, message):
            call()


def test_channels_that_end_earlier_are_a_stream_of_their_own(tmp_path: Path) -> None:
    """With a time column each, forces at 500 Hz and struts at 250 Hz: fields of struts are empty in the second half."""
    lines = Written(columns="Multi").text().splitlines()
    first = next(k for k, line in enumerate(lines, 1) if line.startswith("X_Value"))
    rows = [line.split("\t") for line in lines[first : first + RUN.count]]
    for k, row in enumerate(rows):
        row[:12] = rows[2 * k][:12] if 2 * k < RUN.count else [""] * 12
    text = "\n".join([*lines[:first], *("\t".join(row) for row in rows)])
    recording = read(written(tmp_path, text, "run.lvm"), CASE)
    np.testing.assert_allclose(recording.forces, RUN.forces, rtol=1e-8)
    (other,) = recording.others
    np.testing.assert_allclose(other.drives, RUN.struts[::2], rtol=1e-8)
    np.testing.assert_allclose(other.t, RUN.t[::2], atol=1e-9)


def test_time_columns_without_a_time_are_refused(tmp_path: Path) -> None:
    """The header lost the line that says there are no time columns."""
    lines = [line for line in Written(columns="No").text().split("\n") if not line.startswith("X_Columns")]
    file = written(tmp_path, "\n".join(lines))
    for call in (read, look):
        with pytest.raises(RecordingError) as refused:
            call(file, CASE)
        assert "time stamps in no row" in one_line(refused.value)


def test_times_with_exponents_of_fortran_are_read(tmp_path: Path) -> None:
    text = Written().text()
    first = number(RUN.t[0], ".")
    head, _, rows = text.partition("X_Value\t")
    assert f"\n{first}\t" in rows
    file = written(tmp_path, head + "X_Value\t" + rows.replace(f"\n{first}\t", f"\n{first}D+00\t", 1))
    assert len(read(file, CASE).forces) == RUN.count
