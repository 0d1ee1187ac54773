"""The clock of a table: stamps that can be of one, repeated rows, the start, and parts that are shifted."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import Array
from cases.recording_format import CLOCK, SHIFTED
from identification.finding import Kind, note
from identification.recording.formats.clocks import agrees
from identification.recording.formats.table import LARGEST, ColumnTable


def require_clock(table: ColumnTable) -> None:
    """Raises RecordingError at the first time stamp that cannot be of a clock."""
    if table.stamps is not None:
        table.require(CLOCK, np.abs(table.stamps) < LARGEST, "is not a time stamp", "remove the row")


def clocked(table: ColumnTable) -> ColumnTable:
    """The table without repeated rows, and with the clock that the case states where its stamps are of another kind."""
    table = _without_repeats(table)
    period = table.form.clock.period
    if period is None or table.stamps is None or not table.stamped:
        return table
    t = (table.stamps - table.stamps[0]) * table.tick
    if table.rows < 2 or agrees(t, period):
        return table
    if table.form.format == "twincat-scope":  # its clocks are at different rates
        finding = note(
            Kind.CLOCK,
            phrase(
                "period_not_used",
                "{file}: recording.clock.period_ms is not used, its clocks have their stamps",
                file=Path(table.source).name,
            ),
        )
        return replace(table, stamped=False, findings=(*table.findings, finding))
    sentence = phrase(
        "period_counts_apart",
        "{file}: recording.clock.period_ms = {period} counts, not its time stamps, which are {apart} ms apart on "
        "average",
        file=Path(table.source).name,
        period=f"{period * 1e3:.6g}",
        apart=f"{float(t[-1]) / (table.rows - 1) * 1e3:.4g}",
    )
    finding = note(Kind.CLOCK, sentence)
    return replace(table, stamps=np.arange(table.rows), tick=period, stamped=False, findings=(*table.findings, finding))


def _without_repeats(table: ColumnTable) -> ColumnTable:
    """Without rows that repeat the one above, stamp and values alike, unless others repeat their stamp alone."""
    if table.stamps is None or table.rows < 2 or not table.values:
        return table
    again = np.r_[False, table.stamps[1:] == table.stamps[:-1]]
    at = np.flatnonzero(again)
    if not len(at) or any(not np.array_equal(c[at], c[at - 1], equal_nan=True) for c in table.values.values()):
        return table
    values = {ours: column[~again] for ours, column in table.values.items()}
    places = {"file": Path(table.source).name, "first": table.lines.place(int(at[0]))}
    finding = note(
        Kind.CLOCK,
        phrase(
            "rows_repeat",
            "{file}: {count} rows repeat the one above them, {first} first; left out",
            count=len(at),
            **places,
        )
        if len(at) > 1
        else phrase("row_repeats", "{file}: 1 row repeats the one above it, {first} first; left out", **places),
    )
    remaining = {"stamps": table.stamps[~again], "lines": table.lines.without(at.tolist())}
    return replace(table, values=values, findings=(*table.findings, finding), **remaining)


def by_clock(table: ColumnTable) -> list[ColumnTable]:
    """A table in parts whose stamps `clock.offset_s` shifts by different times; what it does not name stays first."""
    if table.stamps is None:
        return [table]
    parts: dict[float, dict[str, Array]] = {}
    for name, columns in SHIFTED.items():
        if columns_of_clock := {ours: values for ours, values in table.values.items() if ours in columns}:
            parts.setdefault(table.form.clock.offset_s.get(name, 0.0), {}).update(columns_of_clock)
    if len(parts) < 2:
        return [table]
    named = {ours for columns_of_clock in parts.values() for ours in columns_of_clock}
    shifts = sorted(parts, key=abs)
    parts[shifts[0]] |= {ours: values for ours, values in table.values.items() if ours not in named}
    return [
        replace(table, values=parts[shift], findings=table.findings if shift == shifts[0] else ()) for shift in shifts
    ]


def start_of(table: ColumnTable) -> Fraction:
    """Time of the first sample [s], exact: a double has too few digits for epochs in ns."""
    assert table.stamps is not None
    offsets = table.form.clock.offset_s
    shift = next((offsets.get(name, 0.0) for name, columns in SHIFTED.items() if {*columns} & {*table.values}), 0.0)
    # the tick is a decimal fraction of a second, which limit_denominator finds behind its binary rounding
    tick = Fraction(table.tick).limit_denominator(10**12)
    return Fraction(table.stamps[0].item()) * tick + Fraction(shift)
