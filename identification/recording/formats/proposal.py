"""The table `[recording]` that reads a file of unknown format: from its names, its numbers, and what the case states.

What the case states counts before what names say, and names before what values say; of a file that the case does not
read, the units that its labels state count before those that the case keeps of another file. Each guess, and each
doubt, is a sentence.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cases.base.errors import printable
from cases.base.phrases import NOTHING, Phrase, phrase
from cases.base.units import Array
from cases.recording_format import (
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    ROLE_OF,
    ROLE_UNITS,
    TICKS,
    TRIGGER,
    WRENCH,
    FileFormat,
)
from cases.schema import Case
from identification.recording.formats.column_places import ColumnPlaces, column_places
from identification.recording.formats.column_units import ColumnUnits, column_units, labels_of
from identification.recording.formats.kept_units import for_this_file
from identification.recording.formats.layout import TextColumns
from identification.recording.formats.reasons import NO_REASON, Reason, Why, because
from identification.recording.formats.stated_rates import stated_step
from identification.recording.formats.units_by_values import (
    USUAL_RATE,
)

CUTOFF_HZ = 40.0  # of a proposal where the case states none
LEAST_CUTOFF_HZ = 1.0  # below, nothing of an excitation is left
_OTHER_RATE = 0.05  # share by which the rate of the stamps differs from that of a header, from which on it is said
_CUTOFF_SHARE = 0.19  # of the rows per second; the reader takes a fifth at most
LAYOUT = frozenset(
    {"format", "delimiter", "decimal", "header_rows", "names_row", "trailing_rows", "column_names", "encoding", "empty"}
)
"""Keys of `[recording]` that say how a file of text is laid out."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """What the columns of a file mean, and the table that says so."""

    places: Mapping[str, int]  # our name -> position in the file
    units: Mapping[str, str]  # our name -> unit that the file is taken to use; empty where there is none
    guessed: frozenset[str]  # our names whose unit follows from values alone
    names: tuple[str, ...]  # of the columns, those that the case gives them where the file does not
    settings: Mapping[str, Any]  # `[recording]` by key
    doubts: tuple[Phrase, ...]  # what a person should compare or complete, a sentence each
    rate: float | None = None  # rows per second; None where there is no clock
    reasons: Mapping[str, Reason] = field(default_factory=dict)  # our name -> why the column is taken for it
    unit_reasons: Mapping[str, Reason] = field(default_factory=dict)  # our name -> why it has this unit
    setting_reasons: Mapping[str, Reason] = field(default_factory=dict)  # key of `settings` -> why it has this value
    clock_counts: float = 1.0  # numbers of the clock for one of its unit, as its label says

    @property
    def has_forces(self) -> bool:
        """Whether the readings of the force sensors are in the file."""
        return bool({WRENCH[0], BAR_FORCES[0]} & self.places.keys())


def stated_of(form: FileFormat) -> dict[str, Any]:
    """The keys that a case states in `[recording]`, as TOML has them."""
    stated: dict[str, Any] = form.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    return stated


def proposed(table: TextColumns, case: Case | None, as_stated: bool = False) -> Proposal:
    """The meaning of a table's columns, and the settings by which it is read.

    Args:
        table: as the file has it.
        case: the machine, and what it states of its recordings; None: names alone count.
        as_stated: whether the case reads the file, so that what it states of names and clocks holds.
    """
    stated: dict[str, Any] = {} if case is None else stated_of(case.recording)
    layout, names = _named(table, stated)
    columns = column_places(table, case, stated, names)
    kept: tuple[Phrase, ...] = ()
    if not as_stated:
        stated, kept = for_this_file(case, stated, columns, labels_of(table, columns))
    units = column_units(table, case, stated, columns)
    draft = _Settings(table, stated, columns, units, as_stated)
    settings = draft.of(layout)
    return Proposal(
        columns.places, units.units, frozenset(units.guessed), names, settings,
        tuple(dict.fromkeys([*columns.doubts, *kept, *units.doubts, *draft.doubts])),
        rate_of(columns.places, units.units, units.numbers, settings), columns.reasons,
        {**units.reasons, CLOCK: draft.clock_reason} if draft.clock_reason else units.reasons,
        dict(draft.why(settings)), units.clock_counts,
    )  # fmt: skip


def _named(table: TextColumns, stated: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Layout and names of the columns, those that the case gives them where the file has none of its own."""
    layout, names = dict(table.settings), tuple(table.names)
    names_of_case, names_of_layout = stated.get("column_names", ()), layout.get("column_names", ())
    if names_of_case and len(names_of_case) == len(names_of_layout):
        layout["column_names"] = names_of_case
        renamed = dict(zip(names_of_layout, names_of_case, strict=True))
        names = tuple(renamed.get(name, name) for name in names)
    return layout, names


class _Settings:
    """The table `[recording]` while it is filled."""

    def __init__(
        self, table: TextColumns, stated: Mapping[str, Any], columns: ColumnPlaces, units: ColumnUnits, as_stated: bool
    ) -> None:
        self.table, self.stated, self.columns, self.units, self.as_stated = table, stated, columns, units, as_stated
        self.clock_reason = units.reasons.get(CLOCK, NO_REASON)
        self.doubts: list[Phrase] = []

    def of(self, layout: Mapping[str, Any]) -> dict[str, Any]:
        """The table `[recording]`, with what the case states beside names, units and layout."""
        result = {key: value for key, value in layout.items() if value is not None}
        own_clock = self.table.clock is not None  # which the format says
        dated = self.columns.places.get(CLOCK) in self.table.dates  # whose unit follows from how they are written
        ordered = [ours for ours in COLUMNS if ours in self.columns.places and not (own_clock and ours == CLOCK)]
        renamed = {ours: self.columns.name(ours) for ours in ordered if self.columns.name(ours) != ours}
        if self.columns.bit is not None or "column" in self.stated.get("trigger", {}):
            renamed.pop(TRIGGER, None)
        if self.columns.bit is not None:
            result["trigger"] = {"column": self.columns.name(TRIGGER), "bit": self.columns.bit}
        result |= {"columns": renamed} if renamed else {}
        if units := dict(self._differing_units(ordered)):
            result["units"] = units
        clock = dict(self.stated.get("clock", {}))  # some formats are not valid without a unit
        if CLOCK in self.columns.places and not self.as_stated and clock.pop("period_ms", None) is not None:
            self.doubts.append(
                phrase(
                    "period_left_out",
                    "{name} has time stamps: recording.clock.period_ms of the case is left out",
                    name=self.columns.name(CLOCK),
                )
            )
        if CLOCK not in self.columns.places and "period_ms" not in clock:
            clock |= self._step_of_header()
        if not own_clock:
            stated = clock.pop("unit", None) is not None and CLOCK in self.units.units
            if not dated and (stated or self.units.clock_unit_stated or self.units.units.get(CLOCK, "s") != "s"):
                clock = {"unit": self.units.units[CLOCK], **clock}
        clock |= result.pop("clock", {})
        clock |= {} if self.columns.nanoseconds is None else {"nanoseconds": self.columns.nanoseconds}
        result |= {"clock": clock} if clock else {}
        result |= {"orientation": self.columns.orientation} if self.columns.orientation is not None else {}
        keys = LAYOUT | {"columns", "units", "clock", "filter_cutoff_Hz", "rate_Hz", "files"}
        result |= {key: value for key, value in self.stated.items() if key not in keys}
        self._add_filter(result)
        return result

    def _step_of_header(self) -> dict[str, Any]:
        """The clock of a file whose rows have no time, where its header says how far apart they are."""
        step = stated_step(self.table.header)
        if step is None or self.columns.said.clocks:
            return {}
        period = float(f"{step.period * 1e3:.9g}")
        self.doubts.append(
            phrase(
                "step_in_header",
                "no column is a clock; {text} in the header: recording.clock.period_ms",
                text=repr(printable(" ".join(step.text.split()))),
            )
        )
        self.clock_reason = because(Why.HEADER)
        return {"period_ms": period}

    def _check_stated_rate(self, rate: float | None) -> None:
        """Says where a header states another rate than the time stamps have."""
        step = stated_step(self.table.header)
        if step is None or rate is None or abs(rate * step.period - 1.0) < _OTHER_RATE:
            return
        self.doubts.append(
            phrase(
                "other_rate_in_header",
                "{name} makes {rate} rows a second, the header says {text}: check the unit of the time stamps, "
                "recording.clock.unit",
                name=self.columns.name(CLOCK),
                rate=f"{rate:.4g}",
                text=repr(printable(" ".join(step.text.split()))),
            )
        )

    def why(self, settings: Mapping[str, Any]) -> Iterator[tuple[str, Reason]]:
        """Of each key of the settings why it has its value."""
        reasons = {
            "format": because(Why.FIRST_LINES),
            "delimiter": because(Why.NUMBERS),
            "decimal": because(Why.NUMBERS),
            "header_rows": because(Why.FIRST_ROW, line=int(settings.get("header_rows", 0)) + 1),
            "names_row": because(Why.KNOWN_NAMES),
            "trailing_rows": because(Why.LAST_ROW),
            "column_names": because(Why.NO_NAMES),
            "encoding": because(Why.NOT_UTF8),
            "empty": because(Why.SEVERAL_CLOCKS if settings.get("empty") == "apart" else Why.WHERE_CHANGED),
            "columns": because(Why.OTHER_NAMES),
            "units": because(Why.OTHER_UNITS),
            "clock": self.clock_reason,
            "trigger": because(Why.BIT, bit=self.columns.bit),
            "orientation": because(Why.ORIENTATION, conventions=", ".join(self.columns.said.orientations)),
            "filter_cutoff_Hz": because(Why.FILTER),
            "rate_Hz": because(Why.CLOCK),
        }
        states = because(Why.CASE_STATES)
        for key, value in settings.items():
            why = states if key in self.stated and self.stated[key] == value else reasons.get(key, states)
            if why:
                yield key, why

    def _differing_units(self, ordered: Sequence[str]) -> Iterator[tuple[str, str]]:
        """Units that are not those of our names, or that the case states, which labels may contradict; by role."""
        for role, factors in ROLE_UNITS.items():
            of_role = {self.units.units[ours] for ours in ordered if ROLE_OF.get(ours) == role}
            stated_unit = self.stated.get("units", {}).get(str(role))
            if len(of_role) == 1 and of_role <= factors.keys() - ({factors.usual} - {stated_unit}):
                yield str(role), of_role.pop()

    def _add_filter(self, settings: dict[str, Any]) -> None:
        """The cut-off, which a fifth of the rate limits, and the rate where it is not the usual one."""
        cutoff = float(self.stated.get("filter_cutoff_Hz", CUTOFF_HZ))
        rate = rate_of(self.columns.places, self.units.units, self.units.numbers, settings)
        if CLOCK in self.columns.places:
            self._check_stated_rate(rate)
        if rate is not None and cutoff < LEAST_CUTOFF_HZ <= _CUTOFF_SHARE * rate:
            usual = min(CUTOFF_HZ, float(f"{_CUTOFF_SHARE * rate:.2g}"))
            self.doubts.append(
                phrase(
                    "cutoff_of_case",
                    "filter_cutoff_Hz = {cutoff} of the case leaves nothing of a motion; {rate} rows a second carry "
                    "{usual}",
                    cutoff=f"{cutoff:g}",
                    rate=f"{rate:.4g}",
                    usual=f"{usual:g}",
                )
            )
            cutoff = usual
        if rate is not None and cutoff > 0.2 * rate:
            carried = float(f"{_CUTOFF_SHARE * rate:.2g}")
            low = phrase("slow_rows", "; that leaves nothing of an excitation: record faster, or correct the clock")
            self.doubts.append(
                phrase(
                    "cutoff_carried",
                    "filter_cutoff_Hz: {rate} rows a second carry a fifth of that at most, {carried} Hz in place of "
                    "{cutoff} Hz{low}",
                    rate=f"{rate:.4g}",
                    carried=f"{carried:g}",
                    cutoff=f"{cutoff:g}",
                    low=low if carried < LEAST_CUTOFF_HZ else NOTHING,
                )
            )
            cutoff = carried
        settings["filter_cutoff_Hz"] = cutoff
        expected = float(self.stated.get("rate_Hz", USUAL_RATE))
        if rate is not None and not 0.99 < rate / expected < 1.01:
            expected = float(f"{rate:.4g}")
        if expected != USUAL_RATE or "rate_Hz" in self.stated:
            settings["rate_Hz"] = expected


def rate_of(
    places: Mapping[str, int], units: Mapping[str, str], numbers: Mapping[int, Array], settings: Mapping[str, Any]
) -> float | None:
    """Rows per second; None where there is no clock."""
    period = settings.get("clock", {}).get("period_ms")
    if period:
        return 1e3 / float(period)
    if CLOCK not in places or places[CLOCK] not in numbers or len(numbers[places[CLOCK]]) < 2:
        return None
    stamps = numbers[places[CLOCK]]
    forces = next((numbers[places[ours]] for ours in (WRENCH[0], BAR_FORCES[0]) if ours in places), stamps)
    step = float(np.median(np.diff(stamps)))
    if settings.get("empty") == "apart" and len(forces) > 1:  # rows of the forces alone
        step = float((stamps[-1] - stamps[0]) / (len(forces) - 1))
    if step <= 0.0:  # stamps that stand for some rows each
        step = float((stamps[-1] - stamps[0]) / (len(stamps) - 1))
    step *= TICKS[units[CLOCK]]
    return 1.0 / step if step > 0.0 else None
