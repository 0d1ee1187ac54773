"""What a look at a file of unknown format found: columns, settings, and what is odd; the look at a ROS 2 bag."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cases.files import toml_value
from cases.recording_format import CLOCK, ROLE_OF, STRUTS, TICKS, TRIGGER, WRENCH, Role, units_of
from cases.schema import Case
from cases.units import MM, Array, as_html
from identification.formats.assembly import switched
from identification.formats.binary import (
    AXES,
    KINDS,
    STAMP,
    joint_names,
    joint_rows,
    opened,
    topic_of,
    topics_of,
    wrench_rows,
)
from identification.formats.naming import matched
from identification.formats.table import Stamps, listed, lost_samples, shown, usual_step

RATES = (20.0, 50_000.0)  # rows per second that recorders have
AROUND_HOME = 2.5  # times the length at home that a strut may have where the case states no workspace
_MOST_BLANK = 1e-3  # share of a column, from which on its empty fields are reported


@dataclass(frozen=True, slots=True)
class Column:
    """A column of the file."""

    name: str  # as the file has it
    ours: str | None  # our name of it; None: hexcite does not use it, or its meaning is unknown
    unit: str  # unit that the file is taken to use; empty where there is none
    guessed: bool  # whether meaning or unit follow from the values alone
    values: Array  # numbers, shape (n,); empty where the column holds text


@dataclass(frozen=True, slots=True)
class Look:
    """What a file is likely to be.

    Args:
        file: the file.
        rows: number of rows of numbers.
        columns: in the order of the file.
        settings: proposal for `[recording]` of the case, by key.
        odd: what to look at, one sentence each.
        reads: whether the file is read with these settings.
    """

    file: Path
    rows: int
    columns: tuple[Column, ...]
    settings: Mapping[str, Any]
    odd: tuple[str, ...]
    reads: bool

    @property
    def rate(self) -> float | None:
        """Rows per second; None where there is no clock."""
        clock = next((c for c in self.columns if c.ours == CLOCK), None)
        tick = self.settings.get("clock", {})
        if clock is None or len(clock.values) < 2:
            return 1e3 / tick["period_ms"] if "period_ms" in tick else None
        default = "ms" if self.settings.get("format") == "twincat-scope" else "s"
        step = float(np.median(np.diff(clock.values))) * TICKS[tick.get("unit", default)]
        return 1.0 / step if step > 0.0 else None

    @property
    def toml(self) -> str:
        """The settings as a case file has them."""
        plain = {key: value for key, value in self.settings.items() if key != "columns"}
        lines = ["[recording]", *(f"{key} = {toml_value(value)}" for key, value in plain.items())]
        if "columns" in self.settings:
            columns = self.settings["columns"].items()
            lines += ["", "[recording.columns]", *(f"{ours} = {toml_value(theirs)}" for ours, theirs in columns)]
        return "\n".join(lines)

    def __repr__(self) -> str:
        """Its columns and settings, in a few lines."""
        names = ", ".join(c.ours for c in self.columns if c.ours is not None) or "none that hexcite knows"
        return "\n".join([f"{self.file}: {self.rows} rows; columns: {names}", *self.odd, self.toml])

    __str__ = __repr__

    _repr_html_ = as_html


def oddities(look: Look, case: Case | None) -> Iterator[str]:
    """Sentences on what a person should check."""
    columns = {c.ours: c for c in look.columns if c.ours is not None}
    clock = columns.get(CLOCK)
    if clock is None and "clock" in look.settings:
        period = look.settings["clock"]["period_ms"]
        yield f"no clock: {period:g} ms between rows is a guess; state the recorder's period in clock.period_ms"
    elif clock is None:
        yield "no clock: each row is taken for an averaged standstill; of a motion state clock.period_ms"
    elif np.all(np.diff(clock.values) > 0.0) and (gaps := lost_samples(clock.values)).any():
        count, places, first = int(gaps.sum()), int(np.count_nonzero(gaps)), int(np.argmax(gaps > 0)) + 1
        yield f"{shown(clock.name)}: {count} samples are missing at {places} places, first after row {first}"
    if clock is not None and look.rate is not None and not RATES[0] <= look.rate <= RATES[1]:
        yield f"{look.rate:.3g} rows per second, by this clock: is its unit right?"
    if clock is not None and clock.guessed:
        yield (
            f"{shown(clock.name)}: its unit {clock.unit} is a guess from its steps; if it counts samples, leave it out "
            "and state clock.period_ms"
        )
    if TRIGGER not in columns and (clock is not None or "clock" in look.settings):
        yield "no trigger: the whole motion is evaluated, the ways from and to home too"
    if TRIGGER in columns:
        on = switched(np.nan_to_num(columns[TRIGGER].values))
        if on is not None and not on.any():
            yield f"{shown(columns[TRIGGER].name)}: is never on, so nothing would be evaluated; leave it out of columns"
        elif on is not None and on[-1]:
            yield f"{shown(columns[TRIGGER].name)}: is still on in the last row; was the recorder stopped too early?"
    for column in look.columns:
        if not len(column.values):
            yield f"{shown(column.name)}: holds text; where it is the time, export it as a number"
        elif column.ours is not None:
            yield from _column_oddities(column)
    guesses = [c.name for c in look.columns if c.guessed and c.ours != CLOCK]
    if guesses:
        names = ", ".join(map(shown, guesses))
        yield f"meaning or unit guessed from values: {names}; compare order and unit with the recorder's settings"
    if (possible := strut_range(case)) is not None and STRUTS[0] in columns:
        low, high = (limit / MM for limit in possible)
        factor = units_of(STRUTS[0])[columns[STRUTS[0]].unit] / MM
        middle = float(np.nanmedian([columns[name].values for name in STRUTS])) * factor
        if not low <= middle <= high:
            yield (
                f"struts of {middle:.4g} mm are not what the case lets expect ({low:.4g} to {high:.4g} mm): "
                "another machine, or drive positions?"
            )


def strut_range(case: Case | None) -> tuple[float, float] | None:
    """Shortest and longest strut to be expected [m]: the workspace's, or about that at home; None: nothing is known."""
    if case is None or case.hexapod is None:
        return None
    if case.workspace is not None:
        low, high = case.workspace.strut_length
        return float(low), float(high)
    from identification.hexapod import Hexapod

    usual = float(Hexapod.of(case).strut_lengths(case.hexapod.home.vector[None]).mean())
    return usual / AROUND_HOME, usual * AROUND_HOME


def _column_oddities(column: Column) -> Iterator[str]:
    good = column.values[np.isfinite(column.values)]
    blank = 1.0 - len(good) / len(column.values)
    if blank > _MOST_BLANK:
        yield f"{shown(column.name)}: {100 * blank:.3g} % of its fields hold no number"
    if column.ours not in (TRIGGER, CLOCK) and len(good) > 1 and not np.ptp(good):
        yield f"{shown(column.name)}: never changes ({good[0]:g}); a channel that is not connected?"


_NS = 1e-9
_MOST_JITTER = 0.2  # share of a step, from which on jitter is reported


def look_at_bag(bag: Path, case: Case | None) -> tuple[tuple[Column, ...], dict[str, Any], list[str]]:
    """Columns, settings for `[recording]`, and what is odd; the sensor's readings are those at the joints' stamps.

    Without a case the order of the joints is unknown. Raises RecordingError where joints or a sensor are missing.
    """
    chain = None if case is None else case.chain
    columns_of = {} if chain is None else dict(zip(chain.names, chain.columns, strict=True))
    with opened(bag) as reader:
        stated = {what: None if case is None else case.recording.ros.get(what) for what in KINDS}
        possible = {what: topics_of(reader, what) for what in KINDS}
        chosen = {what: topic_of(bag, reader, what, stated[what] or next(iter(possible[what]), None)) for what in KINDS}
        names = joint_names(reader, chosen["joints"])
        places = matched(names, (), columns_of)[0] if columns_of else {}
        ours = {names[k]: column for column, k in places.items() if column in columns_of.values()}
        stamps, positions = joint_rows(bag, reader, chosen["joints"], tuple(ours) or names)
        read, readings, frame = wrench_rows(bag, reader, chosen["wrench"])
    several = {what: topic for what, topic in chosen.items() if len(possible[what]) > 1}
    renamed = {ours[name]: name for name in ours if columns_of.get(name) != ours[name]}
    settings: dict[str, Any] = {"ros": several} if several else {}
    settings |= {"columns": renamed} if renamed else {}
    odd = [f"{KINDS[what]}: of {listed(possible[what])} this is {shown(several[what])}" for what in several]
    odd += [f"{shown(chosen['wrench'])}: in the frame {shown(frame)}, which must be that of machine.chain.sensor"]
    odd += [*_clock(chosen["joints"], stamps), *_clock(chosen["wrench"], read)]
    t = (stamps - stamps[0]) * _NS
    columns = [Column(STAMP, CLOCK, "s", False, t)]
    for k, name in enumerate(tuple(ours) or names):
        unit = "m" if ROLE_OF.get(ours.get(name, "")) is Role.DRIVES else "rad"
        columns.append(Column(name, ours.get(name), unit, False, positions[:, k]))
    for k, (axis, column) in enumerate(zip(AXES, WRENCH, strict=True)):
        values = np.interp(t, (read - stamps[0]) * _NS, readings[:, k])
        columns.append(Column(axis, column, "N" if k < 3 else "Nm", False, values))
    settings["rate_Hz"] = float(f"{min(1.0 / _step(stamps), 1.0 / _step(read)):.4g}")
    return tuple(columns), settings, odd


def _step(stamps: Stamps) -> float:
    """Usual time between messages [s]."""
    return max(usual_step(stamps), 1.0) * _NS if len(stamps) > 1 else 1.0


def _clock(topic: str, stamps: Stamps) -> Iterator[str]:
    """How often messages come, and how evenly by their own stamps."""
    step = _step(stamps)
    yield f"{shown(topic)}: {len(stamps)} messages, {1.0 / step:.4g} a second"
    away: Array = np.abs(np.diff(stamps) * _NS - step)
    usual = 1e3 * float(np.quantile(away, 0.95)) if len(away) else 0.0
    if usual > _MOST_JITTER * 1e3 * step:
        yield f"{shown(topic)}: stamps vary by {usual:.2g} ms; they are read as equal steps of {1e3 * step:.3g} ms"
