"""The table `[recording]` that reads a file of unknown format: from its names, its numbers, and what the case states.

What the case states counts before what names say, and names before what values say. Each guess, and each doubt, is a
sentence.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from typing import Any

import numpy as np

from cases.base.errors import printable
from cases.base.unit_names import is_share
from cases.base.units import Array
from cases.orientation import ANGLES, CONVENTIONS, QUATERNION, ROLL_PITCH_YAW
from cases.recording_format import (
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    DRIVES,
    ROLE_OF,
    ROLE_UNITS,
    STRUTS,
    TICKS,
    TRIGGER,
    WRENCH,
    FileFormat,
    Role,
)
from cases.schema import Case
from identification.recording.formats.layout import TextColumns
from identification.recording.formats.names.families import words_of
from identification.recording.formats.names.labels import StatedUnit, counted, stated_unit
from identification.recording.formats.names.meaning import groups_of, meaning_of, span
from identification.recording.formats.names.vocabulary import CLOCK_UNITS
from identification.recording.formats.quantities import scale_of_shares
from identification.recording.formats.reasons import NO_REASON, Reason, Why, because
from identification.recording.formats.stated_rates import stated_step
from identification.recording.formats.table import listed
from identification.recording.formats.triggers import changing_bits, switched
from identification.recording.formats.units_by_values import (
    FILETIMES,
    MOST_RADIANS,
    USUAL_RATE,
    strut_unit,
    units_of_motion,
    units_of_values,
)

CUTOFF_HZ = 40.0  # of a proposal where the case states none
LEAST_CUTOFF_HZ = 1.0  # below, nothing of an excitation is left
_OTHER_RATE = 0.05  # share by which the rate of the stamps differs from that of a header, from which on it is said
_SLOW = 1.0  # rows per second below which a stated unit of stamps is taken for an error
_CUTOFF_SHARE = 0.19  # of the rows per second; the reader takes a fifth at most
_RUNNING = 0.04  # share of the steps of a clock that go on, at least: others stand for many rows
_EVEN_ROWS, _EVEN, _NEARLY = 20, 1.5, 0.95  # a clock without a name: least steps, times the usual one, share of them
_ONWARD = 0.5  # sum of all steps over that of their sizes, at least: others begin anew again and again
_LEAST_NANOSECONDS = 1e6  # in a column of nanoseconds that adds to seconds: a thousandth of a second
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
    doubts: tuple[str, ...]  # what a person should compare or complete, a sentence each
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
    draft = _Draft(table, case, as_stated)
    draft.place()
    draft.choose_clock()
    draft.choose_single()
    draft.fit_the_machine()
    draft.doubts += draft.said.doubts
    draft.choose_orientation()
    draft.choose_units()
    settings = draft.settings()
    return Proposal(
        draft.places, draft.units, frozenset(draft.guessed), draft.names, settings,
        tuple(dict.fromkeys(draft.doubts)), rate_of(draft.places, draft.units, draft.numbers, settings),
        draft.reasons, draft.unit_reasons, dict(draft.why(settings)), draft.counts,
    )  # fmt: skip


class _Draft:
    """A proposal that is being made, in the order of `proposed`."""

    def __init__(self, table: TextColumns, case: Case | None, as_stated: bool) -> None:
        self.table, self.case, self.numbers, self.as_stated = table, case, table.numbers, as_stated
        self.stated: dict[str, Any] = {} if case is None else stated_of(case.recording)
        self.layout, self.names = dict(table.settings), tuple(table.names)
        stated_names, layout_names = self.stated.get("column_names", ()), self.layout.get("column_names", ())
        if stated_names and len(stated_names) == len(layout_names):  # a file without names of its own
            self.layout["column_names"] = stated_names
            renamed = dict(zip(layout_names, stated_names, strict=True))
            self.names = tuple(renamed.get(name, name) for name in self.names)
        self.said = meaning_of(self.names, case, table.units)
        self.places: dict[str, int] = {}
        self.units: dict[str, str] = {}
        self.guessed: dict[str, str] = {}
        self.orientation: str | None = None
        self.bit: int | None = None  # of the trigger's column
        self.nanoseconds: str | None = None  # column that adds nanoseconds to the stamps
        self.counts = 1.0  # of the clock, for one of its unit
        self.clock_unit_stated = False  # whether the settings must state it, though it is the usual one
        self.doubts: list[str] = []
        self.reasons: dict[str, Reason] = {}  # our name -> why the column is taken for it
        self.unit_reasons: dict[str, Reason] = {}  # our name -> why it has this unit

    @property
    def _says_its_unit(self) -> bool:
        """Whether the unit of the clock follows from the format, or from how stamps are written."""
        return self.table.clock is not None or self.places.get(CLOCK) in self.table.dates

    def name(self, ours: str) -> str:
        """What the file calls a column of ours."""
        return self.names[self.places[ours]]

    def values(self, ours: str) -> Array:
        """The numbers of a column of ours, shape (n,)."""
        return self.numbers[self.places[ours]]

    def place(self) -> None:
        """Our columns by what the case states, then by names.

        Of a group of which the file lacks one that the case names, the names say where it is.
        """
        columns = dict(self.stated.get("columns", {}))
        if column := self.stated.get("trigger", {}).get("column"):
            columns[TRIGGER] = column
        lacking = {ours for ours, theirs in columns.items() if theirs not in self.names}
        stated_places = {
            ours: self.names.index(columns[ours])
            for group in groups_of(self.case)
            if not lacking & {*group}
            for ours in group
            if ours in columns
        }
        used = {*stated_places.values()}
        self.places = {ours: k for ours, k in self.said.places.items() if k in self.numbers and k not in used}
        self.places |= {ours: k for ours, k in stated_places.items() if k in self.numbers or ours == CLOCK}
        self.reasons = {
            ours: because(Why.OUR_NAME if self.names[k] == ours else Why.NAME) for ours, k in self.places.items()
        }
        self.reasons |= {ours: because(Why.CASE_NAMES) for ours in stated_places if ours in self.places}
        if lacking:
            theirs = listed([columns[ours] for ours in columns if ours in lacking])
            self.doubts.append(f"recording.columns of the case names {theirs}, which the file does not have")

    def choose_clock(self) -> None:
        """The clock: that of the format or of the case, else the first of its candidates that runs on."""
        if self.table.clock is not None:
            self.places[CLOCK], self.reasons[CLOCK] = self.table.clock[0], because(Why.FORMAT)
            return
        if CLOCK in self.places:
            return
        running = [k for k in self.said.clocks if k in self.numbers and runs(self.numbers[k])]
        if (parts := self._clock_in_two()) is not None:
            seconds, nanoseconds = parts
            self.places[CLOCK], self.nanoseconds = seconds, self.names[nanoseconds]
            self.reasons[CLOCK] = because(Why.TWO_COLUMNS, column=self.nanoseconds)
            whole = self.numbers[seconds] - self.numbers[seconds][0]
            self.numbers = {**self.numbers, seconds: whole + 1e-9 * self.numbers[nanoseconds]}
        elif running:
            self.places[CLOCK], self.reasons[CLOCK] = running[0], because(Why.RUNS_ON)
            if others := [self.names[k] for k in running[1:]]:
                self.doubts.append(f"{self.name(CLOCK)} is taken for the clock; {', '.join(others)} runs on too")
        elif self.said.clocks:
            which = ", ".join(repr(self.names[k]) for k in self.said.clocks)
            self.doubts.append(f"{which}: by the name a time, but no number that runs on with the rows")
        if CLOCK not in self.places and "period_ms" not in self.stated.get("clock", {}):
            self._clock_without_a_name()

    def _clock_without_a_name(self) -> None:
        """What no name makes a clock, but rises evenly: ticks of 100 ns are one, other numbers may be one."""
        rising = [k for k in sorted({*self.numbers} - {*self.places.values()}) if _rises_evenly(self.numbers[k])]
        for k in rising:
            if FILETIMES[0] < self.numbers[k][0] < FILETIMES[1]:
                self.places[CLOCK], self.reasons[CLOCK] = k, because(Why.TICKS)
                return
        for k in rising:
            name = repr(printable(self.names[k]))
            if np.all(np.diff(self.numbers[k]) == 1.0):
                self.doubts.append(f"{name} counts the rows, which is not a time: state recording.clock.period_ms")
                continue
            self.doubts.append(
                f"{name} rises evenly, as a clock does: if it is one, write t_s = {name} in [recording.columns], and "
                f"its unit in recording.clock.unit ({', '.join(TICKS)})"
            )

    def _clock_in_two(self) -> tuple[int, int] | None:
        """Columns of whole seconds and of nanoseconds on top, as headers of ROS have them; None: there are none."""
        possible = [k for k in self.said.clocks if k in self.numbers and _whole(self.numbers[k])]
        for seconds, nanoseconds in permutations(possible, 2):
            whole, part = self.numbers[seconds], self.numbers[nanoseconds]
            within = len(whole) == len(part) and bool(((part >= 0.0) & (part < 1e9)).all())
            if within and part.max(initial=0.0) > _LEAST_NANOSECONDS and runs(whole - whole[0] + 1e-9 * part):
                return seconds, nanoseconds
        return None

    def choose_single(self) -> None:
        """The trigger and the override: the only candidate, or the only one that changes."""
        for ours, candidates in self.said.candidates.items():
            used = {*self.places.values()}
            possible = [k for k in candidates if k in self.numbers and k not in used and ours not in self.places]
            changing = [k for k in possible if len(np.unique(self.numbers[k][np.isfinite(self.numbers[k])])) > 1]
            chosen = possible if len(possible) == 1 else changing
            if len(chosen) == 1:
                self.places[ours] = chosen[0]
                self.reasons[ours] = because(Why.NAME if chosen is possible else Why.ALONE_CHANGES)
                if ours == TRIGGER and "trigger" not in self.stated:
                    self.choose_bit()
            elif possible:
                each = ", ".join(self.names[k] for k in possible)
                self.doubts.append(f"{each}: each may be the {ours}; name one as {ours} in [recording.columns]")

    def choose_bit(self) -> None:
        """The bit of the trigger's column, where that is a field of bits of which one alone changes."""
        values = self.values(TRIGGER)
        if not np.isfinite(values).all() or switched(values) is not None:
            return
        bits = changing_bits(values)
        if len(bits) == 1:
            self.bit = bits[0]
            self.doubts.append(f"the trigger is taken for bit {self.bit} of {self.name(TRIGGER)}, which alone changes")

    def fit_the_machine(self) -> None:
        """What names cannot say: six drives of a hexapod whose values are lengths that its struts have are struts."""
        if self.case is None:
            return
        drives = [self.values(drive) for drive in DRIVES if drive in self.places]
        whole = STRUTS[0] not in self.places and len(drives) == len(DRIVES) and "drives" not in self.stated
        if whole and strut_unit(drives, self.case):
            for strut, drive in zip(STRUTS, DRIVES, strict=True):
                self.places[strut] = self.places.pop(drive)
                self.reasons[strut] = self.reasons.pop(drive).also(Why.ARE_LENGTHS)
        if self.case.sensor_frame.channels == WRENCH and BAR_FORCES[0] in self.places and WRENCH[0] not in self.places:
            for channel, force in zip(WRENCH, BAR_FORCES, strict=True):
                self.places[channel] = self.places.pop(force)
                self.reasons[channel] = self.reasons.pop(force).also(Why.WRENCH)

    def choose_orientation(self) -> None:
        """The convention of the orientation that the file has, where the case does not state it."""
        if not self.said.orientations or "orientation" in self.stated:
            return
        if QUATERNION[0] in self.places:
            self.orientation = self.said.orientations[0]
            return
        angles = [self.values(ours) for ours in ANGLES if ours in self.places]
        possible = [name for name in self.said.orientations if len(angles) == len(ANGLES) and _possible(name, angles)]
        if not possible:
            return
        chosen, *others = (CONVENTIONS[name] for name in possible)
        by = f" ({chosen.users})" if chosen.users else ""
        more = "; ".join(f"{other.name!r} ({other.users or other.words})" for other in others)
        sentence = f"orientation taken as {chosen.name!r}{by}: {chosen.words}"
        self.doubts.append(f"{sentence}; it may also be {more}: compare" if more else sentence)
        self.orientation = None if chosen is ROLL_PITCH_YAW else chosen.name

    def choose_units(self) -> None:
        """The unit of each column: as the case states, as its label does, as its values say, as our name has it."""
        values = {ours: self.numbers[k] for ours, k in self.places.items() if k in self.numbers}
        by_values = dict(units_of_values(values, self.case))
        stated_units, clock = self.stated.get("units", {}), self.stated.get("clock", {}).get("unit")
        for ours, k in self.places.items():
            role, usual = ROLE_OF.get(ours), _usual_unit(ours)
            label = _stated_unit(ours, self.names[k], self.table.units[k] if k < len(self.table.units) else "")
            if role is not None and str(role) in stated_units:
                self.units[ours], why = str(stated_units[str(role)]), because(Why.CASE_STATES)
            elif ours == CLOCK and k in self.table.dates:
                self.units[ours], why = "ns", because(Why.DATES)
            elif ours == CLOCK and (clock is not None or self.table.clock is not None):
                self.units[ours] = str(clock) if self.table.clock is None else self.table.clock[1]
                why = because(Why.CASE_STATES if self.table.clock is None else Why.FORMAT)
            elif label is not None and (label.symbol is not None or ours != CLOCK):
                self.units[ours], why = label.symbol or label.text, because(Why.LABEL)
            elif ours in by_values and by_values[ours] != usual and self.names[k] != ours:
                self.units[ours] = self.guessed[ours] = by_values[ours]
                why = self._fits(ours)
            else:
                fits = because(Why.OUR_UNIT_FITS if by_values.get(ours) == usual else Why.OUR_UNIT)
                self.units[ours], why = usual, fits if usual else NO_REASON
            self.unit_reasons[ours] = why
            if ours == CLOCK and label is not None and label.symbol is not None and label.counts != 1.0:
                self.counts = label.counts
                self.numbers = {**self.numbers, k: self.numbers[k] / label.counts}  # as the reader counts them too
                self.units[ours], self.clock_unit_stated = label.symbol, True
            if (
                ours == CLOCK
                and label is not None
                and label.symbol is None
                and clock is None
                and self.table.clock is None
            ):
                self.clock_unit_stated = True
                self.doubts.append(
                    f"{self.names[k]}: {label.text!r} is not a unit of time; by their steps the stamps are in "
                    f"{self.units[ours]}"
                )
        self._check_clock_unit(by_values)
        self._check_motion_units(values)
        self._ask_for_scales(values)
        if self.guessed:
            groups: dict[str, list[str]] = {}
            for ours, unit in self.guessed.items():
                groups.setdefault(unit, []).append(ours)
            each = ", ".join(f"{span(group)} in {unit}" for unit, group in groups.items())
            self.doubts.append(f"units guessed from values: {each}; compare them with the recorder's settings")

    def _check_clock_unit(self, by_values: Mapping[str, str]) -> None:
        """A clock whose stated unit makes a recorder slower than any is has the unit that fits its steps."""
        if CLOCK not in by_values or by_values[CLOCK] == self.units[CLOCK] or self._says_its_unit:
            return
        step, wrong, unit = float(np.median(np.diff(self.values(CLOCK)))), self.units[CLOCK], by_values[CLOCK]
        if step <= 0.0 or 1.0 / (step * TICKS[wrong]) >= _SLOW:
            return
        self.doubts.append(
            f"{self.name(CLOCK)}: its steps of {step:.4g} {wrong} would be {1.0 / (step * TICKS[wrong]):.3g} rows a "
            f"second; they seem to be in {unit}, {1.0 / (step * TICKS[unit]):.4g} rows a second: recording.clock.unit"
        )
        self.units[CLOCK] = self.guessed[CLOCK] = unit
        self.unit_reasons[CLOCK] = self._fits(CLOCK)

    def _fits(self, ours: str) -> Reason:
        """Why the unit of a column was taken from its values."""
        if ours == CLOCK:
            step = float(np.median(np.diff(self.values(CLOCK)))) * TICKS[self.units[CLOCK]]
            return because(Why.RATE, rate=f"{1.0 / step:.4g}")
        if ours in STRUTS:
            return because(Why.LENGTHS)
        return because(Why.ENDS if ROLE_OF.get(ours) is Role.JOINTS else Why.SMALL)

    def _check_motion_units(self, values: Mapping[str, Array]) -> None:
        """Says where joints, in the unit that is stated, are where the machine does not come."""
        for unit, columns, sure in units_of_motion(values, self.case):
            if sure and not self.guessed.keys() & {*columns} and {self.units[ours] for ours in columns} != {unit}:
                role = ROLE_OF[columns[0]]
                self.doubts.append(
                    f"{span(columns)}: in {self.units[columns[0]]} the joints are far from home or beyond their ends, "
                    f"in {unit} they are not; if they are in {unit}, state recording.units.{role} = '{unit}'"
                )

    def _ask_for_scales(self, values: Mapping[str, Array]) -> None:
        """Says which channels need a scale: those in counts, or in a unit of another quantity."""
        needed: list[str] = []
        for ours, column in values.items():
            role = ROLE_OF.get(ours)
            if role is None or ours in self.stated.get("scale", {}) or str(role) in self.stated.get("units", {}):
                continue
            counts = self.name(ours) != ours and counted(self.name(ours), _whole(column)) is not None
            if counts or ROLE_UNITS[role].symbol(self.units[ours]) is None:
                needed.append(ours)
                self.units[ours] = "counts" if counts else self.units[ours]
                self.unit_reasons[ours] = because(Why.NO_UNIT)
        if needed:
            keys = ", ".join(f"{ours} = .." for ours in needed)
            shares = all(is_share(self.units[ours]) for ours in needed)
            ranges = None if self.case is None else self.case.sensors.range
            stated = scale_of_shares(needed, ranges) if shares else None
            what = "what a 1 of each is in the unit of our name"
            if stated is not None:
                what = f"the range of each over 100{'' if ranges is None else ', by [sensors] of the case'}"
            self.doubts.append(
                f"{span([self.name(ours) for ours in needed])}: state {what}: "
                f"{stated or f'recording.scale = {{ {keys} }}'}"
            )

    def settings(self) -> dict[str, Any]:
        """The table `[recording]`, with what the case states beside names, units and layout."""
        result = {key: value for key, value in self.layout.items() if value is not None}
        own_clock = self.table.clock is not None  # which the format says
        dated = self.places.get(CLOCK) in self.table.dates  # whose unit follows from how they are written
        ordered = [ours for ours in COLUMNS if ours in self.places and not (own_clock and ours == CLOCK)]
        renamed = {ours: self.name(ours) for ours in ordered if self.name(ours) != ours}
        if self.bit is not None or "column" in self.stated.get("trigger", {}):
            renamed.pop(TRIGGER, None)
        if self.bit is not None:
            result["trigger"] = {"column": self.name(TRIGGER), "bit": self.bit}
        result |= {"columns": renamed} if renamed else {}
        if units := dict(self._differing_units(ordered)):
            result["units"] = units
        clock = dict(self.stated.get("clock", {}))  # some formats are not valid without a unit
        if CLOCK in self.places and not self.as_stated and clock.pop("period_ms", None) is not None:
            self.doubts.append(f"{self.name(CLOCK)} has time stamps: recording.clock.period_ms of the case is left out")
        if CLOCK not in self.places and "period_ms" not in clock:
            clock |= self._step_of_header()
        if not own_clock:
            stated = clock.pop("unit", None) is not None and CLOCK in self.units
            if not dated and (stated or self.clock_unit_stated or self.units.get(CLOCK, "s") != "s"):
                clock = {"unit": self.units[CLOCK], **clock}
        clock |= result.pop("clock", {})
        clock |= {} if self.nanoseconds is None else {"nanoseconds": self.nanoseconds}
        result |= {"clock": clock} if clock else {}
        result |= {"orientation": self.orientation} if self.orientation is not None else {}
        keys = LAYOUT | {"columns", "units", "clock", "filter_cutoff_Hz", "rate_Hz", "files"}
        result |= {key: value for key, value in self.stated.items() if key not in keys}
        self._add_filter(result)
        return result

    def _step_of_header(self) -> dict[str, Any]:
        """The clock of a file whose rows have no time, where its header says how far apart they are."""
        step = stated_step(self.table.header)
        if step is None or self.said.clocks:
            return {}
        period = float(f"{step.period * 1e3:.9g}")
        self.doubts.append(f"no column is a clock; {printable(step.text)!r} in the header: recording.clock.period_ms")
        self.unit_reasons[CLOCK] = because(Why.HEADER)
        return {"period_ms": period}

    def _check_stated_rate(self, rate: float | None) -> None:
        """Says where a header states another rate than the time stamps have."""
        step = stated_step(self.table.header)
        if step is None or rate is None or abs(rate * step.period - 1.0) < _OTHER_RATE:
            return
        self.doubts.append(
            f"{self.name(CLOCK)} makes {rate:.4g} rows a second, the header says {printable(step.text)!r}: check the "
            "unit of the time stamps, recording.clock.unit"
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
            "clock": self.unit_reasons.get(CLOCK, NO_REASON),
            "trigger": because(Why.BIT, bit=self.bit),
            "orientation": because(Why.ORIENTATION, conventions=", ".join(self.said.orientations)),
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
            of_role = {self.units[ours] for ours in ordered if ROLE_OF.get(ours) == role}
            stated_unit = self.stated.get("units", {}).get(str(role))
            if len(of_role) == 1 and of_role <= factors.keys() - ({factors.usual} - {stated_unit}):
                yield str(role), of_role.pop()

    def _add_filter(self, settings: dict[str, Any]) -> None:
        """The cut-off, which a fifth of the rate limits, and the rate where it is not the usual one."""
        cutoff = float(self.stated.get("filter_cutoff_Hz", CUTOFF_HZ))
        rate = rate_of(self.places, self.units, self.numbers, settings)
        if CLOCK in self.places:
            self._check_stated_rate(rate)
        if rate is not None and cutoff < LEAST_CUTOFF_HZ <= _CUTOFF_SHARE * rate:
            usual = min(CUTOFF_HZ, float(f"{_CUTOFF_SHARE * rate:.2g}"))
            self.doubts.append(
                f"filter_cutoff_Hz = {cutoff:g} of the case leaves nothing of a motion; {rate:.4g} rows a second carry "
                f"{usual:g}"
            )
            cutoff = usual
        if rate is not None and cutoff > 0.2 * rate:
            carried = float(f"{_CUTOFF_SHARE * rate:.2g}")
            low = "; that leaves nothing of an excitation: record faster, or correct the clock"
            self.doubts.append(
                f"filter_cutoff_Hz: {rate:.4g} rows a second carry a fifth of that at most, {carried:g} Hz in place of "
                f"{cutoff:g} Hz{low if carried < LEAST_CUTOFF_HZ else ''}"
            )
            cutoff = carried
        settings["filter_cutoff_Hz"] = cutoff
        expected = float(self.stated.get("rate_Hz", USUAL_RATE))
        if rate is not None and not 0.99 < rate / expected < 1.01:
            expected = float(f"{rate:.4g}")
        if expected != USUAL_RATE or "rate_Hz" in self.stated:
            settings["rate_Hz"] = expected


def runs(stamps: Array) -> bool:
    """Whether numbers, shape (n,), can be the stamps of a clock; a few that go back are for the reader to name."""
    steps = np.diff(stamps)
    if not len(steps) or not np.isfinite(steps).all():
        return False
    way = float(np.abs(steps).sum())
    return bool(np.mean(steps > 0.0) >= _RUNNING) and way > 0.0 and float(steps.sum()) >= _ONWARD * way


def _rises_evenly(values: Array) -> bool:
    """Whether numbers, shape (n,), rise from row to row, by steps that are nearly alike."""
    steps = np.diff(values)
    if len(steps) < _EVEN_ROWS or not (np.isfinite(steps).all() and (steps > 0.0).all()):
        return False
    usual = float(np.median(steps))
    return bool(np.mean((steps > usual / _EVEN) & (steps < usual * _EVEN)) > _NEARLY)


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


def _possible(convention: str, angles: Sequence[Array]) -> bool:
    """Whether three numbers, shapes (n,), can be an orientation of a convention, in degrees or in radians."""
    size = max(float(np.nanmax(np.abs(angle), initial=0.0)) for angle in angles)
    half = np.pi if size <= MOST_RADIANS else 180.0
    if convention == "rotation vector":
        return bool(np.nanmax(np.linalg.norm(angles, axis=0), initial=0.0) <= 1.003 * half)
    if convention.startswith("zyz"):
        return bool(np.nanmin(angles[1], initial=0.0) >= -0.003 * half)
    return bool(np.nanmax(np.abs(angles[1]), initial=0.0) <= 0.503 * half)


def _usual_unit(ours: str) -> str:
    """The unit that the name of a column of ours has."""
    return "s" if ours == CLOCK else ROLE_UNITS[ROLE_OF[ours]].usual if ours in ROLE_OF else ""


def _whole(values: Array) -> bool:
    numbers = values[np.isfinite(values)]
    return bool(len(numbers)) and bool(np.all(numbers == np.rint(numbers)))


def _stated_unit(ours: str, label: str, cell: str) -> StatedUnit | None:
    """The unit that a label, or a cell of a row of units, states for a column of ours."""
    units = TICKS if ours == CLOCK else ROLE_UNITS[ROLE_OF[ours]] if ours in ROLE_OF else None
    if units is None:
        return None
    stated = stated_unit("" if label in COLUMNS else label, cell, units)
    if stated is None and ours == CLOCK and label not in COLUMNS:
        words = words_of(label)
        unit = next((CLOCK_UNITS[word] for word in words[::-1] if word in CLOCK_UNITS), None)
        return None if unit is None else StatedUnit(unit, unit)
    return stated
