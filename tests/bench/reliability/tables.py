"""Tables of setpoints with cells, columns and rows damaged."""

import random

import numpy as np

from tests.postprocessors.tables import (
    ACCELERATIONS,
    CYCLE,
    POSE,
    RATES,
    STRUTS,
    TABLES,
    Table,
    renumbered,
    with_its_struts,
)

KINDS = (
    "outlier",
    "exchange",
    "scale",
    "shift",
    "drop",
    "double",
    "swap",
    "hold",
    "offset",
    "bump",
    "round",
    "stretch",
)
GROUPS = (POSE, RATES, ACCELERATIONS, STRUTS, slice(19, 25))


def damaged_table(draw: random.Random) -> Table:
    """A table after one to three accidents, consistent with its struts or not."""
    table = TABLES[draw.choice(list(TABLES))]().copy()
    for _ in range(draw.randint(1, 3)):
        table = damaged(table, draw.choice(KINDS), draw)
    table = renumbered(table)
    return with_its_struts(table) if draw.random() < 0.5 else table


def damaged(table: Table, kind: str, draw: random.Random) -> Table:
    """The table after an accident; sizes are powers of ten times the range of the column."""
    column, row, count = draw.randrange(37), int(draw.uniform(0.02, 0.98) * len(table)), draw.randint(1, 20)
    rows, size, part = slice(row, row + count), 10.0 ** draw.uniform(-9.0, 1.0), draw.choice(GROUPS)
    extent = max(float(np.ptp(table[:, column])), 1e-6)
    match kind:
        case "outlier":
            table[row, column] += size * extent
        case "exchange":
            other = (column + count) % 37
            table[:, [column, other]] = table[:, [other, column]]
        case "scale":
            table[:, column] *= 1.0 + size
        case "shift":
            table[:, part] = np.roll(table[:, part], count % 3 - 1, axis=0)
        case "drop":
            table = np.delete(table, rows, axis=0)
        case "double":
            table = np.insert(table, [row] * len(table[rows]), table[rows], axis=0)
        case "swap":
            other = min(row + count, len(table) - 1)
            table[[row, other]] = table[[other, row]]
        case "hold":
            table[rows, column] = table[row, column]
        case "offset":
            table[row:, column] += size * extent
        case "round":
            table[:, part] = np.round(table[:, part], count % 13)
        case "stretch":
            table[:, RATES] *= 1.0 + size
            table[:, ACCELERATIONS] *= (1.0 + size) ** 2
        case "bump":  # a smooth one, whose derivatives stand in the other columns
            u = (np.arange(len(table)) - row) / (2.0 * count)
            axis, height, hill = column % 6, size * extent, np.exp(-u * u / 2)
            hill[np.abs(u) > 6] = 0.0
            width = 2.0 * count * CYCLE
            table[:, 1 + axis] += height * hill
            table[:, 7 + axis] -= height * u * hill / width
            table[:, 13 + axis] += height * (u * u - 1) * hill / width**2
    return table
