"""Tables as text: every row is one line."""

import re

import numpy as np
import pytest

from cases.schema import Case
from identification.limit import Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Status
from identification.limit_proof import prove
from identification.motion import StandingPoses
from identification.precision import limit_lines
from planner.plans import Plan

LIMITS = (
    LimitCheck(Limit(LimitKind.STRUT_ACCELERATION, move=OwnMove.WAY_HOME), "from anywhere, at most", -450.6, -10.0,
               "m/s^2", 45.06, 0.0, Status.ENFORCED, binding=False),
    LimitCheck(Limit(LimitKind.SENSOR_FORCE), "", 1445.0, 4000.0, "N", 0.36125, 0.0, Status.PROVEN),
)  # fmt: skip


def test_every_row_is_a_line_and_numbers_stand_at_the_right() -> None:
    head, *rows = limit_lines(LIMITS)
    assert len(rows) == 2
    assert head.index("status") == rows[0].index("enforced by controller") == rows[1].index("proven")
    assert "way home (from anywhere, at most)" in rows[0]
    assert rows[0].index("~-450.6") + len("~-450.6") == rows[1].index("1445") + len("1445")
    assert "36.12 %" in rows[1]


def test_a_limit_that_is_exceeded_reads_so_and_strut_lengths_show_both_bounds() -> None:
    """What is used of a strut length is the distance from the middle of both bounds, so both stand there."""
    length, bounds = Limit(LimitKind.STRUT_LENGTH), (650.0, 1460.0)
    strut = LimitCheck(length, "strut 6", 1463.0, 1460.0, "mm", 1.0072, 0.0, Status.PROVEN, bounds=bounds)
    row = re.split(" {2,}", limit_lines((strut,))[1].strip())
    assert row == ["strut length (strut 6)", "1463", "650 to 1460", "mm", "100.72 %", "EXCEEDED"]
    middle, half = (650.0 + 1460.0) / 2, (1460.0 - 650.0) / 2
    assert abs(1463.0 - middle) / half == pytest.approx(strut.ratio, abs=1e-3)


def test_a_limit_to_both_sides_reads_so_wherever_it_was_approached(hexapod_case: Case) -> None:
    home = hexapod_case.machine.home.vector
    for side in (-1.0, 1.0):
        away = home + side * np.r_[0.2, np.zeros(5)]
        report = prove(StandingPoses(np.array([home, away])), hexapod_case, 1.0)
        (row,) = (row.split() for row in limit_lines(report.checks) if row.startswith("  position (x)"))
        assert row[2:5] == [f"{side * 200:g}", "±250", "mm"]
        assert LimitReport.of_json(report.to_json()) == report


def test_predicted_deviations_are_named_in_words(saved_plan: Plan) -> None:
    rows = {words: (std, unit) for words, std, unit in saved_plan.deviation_rows()}
    assert float(rows["mass (m)"][0]) == pytest.approx(saved_plan.predicted_std["m"], rel=0.06)
    assert float(rows["centre of gravity z (zC)"][0]) == pytest.approx(saved_plan.predicted_std["zC"] * 1e3, rel=0.06)
    assert rows["centre of gravity z (zC)"][1] == "mm"
