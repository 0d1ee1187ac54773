"""The page of a validation: models side by side say what their methods can tell."""

from planner.reports.validation import models_table
from tests.planner.comparison.excitations import CASE, disturbed


def test_models_side_by_side_show_what_the_methods_tell():
    """Of poses alone no inertia, and no word of motions that were not made."""
    table, note = models_table(CASE, {5: disturbed("Q")[0].estimate})
    assert not any(row[0].startswith("IC") for row in table.rows)
    assert "480 poses" in note.text
    assert "hand-made" not in note.text
    table, note = models_table(CASE, {9: disturbed("D")[0].estimate})
    assert any(row[0].startswith("IC33") for row in table.rows)
    assert "480 poses" not in note.text
