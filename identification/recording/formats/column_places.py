"""Which column of a file is which of ours: by the case, by names, and by values where these leave it open."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any

import numpy as np

from cases.base.errors import printable
from cases.base.phrases import Phrase, phrase, said
from cases.base.units import Array
from cases.orientation import ANGLES, CONVENTIONS, QUATERNION, ROLL_PITCH_YAW
from cases.recording_format import BAR_FORCES, CLOCK, DRIVES, STRUTS, TICKS, TRIGGER, WRENCH
from cases.schema import Case
from identification.recording.formats.layout import TextColumns
from identification.recording.formats.names.meaning import Meaning, groups_of, meaning_of
from identification.recording.formats.reasons import Reason, Why, because
from identification.recording.formats.table import listed
from identification.recording.formats.triggers import changing_bits, switched
from identification.recording.formats.units_by_values import FILETIMES, MOST_RADIANS, strut_unit

_RUNNING = 0.04  # share of the steps of a clock that go on, at least: others stand for many rows
_EVEN_ROWS, _EVEN, _NEARLY = 20, 1.5, 0.95  # a clock without a name: least steps, times the usual one, share of them
_ONWARD = 0.5  # sum of all steps over that of their sizes, at least: others begin anew again and again
_LEAST_NANOSECONDS = 1e6  # in a column of nanoseconds that adds to seconds: a thousandth of a second


@dataclass(frozen=True, slots=True)
class ColumnPlaces:
    """Which column of a file is which of ours, and why."""

    said: Meaning  # what the names say
    names: tuple[str, ...]  # of the columns, those that the case gives them where the file does not
    numbers: Mapping[int, Array]  # position in the file -> numbers, shape (n,), of a clock in two columns both together
    places: Mapping[str, int]  # our name -> position in the file
    reasons: Mapping[str, Reason]  # our name -> why the column is taken for it
    doubts: tuple[Phrase, ...]  # what a person should compare or complete, a sentence each
    orientation: str | None  # convention of the orientation; None for the usual one
    bit: int | None  # bit of the trigger's column
    nanoseconds: str | None  # column that adds nanoseconds to the stamps

    def name(self, ours: str) -> str:
        """What the file calls a column of ours."""
        return self.names[self.places[ours]]

    def values(self, ours: str) -> Array:
        """The numbers of a column of ours, shape (n,)."""
        return self.numbers[self.places[ours]]


def column_places(
    table: TextColumns, case: Case | None, stated: Mapping[str, Any], names: tuple[str, ...]
) -> ColumnPlaces:
    """Which column of a file is which of ours.

    Args:
        table: the file.
        case: machine that the file is from; None: names alone count.
        stated: keys that the case states in `[recording]`, as TOML has them.
        names: names of the columns.
    """
    draft = _Draft(table, case, stated, names)
    draft.place()
    draft.choose_clock()
    draft.choose_single()
    draft.fit_the_machine()
    draft.doubts += draft.said.doubts
    draft.choose_orientation()
    return ColumnPlaces(
        draft.said, names, draft.numbers, draft.places, draft.reasons, tuple(draft.doubts), draft.orientation,
        draft.bit, draft.nanoseconds,
    )  # fmt: skip


class _Draft:
    """Places of columns while they are looked for, in the order of `column_places`."""

    def __init__(
        self, table: TextColumns, case: Case | None, stated: Mapping[str, Any], names: tuple[str, ...]
    ) -> None:
        self.table, self.case, self.stated, self.names = table, case, stated, names
        self.numbers: Mapping[int, Array] = table.numbers
        self.said = meaning_of(names, case, table.units)
        self.places: dict[str, int] = {}
        self.orientation: str | None = None
        self.bit: int | None = None
        self.nanoseconds: str | None = None
        self.doubts: list[Phrase] = []
        self.reasons: dict[str, Reason] = {}

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
            self.doubts.append(
                phrase(
                    "names_of_case",
                    "the case was for files of another kind: recording.columns names {theirs}, which the file does not "
                    "have; the proposal takes its own names",
                    theirs=theirs,
                )
            )

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
                self.doubts.append(
                    phrase(
                        "taken_for_clock",
                        "{name} is taken for the clock; {others} runs on too",
                        name=self.name(CLOCK),
                        others=", ".join(others),
                    )
                )
        elif idle := [k for k in self.said.clocks if k not in self.places.values()]:
            which = ", ".join(repr(self.names[k]) for k in idle)
            self.doubts.append(
                phrase(
                    "time_by_name", "{which}: by the name a time, but no number that runs on with the rows", which=which
                )
            )
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
                self.doubts.append(
                    phrase(
                        "counts_rows",
                        "{name} counts the rows, which is not a time: state recording.clock.period_ms",
                        name=name,
                    )
                )
                continue
            self.doubts.append(
                phrase(
                    "rises_evenly",
                    "{name} rises evenly, as a clock does: if it is one, write t_s = {name} in [recording.columns], "
                    "and its unit in recording.clock.unit ({units})",
                    name=name,
                    units=", ".join(TICKS),
                )
            )

    def _clock_in_two(self) -> tuple[int, int] | None:
        """Columns of whole seconds and of nanoseconds on top, as headers of ROS have them; None: there are none."""
        possible = [k for k in self.said.clocks if k in self.numbers and are_whole(self.numbers[k])]
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
                self.doubts.append(
                    phrase(
                        "each_may_be",
                        "{names}: each may be the {ours}; name one as {ours} in [recording.columns]",
                        names=each,
                        ours=ours,
                    )
                )

    def choose_bit(self) -> None:
        """The bit of the trigger's column, where that is a field of bits of which one alone changes."""
        values = self.values(TRIGGER)
        if not np.isfinite(values).all() or switched(values) is not None:
            return
        bits = changing_bits(values)
        if len(bits) == 1:
            self.bit = bits[0]
            self.doubts.append(
                phrase(
                    "taken_for_bit",
                    "the trigger is taken for bit {bit} of {column}, which alone changes",
                    bit=self.bit,
                    column=self.name(TRIGGER),
                )
            )

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
        sentence = phrase(
            "orientation_taken",
            "orientation taken as {name}: {words}",
            name=f"{chosen.name!r}{by}",
            words=said(chosen.words),
        )
        if more:
            sentence = phrase(
                "orientation_or", "{sentence}; it may also be {more}: compare", sentence=sentence, more=said(more)
            )
        self.doubts.append(sentence)
        self.orientation = None if chosen is ROLL_PITCH_YAW else chosen.name


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


def _possible(convention: str, angles: Sequence[Array]) -> bool:
    """Whether three numbers, shapes (n,), can be an orientation of a convention, in degrees or in radians."""
    size = max(float(np.nanmax(np.abs(angle), initial=0.0)) for angle in angles)
    half = np.pi if size <= MOST_RADIANS else 180.0
    if convention == "rotation vector":
        return bool(np.nanmax(np.linalg.norm(angles, axis=0), initial=0.0) <= 1.003 * half)
    if convention.startswith("zyz"):
        return bool(np.nanmin(angles[1], initial=0.0) >= -0.003 * half)
    return bool(np.nanmax(np.abs(angles[1]), initial=0.0) <= 0.503 * half)


def are_whole(values: Array) -> bool:
    """Whether all numbers that are there, shape (n,), are integers; not where there are none."""
    numbers = values[np.isfinite(values)]
    return bool(len(numbers)) and bool(np.all(numbers == np.rint(numbers)))
