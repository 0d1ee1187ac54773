"""The proof of a program knows the worst limit of its lines."""

from pathlib import Path

import pytest

import hexcite as hx
from identification.limits.limit import KINETIC

PAIRS = [
    ("hexapod", "sinumerik"),
    *(
        pytest.param(*pair, marks=pytest.mark.repeats)
        for pair in (
            ("hexapod", "linuxcnc"),
            ("hexapod", "twincat"),
            ("hexapod", "setpoints"),
            ("five_axis_table", "linuxcnc"),
            ("ur10_wrist", "urscript"),
            ("ur10_wrist", "ros2"),
        )
    ),
]


@pytest.mark.parametrize(("name", "dialect"), PAIRS)
def test_the_lines_are_those_of_the_text(name: str, dialect: str, tmp_path: Path):
    """The program is proven before the header states what was proven; a reader of the file finds the same lines."""
    case = hx.load_case(name)
    written = hx.write(hx.plan(case, hx.Manual()), dialect, accept=KINETIC)
    file = tmp_path / f"p{written.dialect.suffix}"
    written.save(file)
    read = hx.check(file, case)
    assert written.proof.of_lines == read.proof.of_lines
    assert len(read.proof.of_lines) > 1


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
