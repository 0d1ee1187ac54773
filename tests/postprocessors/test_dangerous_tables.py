"""Tables of setpoints damaged as spreadsheets, scripts and wrong settings damage them are refused."""

import numpy as np
import pytest

from cases.base.errors import ProgramError
from tests.helpers import few, seeds
from tests.postprocessors.damaged_tables import DAMAGE
from tests.postprocessors.programs import HOME
from tests.postprocessors.tables import (
    CASE,
    COLUMNS,
    CYCLE,
    LANGUAGE,
    LIMITS,
    POSE,
    TABLES,
    TRIGGER,
    UNITS,
    T,
    as_csv,
    fastest,
    moves,
    proof,
    refused,
    renumbered,
    share_as_driven,
    with_its_struts,
)


@pytest.mark.parametrize("name", TABLES)
def test_the_tables_before_the_damage_are_proven(name: str):
    assert proof(as_csv(TABLES[name]())).ok
    assert 0.7 < share_as_driven(TABLES[name]()) <= 1.0


@pytest.mark.first(24)
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_to_columns_units_and_rows_is_refused(damage: str, name: str):
    assert refused(as_csv(DAMAGE[damage](TABLES[name]().copy())))


@pytest.mark.first(24)
@pytest.mark.parametrize("column", range(1, 37), ids=COLUMNS[1:37])
@pytest.mark.parametrize("name", TABLES)
def test_a_single_outlier_of_a_thousandth_of_its_column_is_refused(name: str, column: int):
    table = TABLES[name]().copy()
    table[fastest(table), column] += 1e-3 * np.ptp(table[:, column])
    assert refused(as_csv(table))


def test_an_outlier_of_20_nm_is_refused_where_the_jerk_is_near_its_limit():
    """Drives that follow the positions alone would jerk by 1.4 of the limit there."""
    table = moves().copy()
    table[int(np.argmax(np.abs(np.diff(table[:, 13])))) + 2, 1] += 2e-5
    table = with_its_struts(table)
    assert share_as_driven(table) > 1.2
    assert refused(as_csv(table))


@seeds(5)
def test_whatever_a_jerk_within_its_limit_does_between_rows_the_table_is_read(seed: int):
    """Jerk changes at random ten times a cycle, then backwards and turned, until the machine stands again."""
    draw, fine = np.random.default_rng(seed), CYCLE / 10
    drawn = LIMITS.jerk[0] * np.sign(draw.uniform(-1.0, 1.0, 300) + draw.choice([-0.5, 0.0, 0.5]))
    jerk = np.concatenate([drawn, -drawn, -drawn, drawn])
    a, v, x = np.zeros((3, len(jerk) + 1))
    for k, j in enumerate(jerk):
        a[k + 1], v[k + 1] = a[k] + j * fine, v[k] + a[k] * fine + j * fine**2 / 2
        x[k + 1] = x[k] + v[k] * fine + a[k] * fine**2 / 2 + j * fine**3 / 6
    v[-1] = a[-1] = 0.0  # but for rounding
    rows = slice(None, None, 10)
    table = np.zeros((len(x[rows]) + 1, len(COLUMNS)))
    table[:, POSE] = HOME / UNITS[POSE]
    table[:-1, 1] += x[rows] * 1e3
    table[-1, 1] = table[-2, 1]
    table[:-1, 7], table[:-1, 13] = v[rows] * 1e3, a[rows] * 1e3
    table = with_its_struts(renumbered(table))
    assert LANGUAGE.read(as_csv(table), "t", CASE).stretches


@pytest.mark.parametrize("value", few(np.nan, 1e300, np.inf, -np.inf, kept=2))
@pytest.mark.parametrize("column", [T, 1, 10, 16, 20, 30, TRIGGER], ids=lambda k: COLUMNS[k])
def test_what_is_no_number_is_refused_wherever_it_stands(value: float, column: int):
    table = moves().copy()
    table[fastest(table), column] = value
    with np.errstate(invalid="ignore"):
        assert refused(as_csv(table))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((b",", b";"), "then the columns t_s,x_mm,"),
        ((b".", b","), "cells' where a row is 38 plain numbers"),
        ((b"x_mm,y_mm", b"y_mm,x_mm"), "then the columns t_s,x_mm,"),
        ((b"# format", b"\xef\xbb\xbf# format"), "then the columns t_s,x_mm,"),
    ],
    ids=["semicolons", "decimal commas", "headings exchanged", "a byte order mark"],
)
def test_what_spreadsheets_make_of_a_table_is_refused(change: tuple[bytes, bytes], words: str):
    head, body = as_csv(moves()).split(b"t_s,", 1)
    content = head.replace(*change) + b"t_s," + body.replace(*change)
    with pytest.raises(ProgramError, match=words):
        proof(content)
