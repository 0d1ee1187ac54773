"""Reads tables of setpoints: rows that follow from each other, with struts that belong to their poses.

Rates, accelerations and struts are checked: each row must lead to the next within the jerk limits, and the struts
of a hexapod are computed again from pose, rates and accelerations.
"""

import re
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from cases.base.errors import Code, ProgramError
from cases.base.units import MM
from cases.controller import Setpoints
from cases.recording_format import setpoint_columns
from cases.schema import Case
from cases.tables import own_units
from identification.limits.proof import limited_machine
from identification.motion.motion import Array, Motion
from postprocessors.reading import NUMBER, Grouping, Reading

FORMAT = "hexcite setpoints 1"
LARGEST = 1e7  # mm, degrees and their rates: no machine has such numbers
ROUNDING = np.array([1e-9, 1e-6]) * MM  # tolerance of poses and rates: a thousand times the last decimal of a table
JERK_ROUNDING = 1e-3  # share of the jerk limit by which rounding in a table may exceed it
STRUT_ROUNDING = np.array([1e-6, 1e-4, 1e-2]) * MM
AROUND = 3  # rows to either side by which the jerk between two is judged
SAME = 1e-9  # [s] and [m, rad]


def read_setpoints(content: bytes, file: str, case: Case) -> Reading:
    """Reads a table, see `Dialect.read`: also rows that do not belong together are refused, with their line."""
    settings = case.need_settings(Setpoints, "a setpoint table")
    home, limits = case.need_motion("the check of a table")
    columns, count, cycle = setpoint_columns(limits.columns, limits.of_pose), len(home), settings.cycle
    first, numbers = _read_table(content, file, settings.most_rows, columns)
    values, trigger = numbers * own_units(columns), numbers[:, -1]
    p, v, a = (values[:, 1 + k * count : 1 + (k + 1) * count] for k in range(3))
    rest = np.asarray(~(v.any(axis=1) | a.any(axis=1)))

    def require(right: NDArray[np.bool_], column: int, problem: str, row: int = 0) -> None:
        """Raises at the first cell that is not right, of cells that begin in a row and a column."""
        wrong = np.argwhere(~right.reshape(len(right), -1))
        if len(wrong):
            k, joint = wrong[0].tolist()
            cell = f"{columns[column + joint]} = {numbers[row + k, column + joint]:.9g}"
            raise ProgramError(
                file=file, line=first + row + k, problem=f"{cell} {problem}", remedy="correct it", code=Code.SYNTAX
            )

    require(np.abs(numbers) <= LARGEST, 0, "is not a number of a machine's size")
    problem = f"where rows begin at 0 and follow each {1e3 * cycle:g} ms, the case's cycle"
    require(np.abs(values[:, 0] - np.arange(len(values)) * cycle) <= SAME, 0, problem)
    require(np.isin(trigger, (0.0, 1.0)), -1, "is neither 0 nor 1")
    within = (np.arange(len(rest)) % (len(rest) - 1)) != 0
    require(rest | within, 1 + count, "where the table must begin and end at rest")
    require(np.abs(p[:1] - home) <= SAME, 1, "is not at home, where the machine must stand when the table starts")
    # No jerk within its limit J and with the mean q J leads from the row before. Rates and poses differ from those of a
    # constant jerk by a weighted mean of the jerk, which is largest where the jerk is J as long as its weight is large,
    # and -J otherwise. Where a coordinate has mean jerks beyond J, as of plans that leave jerk out, rows follow from
    # themselves, and the proof judges them: between two rows J is then twice what it is around them.
    mean = (a[1:] - a[:-1]) / cycle
    padded = np.abs(np.pad(mean, ((AROUND, AROUND), (0, 0)), "edge"))
    around = sliding_window_view(padded, 2 * AROUND + 1, axis=0).max(axis=2)
    beyond = (np.abs(mean) > limits.jerk).any(axis=0)
    most = np.where(beyond, np.maximum(limits.jerk, 2.0 * around), limits.jerk)
    q = mean / most
    rates = v[1:] - v[:-1] - cycle * (a[1:] + a[:-1]) / 2
    poses = p[1:] - p[:-1] - cycle * v[:-1] - cycle**2 * (2 * a[:-1] + a[1:]) / 6
    varied = most * (1.0 - q**2) * (1.0 + JERK_ROUNDING)
    problem = "does not follow from the row before with its rate and acceleration"
    require(np.abs(rates) <= cycle**2 * varied / 4 + ROUNDING[1], 1 + count, problem, row=1)
    bound = cycle**3 * varied * (3.0 - np.sign(poses) * q) / 24
    require(np.abs(poses) <= bound + ROUNDING[0], 1, problem, row=1)
    motion = Motion(values[:, 0], p, v, a, np.zeros_like(p))
    if limits.of_pose:
        off = np.hstack(limited_machine(case).drives(motion)) - values[:, 1 + 3 * count : -1]
        problem = "is not what the pose and its derivatives give"
        require(np.abs(off) <= np.repeat(STRUT_ROUNDING, 6), 1 + 3 * count, problem)
    require((np.diff(trigger[:-1]) == 0.0) | rest[1:-1], -1, "in motion: the trigger switches at rest alone", row=1)
    return _grouped(Grouping(file), motion, rest, trigger, first, cycle).reading(len(values))


def _read_table(content: bytes, file: str, most: int, columns: tuple[str, ...]) -> tuple[int, Array]:
    """Line of the first row, and the numbers of a table of at most `most` rows; errors as `Dialect.read`."""
    lines = content.decode("latin-1").replace("\r\n", "\n").split("\n")
    number = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    if not re.fullmatch(rf"#\s*format: {FORMAT}\s*", lines[0]) or lines[number : number + 1] != [",".join(columns)]:
        problem = f"not '# format: {FORMAT}' and then the columns {columns[0]},{columns[1]},..,{columns[-1]}"
        raise ProgramError(
            file=file,
            line=number + 1,
            problem=problem,
            remedy="is this a table of setpoints for this case?",
            code=Code.SYNTAX,
        )
    first, rows = number + 2, lines[number + 1 :]
    if rows[-1:] != [""] or len(rows) < 3:  # its two first ones and the end of the last
        raise ProgramError(
            file=file,
            line=len(lines),
            problem="the last line has no end, or is the only one",
            remedy="the file is truncated",
            code=Code.DAMAGED,
        )
    rows.pop()
    if len(rows) > most:
        problem = f"{len(rows)} rows, the controller's memory holds {most} (most_rows)"
        raise ProgramError(file=file, problem=problem, remedy="plan a shorter motion", code=Code.OUT_OF_RANGE)
    plain = re.compile(",".join([f"(?>{NUMBER})"] * len(columns)))  # (?>..) tries no second way: there are too many
    values = np.empty((len(rows), len(columns)))
    for row, text in enumerate(rows):
        cells = text.split(",")
        if not plain.fullmatch(text):
            odd = next((cell for cell in cells if not re.fullmatch(NUMBER, cell)), f"{len(cells)} cells")
            problem = f"{odd!r} where a row is {len(columns)} plain numbers with commas between them"
            raise ProgramError(file=file, line=first + row, problem=problem, remedy="correct it", code=Code.SYNTAX)
        values[row] = cells  # row by row: the words of all take seven times the memory of the file
    return first, values


def _grouped(
    motions: Grouping, motion: Motion, rest: NDArray[np.bool_], trigger: Array, first: int, cycle: float
) -> Grouping:
    """Standstills, paths between them, and the trigger where it switches at rest; the first row is at a line."""
    still = rest[1:] & rest[:-1] & ~(np.diff(motion.coordinates, axis=0).any(axis=1))
    change = np.flatnonzero(np.diff(still) | (np.diff(trigger[:-1]) != 0.0)) + 1
    motions.stand(motion.coordinates[0])
    for start, end in pairwise([0, *map(int, change), len(still)]):
        if bool(trigger[start]) != motions.trigger:
            motions.switch(first + start, not motions.trigger, at_once=True)
        if still[start]:
            motions.pause(first + start, (end - start) * cycle)
            continue
        rows = slice(start, end + 1)
        motions.rows(first + start, cycle, motion.coordinates[rows], motion.rates[rows], motion.accelerations[rows])
    if bool(trigger[-1]) != motions.trigger:
        motions.switch(first + len(still), not motions.trigger, at_once=True)
    return motions
