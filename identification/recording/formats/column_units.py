"""Units of a file's columns: as the case states, as labels do, as values say, as our names have them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cases.base.phrases import Phrase, enumerated, phrase
from cases.base.unit_names import is_share
from cases.base.units import Array
from cases.recording_format import CLOCK, COLUMNS, ROLE_OF, ROLE_UNITS, STRUTS, TICKS, Role
from cases.schema import Case
from identification.recording.formats.column_places import ColumnPlaces, are_whole
from identification.recording.formats.layout import TextColumns
from identification.recording.formats.names.families import words_of
from identification.recording.formats.names.labels import StatedUnit, counted, stated_unit
from identification.recording.formats.names.meaning import span
from identification.recording.formats.names.vocabulary import CLOCK_UNITS
from identification.recording.formats.quantities import scale_of_shares
from identification.recording.formats.reasons import NO_REASON, Reason, Why, because
from identification.recording.formats.units_by_values import units_of_motion, units_of_values

_SLOW = 1.0  # rows per second below which a stated unit of stamps is taken for an error


@dataclass(frozen=True, slots=True)
class ColumnUnits:
    """The unit of each column of a file, and why."""

    units: Mapping[str, str]  # our name -> unit that the file is taken to use; empty where there is none
    guessed: Mapping[str, str]  # those of them that follow from values alone
    reasons: Mapping[str, Reason]  # our name -> why it has this unit
    doubts: tuple[Phrase, ...]  # what a person should compare or complete, a sentence each
    numbers: Mapping[int, Array]  # position in the file -> numbers, shape (n,), those of the clock in its unit
    clock_counts: float  # numbers of the clock for one of its unit, as its label says
    clock_unit_stated: bool  # whether the settings must state the clock's, though it is the usual one


def column_units(
    table: TextColumns, case: Case | None, stated: Mapping[str, Any], columns: ColumnPlaces
) -> ColumnUnits:
    """The unit of each column; arguments as of `column_places`."""
    draft = _Draft(table, case, stated, columns)
    draft.choose_units()
    return ColumnUnits(
        draft.units, draft.guessed, draft.reasons, tuple(draft.doubts), draft.numbers, draft.counts,
        draft.clock_unit_stated,
    )  # fmt: skip


class _Draft:
    """Units while they are chosen."""

    def __init__(self, table: TextColumns, case: Case | None, stated: Mapping[str, Any], columns: ColumnPlaces) -> None:
        self.table, self.case, self.stated, self.columns = table, case, stated, columns
        self.numbers = columns.numbers
        self.units: dict[str, str] = {}
        self.guessed: dict[str, str] = {}
        self.counts = 1.0
        self.clock_unit_stated = False
        self.doubts: list[Phrase] = []
        self.reasons: dict[str, Reason] = {}

    @property
    def _says_its_unit(self) -> bool:
        """Whether the unit of the clock follows from the format, or from how stamps are written."""
        return self.table.clock is not None or self.columns.places.get(CLOCK) in self.table.dates

    def _values(self, ours: str) -> Array:
        """The numbers of a column of ours, shape (n,)."""
        return self.numbers[self.columns.places[ours]]

    def choose_units(self) -> None:
        """The unit of each column: as the case states, as its label does, as its values say, as our name has it."""
        values = {ours: self.numbers[k] for ours, k in self.columns.places.items() if k in self.numbers}
        by_values = dict(units_of_values(values, self.case))
        labels = labels_of(self.table, self.columns)
        for ours, k in self.columns.places.items():
            label = labels[ours]
            self.units[ours], self.reasons[ours] = self._unit(ours, k, label, by_values)
            if ours == CLOCK and label is not None and label.symbol is not None and label.counts != 1.0:
                self.counts = label.counts
                self.numbers = {**self.numbers, k: self.numbers[k] / label.counts}  # as the reader counts them too
                self.units[ours], self.clock_unit_stated = label.symbol, True
            if (
                ours == CLOCK
                and label is not None
                and label.symbol is None
                and self._stated_clock is None
                and self.table.clock is None
            ):
                self.clock_unit_stated = True
                self.doubts.append(
                    phrase(
                        "not_a_time_unit",
                        "{name}: {text} is not a unit of time; by their steps the stamps are in {unit}",
                        name=self.columns.names[k],
                        text=repr(label.text),
                        unit=self.units[ours],
                    )
                )
        self._check_clock_unit(by_values)
        self._check_motion_units(values)
        self._ask_for_scales(values)
        self._doubt_guesses()

    @property
    def _stated_clock(self) -> str | None:
        """The unit of time stamps that the case states."""
        unit: str | None = self.stated.get("clock", {}).get("unit")
        return unit

    def _unit(self, ours: str, k: int, label: StatedUnit | None, by_values: Mapping[str, str]) -> tuple[str, Reason]:
        """The unit of a column of ours, the k-th of the file, and why: the first of these that says one."""
        role, usual, clock = ROLE_OF.get(ours), _usual_unit(ours), self._stated_clock
        stated_units = self.stated.get("units", {})
        if role is not None and str(role) in stated_units:
            return str(stated_units[str(role)]), because(Why.CASE_STATES)
        if ours == CLOCK and k in self.table.dates:
            return "ns", because(Why.DATES)
        if ours == CLOCK and self.table.clock is not None:
            return self.table.clock[1], because(Why.FORMAT)
        if ours == CLOCK and clock is not None:
            return clock, because(Why.CASE_STATES)
        if label is not None and (label.symbol is not None or ours != CLOCK):
            return label.symbol or label.text, because(Why.LABEL)
        if ours in by_values and by_values[ours] != usual and self.columns.names[k] != ours:
            self.units[ours] = self.guessed[ours] = by_values[ours]
            return by_values[ours], self._fits(ours)
        fits = because(Why.OUR_UNIT_FITS if by_values.get(ours) == usual else Why.OUR_UNIT)
        return usual, fits if usual else NO_REASON

    def _doubt_guesses(self) -> None:
        """Units that follow from values alone are to be compared with the recorder's."""
        groups: dict[str, list[str]] = {}
        for ours, unit in self.guessed.items():
            groups.setdefault(unit, []).append(ours)
        each = [phrase("span_in", "{names} in {unit}", names=span(group), unit=unit) for unit, group in groups.items()]
        if each:
            words = "units guessed from values: {each}; compare them with the recorder's settings"
            self.doubts.append(phrase("units_guessed", words, each=enumerated("comma", each)))

    def _check_clock_unit(self, by_values: Mapping[str, str]) -> None:
        """A clock whose stated unit makes a recorder slower than any is has the unit that fits its steps."""
        if CLOCK not in by_values or by_values[CLOCK] == self.units[CLOCK] or self._says_its_unit:
            return
        step, wrong, unit = float(np.median(np.diff(self._values(CLOCK)))), self.units[CLOCK], by_values[CLOCK]
        if step <= 0.0 or 1.0 / (step * TICKS[wrong]) >= _SLOW:
            return
        self.doubts.append(
            phrase(
                "other_clock_unit",
                "{name}: its steps of {step} {wrong} would be {slow} rows a second; they seem to be in {unit}, {rate} "
                "rows a second: recording.clock.unit",
                name=self.columns.name(CLOCK),
                step=f"{step:.4g}",
                wrong=wrong,
                slow=f"{1.0 / (step * TICKS[wrong]):.3g}",
                unit=unit,
                rate=f"{1.0 / (step * TICKS[unit]):.4g}",
            )
        )
        self.units[CLOCK] = self.guessed[CLOCK] = unit
        self.reasons[CLOCK] = self._fits(CLOCK)

    def _fits(self, ours: str) -> Reason:
        """Why the unit of a column was taken from its values."""
        if ours == CLOCK:
            step = float(np.median(np.diff(self._values(CLOCK)))) * TICKS[self.units[CLOCK]]
            return because(Why.RATE, rate=f"{1.0 / step:.4g}")
        if ours in STRUTS:
            return because(Why.LENGTHS)
        if ROLE_OF.get(ours) is Role.POSITIONS:
            return because(Why.NEAR_HOME)
        return because(Why.ENDS if ROLE_OF.get(ours) is Role.JOINTS else Why.SMALL)

    def _check_motion_units(self, values: Mapping[str, Array]) -> None:
        """Says where joints, in the unit that is stated, are where the machine does not come."""
        for unit, columns, sure in units_of_motion(values, self.case):
            if sure and not self.guessed.keys() & {*columns} and {self.units[ours] for ours in columns} != {unit}:
                role = ROLE_OF[columns[0]]
                self.doubts.append(
                    phrase(
                        "joints_far",
                        "{names}: in {wrong} the joints are far from home or beyond their ends, in {unit} they are "
                        "not; if they are in {unit}, state recording.units.{role} = '{unit}'",
                        names=span(columns),
                        wrong=self.units[columns[0]],
                        unit=unit,
                        role=role,
                    )
                )

    def _ask_for_scales(self, values: Mapping[str, Array]) -> None:
        """Says which channels need a scale: those in counts, or in a unit of another quantity."""
        needed: list[str] = []
        for ours, column in values.items():
            role = ROLE_OF.get(ours)
            if role is None or ours in self.stated.get("scale", {}) or str(role) in self.stated.get("units", {}):
                continue
            counts = self.columns.name(ours) != ours and counted(self.columns.name(ours), are_whole(column)) is not None
            if counts or ROLE_UNITS[role].symbol(self.units[ours]) is None:
                needed.append(ours)
                self.units[ours] = "counts" if counts else self.units[ours]
                self.reasons[ours] = because(Why.NO_UNIT)
        if needed:
            keys = ", ".join(f"{ours} = .." for ours in needed)
            shares = all(is_share(self.units[ours]) for ours in needed)
            ranges = None if self.case is None else self.case.sensors.range
            stated = scale_of_shares(needed, ranges) if shares else None
            what = phrase("what_a_1_is", "what a 1 of each is in the unit of our name")
            if stated is not None and ranges is None:
                what = phrase("range_over_100", "the range of each over 100")
            elif stated is not None:
                what = phrase("range_of_case", "the range of each over 100, by [sensors] of the case")
            self.doubts.append(
                phrase(
                    "state_scales",
                    "{names}: state {what}: {keys}",
                    names=span([self.columns.name(ours) for ours in needed]),
                    what=what,
                    keys=stated or f"recording.scale = {{ {keys} }}",
                )
            )


def labels_of(table: TextColumns, columns: ColumnPlaces) -> dict[str, StatedUnit | None]:
    """The unit that the file states for each column of ours; None where it states none."""
    units = table.units
    return {
        ours: _stated_unit(ours, columns.names[k], units[k] if k < len(units) else "")
        for ours, k in columns.places.items()
    }


def _usual_unit(ours: str) -> str:
    """The unit that the name of a column of ours has."""
    return "s" if ours == CLOCK else ROLE_UNITS[ROLE_OF[ours]].usual if ours in ROLE_OF else ""


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
