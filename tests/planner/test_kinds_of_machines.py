"""What searches a motion asks a machine for its coordinates and limits, never for its kind."""

import ast
from pathlib import Path

import pytest

PLANNER = Path(__file__).parents[2] / "planner"


@pytest.mark.parametrize("package", ["families", "search", "bounds"])
def test_no_module_asks_which_kind_of_machine_a_case_has(package: str):
    files = sorted((PLANNER / package).glob("*.py"))
    assert len(files) > 3
    for file in files:
        found = [n for n in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(n, ast.Attribute)]
        asked = [
            ast.unparse(n) for n in found if n.attr in ("chain", "hexapod") and ast.unparse(n.value).endswith("case")
        ]
        assert asked == [], file
