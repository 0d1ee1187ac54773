"""Tables of setpoints with any cells, columns and rows damaged: what is still called proven is harmless."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases.errors import ProgramError
from tests.helpers import one_line
from tests.postprocessors.damaged_tables import DAMAGE
from tests.postprocessors.tables import (
    ACCELERATIONS,
    CYCLE,
    POSE,
    RATES,
    STRUTS,
    TABLES,
    Table,
    as_csv,
    as_parquet,
    path,
    proof,
    renumbered,
    share_as_driven,
    with_its_struts,
)

GROUPS = {"pose": POSE, "rates": RATES, "accelerations": ACCELERATIONS, "struts": STRUTS, "lengths": slice(19, 25)}


EDITS = st.tuples(
    st.sampled_from(
        [
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
        ]
    ),
    st.integers(0, 36),
    st.floats(0.02, 0.98),
    st.floats(-9.0, 1.0),
    st.integers(1, 20),
)


def edited(table: Table, edits: list[tuple[str, int, float, float, int]], consistent: bool, renumber: bool) -> Table:
    """A table with cells, columns and rows damaged: sizes are powers of ten times the range of the column."""
    for kind, column, share, power, count in edits:
        row = int(share * len(table))
        rows, size = slice(row, row + count), 10.0**power
        part = list(GROUPS.values())[column % len(GROUPS)]
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
    if renumber:
        renumbered(table)
    return with_its_struts(table) if consistent else table


def judged(name: str, packed: bool, edits: list[tuple[str, int, float, float, int]], consistent: bool) -> bool:
    """Whether a damaged table is still called proven; it must then be harmless."""
    table = edited(TABLES[name]().copy(), edits, consistent, renumber=True)
    try:
        result = proof(as_parquet(table) if packed else as_csv(table))
    except ProgramError as error:
        assert one_line(error).startswith("t")
        return False
    assert result.ok == (not result.violations)
    if result.ok:
        assert share_as_driven(table) <= 1.0 + 1e-3
    return result.ok


damaged = given(
    packed=st.booleans(), edits=st.lists(EDITS, min_size=1, max_size=3), consistent=st.booleans()
)  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
@settings(max_examples=60, deadline=None)
@damaged
def test_a_damaged_table_that_is_called_proven_is_harmless(
    name: str, packed: bool, edits: list[tuple[str, int, float, float, int]], consistent: bool
):
    judged(name, packed, edits, consistent)


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
@settings(max_examples=2500, deadline=None)
@damaged
def test_thousands_of_damaged_tables_that_are_called_proven_are_harmless(
    name: str, packed: bool, edits: list[tuple[str, int, float, float, int]], consistent: bool
):
    judged(name, packed, edits, consistent)


def test_the_judge_sees_what_is_dangerous_and_the_proof_lets_pass_what_is_not():
    for damage in (
        "twice the way",
        "twice the speed",
        "struts exchanged",
        "rates per minute",
        "micrometres for picometres",
    ):
        assert share_as_driven(DAMAGE[damage](path().copy())) > 1.0, damage
    assert judged("path", True, [("round", 0, 0.5, 0.0, 12)], True)  # the last digit
    assert judged("path", True, [("bump", 0, 0.5, -3.0, 20)], True)  # 80 ms wide, a thousandth of the way
