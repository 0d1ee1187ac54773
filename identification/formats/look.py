"""A file of unknown format: what its columns are likely to mean, and the table `[recording]` that reads it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from cases.errors import RecordingError
from cases.files import toml_value
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
    RecordingFormat,
    Role,
)
from cases.schema import Case
from cases.units import Array, as_html
from identification.formats.binary import KINDS, joint_names, opened, topic_of, topics_of
from identification.formats.layout import TextColumns, look_at_text
from identification.formats.meaning import matched
from identification.formats.reading import bag_of, is_bag, is_parquet, read_run, read_tables
from identification.formats.table import listed

CUTOFF_HZ = 40.0  # of a proposal where the case states none
_USUAL_RATE = 1000.0
_RATES = (20.0, 50_000.0)  # rows per second that recorders have
_AROUND_HOME = 2.5  # times the length at home that a strut may have where the case states no workspace
_MOST_RADIANS = 6.5  # of joints; in degrees one of them is beyond that in any motion


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
    """What a file is likely to be."""

    file: Path
    rows: int  # number of rows of numbers; 0 of a bag, whose messages are not read
    columns: tuple[Column, ...]  # in the order of the file; empty of a bag
    settings: Mapping[str, Any]  # proposal for `[recording]` of the case, by key
    odd: tuple[str, ...]  # what to look at, one sentence each
    reads: bool  # whether the file is read with these settings

    @property
    def rate(self) -> float | None:
        """Rows per second; None where there is no clock."""
        clock = next((c for c in self.columns if c.ours == CLOCK), None)
        step = 0.0 if clock is None else float(np.median(np.diff(clock.values))) * TICKS[clock.unit]
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
    result = _bag(file, case, cutoff) if is_bag(file) else _table(file, case, cutoff)
    problem = _problem(file, result.settings, case)
    odd = result.odd if problem is None else (*result.odd, f"not read with these settings: {problem}")
    return replace(result, odd=odd, reads=problem is None)


def _table(file: Path, case: Case | None, cutoff: float) -> Look:
    """The look at a text or a Parquet file."""
    found = _parquet(file) if is_parquet(file) else look_at_text(file)
    names, numbers, settings = found.names, found.numbers, found.settings
    places, units = matched(names, found.units, _joints(case))
    places = {ours: k for ours, k in places.items() if k in numbers}
    units = {ours: unit for ours, unit in units.items() if ours != CLOCK or unit in TICKS}
    if found.clock is not None:
        places[CLOCK], units[CLOCK] = found.clock
    if case is not None and case.sensor_frame.transducer is not None and BAR_FORCES[0] in places:
        forces = [places.pop(ours) for ours in BAR_FORCES]
        places = dict(zip(WRENCH, forces, strict=True)) | places
    drives = [numbers[places[drive]] for drive in DRIVES if drive in places]
    if STRUTS[0] not in places and len(drives) == len(DRIVES) and _strut_unit(drives, case):  # they are lengths
        places |= {strut: places.pop(drive) for strut, drive in zip(STRUTS, DRIVES, strict=True)}
    guessed = {
        ours: unit
        for ours, unit in _units_of_values({ours: numbers[k] for ours, k in places.items()}, case)
        if ours not in units and unit != _usual_unit(ours) and names[places[ours]] != ours
    }
    units = {ours: units.get(ours, guessed.get(ours, _usual_unit(ours))) for ours in places}
    _add_meaning(settings, names, {o: k for o, k in places.items() if found.clock is None or o != CLOCK}, units)
    settings["filter_cutoff_Hz"] = cutoff
    ours_of = {k: ours for ours, k in places.items()}
    columns = [
        Column(name, ours, units.get(ours or "", ""), ours in guessed, numbers.get(k, np.zeros(0)))
        for k, name in enumerate(names)
        for ours in [ours_of.get(k)]
        if name
    ]
    rows = max((len(values) for values in numbers.values()), default=0)
    result = Look(file, rows, tuple(columns), settings, tuple(_advice(places, guessed)), True)
    if result.rate is not None:
        settings["filter_cutoff_Hz"] = min(cutoff, float(f"{0.19 * result.rate:.2g}"))  # a fifth at most
        if not 0.99 < result.rate / _USUAL_RATE < 1.01:
            settings["rate_Hz"] = float(f"{result.rate:.4g}")
    return result


def _advice(places: Mapping[str, int], guessed: Mapping[str, str]) -> Iterator[str]:
    """Sentences on what a person should check or complete."""
    if CLOCK not in places:
        yield "no clock: each row is taken for an averaged standstill; of a motion state clock.period_ms"
    elif TRIGGER not in places:
        yield "no trigger: the whole motion is evaluated, the ways from and to home too"
    if guessed:
        units = ", ".join(f"{ours} in {unit}" for ours, unit in guessed.items())
        yield f"units guessed from values: {units}; compare them with the recorder's settings"


def _parquet(file: Path) -> TextColumns:
    """As `look_at_text`; a Parquet file needs no settings."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(file)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(file, "is a damaged Parquet file", "copy or export it again") from error
    numbers = {
        k: np.asarray(table.column(k).cast(pa.float64(), safe=False).to_numpy())
        for k, kind in enumerate(table.schema.types)
        if pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)
    }
    finite = {k: values for k, values in numbers.items() if np.isfinite(values).any()}
    return TextColumns(table.schema.names, [], finite, {}, None)


def _joints(case: Case | None) -> dict[str, str] | None:
    """Names of the joints of a chain -> our columns."""
    return None if case is None or case.chain is None else dict(zip(case.chain.names, case.chain.columns, strict=True))


def _bag(bag: Path, case: Case | None, cutoff: float) -> Look:
    """The topics of a ROS 2 bag; without a case the order of the joints is unknown."""
    settings: dict[str, Any] = {"filter_cutoff_Hz": cutoff}
    joints = _joints(case)
    with opened(bag) as reader:
        topics = {what: topics_of(reader, what) for what in KINDS}
        chosen = {what: topic_of(bag, reader, what, next(iter(topics[what]), None)) for what in KINDS}
        names = joint_names(reader, chosen["joints"])
    if several := {str(what): topic for what, topic in chosen.items() if len(topics[what]) > 1}:
        settings["ros"] = several
    places = {} if joints is None else matched(names, (), joints)[0]
    renamed = {ours: names[places[ours]] for joint, ours in (joints or {}).items() if ours in places}
    if renamed != {ours: joint for joint, ours in (joints or {}).items()}:
        settings["columns"] = renamed
    odd = [f"{kind.rpartition('/')[2]}: {listed(topics[what])}" for what, kind in KINDS.items()]
    if joints is None:
        odd.append("name the robot with --case, for the order of its joints")
    return Look(bag, 0, (), settings, tuple(odd), True)


def _strut_unit(columns: Sequence[Array], case: Case | None) -> str | None:
    """The unit in which six columns are strut lengths that the machine has; None: there is none."""
    if case is None or case.hexapod is None:
        return None
    if case.workspace is not None:
        low, high = case.workspace.strut_length
    else:
        from identification.hexapod import Hexapod

        usual = float(Hexapod.of(case).strut_lengths(case.hexapod.home.vector[None]).mean())
        low, high = usual / _AROUND_HOME, usual * _AROUND_HOME
    least, most = min(map(np.nanmin, columns)), max(map(np.nanmax, columns))
    inside = (u for u, factor in ROLE_UNITS[Role.STRUTS].items() if low <= least * factor and most * factor <= high)
    return next(inside, None)


def _units_of_values(values: Mapping[str, Array], case: Case | None) -> Iterator[tuple[str, str]]:
    """Units of clock, struts and turning joints that fit their values."""
    if CLOCK in values and len(clock := values[CLOCK]) > 1 and (step := float(np.median(np.diff(clock)))) > 0.0:
        names = ("filetime",) if 1e17 < clock[0] < 1e18 else ("s", "ms", "us", "ns")
        rates = {unit: 1.0 / (step * TICKS[unit]) for unit in names}
        possible = [unit for unit, rate in rates.items() if _RATES[0] <= rate <= _RATES[1]]
        if possible:
            yield CLOCK, min(possible, key=lambda unit: abs(np.log(rates[unit] / _USUAL_RATE)))
    if STRUTS[0] in values and (length := _strut_unit([values[strut] for strut in STRUTS], case)):
        yield from ((strut, length) for strut in STRUTS)
    turning = [ours for ours in values if ROLE_OF.get(ours) is Role.JOINTS]
    if turning and max(float(np.nanmax(np.abs(values[ours]))) for ours in turning) <= _MOST_RADIANS:
        yield from ((ours, "rad") for ours in turning)


def _usual_unit(ours: str) -> str:
    """The unit that the name of a column of ours has."""
    return "s" if ours == CLOCK else next(iter(ROLE_UNITS[ROLE_OF[ours]]), "") if ours in ROLE_OF else ""


def _add_meaning(
    settings: dict[str, Any], names: Sequence[str], places: Mapping[str, int], units: Mapping[str, str]
) -> None:
    """Adds columns, units and clock of `[recording]` to the settings."""
    ordered = [ours for ours in COLUMNS if ours in places]
    if renamed := {ours: names[places[ours]] for ours in ordered if names[places[ours]] != ours}:
        settings["columns"] = renamed
    differing: dict[str, str] = {}
    for role, factors in ROLE_UNITS.items():
        stated = {units[ours] for ours in ordered if ROLE_OF.get(ours) == role}
        if len(stated) == 1 and stated <= factors.keys() - {next(iter(factors))}:
            differing[str(role)] = stated.pop()
    if differing:
        settings["units"] = differing
    if CLOCK in places and units[CLOCK] != "s":
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
