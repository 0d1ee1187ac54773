"""Reads tables of setpoints: rows that follow from each other, with struts that belong to their poses.

Rates, accelerations and struts are checked: each row must lead to the next within the jerk limits, and the struts
of a hexapod are computed again from pose, rates and accelerations.
"""

import re
from collections.abc import Iterator
from itertools import chain, pairwise

import numpy as np
from numpy.typing import NDArray

from cases.controller import Setpoints
from cases.errors import ProgramError
from cases.recording_format import setpoint_columns
from cases.schema import Case
from cases.tables import own_units
from cases.units import MM
from identification.limit_proof import limited_machine
from identification.motion import Array, Motion
from postprocessors.reading import NUMBER, Grouping, Reading

FORMAT = "hexcite setpoints 1"
LARGEST = 1e7  # mm, degrees and their rates: no machine has such numbers


def read_table(content: bytes, file: str, most: int, columns: tuple[str, ...]) -> tuple[int, Array]:
    """Line of the first row, and the numbers of a table of at most `most` rows; errors as `Dialect.read`."""
    lines = content.decode("latin-1").replace("\r\n", "\n").split("\n")
    number = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    if lines[number : number + 1] != [",".join(columns)]:
        problem = f"the columns are not {columns[0]},{columns[1]},..,{columns[-1]}; write all of them"
        raise ProgramError(file, number + 1, 0, problem)
    if not re.fullmatch(rf"#\s*format: {FORMAT}\s*", lines[0]):
        raise ProgramError(file, 1, 0, f"does not begin with '# format: {FORMAT}'; is this a table of setpoints?")
    first, rows = number + 2, lines[number + 1 :]
    if rows[-1:] != [""] or len(rows) < 3:  # its two first ones and the end of the last
        raise ProgramError(file, len(lines), 0, "the last line has no end, or is the only one; the file is truncated")
    rows.pop()
    if len(rows) > most:
        problem = f"{len(rows)} rows, the controller's memory holds {most} (most_rows); plan a shorter motion"
        raise ProgramError(file, 0, 0, problem)
    plain = re.compile(",".join([f"(?>{NUMBER})"] * len(columns)))  # (?>..) tries no second way: there are too many
    values = np.empty((len(rows), len(columns)))
    for row, text in enumerate(rows):
        cells = text.split(",")
        if not plain.fullmatch(text):
            raise _not_plain(cells, file, first + row, columns)
        values[row] = cells  # row by row: the words of all take seven times the memory of the file
    for row, column in np.argwhere(np.abs(values) > LARGEST)[:1].tolist():
        problem = f"{columns[column]} = {values[row, column]:g} is not a machine's number"
        raise ProgramError(file, first + row, 0, problem)
    return first, values


def _not_plain(cells: list[str], file: str, line: int, columns: tuple[str, ...]) -> ProgramError:
    if len(cells) != len(columns):
        return ProgramError(file, line, 0, f"{len(cells)} cells where {len(columns)} columns stand; correct it")
    bad = next(k for k, cell in enumerate(cells) if not re.fullmatch(NUMBER, cell))
    column = sum(len(cell) + 1 for cell in cells[:bad]) + 1
    return ProgramError(file, line, column, f"{columns[bad]} = {cells[bad]!r} is not a plain number; correct it")


ROUNDING = np.array([1e-9, 1e-6]) * MM  # tolerance of poses and rates: a thousand times the last decimal of a table
JERK_ROUNDING = 1e-3  # share of the jerk limit by which rounding in a table may exceed it
STRUT_ROUNDING = np.array([1e-6, 1e-4, 1e-2]) * MM
SAME_TIME = 1e-9  # [s]
AT_HOME = 1e-9  # [m, rad]

Problem = tuple[int, int | None, str]
"""Row, column (None for the row as a whole), and what is wrong there."""


def read_setpoints(content: bytes, file: str, case: Case) -> Reading:
    """Reads a table, see `Dialect.read`: also rows that do not belong together are refused, with their line."""
    settings = case.need_settings(Setpoints, "a setpoint table")
    home, limits = case.need_motion("the check of a table")
    columns, count = setpoint_columns(limits.columns, limits.of_pose), len(home)
    first, numbers = read_table(content, file, settings.most_rows, columns)
    values, trigger = numbers * own_units(columns), numbers[:, -1]
    pose, rates, accelerations = (values[:, 1 + k * count : 1 + (k + 1) * count] for k in range(3))
    motion = Motion(values[:, 0], pose, rates, accelerations, np.zeros_like(pose))
    problems = chain(
        _of_the_form(motion, trigger, settings.cycle, home),
        _of_the_sequence(motion, settings.cycle, limits.jerk),
        _of_the_drives(motion, values[:, 1 + 3 * count : -1], case) if limits.of_pose else (),
        _of_the_trigger(motion, trigger),
    )
    for row, column, problem in problems:
        place = "" if column is None else f"{columns[column]}: "
        raise ProgramError(file, first + row, 0, f"{place}{problem}")
    return _grouped(Grouping(file), motion, trigger, first, settings.cycle).reading(len(values))


def _at_rest(motion: Motion) -> NDArray[np.bool_]:
    return np.asarray(~(motion.rates.any(axis=1) | motion.accelerations.any(axis=1)))


def _of_the_form(motion: Motion, trigger: Array, cycle: float, home: Array) -> Iterator[Problem]:
    mask = np.abs(motion.t - np.arange(len(motion.t)) * cycle) > SAME_TIME
    if mask.any():
        row = int(np.argmax(mask))
        gap = f"{1e3 * np.diff(motion.t)[row - 1]:.6g} ms after the row before" if row else f"{motion.t[0]:g} s"
        yield row, 0, f"{gap}; rows begin at 0 and follow each {1e3 * cycle:g} ms, the case's cycle"
    wrong = ~np.isin(trigger, (0.0, 1.0))
    if wrong.any():
        row = int(np.argmax(wrong))
        yield row, -1, f"{trigger[row]:g} is neither 0 nor 1; correct it"
    rest = _at_rest(motion)
    for row, verb in ((0, "begins"), (len(rest) - 1, "ends")):
        if not rest[row]:
            yield row, None, f"the table {verb} in motion; it must be at rest there"
    off = np.abs(motion.pose[0] - home) > AT_HOME
    if off.any():
        yield 0, 1 + int(np.argmax(off)), "the table does not begin at home, where the machine must stand"


def _of_the_sequence(motion: Motion, cycle: float, jerk: Array) -> Iterator[Problem]:
    """Rows to which no jerk within its limit J and with the mean q J can lead from the row before.

    Rates and poses differ from those of a constant jerk by a weighted mean of the jerk. It is largest where the
    jerk is J as long as its weight is large, and -J otherwise: J h^2 (1 - q^2) / 4 for rates, J h^3 (1 - q^2)
    (3 - q) / 24 for poses. A table whose mean jerk is beyond J follows from itself; the proof judges it.
    """
    h, p, v, a = cycle, motion.pose, motion.rates, motion.accelerations
    mean = (a[1:] - a[:-1]) / h
    most = np.where(np.abs(mean) <= jerk, jerk, 2.0 * np.abs(mean))
    q = mean / most
    rates = v[1:] - v[:-1] - h * (a[1:] + a[:-1]) / 2
    poses = p[1:] - p[:-1] - h * v[:-1] - h**2 * (2 * a[:-1] + a[1:]) / 6
    varied = most * (1.0 - q**2) * (1.0 + JERK_ROUNDING)
    for start, error, bound, rounding in (
        (1 + len(jerk), rates, h**2 * varied / 4, ROUNDING[1]),
        (1, poses, h**3 * varied * (3.0 - np.sign(poses) * q) / 24, ROUNDING[0]),
    ):
        bad = np.argwhere(~(np.abs(error) <= bound + rounding))
        if len(bad):
            row, k = bad[0].tolist()
            yield row + 1, start + k, "does not follow from the row before with its rate and acceleration; correct it"


def _of_the_drives(motion: Motion, written: Array, case: Case) -> Iterator[Problem]:
    exact = np.hstack(limited_machine(case).drives(motion))
    bad = np.argwhere(~(np.abs(exact - written) <= np.repeat(STRUT_ROUNDING, 6)))
    if len(bad):
        row, k = bad[0].tolist()
        value, expected = written[row, k] / MM, exact[row, k] / MM
        column = 1 + 3 * motion.pose.shape[1] + k
        yield row, column, f"{value:.9g}, but the pose and its derivatives give {expected:.9g}"


def _of_the_trigger(motion: Motion, trigger: Array) -> Iterator[Problem]:
    moving = np.flatnonzero((np.diff(trigger[:-1]) != 0.0) & ~_at_rest(motion)[1:-1])
    if len(moving):
        yield int(moving[0]) + 1, -1, "the trigger switches in motion; switch at rest"


def _grouped(motions: Grouping, motion: Motion, trigger: Array, first: int, cycle: float) -> Grouping:
    """Standstills, paths between them, and the trigger where it switches at rest; the first row is at a line."""
    rest = _at_rest(motion)
    still = rest[1:] & rest[:-1] & ~(np.diff(motion.pose, axis=0).any(axis=1))
    change = np.flatnonzero(np.diff(still) | (np.diff(trigger[:-1]) != 0.0)) + 1
    motions.stand(motion.pose[0])
    for start, end in pairwise([0, *map(int, change), len(still)]):
        if bool(trigger[start]) != motions.trigger:
            motions.switch(first + start, not motions.trigger, at_once=True)
        if still[start]:
            motions.pause(first + start, (end - start) * cycle)
            continue
        rows = slice(start, end + 1)
        motions.rows(first + start, cycle, motion.pose[rows], motion.rates[rows], motion.accelerations[rows])
    if bool(trigger[-1]) != motions.trigger:
        motions.switch(first + len(still), not motions.trigger, at_once=True)
    return motions
