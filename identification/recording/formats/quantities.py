"""Units of the columns that are used: what the case states, else what the file states; else that of our name.

A unit that is not known, or not of the column's quantity, is refused: no unit is taken for the usual one because it
could not be read. What the case states wins, for labels err too; that they differ is a finding.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cases.base.errors import Code, RecordingError, Remedy, Write
from cases.base.phrases import NOTHING, phrase
from cases.base.unit_names import is_share, is_unit
from cases.base.units import Array
from cases.recording_format import (
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    ROLE_OF,
    ROLE_UNITS,
    TICKS,
    WRENCH,
    FileFormat,
    FileOfRun,
    RecordingFormat,
    Role,
)
from identification.finding import Finding, Kind, note, warning
from identification.recording.formats.names.families import words_of
from identification.recording.formats.names.labels import StatedUnit, counted, is_count, stated_unit
from identification.recording.formats.names.vocabulary import computed
from identification.recording.formats.table import ColumnTable, shown

_FORCES = (*BAR_FORCES, *WRENCH)
_ENOUGH = 1000  # rows that show whether numbers are whole
MOST_BEYOND = 0.3  # share of a channel's readings beyond its range, from which on its unit cannot be right


def with_units(table: ColumnTable, ranges: Array | None = None) -> ColumnTable:
    """The table with SI values of its columns' units, with findings about them; raises RecordingError.

    Args:
        table: the table, in the units of the file.
        ranges: of the force channels, as of `Sensors.range`; the error names what shares of them are then.
    """
    form = table.form
    factors: dict[str, float] = {}
    by_label: dict[Role, list[tuple[str, StatedUnit]]] = {}
    contradicted: dict[Role, list[tuple[str, StatedUnit]]] = {}
    unknown: dict[str, StatedUnit] = {}
    silent: dict[Role, list[str]] = {}
    for ours, values in table.values.items():
        role = ROLE_OF.get(ours)
        factors[ours] = form.factor(ours)
        if role is None or ours in form.scale:
            continue
        units, label = ROLE_UNITS[role], form.file_name(ours)
        stated = _stated(table, ours)
        if role in form.units:
            if stated is None:
                continue
            if stated.counts != 1.0 and label not in COLUMNS:
                factors[ours] /= stated.counts
                by_label.setdefault(role, []).append((label, stated))
            elif (stated.several or is_unit(stated.text)) and stated.symbol != units.symbol(form.units[role]):
                contradicted.setdefault(role, []).append((label, stated))
        elif stated is None:
            if label not in COLUMNS and (word := counted(label, _whole(values))):
                unknown[ours] = StatedUnit(word, None)
            elif label not in COLUMNS:
                silent.setdefault(role, []).append(ours)
        elif stated.symbol is None or stated.several:
            unknown[ours] = stated
        else:
            factors[ours] = units[stated.symbol] / stated.counts
            if stated.symbol != units.usual or stated.counts != 1.0:
                by_label.setdefault(role, []).append((label, stated))
    if unknown:
        raise _refusal(table, unknown, ranges)
    for role, columns in silent.items():
        if beside := by_label.get(role) or (by_label.get(Role.FORCES) if role is Role.MOMENTS else None):
            raise _without_a_unit(table, role, columns, *beside[0])
    findings = [
        note(
            Kind.FORMAT,
            phrase(
                "read_in_unit",
                "{role} are read in {unit}, as the file says of {columns}, {file}",
                role=role,
                unit=_symbols(columns),
                columns=_labels(columns),
                file=table.source,
            ),
        )
        for role, columns in by_label.items()
    ]
    findings += [
        replace(
            contradiction(
                f"{_table_of(form)}.units.{role}", _labels(columns), _symbols(columns), form.units[role], table.source
            ),
            remedies=_by_label(table, role, columns, ranges),
        )
        for role, columns in contradicted.items()
    ]
    tick, of_clock = _tick(table)
    all_findings = (*table.findings, *findings, *of_clock, *_whole_forces(table), *_no_readings(table))
    return replace(table, factors=factors, tick=tick, findings=all_findings)


def fits_range(forces: Array, most: float) -> bool:
    """Whether readings, shape (n,) or (n, k) [N], are within a sensor's range [N], but for a few."""
    known = forces[np.isfinite(forces)]
    return not known.size or bool(np.mean(np.abs(known) >= most) <= MOST_BEYOND)


def force_unit_in_range(forces: Array, kept: str, most: float) -> str | None:
    """The unit that fits a sensor's range where the kept one does not: that of our names; None where that is no help.

    >>> force_unit_in_range(np.array([120.0, -80.0, 95.0]), "kN", 5000.0)
    'N'

    Args:
        forces: readings as the file has them, shape (n,) or (n, k).
        kept: unit that the case keeps.
        most: range of a sensor [N].
    """
    units = ROLE_UNITS[Role.FORCES]
    symbol = units.symbol(kept) or units.usual
    if symbol == units.usual or fits_range(forces * units[symbol], most):
        return None
    return units.usual if fits_range(forces * units[units.usual], most) else None


CONTRADICTED = "contradicted"
"""Key of what a file says of a unit otherwise than the settings."""


def contradiction(key: str, labels: str, says: str, used: str, source: str = "", whose: str = "of the case") -> Finding:
    """What to say where a file states a unit otherwise than the settings, which are used.

    Args:
        key: of the settings.
        labels: columns of the file.
        says: the unit by the file.
        used: the unit by the settings.
        source: the file.
        whose: words for whose settings they are.
    """
    sentence = f"the file says {says} of {labels}, {key} {whose} says {used}, which is used; correct one of them"
    entries = {"key": key, "labels": labels, "says": says, "used": used}
    return warning(Kind.FORMAT, sentence, source, contradicted=entries)


def _table_of(form: FileFormat) -> str:
    """Where the keys of a file stand in its case."""
    return f"recording.files[{form.number + 1}]" if isinstance(form, FileOfRun) else "recording"


def _by_label(
    table: ColumnTable, role: Role, columns: Sequence[tuple[str, StatedUnit]], ranges: Array | None
) -> tuple[Remedy, ...]:
    """The key by which forces are read in the unit of their labels, tried: they are within their ranges then."""
    symbols = {stated.symbol for _, stated in columns if not stated.several}
    named = [ours for ours in table.values if ROLE_OF.get(ours) is role and ours in _FORCES]
    if len(symbols) != 1 or len(columns) != len(named) or ranges is None or not isinstance(table.form, RecordingFormat):
        return ()
    symbol = symbols.pop()
    if symbol is None:
        return ()
    most = float(ranges[0 if role is Role.FORCES else 3])
    if not all(fits_range(table.values[ours] * ROLE_UNITS[role][symbol], most) for ours in named):
        return ()
    return (
        Remedy(
            phrase("unit_of_labels", "the unit is that of the labels"), (Write(("recording", "units", role), symbol),)
        ),
    )


def _stated(table: ColumnTable, ours: str) -> StatedUnit | None:
    """The unit that the file states for a column; beside a name of ours, which says one too, several if it differs."""
    label = table.form.file_name(ours)
    units = TICKS if ours == CLOCK else ROLE_UNITS[ROLE_OF[ours]]
    if label not in COLUMNS:
        return stated_unit(label, table.unit_cells.get(ours, ""), units, table.header)
    stated = stated_unit("", table.unit_cells.get(ours, ""), units, table.header)
    if stated is None or stated.symbol is None or (stated.symbol == units.usual and stated.counts == 1.0):
        return stated
    other = stated.text if stated.counts == 1.0 else f"{stated.text}/{stated.counts:.6g}"
    return replace(stated, text=f"{units.usual} and {other}", several=True)


def scale_of_shares(columns: Sequence[str], ranges: Array | None) -> str | None:
    """The key that reads forces which are given as percent of their ranges; None where a column is not a force.

    Args:
        columns: our names.
        ranges: of the channels, shape (6,) [N, or N and N m]; None where the case does not say.
    """
    names = WRENCH if {*columns} <= {*WRENCH} else BAR_FORCES
    if not {*columns} <= {*names}:
        return None
    one = {ours: ".." if ranges is None else f"{ranges[names.index(ours)] / 100.0:.6g}" for ours in columns}
    return f"recording.scale = {{ {', '.join(f'{ours} = {value}' for ours, value in one.items())} }}"


def _refusal(table: ColumnTable, unknown: Mapping[str, StatedUnit], ranges: Array | None) -> RecordingError:
    """The error for columns whose unit is not known, our name -> what the file says."""
    ours, stated = next(iter(unknown.items()))
    role, label = ROLE_OF[ours], table.form.file_name(ours)
    units = ROLE_UNITS[role]
    others = phrase("likewise", " (likewise {count} more)", count=len(unknown) - 1) if len(unknown) > 1 else NOTHING
    scale = phrase(
        "scale_of",
        "recording.scale = {{ {ours} = .. }}, what a 1 of each channel is in {usual}",
        ours=ours,
        usual=units.usual,
    )
    remedy = phrase(
        "state_unit",
        "state recording.units.{role}, one of {units}; or {scale}",
        role=role,
        units=", ".join(units),
        scale=scale,
    )
    if is_count(stated.text):
        problem = phrase(
            "counts",
            "holds counts ({text}), which have a unit by a factor only{others}",
            text=shown(stated.text),
            others=others,
        )
        remedy = phrase(
            "state_scale",
            "state {scale}; where they are {role} already, recording.units.{role} = '{usual}'",
            scale=scale,
            role=role,
            usual=units.usual,
        )
    elif is_share(stated.text) and (keys := scale_of_shares([*unknown], ranges)) is not None:
        problem = phrase(
            "shares",
            "holds shares of a range ({text}), which have a unit by that range only{others}",
            text=shown(stated.text),
            others=others,
        )
        range_words = (
            phrase("over_100", "the range of each sensor over 100 (over 1 where numbers end at 1)")
            if ranges is None
            else phrase(
                "range_of_sensors", "if 100 % is the range in [sensors]; else the range that the recorder has, over 100"
            )
        )
        remedy = phrase("state_range", "state {keys}, {range}", keys=keys, range=range_words)
    elif stated.several:
        problem = phrase(
            "several_units", "has units that differ, {text}{others}", text=shown(stated.text), others=others
        )
    else:
        problem = phrase(
            "unknown_unit",
            "{text} is not a known unit of {role}{others}",
            text=repr(shown(stated.text)),
            role=role,
            others=others,
        )
    return RecordingError(place=f"{table.source}, {shown(label)}", problem=problem, remedy=remedy, code=Code.UNIT)


def _without_a_unit(
    table: ColumnTable, role: Role, silent: Sequence[str], label: str, stated: StatedUnit
) -> RecordingError:
    """The error for columns that state no unit beside one, `label`, that states another unit than our names have."""
    units = ROLE_UNITS[role]
    others = phrase("likewise", " (likewise {count} more)", count=len(silent) - 1) if len(silent) > 1 else NOTHING
    same = units.symbol(stated.text)
    return RecordingError(
        place=f"{table.source}, {shown(table.form.file_name(silent[0]))}",
        problem=phrase(
            "no_unit_beside",
            "states no unit{others}, where {label} states {text}",
            others=others,
            label=shown(label),
            text=shown(stated.text),
        ),
        remedy=phrase(
            "state_unit_of_all",
            "state recording.units.{role} = '{unit}' if all {role} are in {unit}; else recording.scale = {{ {keys} }}, "
            "what a 1 of each is in {usual}",
            role=role,
            unit=same or units.usual,
            keys=", ".join(f"{ours} = 1" for ours in silent),
            usual=units.usual,
        ),
        code=Code.UNIT,
    )


def _tick(table: ColumnTable) -> tuple[float, list[Finding]]:
    """Duration of a unit of the time stamps [s], and findings about it; raises RecordingError."""
    form = table.form
    label = form.file_name(CLOCK)
    of_file = table.stamps is not None and form.clock.period_ms is None and label in table.names
    if not of_file or table.tick != form.tick or form.format == "twincat-scope":
        return table.tick, []
    if CLOCK in form.scale:
        return form.scale[CLOCK], []
    if (stated := _stated(table, CLOCK)) is None:
        return table.tick, []
    if form.clock.unit is not None:
        if stated.symbol == form.clock.unit and stated.counts != 1.0 and not stated.several:
            return _multiple(table, stated)
        if stated.symbol in (None, form.clock.unit):
            return table.tick, []
        key, unit = f"{_table_of(form)}.clock.unit", form.clock.unit
        return table.tick, [contradiction(key, shown(label), stated.text, unit, table.source)]
    if stated.symbol is None or stated.several:
        known = "is not a unit of time that is known" if not stated.several else "are units that differ"
        raise RecordingError(
            place=f"{table.source}, {shown(label)}",
            problem=f"{shown(stated.text)!r} {known}",
            remedy=f"state recording.clock.unit: {', '.join(TICKS)}; of counts recording.scale = {{ t_s = 0.001 }} [s]",
            code=Code.UNIT,
        )
    if stated.counts != 1.0:
        return _multiple(table, stated)
    if stated.symbol == TICKS.usual:
        return table.tick, []
    sentence = f"time stamps are read in {stated.symbol}, as {shown(label)} says in {table.source}"
    return TICKS[stated.symbol], [note(Kind.FORMAT, sentence)]


def _multiple(table: ColumnTable, stated: StatedUnit) -> tuple[float, list[Finding]]:
    """Duration of a unit of the time stamps that is a multiple or a part of a known one [s], and a note."""
    assert stated.symbol is not None
    sentence = (
        f"a 1 of the time stamps is {stated.text}, as {shown(table.form.file_name(CLOCK))} says in {table.source}"
    )
    return TICKS[stated.symbol] / stated.counts, [note(Kind.FORMAT, sentence)]


def _whole(values: Array) -> bool:
    """Whether all numbers are whole, those that are missing apart, and some of them differ."""
    for part in (values[:_ENOUGH], values):
        numbers = part[np.isfinite(part)]
        if not len(numbers) or np.any(numbers != np.rint(numbers)):
            return False
    return bool(numbers.max() > numbers.min())


def _whole_forces(table: ColumnTable) -> Iterator[Finding]:
    """A finding where forces whose unit nobody states are whole numbers, as converters give them."""
    form = table.form
    silent = [ours for ours in table.values if ours in _FORCES and _nobody_says(table, ours)]
    if silent and all(_whole(table.values[ours]) for ours in silent):
        label, role = shown(form.file_name(silent[0])), ROLE_OF[silent[0]]
        yield warning(
            Kind.FORMAT,
            f"{label} to {shown(form.file_name(silent[-1]))} hold whole numbers only and are taken to be in "
            f"{ROLE_UNITS[role].usual}: of counts of a converter state recording.scale in the case, else "
            f"recording.units.{role} = '{ROLE_UNITS[role].usual}'",
            table.source,
        )


def _nobody_says(table: ColumnTable, ours: str) -> bool:
    """Whether neither case nor file states the unit of a column."""
    form = table.form
    named = form.file_name(ours) in COLUMNS or ours in form.scale or ROLE_OF[ours] in form.units
    return not named and _stated(table, ours) is None


def _no_readings(table: ColumnTable) -> Iterator[Finding]:
    """A finding where the columns of the forces are not readings of a sensor by their names."""
    for ours in table.values:
        if ours in _FORCES and (what := computed(words_of(label := table.form.file_name(ours)))):
            yield warning(
                Kind.FORMAT,
                f"{shown(label)} is not a reading of the sensor but {what[0]}; {what[1]}",
                table.source,
            )
            return


def _labels(columns: Sequence[tuple[str, StatedUnit]]) -> str:
    others = f" (likewise {len(columns) - 1} more)" if len(columns) > 1 else ""
    return f"{shown(columns[0][0])}{others}"


def _symbols(columns: Sequence[tuple[str, StatedUnit]]) -> str:
    symbols = ((stated.symbol or stated.text, stated.counts) for _, stated in columns)
    return " and ".join(dict.fromkeys(unit if counts == 1.0 else f"{unit}/{counts:.6g}" for unit, counts in symbols))
