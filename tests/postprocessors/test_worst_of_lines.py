"""The proof of a program knows the worst limit of its lines."""

import pytest

import hexcite as hx


@pytest.mark.slow
def test_the_worst_of_all_lines_is_the_worst_of_the_program():
    case = hx.load_case("hexapod")
    plan = hx.plan(case, hx.PointToPoint(moves=12), duration=6.0, starts=1, workers=1, seed=1)
    proof = hx.write(plan, "sinumerik").proof
    lines = [check.line for check in proof.of_lines]
    assert lines == sorted({*lines})
    assert lines[0] > 0
    whole = {check.name: check for check in proof.limits.checks}
    for check in proof.of_lines:
        assert check.ratio <= 1.0 + 1e-9
        assert check.kind in {each.kind for each in whole.values()}
    assert max(check.ratio for check in proof.of_lines) == max(check.ratio for check in proof.limits.checks)
    assert [entry["line"] for entry in proof.lines_to_json()] == lines
