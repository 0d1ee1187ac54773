"""Tables as text: every row is one line."""

import re

import numpy as np
import pytest

from cases.schema import Case
from hexcite.reports.drawing.figures import limits_table
from identification.limits.limit import Limit, LimitCheck, LimitKind, LimitReport, OwnMove, Quantity, Status
from identification.limits.proof import prove, worst_case
from identification.motion.motion import StandingPoses
from identification.texts import efficiency_text, limit_lines, use_text
from planner.bounds.bound import Bound
from planner.plans.plan import Plan

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
    """A share would be counted from the middle of both bounds, so what is left to the nearer one stands there."""
    length, bounds = Limit(LimitKind.STRUT_LENGTH), (650.0, 1460.0)
    strut = LimitCheck(length, "strut 6", 1463.0, 1460.0, "mm", 1.0072, 0.0, Status.PROVEN, bounds=bounds)
    row = re.split(" {2,}", limit_lines((strut,))[1].strip())
    assert row == ["strut length (strut 6)", "1463", "650 to 1460", "mm", "3 beyond", "EXCEEDED"]
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
    rows = {words: (std, unit) for words, std, unit in saved_plan.deviation_rows()[1:]}
    assert float(rows["mass (m)"][0]) == pytest.approx(saved_plan.predicted_std["m"], rel=0.06)
    assert float(rows["centre of gravity z (zC)"][0]) == pytest.approx(saved_plan.predicted_std["zC"] * 1e3, rel=0.06)
    assert rows["centre of gravity z (zC)"][1] == "mm"


def test_a_least_value_stands_beside_what_it_must_not_fall_below() -> None:
    """46.3 % of the determinant are above 0 by 46.3; no share of a limit of 0 can be told."""
    singular = LimitCheck(
        Limit(LimitKind.SINGULARITY), "", 46.3, 0.0, "% of det J^-1 at home", 0.537, 0.0, Status.PROVEN
    )
    near = LimitCheck(Limit(LimitKind.DISTANCE_FROM_BOX, "vice"), "tool", -3.5, 0.0, "mm", 1.02, 0.0, Status.PROVEN)
    rows = [re.split(" {2,}", line.strip()) for line in limit_lines((singular, near))[1:]]
    assert rows[0][1:3] == ["46.3", "at least 0"]
    assert rows[0][4] == "46.3 left"
    assert rows[1][-2:] == ["3.5 beyond", "EXCEEDED"]
    bars = limits_table(LimitReport((singular, near)))
    assert bars.count('class="track none"') == 2
    assert "46.3 % left" in bars


def test_struts_read_against_the_end_that_they_come_to() -> None:
    length, bounds = Limit(LimitKind.STRUT_LENGTH), (260.0, 795.0)
    short = LimitCheck(length, "strut 1", 268.0, 260.0, "mm", 0.97, 0.0, Status.PROVEN, bounds=bounds)
    assert use_text(short, unit="mm") == "8 mm left"
    assert short.sentence(timed=False) == "strut length (strut 1) reaches 268 mm, limit 260"
    far = LimitCheck(length, "strut 1", 1333.0, 795.0, "mm", 3.0107, 0.0, Status.PROVEN, bounds=bounds)
    assert use_text(far, unit="mm") == "538 mm beyond"
    assert "%" not in far.sentence()


def test_of_several_distances_the_least_is_told() -> None:
    """Two pairs of bodies of other sizes: the thick ones use more of their vicinity, the thin ones are closer."""
    values = np.array([[0.300, 0.262], [0.290, 0.260]])
    quantity = Quantity.clear(Limit(LimitKind.DISTANCE_BETWEEN_LINKS), ("thick", "thin"), values, np.array([0.4, 0.2]))
    worst = worst_case(quantity, np.array([0.0, 1.0]))
    assert (worst.place, worst.worst, worst.time) == ("thin", pytest.approx(260.0), 1.0)
    inside = Quantity.clear(quantity.of, ("thick", "thin"), values - 0.295, np.array([0.4, 0.2]))
    assert not worst_case(inside, np.array([0.0, 1.0])).kept


@pytest.mark.parametrize(("value", "said"), [(0.58234, "0.582"), (1.0, "1.000"), (1.064, "above 1 (1.064")])
def test_an_efficiency_above_one_says_why(value: float, said: str) -> None:
    assert efficiency_text(value).startswith(said)
    assert (":" in efficiency_text(value)) == (value > 1.0)


def test_a_bound_that_a_motion_exceeds_is_raised_to_it() -> None:
    estimate = Bound(10.0, 21.0, 20, "a search", False, 9.9)
    raised = estimate.raised(11.24)
    assert raised.efficiency(11.24) == 1.0
    assert estimate.efficiency(11.24) == pytest.approx(1.064, abs=1e-3)
    assert (raised.certified, estimate.raised(9.0)) == (False, estimate)
    proven = Bound(10.0, 20.01, 20, "branch and bound", True, 9.99)
    assert proven.raised(10.01).certified
    assert not proven.raised(11.0).certified
