"""What spreadsheets, scripts and wrong settings make of a table of setpoints."""

import numpy as np

from tests.postprocessors.tables import (
    ACCELERATIONS,
    COLUMNS,
    POSE,
    RATES,
    STRUTS,
    TRIGGER,
    Edit,
    T,
    Table,
    fastest,
    renumbered,
    with_its_struts,
)


def exchanged(one: str, other: str) -> Edit:
    def edit(table: Table) -> Table:
        pair = [COLUMNS.index(one), COLUMNS.index(other)]
        table[:, pair] = table[:, pair[::-1]]
        return table

    return edit


def scaled(part: slice | int, factor: float) -> Edit:
    def edit(table: Table) -> Table:
        table[:, part] *= factor
        return table

    return edit


def shifted(part: slice, rows: int) -> Edit:
    def edit(table: Table) -> Table:
        table[:, part] = np.roll(table[:, part], rows, axis=0)
        return table

    return edit


def without(first: int | None, count: int | None) -> Edit:
    """Rows lost, counted from the fastest one; None: from the begin, to the end."""

    def edit(table: Table) -> Table:
        row = fastest(table)
        start = 0 if first is None else row + first
        return renumbered(np.delete(table, slice(start, None if count is None else row + count), axis=0))

    return edit


def enlarged(table: Table) -> Table:
    """Twice the way in the same time, consistent in all columns."""
    table[:, POSE] = table[0, POSE] + 2 * (table[:, POSE] - table[0, POSE])
    table[:, RATES] *= 2
    table[:, ACCELERATIONS] *= 2
    return with_its_struts(table)


def hastened(table: Table) -> Table:
    """Each second row, which is the motion at twice its speed, consistent in all columns."""
    table = table[::2] if len(table) % 2 else table[:-1:2]
    table[:, RATES] *= 2
    table[:, ACCELERATIONS] *= 4
    return with_its_struts(renumbered(table))


def moved(table: Table) -> Table:
    """All poses 1 mm to the side, where the machine does not stand when the table starts."""
    table[:, 1] += 1.0
    return with_its_struts(table)


def rounded(digits: int) -> Edit:
    """Positions of so many decimals, consistent: coarse steps are leaps of velocity to a drive."""

    def edit(table: Table) -> Table:
        table[:, POSE] = np.round(table[:, POSE], digits)
        return with_its_struts(table)

    return edit


def single_precision(table: Table) -> Table:
    table[:, POSE] = table[:, POSE].astype(np.float32)
    return with_its_struts(table)


def two_rows_exchanged(table: Table) -> Table:
    row = fastest(table)
    table[[row, row + 1]] = table[[row + 1, row]]
    return renumbered(table)


def a_row_twice(table: Table) -> Table:
    row = fastest(table)
    return renumbered(np.insert(table, row, table[row], axis=0))


def held(table: Table) -> Table:
    """A column filled down from one cell, as a spreadsheet does."""
    row = fastest(table)
    table[row : row + 10, 1] = table[row, 1]
    return with_its_struts(table)


DAMAGE: dict[str, Edit] = {
    "positions exchanged": exchanged("x_mm", "y_mm"),
    "angles exchanged": exchanged("a_deg", "c_deg"),
    "struts exchanged": exchanged("l1_mm", "l2_mm"),
    "speeds of struts exchanged": exchanged("ld1_mm_s", "ld6_mm_s"),
    "rates exchanged": exchanged("v_x_mm_s", "v_a_deg_s"),
    "whole coordinates exchanged": lambda t: exchanged("acc_x_mm_s2", "acc_y_mm_s2")(
        exchanged("v_x_mm_s", "v_y_mm_s")(exchanged("x_mm", "y_mm")(t))
    ),
    "positions and heights exchanged, struts to match": lambda t: with_its_struts(
        exchanged("acc_x_mm_s2", "acc_z_mm_s2")(exchanged("v_x_mm_s", "v_z_mm_s")(exchanged("x_mm", "z_mm")(t)))
    ),
    "positions in metres": scaled(slice(1, 4), 1e-3),
    "angles in radians": scaled(slice(4, 7), np.pi / 180),
    "angles in radians, struts to match": lambda t: with_its_struts(scaled(slice(4, 7), np.pi / 180)(t)),
    "rates per minute": scaled(RATES, 60.0),
    "accelerations in g": scaled(ACCELERATIONS, 1 / 9810),
    "struts in metres": scaled(slice(19, 25), 1e-3),
    "positions in inches": scaled(slice(1, 4), 1 / 25.4),
    "time in milliseconds": scaled(T, 1e3),
    "twice as fast by its clock": scaled(T, 0.5),
    "twice as slow by its clock": scaled(T, 2.0),
    "angles with the other sign": scaled(5, -1.0),
    "struts a row late": shifted(STRUTS, 1),
    "rates a row late": shifted(RATES, 1),
    "accelerations a row early": shifted(ACCELERATIONS, -1),
    "positions a row late": shifted(POSE, 1),
    "the trigger a row late": shifted(slice(TRIGGER, TRIGGER + 1), 1),
    "a row lost": without(0, 1),
    "ten rows lost": without(0, 10),
    "the end lost": without(0, None),
    "the begin lost": without(None, 0),
    "a row twice": a_row_twice,
    "two rows exchanged": two_rows_exchanged,
    "a column filled down": held,
    "backwards": lambda t: renumbered(t[::-1].copy()),
    "twice the way": enlarged,
    "twice the speed": hastened,
    "away from home": moved,
    "micrometres for picometres": rounded(3),
    "single precision": single_precision,
}
