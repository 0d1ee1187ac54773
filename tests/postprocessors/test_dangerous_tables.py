"""Tables of setpoints damaged as spreadsheets, scripts and wrong settings damage them: refused, or harmless.

What is nevertheless called proven is judged again from the positions alone, as drives would follow them.
"""

import io
from collections.abc import Callable
from functools import cache

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyarrow import parquet

from cases.errors import ProgramError
from cases.loading import load_case
from identification.limited import strut_motion
from identification.limits import prove
from identification.motion import Joined, Motion, Standstill
from identification.profile import StraightMove
from planner.families.fourier import FourierFamily
from postprocessors.dialects import dialect
from postprocessors.program import excitation_program
from postprocessors.proof import ProgramProof, prove_program
from postprocessors.reading.setpoint_table import COLUMNS, METADATA, UNITS
from postprocessors.setpoints import DECIMALS, write_parquet
from tests.helpers import one_line
from tests.postprocessors.independent import derivatives_reached, share_of_limits, strut_lengths
from tests.postprocessors.programs import HOME

CASE = load_case("hexapod")
LIMITS = CASE.limits.motion
LANGUAGE = dialect("setpoints").load()
HEADER = "# format: hexcite setpoints 1"
CYCLE = 1e-3
T, POSE, RATES, ACCELERATIONS, STRUTS, TRIGGER = 0, slice(1, 7), slice(7, 13), slice(13, 19), slice(19, 37), 37
GROUPS = {"pose": POSE, "rates": RATES, "accelerations": ACCELERATIONS, "struts": STRUTS, "lengths": slice(19, 25)}

Table = np.ndarray
Edit = Callable[[Table], Table]


def cells(content: bytes) -> Table:
    table = parquet.read_table(pa.BufferReader(content))
    return np.column_stack([table.column(name).to_numpy() for name in COLUMNS])


@cache
def moves() -> Table:
    """There and back with a pause, at 90 % of the limits."""
    limits = [0.9 * v for v in (LIMITS.rate, LIMITS.acceleration, LIMITS.jerk)]
    far = HOME + np.r_[0.02, -0.015, 0.01, 0.02, -0.01, 0.03]
    there, back = StraightMove.fastest(HOME, far, *limits), StraightMove.fastest(far, HOME, *limits)
    program = excitation_program(Joined((there, Standstill(far, 0.02), back)), CASE, ())
    return cells(write_parquet(program, CASE))


@cache
def path() -> Table:
    """A Fourier motion of half a second that uses 85 % of its tightest limit."""
    family = FourierFamily(2, 0.5, 1, HOME, (LIMITS.pose[1] - LIMITS.pose[0]) / 2, 12)
    unknowns = np.random.default_rng(1).normal(size=family.unknowns * 6)
    for _ in range(6):
        unknowns *= 0.85 / prove(family.motion(unknowns), CASE, 2000.0).worst_ratio
    return cells(write_parquet(excitation_program(family.motion(unknowns), CASE, ()), CASE))


TABLES = {"moves": moves, "path": path}


def as_csv(table: Table) -> bytes:
    row = ",".join(f"%.{digits}f" for digits in DECIMALS)
    return "\n".join([HEADER, ",".join(COLUMNS), *(row % tuple(cells) for cells in table), ""]).encode()


def as_parquet(table: Table) -> bytes:
    packed = pa.table([pa.array(np.ascontiguousarray(column)) for column in table.T], names=list(COLUMNS))
    sink = io.BytesIO()
    parquet.write_table(packed.replace_schema_metadata({METADATA: HEADER.encode()}), sink)
    return sink.getvalue()


def proof(content: bytes, case=CASE) -> ProgramProof:
    reading = LANGUAGE.read(content, "t", case)
    return prove_program(reading, case, LANGUAGE.guarantees(reading, case))


def refused(content: bytes, case=CASE) -> bool:
    try:
        return not proof(content, case).ok
    except ProgramError as error:
        return one_line(error).startswith("t")


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("encode", [as_csv, as_parquet])
def test_the_tables_before_the_damage_are_proven(name: str, encode: Callable[[Table], bytes]):
    assert proof(encode(TABLES[name]())).ok
    assert 0.7 < share_as_driven(TABLES[name]()) <= 1.0


def renumbered(table: Table, cycle: float = CYCLE) -> Table:
    table[:, T] = np.arange(len(table)) * cycle
    return table


def with_its_struts(table: Table) -> Table:
    """The struts that belong to the poses: damage that no comparison of columns can see."""
    si = table * UNITS
    motion = Motion(si[:, T], *(si[:, part].copy() for part in (POSE, RATES, ACCELERATIONS)), np.zeros((len(si), 6)))
    table[:, STRUTS] = np.hstack(strut_motion(motion, CASE.machine)) / UNITS[STRUTS]
    return table


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


def fastest(table: Table) -> int:
    """The row at which it matters most."""
    return int(np.argmax(np.abs(table[:, 7])))


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


@pytest.mark.parametrize("encode", [as_csv, as_parquet])
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_to_columns_units_and_rows_is_refused(damage: str, name: str, encode: Callable[[Table], bytes]):
    assert refused(encode(DAMAGE[damage](TABLES[name]().copy())))


@pytest.mark.parametrize("column", range(1, 37), ids=COLUMNS[1:37])
@pytest.mark.parametrize("name", TABLES)
def test_a_single_outlier_of_a_thousandth_of_its_column_is_refused(name: str, column: int):
    table = TABLES[name]().copy()
    table[fastest(table), column] += 1e-3 * np.ptp(table[:, column])
    assert refused(as_parquet(table))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
@pytest.mark.parametrize("column", [T, 1, 10, 16, 20, 30, TRIGGER], ids=lambda k: COLUMNS[k])
def test_what_is_no_number_is_refused_wherever_it_stands(value: float, column: int):
    table = moves().copy()
    table[fastest(table), column] = value
    assert refused(as_parquet(table))
    with np.errstate(invalid="ignore"):
        assert refused(as_csv(table))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((b",", b";"), "the columns are not"),
        ((b".", b","), "cells where 38 columns stand"),
        ((b"x_mm,y_mm", b"y_mm,x_mm"), "the columns are not"),
        ((b"# format", b"\xef\xbb\xbf# format"), "the columns are not"),
    ],
    ids=["semicolons", "decimal commas", "headings exchanged", "a byte order mark"],
)
def test_what_spreadsheets_make_of_a_table_is_refused(change: tuple[bytes, bytes], words: str):
    head, body = as_csv(moves()).split(b"t_s,", 1)
    content = head.replace(*change) + b"t_s," + body.replace(*change)
    with pytest.raises(ProgramError, match=words):
        proof(content)


def share_as_driven(table: Table) -> float:
    """The largest share of a limit that drives use which follow the positions alone; above 1 it is dangerous.

    Tables that contradict themselves count as dangerous too: a controller may follow either column.
    """
    si = table * UNITS
    if not np.allclose(np.diff(si[:, T]), CYCLE, rtol=0.0, atol=1e-9):
        return np.inf
    times, pose, lengths = np.arange(len(si)) * CYCLE, si[:, POSE], si[:, 19:25]
    if np.abs(lengths - strut_lengths(pose, CASE)).max() > 2e-9 or np.abs(pose[[0]] - HOME).max() > 1e-8:
        return np.inf
    for values, rates, most in (
        (pose, si[:, RATES], LIMITS.jerk),
        (si[:, RATES], si[:, ACCELERATIONS], None),
        (lengths, si[:, 25:31], None),
        (si[:, 25:31], si[:, 31:37], None),
    ):
        middle = (values[2:] - values[:-2]) / (2 * CYCLE)
        off = np.abs(middle - rates[1:-1])
        if off.max() > (1e-4 if most is not None else 0.2):  # jerk h^2 / 6; h times a leap of acceleration
            return np.inf
    shares = [share_of_limits(times, pose, CASE)]
    for order, limit in ((1, LIMITS.strut_velocity_m_s), (2, LIMITS.strut_acceleration_m_s2)):
        shares.append(float(np.abs(derivatives_reached(times, lengths, order)).max()) / limit)
    return max(shares)


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
