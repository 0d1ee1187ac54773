"""What searches, proves or writes a motion asks a machine for its coordinates and limits, never for its kind."""

import ast
from pathlib import Path

import pytest

HOME = Path(__file__).parents[2]
KINDS = ("chain", "hexapod")
OF_ONE_KIND = "configuration.py"  # the kinematics of a case, with which LinuxCNC is configured


@pytest.mark.parametrize(
    "place",
    [
        "planner/families", "planner/search", "planner/bounds", "planner/retiming.py", "planner/controller_limits.py",
        "identification/motion", "identification/machines/path_timing.py", "identification/machines/executed.py",
        "identification/limits/proof.py", "postprocessors/proof", "postprocessors/dialects",
        "postprocessors/controllers", "postprocessors",
    ],
)  # fmt: skip
def test_no_module_asks_which_kind_of_machine_a_case_has(place: str):
    deep = place in ("postprocessors/controllers", "postprocessors/dialects")
    files = [HOME / place] if place.endswith(".py") else sorted((HOME / place).glob("**/*.py" if deep else "*.py"))
    assert files
    for file in files:
        if file.name == OF_ONE_KIND:
            continue
        found = [n for n in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(n, ast.Attribute)]
        asked = [ast.unparse(n) for n in found if n.attr in KINDS and ast.unparse(n.value).endswith("case")]
        assert asked == [], file
