"""Writes tables of setpoints, one row a control cycle: the one form of a program that carries time exactly.

The machine must stand at home when the table starts. Motions last a whole number of cycles: each is slowed by less than
one. Rates and accelerations are those of the motion, not differences; strut lengths of a hexapod and their derivatives
are (7), (8) and the derivative of (8).
"""

from collections.abc import Iterator
from itertools import count, groupby

import numpy as np

from cases.base.errors import Code, ProgramError
from cases.base.units import DEG, MM
from cases.controller import Setpoints
from cases.recording_format import setpoint_columns
from cases.schema import Case
from identification.motion.motion import Array, Joined, Slowed, Standstill, Trajectory
from postprocessors.blocks import Blocks, ToHome, Trigger, block_motions
from postprocessors.dialects.block_writer import header_of
from postprocessors.reading import Reading, Still, Timed

FORMAT = "hexcite setpoints 1"
# Coordinates, rates, accelerations: so fine that jerks, the differences of accelerations, keep seven digits.
DECIMALS, STRUT_DECIMALS = (12, 9, 6), [9] * 6 + [7] * 6 + [5] * 6
SAME = 1e-9  # [m, rad] tolerance between table and plan, for rounding


TablePart = tuple[Trajectory | None, int, bool]
"""A stretch of whole cycles: its motion, None for a standstill, how many cycles, and whether the trigger is on."""


def _parts(program: Blocks, cycle: float) -> Iterator[TablePart]:
    """Parts of a table: motions up to the next standstill, or switch of the trigger, as one; each standstill alone."""
    number = count(1)

    def stretch(block: tuple[Trajectory, bool]) -> tuple[int, bool]:
        return next(number) if isinstance(block[0], Standstill) else 0, block[1]

    for (standing, on), blocks in groupby(block_motions(program), stretch):
        motions = [motion for motion, _ in blocks]
        motion = Joined(tuple(motions)) if len(motions) > 1 else motions[0]
        cycles = max(1, int(np.ceil(motion.duration / cycle - 1e-6)))
        yield None if standing else Slowed(motion, motion.duration / (cycles * cycle)), cycles, on


def _motion(program: Blocks, cycle: float) -> tuple[list[Array], Array]:
    """Pose, rates and accelerations at all rows, and whether the trigger is on in the cycle that each row begins."""
    home = next(b.coordinates for b in program if isinstance(b, ToHome))
    rows: list[list[Array]] = [[home[None, :]], [np.zeros((1, len(home)))], [np.zeros((1, len(home)))]]
    trigger: list[Array] = []
    for motion, cycles, on in _parts(program, cycle):
        if motion is None:
            stand = np.tile(rows[0][-1][-1], (cycles, 1))
            values = [stand, np.zeros_like(stand), np.zeros_like(stand)]
        else:
            at = motion.at(np.minimum(np.arange(1, cycles + 1) * cycle, motion.duration))
            values = [np.array(v) for v in (at.coordinates, at.rates, at.accelerations)]
            values[1][-1] = values[2][-1] = 0.0  # at rest
        for column, value in zip(rows, values, strict=True):
            column.append(value)
        trigger.append(np.full(cycles, float(on)))
    last = [b.on for b in program if isinstance(b, Trigger)][-1:]
    return [np.vstack(column) for column in rows], np.concatenate([*trigger, [float(any(last))]])


def decimals_of(case: Case) -> list[int]:
    """Decimals of each column of a table."""
    home, limits = case.need_motion("a setpoint table")
    return [6, *(places for places in DECIMALS for _ in home), *(STRUT_DECIMALS if limits.of_pose else ()), 0]


def write_setpoints(program: Blocks, case: Case) -> bytes:
    """The table as CSV, plain ASCII; see `Dialect.write`."""
    settings, decimals = case.need_settings(Setpoints, "a setpoint table"), decimals_of(case)
    limits = case.need_motion("a setpoint table")[1]
    motion, trigger = _motion(program, settings.cycle)
    values = [v / np.where(limits.turns, DEG, MM) for v in motion]
    words = [f"joints: from the base, {', '.join(limits.labels)}; angles not wrapped"]
    if limits.of_pose:
        from identification.machines.of_case import machine_of  # CasADi, which other dialects do not need

        machine = machine_of(case)
        values += [v / MM for v in (machine.drives(motion[0]), *machine.further_drives(case, *motion)[0])]
        words = [
            "pose: origin of the platform in the base frame; R = Rz(c) Ry(b) Rx(a), angles not wrapped",
            "struts: l1 to l6 with first (ld) and second (ldd) derivatives",
        ]
    notes = [
        f"format: {FORMAT}",
        f"cycle_ms: {settings.cycle_ms:g}",
        "units: as the columns say; t_s from the start",
        *words,
        "start: the machine must stand in the first row's pose",
        *(f"note: {line}" for line in header_of(program)),
    ]
    header = ["# " + line.encode("ascii", "replace").decode("ascii").replace("\n", " ") for line in notes]
    columns = np.column_stack([np.arange(len(trigger)) * settings.cycle, *values, trigger]).T
    rounded = np.column_stack([np.round(v, d) for v, d in zip(columns, decimals, strict=True)]) + 0.0  # no -0
    row = ",".join(f"%.{d}f" for d in decimals)
    names = ",".join(setpoint_columns(limits.columns, limits.of_pose))
    return ("\n".join([*header, names, *(row % tuple(v) for v in rounded)]) + "\n").encode("ascii")


def require_same_table(program: Blocks, reading: Reading, case: Case) -> None:
    """Raises ProgramError unless the table, as read back, is the program's motion row by row.

    Where a path stands for some rows, the reader has a standstill between two paths: rows are compared, not stretches.
    """
    cycle = case.need_settings(Setpoints, "a setpoint table").cycle
    (written, _, _), switched = _motion(program, cycle)
    lines, coordinates, trigger = _rows(reading, written[0], cycle)
    if len(coordinates) != len(written):
        raise ProgramError(
            file=reading.file,
            problem=f"{len(coordinates)} rows where {len(written)} were written",
            remedy="report this",
            code=Code.INTERNAL,
        )
    different = np.any(np.abs(coordinates - written) > SAME, axis=1)
    different[1:] |= trigger != switched[:-1]  # a row ends the cycle that the one before began
    if different.any():
        raise ProgramError(
            file=reading.file,
            line=int(lines[np.argmax(different)]),
            problem="a row reads back differently",
            remedy="report this",
            code=Code.INTERNAL,
        )


def _rows(reading: Reading, start: Array, cycle: float) -> tuple[Array, Array, Array]:
    """Lines and coordinates of all rows, shapes (n,) and (n, k), and the trigger in the cycles between, (n - 1,)."""
    lines, coordinates, trigger = [np.zeros(1)], [start[None, :]], list[Array]()
    for stretch in reading.stretches:
        if isinstance(stretch, Timed):
            path = stretch.points.at(stretch.points.times).coordinates
            lines_of_stretch = np.asarray(stretch.lines, dtype=float)
            coordinates.append(path[1:])
        else:
            assert isinstance(stretch, Still)
            lines_of_stretch = stretch.line + np.arange(round(stretch.duration / cycle), dtype=float)
            coordinates.append(np.tile(coordinates[-1][-1], (len(lines_of_stretch), 1)))
        lines.append(lines_of_stretch)
        trigger.append(np.full(len(lines_of_stretch), stretch.trigger))
    return np.concatenate(lines), np.concatenate(coordinates), np.concatenate(trigger)
