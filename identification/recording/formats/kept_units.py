"""Units that a case keeps of another file: where this one says or shows another, they are not proposed for it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from cases.base.phrases import Phrase, phrase
from cases.base.units import Array
from cases.recording_format import CLOCK, ROLE_OF, ROLE_UNITS, TICKS, Role
from cases.schema import Case
from identification.recording.formats.column_places import ColumnPlaces
from identification.recording.formats.names.labels import StatedUnit
from identification.recording.formats.names.meaning import span
from identification.recording.formats.quantities import fits_range, force_unit_in_range
from identification.recording.formats.units_by_values import unit_that_fits, units_of_values


def for_this_file(
    case: Case | None, stated: Mapping[str, Any], columns: ColumnPlaces, labels: Mapping[str, StatedUnit | None]
) -> tuple[dict[str, Any], tuple[Phrase, ...]]:
    """What a case states, without kept units that a file which it does not read contradicts; and a sentence of each.

    A unit goes where all labels of its columns state another, and values do not speak for the kept one; or where no
    label states any and values exclude the kept one (forces beyond the range of their sensors, struts and joints that
    the machine does not have, a clock that no recorder has) and fit another.

    Args:
        stated: the `[recording]` of the case, by key.
        labels: our name -> unit that the file states.
    """
    units, doubts = dict(stated.get("units", {})), list[Phrase]()
    for role in [role for role in units if role in {*Role}]:
        of_role = {ours: labels[ours] for ours in columns.places if ROLE_OF.get(ours) == role and ours in labels}
        other = _other(of_role, units[role], ROLE_UNITS[Role(role)])
        values = {ours: _numbers(columns, ours) for ours in of_role}
        if other is not None and not _speaks_for(case, values, str(units[role]), other):
            doubts.append(_labelled(columns, of_role, f"recording.units.{role}", units.pop(role), other))
        elif role != Role.FORCES and not any(of_role.values()):
            if (usual := unit_that_fits(values, units[role], case)) is not None:
                doubts.append(_excluded(columns, of_role, f"recording.units.{role}", units.pop(role), usual))
        elif role == Role.FORCES and case is not None and case.sensors.range_N is not None:
            unlabelled = of_role and not any(of_role.values())
            forces = np.concatenate([*values.values()]) if unlabelled else np.zeros(0)
            if (usual := force_unit_in_range(forces, units[role], case.sensors.range_N)) is not None:
                doubts.append(
                    phrase(
                        "kept_out_of_range",
                        "{names}: in {kept}, which recording.units.forces keeps of another file, they are beyond the "
                        "range of {most} N; no label states a unit, and {unit} fits: it is proposed",
                        names=span([columns.name(ours) for ours in of_role]),
                        kept=units.pop(role),
                        most=f"{case.sensors.range_N:g}",
                        unit=usual,
                    )
                )
    clock = dict(stated.get("clock", {}))
    if "unit" in clock and CLOCK in labels:
        of_clock, stamps = {CLOCK: labels[CLOCK]}, {CLOCK: _numbers(columns, CLOCK)}
        other = _other(of_clock, clock["unit"], TICKS)
        if other is not None and not _speaks_for(case, stamps, clock["unit"], other):
            doubts.append(_labelled(columns, of_clock, "recording.clock.unit", clock.pop("unit"), other))
        elif labels[CLOCK] is None and (usual := unit_that_fits(stamps, clock["unit"], case)) is not None:
            doubts.append(_excluded(columns, of_clock, "recording.clock.unit", clock.pop("unit"), usual))
    rest = {key: value for key, value in stated.items() if key not in ("units", "clock")}
    parts = {"units": units, "clock": clock}
    return rest | {key: value for key, value in parts.items() if value}, tuple(doubts)


def _numbers(columns: ColumnPlaces, ours: str) -> Array:
    return columns.numbers.get(columns.places[ours], np.zeros(0))


def _other(labels: Mapping[str, StatedUnit | None], kept: str, units: Mapping[str, float]) -> str | None:
    """The one unit that all of some labels state, where it is not the kept one; None where there is none such."""
    symbols = {
        None if label is None or label.several or label.counts != 1.0 else label.symbol for label in labels.values()
    }
    if len(symbols) != 1 or (symbol := symbols.pop()) is None or units[symbol] == units.get(kept):
        return None
    return symbol


def _speaks_for(case: Case | None, values: Mapping[str, Array], kept: str, other: str) -> bool:
    """Whether values fit the machine in the kept unit, and not in that of the labels."""
    by_values = dict(units_of_values({ours: column for ours, column in values.items() if column.size}, case))
    fitting = {by_values[ours] for ours in values if ours in by_values}
    if fitting:
        return kept in fitting and other not in fitting
    of_forces = [column for ours, column in values.items() if ROLE_OF.get(ours) is Role.FORCES]
    if not of_forces or case is None or case.sensors.range_N is None:
        return False
    units, forces, most = ROLE_UNITS[Role.FORCES], np.concatenate(of_forces), case.sensors.range_N
    return fits_range(forces * units[units.symbol(kept) or kept], most) and not fits_range(forces * units[other], most)


def _excluded(
    columns: ColumnPlaces, of_role: Mapping[str, StatedUnit | None], key: str, kept: str, other: str
) -> Phrase:
    return phrase(
        "kept_excluded",
        "{names}: in {kept}, which {key} keeps of another file, their values cannot be; no label states a unit, and "
        "{unit} fits: it is proposed",
        names=span([columns.name(ours) for ours in of_role]),
        kept=kept,
        key=key,
        unit=other,
    )


def _labelled(
    columns: ColumnPlaces, of_role: Mapping[str, StatedUnit | None], key: str, kept: str, other: str
) -> Phrase:
    return phrase(
        "label_over_kept",
        "{names}: the file says {unit}, {key} of the case, which is of another file, says {kept}; {unit} is proposed",
        names=span([columns.name(ours) for ours in of_role]),
        unit=other,
        key=key,
        kept=kept,
    )
