"""Reads tables of setpoints: rows that follow from each other, with struts that belong to their poses.

Rates, accelerations and struts are checked: each row must lead to the next within the jerk limits, and the struts
of a hexapod are computed again from pose, rates and accelerations.
"""

import re
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cases.controller import Setpoints
from cases.errors import ProgramError
from cases.machine import own_units
from cases.recording_format import setpoint_columns
from cases.schema import Case
from cases.units import MM
from identification.limit_proof import limited_machine
from identification.motion import Array, Motion
from postprocessors.reading import Grouping, Reading

FORMAT = "hexcite setpoints 1"
LARGEST = 1e7  # mm, degrees and their rates: no machine has such numbers
PARQUET = b"PAR1"
METADATA = b"hexcite"
_HEADER = re.compile(r"#\s*(?P<key>[a-z_]+):\s*(?P<value>.*?)\s*$")
_STRANGE = re.compile(r"[^0-9.,+\-\n]")


Table = tuple[int, dict[str, str], Array]
"""Line of the first row (Parquet: 1), keys and values of the header, and the numbers, one row a cycle."""


def read_table(content: bytes, file: str, most: int, columns: tuple[str, ...]) -> Table:
    """The numbers of a table of at most `most` rows; errors as `Language.read`."""
    table = _parquet(content, file, columns) if content[:4] == PARQUET else _csv(content, file, columns)
    first, header, values = table
    rows, _ = values.shape
    if rows > most:
        raise ProgramError(
            file, 0, 0, f"{rows} rows, the controller's memory holds {most} (most_rows); plan a shorter motion"
        )
    if rows < 2:
        raise ProgramError(file, 0, 0, "fewer than two rows; the file is truncated")
    bad = ~(np.abs(values) <= LARGEST)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        value = values[row, column]
        raise ProgramError(file, first + int(row), 0, f"{columns[column]} = {value:g} is not a machine's number")
    if header.get("format") != FORMAT:
        raise ProgramError(file, 1, 0, f"does not begin with '# format: {FORMAT}'; is this a table of setpoints?")
    return table


def _csv(content: bytes, file: str, columns: tuple[str, ...]) -> Table:
    text = content.decode("latin-1").replace("\r\n", "\n")
    lines = text.split("\n")
    header: dict[str, str] = {}
    number = 0
    while number < len(lines) and lines[number].startswith("#"):
        if match := _HEADER.match(lines[number]):
            header.setdefault(match["key"], match["value"])
        number += 1
    if number == len(lines) or lines[number].split(",") != list(columns):
        raise ProgramError(
            file, number + 1, 0, f"the columns are not {columns[0]},{columns[1]},..,{columns[-1]}; write all of them"
        )
    body = lines[number + 1 :]
    if body[-1:] != [""]:
        raise ProgramError(file, len(lines), 0, "the last line has no end; the file is truncated")
    body.pop()
    whole = "\n".join(body)
    if match := _STRANGE.search(whole):
        row, column = whole.count("\n", 0, match.start()), match.start() - whole.rfind("\n", 0, match.start()) - 1
        bad = match[0]
        raise ProgramError(file, number + 2 + row, column + 1, f"{bad!r} is not a part of a plain number; correct it")
    return (number + 2, header, _numbers(body, number + 2, file, columns))


def _numbers(body: list[str], first: int, file: str, columns: tuple[str, ...]) -> Array:
    values = np.empty((len(body), len(columns)))
    for row, line in enumerate(body):
        cells = line.split(",")
        if len(cells) != len(columns):
            raise ProgramError(
                file, first + row, 0, f"{len(cells)} cells where {len(columns)} columns stand; correct it"
            )
        try:
            values[row] = cells
        except ValueError:
            bad = next(k for k, cell in enumerate(cells) if not re.fullmatch(r"[+-]?(?:\d+\.?\d*|\.\d+)", cell))
            column = sum(len(cell) + 1 for cell in cells[:bad]) + 1
            raise ProgramError(
                file, first + row, column, f"{columns[bad]} = {cells[bad]!r} is not a number; correct it"
            ) from None
    return values


def _parquet(content: bytes, file: str, columns: tuple[str, ...]) -> Table:
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.read_table(pa.BufferReader(content))
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0][:120] if str(error) else "damaged"
        raise ProgramError(file, 0, 0, f"is damaged Parquet ({reason}); write it again") from error
    if tuple(table.column_names) != columns:
        raise ProgramError(file, 0, 0, f"the columns are not {columns[0]}, {columns[1]}, .., {columns[-1]}; write all")
    wrong = next((f.name for f in table.schema if f.type != pa.float64()), None)
    if wrong is not None:
        raise ProgramError(file, 0, 0, f"column {wrong} does not hold 64-bit floats; write it so")
    text = (table.schema.metadata or {}).get(METADATA, b"").decode("latin-1")
    header = {m["key"]: m["value"] for line in reversed(text.split("\n")) if (m := _HEADER.match(line))}
    return (1, header, np.column_stack([table.column(name).to_numpy() for name in columns]))


ROUNDING = np.array([1e-9, 1e-6]) * MM  # tolerance of poses and rates: a thousand times the last decimal of a table
JERK_ROUNDING = 1e-3  # share of the jerk limit by which rounding in a table may exceed it
STRUT_ROUNDING = np.array([1e-6, 1e-4, 1e-2]) * MM
SAME_TIME = 1e-9  # [s]
AT_HOME = 1e-9  # [m, rad]
_PARTS = ("pose", "rates", "accelerations")


class _Rows:
    """The table in SI with the places of its cells."""

    def __init__(self, file: str, table: Table, settings: Setpoints, columns: tuple[str, ...], count: int) -> None:
        self.file, self.columns, self.units = file, columns, own_units(columns)
        self.parts = {name: slice(1 + k * count, 1 + (k + 1) * count) for k, name in enumerate(_PARTS)}
        self.struts = slice(1 + 3 * count, len(columns) - 1)
        self.first, _, numbers = table
        self.cycle = settings.cycle
        self.values = numbers * self.units
        self.time = self.values[:, 0]
        self.pose, self.rates, self.accelerations = (self.values[:, part] for part in self.parts.values())
        self.trigger = numbers[:, -1]
        self.rest: NDArray[np.bool_] = np.asarray(~(self.rates.any(axis=1) | self.accelerations.any(axis=1)))

    def error(self, row: int, column: int | None, problem: str) -> ProgramError:
        place = "" if column is None else f"{self.columns[column]}: "
        return ProgramError(self.file, self.first + row, 0, f"{place}{problem}")

    def require(self, case: Case) -> None:
        home, limits = case.need_motion("the check of a table")
        steps = np.diff(self.time)
        mask = np.abs(self.time - np.arange(len(self.time)) * self.cycle) > SAME_TIME
        if mask.any():
            row = int(np.argmax(mask))
            gap = f"{1e3 * steps[row - 1]:.6g} ms after the row before" if row else f"{self.time[0]:g} s"
            raise self.error(
                row, 0, f"{gap}; rows begin at 0 and follow each {1e3 * self.cycle:g} ms, the case's cycle"
            )
        wrong = ~np.isin(self.trigger, (0.0, 1.0))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise self.error(row, len(self.columns) - 1, f"{self.trigger[row]:g} is neither 0 nor 1; correct it")
        for row, verb in ((0, "begins"), (-1, "ends")):
            if not self.rest[row]:
                raise self.error(row % len(self.time), None, f"the table {verb} in motion; it must be at rest there")
        off = np.abs(self.pose[0] - home) > AT_HOME
        if off.any():
            raise self.error(
                0, 1 + int(np.argmax(off)), "the table does not begin at home, where the machine must stand"
            )
        self._require_sequence(limits.jerk)
        if limits.of_pose:
            self._require_drives(case)

    def _require_sequence(self, jerk: Array) -> None:
        """Raises where no jerk within its limit J and with the mean q J can lead from a row to the next.

        Rates and poses differ from those of a constant jerk by a weighted mean of the jerk. It is largest where the
        jerk is J as long as its weight is large, and -J otherwise: J h^2 (1 - q^2) / 4 for rates, J h^3 (1 - q^2)
        (3 - q) / 24 for poses. A table whose mean jerk is beyond J follows from itself; the proof judges it.
        """
        h = self.cycle
        p, v, a = self.pose, self.rates, self.accelerations
        mean = (a[1:] - a[:-1]) / h
        most = np.where(np.abs(mean) <= jerk, jerk, 2.0 * np.abs(mean))
        q = mean / most
        rates = v[1:] - v[:-1] - h * (a[1:] + a[:-1]) / 2
        poses = p[1:] - p[:-1] - h * v[:-1] - h**2 * (2 * a[:-1] + a[1:]) / 6
        varied = most * (1.0 - q**2) * (1.0 + JERK_ROUNDING)
        errors = {
            "rates": (rates, h**2 * varied / 4, ROUNDING[1]),
            "pose": (poses, h**3 * varied * (3.0 - np.sign(poses) * q) / 24, ROUNDING[0]),
        }
        for name, (error, bound, rounding) in errors.items():
            bad = ~(np.abs(error) <= bound + rounding)
            if bad.any():
                row, k = (int(n) for n in np.argwhere(bad)[0])
                column = self.parts[name].start + k
                raise self.error(
                    row + 1, column, "does not follow from the row before with its rate and acceleration; correct it"
                )

    def _require_drives(self, case: Case) -> None:
        none = np.zeros_like(self.pose)
        motion = Motion(self.time.copy(), self.pose.copy(), self.rates.copy(), self.accelerations.copy(), none)
        exact = np.hstack(limited_machine(case).drives(motion))
        bad = ~(np.abs(exact - self.values[:, self.struts]) <= np.repeat(STRUT_ROUNDING, 6))
        if bad.any():
            row, k = (int(n) for n in np.argwhere(bad)[0])
            column = self.struts.start + k
            value, expected = self.values[row, column] / self.units[column], exact[row, k] / self.units[column]
            raise self.error(row, column, f"{value:.9g}, but the pose and its derivatives give {expected:.9g}")

    def grouped(self) -> Grouping:
        """Standstills, paths between them, and the trigger where it switches at rest."""
        still = self.rest[1:] & self.rest[:-1] & ~(np.diff(self.pose, axis=0).any(axis=1))
        change = np.flatnonzero((np.diff(still.astype(int)) != 0) | (np.diff(self.trigger[:-1]) != 0.0)) + 1
        edges = [0, *(int(c) for c in change), len(still)]
        motions = Grouping(self.file)
        motions.stand(self.pose[0])
        for start, end in pairwise(edges):
            if bool(self.trigger[start]) != motions.trigger:
                if not self.rest[start]:
                    raise self.error(start, len(self.columns) - 1, "the trigger switches in motion; switch at rest")
                motions.switch(self.first + start, not motions.trigger, at_once=True)
            if still[start]:
                motions.pause(self.first + start, (end - start) * self.cycle)
                continue
            if not self.rest[end]:
                raise self.error(end, len(self.columns) - 1, "the trigger switches in motion; switch at rest")
            rows = slice(start, end + 1)
            values = self.pose[rows], self.rates[rows], self.accelerations[rows]
            motions.rows(self.first + start, self.cycle, *values)
        if bool(self.trigger[-1]) != motions.trigger:
            motions.switch(self.first + len(still), not motions.trigger, at_once=True)
        return motions


def read_setpoints(content: bytes, file: str, case: Case) -> Reading:
    """Reads a table, see `Language.read`: also rows that do not belong together are refused, with their line."""
    settings = case.need_settings(Setpoints, "a setpoint table")
    home, limits = case.need_motion("the check of a table")
    columns = setpoint_columns(limits.columns, limits.of_pose)
    table = read_table(content, file, settings.most_rows, columns)
    rows = _Rows(file, table, settings, columns, len(home))
    rows.require(case)
    return rows.grouped().reading(len(rows.values))
