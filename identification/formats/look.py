"""A file of unknown format: what its columns are likely to mean, and the table `[recording]` that reads it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from cases.errors import RecordingError
from cases.machine import POSE
from cases.recording_format import (
    BAR_FORCES,
    CLOCK,
    COLUMNS,
    DRIVES,
    ROLE_OF,
    ROLE_UNITS,
    ROTATION,
    STRUTS,
    TICKS,
    TRIGGER,
    WRENCH,
    RecordingFormat,
    Role,
    units_of,
)
from cases.schema import Case
from cases.units import Array
from identification.formats.assembly import switched
from identification.formats.layout import look_at_text
from identification.formats.looked import RATES, Column, Look, look_at_bag, oddities, strut_range
from identification.formats.naming import matched, may_be_force, sixes, wrenches
from identification.formats.reading import bag_of, is_bag, is_parquet, read_run, read_tables

CUTOFF_HZ = 40.0  # of a proposal where the case states none
_USUAL_RATE = 1000.0
_FORCES_OVER_WEIGHT = (0.02, 50.0)  # how much forces change in a motion, over the weight that is moved
_MOST_RADIANS = 6.5  # of joints; in degrees one of them is beyond that in any motion
_STANDSTILLS = 300  # rows without a clock, from which on they are taken for a motion


def look(file: Path | str, case: Case | None = None) -> Look:
    """What a file of unknown format is likely to be.

    Args:
        file: text, Parquet, or the folder of a ROS 2 bag.
        case: the machine that it was recorded on; without one, units and completeness follow from the names alone.

    Raises:
        RecordingError: the file cannot be read, or holds no table of numbers.
    """
    file = bag_of(Path(file))
    cutoff = (case and case.recording.filter_cutoff_Hz) or CUTOFF_HZ
    if is_bag(file):
        bag_columns, settings, odd = look_at_bag(file, case)
        settings["filter_cutoff_Hz"] = cutoff
        result = Look(file, len(bag_columns[0].values), bag_columns, settings, (), True)
        problem = "name the robot with --case, for the order of its joints" if case is None else None
    else:
        result, odd = _table(file, case, cutoff)
        problem = None
    if (problem := problem or _problem(file, result.settings, case)) is not None:
        odd.append(f"not read with these settings: {problem}")
    return replace(result, odd=tuple(odd), reads=problem is None)


def _table(file: Path, case: Case | None, cutoff: float) -> tuple[Look, list[str]]:
    """The look at a text or a Parquet file, and what is odd."""
    columns, settings, odd = _parquet(file) if is_parquet(file) else look_at_text(file)
    names = [column.name for column in columns]
    numbers = {k: column.values for k, column in enumerate(columns) if len(column.values)}
    chain = None if case is None else case.chain
    joints = None if chain is None else dict(zip((j.name for j in chain.joints), chain.columns, strict=True))
    places, units = matched(names, [column.unit for column in columns], joints)
    places = {ours: k for ours, k in places.items() if k in numbers}
    if settings.get("format") == "twincat-scope":
        places = {CLOCK: names.index("Name")} | {ours: k for ours, k in places.items() if ours != CLOCK}
    if case is not None and case.sensor_frame.transducer is not None:
        places = {ours: k for ours, k in places.items() if ours not in BAR_FORCES}
        if WRENCH[0] not in places:
            places |= dict(zip(WRENCH, next(iter(wrenches(names, list(numbers))), ()), strict=False))
    guessed = _by_values(names, numbers, places, case)
    units |= _units(numbers, places, units, case, guessed)
    _add_meaning(settings, names, places, units)
    settings["filter_cutoff_Hz"] = cutoff
    ours = {k: name for name, k in places.items()}
    columns = [
        replace(column, ours=ours.get(k), unit=_unit(ours.get(k), units), guessed=ours.get(k) in guessed)
        for k, column in enumerate(columns)
        if column.name or k in numbers
    ]
    rows = max((len(values) for values in numbers.values()), default=0)
    result = Look(file, rows, tuple(columns), settings, (), True)
    if result.rate is not None and result.rate < 5.0 * cutoff:
        settings["filter_cutoff_Hz"] = float(f"{0.19 * result.rate:.2g}")  # the low-pass takes a fifth at most
    if result.rate is not None and not 0.99 < result.rate / _USUAL_RATE < 1.01:
        settings["rate_Hz"] = float(f"{result.rate:.4g}")
    elif result.rate is None and rows > _STANDSTILLS:
        settings["clock"] = {"period_ms": 1e3 / (case.recording.rate_Hz if case is not None else _USUAL_RATE)}
    return result, [*odd, *oddities(result, case)]


def _parquet(file: Path) -> tuple[list[Column], dict[str, Any], list[str]]:
    """Columns of a Parquet file, which needs no settings, and nothing odd."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(file)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(file, "is a damaged Parquet file", "copy or export it again") from error
    columns = []
    for field, column in zip(table.schema, table.columns, strict=True):
        plain = pa.types.is_integer(field.type) or pa.types.is_floating(field.type) or pa.types.is_boolean(field.type)
        values = np.asarray(column.cast(pa.float64(), safe=False).to_numpy()) if plain else np.zeros(0)
        columns.append(Column(field.name, None, "", False, values))
    return columns, {}, []


def _by_values(
    names: Sequence[str], columns: Mapping[int, Array], places: dict[str, int], case: Case | None
) -> set[str]:
    """Adds to `places` what the names do not say but the values do; our names of what was added."""
    before = set(places)

    def free() -> list[int]:
        return [k for k in columns if k not in places.values() and np.ptp(columns[k][np.isfinite(columns[k])]) > 0.0]

    if CLOCK not in places:
        clock = next((k for k in free() if _is_clock(columns[k])), None)
        places |= {} if clock is None else {CLOCK: clock}
    if TRIGGER not in places and len(switches := [k for k in free() if _is_switch(columns[k])]) == 1:
        places[TRIGGER] = switches[0]
    if not {STRUTS[0], ROTATION[0], POSE[0]} & places.keys():
        drives = tuple(places[name] for name in DRIVES if name in places)
        if len(drives) == 6 and _strut_unit([columns[k] for k in drives], case):  # the positions are lengths
            places |= {strut: places.pop(drive) for strut, drive in zip(STRUTS, DRIVES, strict=True)}
        elif not drives:
            struts = (six for six in sixes(names, free()) if _strut_unit([columns[k] for k in six], case))
            places |= dict(zip(STRUTS, next(struts, ()), strict=False))
    forces = WRENCH if case is not None and case.sensor_frame.transducer is not None else BAR_FORCES
    if forces[0] not in places:
        unsaid = [k for k in free() if may_be_force(names[k])]
        places |= dict(zip(forces, next(sixes(names, unsaid), ()), strict=False))
    return set(places) - before


def _strut_unit(columns: Sequence[Array], case: Case | None) -> str | None:
    """The unit in which six columns are strut lengths that the machine has; None: there is none."""
    if (possible := strut_range(case)) is None:
        return None
    low, high = possible
    least, most = min(map(np.nanmin, columns)), max(map(np.nanmax, columns))
    inside = (u for u, factor in ROLE_UNITS[Role.STRUTS].items() if low <= least * factor and most * factor <= high)
    return next(inside, None)


def _is_clock(values: Array) -> bool:
    steps = np.diff(values)
    return len(steps) > 2 and bool(np.all(steps > 0.0) and np.median(steps) > 0.5 * np.mean(steps))


def _is_switch(values: Array) -> bool:
    good = values[np.isfinite(values)]
    flags = switched(good) if len(good) else None
    return flags is not None and bool(0 < np.count_nonzero(np.diff(flags)) < len(values) / 50)


def _units(
    columns: Mapping[int, Array],
    places: Mapping[str, int],
    name_units: Mapping[str, str],
    case: Case | None,
    guessed: set[str],
) -> dict[str, str]:
    """Units that names do not state, from the values; what is a guess is added to `guessed`."""
    units: dict[str, str] = {}

    def unstated(group: Sequence[str]) -> list[Array]:
        own = [ours for ours in group if ours in places]
        return [] if {*own} & name_units.keys() else [columns[places[ours]] for ours in own]

    def take(group: Sequence[str], unit: str | None) -> None:
        if unit is not None:
            units.update(dict.fromkeys(group, unit))
            guessed.update(group if unit != _unit(group[0], {}) else ())

    for clock in unstated((CLOCK,)):
        step = float(np.median(np.diff(clock))) if len(clock) > 1 else 0.0
        names = ("filetime",) if step > 0.0 and 1e17 < clock[0] < 1e18 else ("s", "ms", "us", "ns")
        rates = {u: 1.0 / (step * TICKS[u]) for u in names if step > 0.0}
        possible = [u for u, rate in rates.items() if RATES[0] <= rate <= RATES[1]]
        take((CLOCK,), min(possible, key=lambda u: abs(np.log(rates[u] / _USUAL_RATE)), default=None))
    if struts := unstated(STRUTS):
        take(STRUTS, _strut_unit(struts, case))
    turning = [] if case is None or case.chain is None else case.chain.columns
    turning = [ours for ours in turning if ROLE_OF.get(ours) is Role.JOINTS and ours in places]
    if joints := unstated(turning):
        take(turning, "rad" if max(float(np.nanmax(np.abs(joint))) for joint in joints) <= _MOST_RADIANS else None)
    for group in (BAR_FORCES, WRENCH[:3]):
        if (forces := unstated(group)) and case is not None and case.nominal is not None:
            weight = case.nominal.mass_kg * float(np.linalg.norm(case.gravity))
            span = max(float(np.ptp(force[np.isfinite(force)])) for force in forces)
            low, high = (share * weight for share in _FORCES_OVER_WEIGHT)
            take(group, next((u for u, f in ROLE_UNITS[Role.FORCES].items() if low <= span * f <= high), None))
    return units


def _unit(ours: str | None, units: Mapping[str, str]) -> str:
    """The unit of a column of ours, or that of its name."""
    return "" if ours is None else units.get(ours, "s" if ours == CLOCK else next(iter(units_of(ours)), ""))


def _add_meaning(
    settings: dict[str, Any], names: Sequence[str], places: Mapping[str, int], units: Mapping[str, str]
) -> None:
    """Adds columns, units and clock of `[recording]` to the settings."""
    unnamed, scope = "column_names" in settings, settings.get("format") == "twincat-scope"
    if unnamed:  # the columns get our names where they have a meaning, and others where not
        ours = {k: name for name, k in places.items()}
        settings["column_names"] = [ours.get(k, name) for k, name in enumerate(names)]
    ordered = [ours for ours in COLUMNS if ours in places and (not scope or ours != CLOCK)]
    renamed = {ours: names[places[ours]] for ours in ordered if names[places[ours]] != ours and not unnamed}
    settings |= {"columns": renamed} if renamed else {}
    differing: dict[str, str] = {}
    for role, factors in ROLE_UNITS.items():
        stated = {units[ours] for ours in ordered if ROLE_OF.get(ours) == role and ours in units}
        if len(stated) == 1 and stated <= factors.keys() - {next(iter(factors))}:
            differing[str(role)] = stated.pop()
    settings |= {"units": differing} if differing else {}
    if CLOCK in places and units.get(CLOCK, "s") != "s" and not scope:
        settings["clock"] = {"unit": units[CLOCK]}


def _problem(file: Path, settings: Mapping[str, Any], case: Case | None) -> str | None:
    """Why the file is not read with these settings; None: it is."""
    try:
        form = RecordingFormat.model_validate(settings)
        if case is None:
            read_tables(file, form)
        else:
            read_run([file], case.model_copy(update={"recording": form}))
    except ValidationError as error:
        return "; ".join(str(problem["msg"]).removeprefix("Value error, ") for problem in error.errors())
    except RecordingError as error:
        return str(error).removeprefix(f"{file}").lstrip(":, ")
    return None
