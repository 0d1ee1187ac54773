"""The reference is complete: every key of a case file is explained, every command and option has a line."""

import importlib.util
from pathlib import Path

import pytest

from cases.base.unit_names import QUANTITIES
from cases.orientation import CONVENTIONS
from cases.scaffold import explanations
from cases.schema import Case
from cases.tables import Part

spec = importlib.util.spec_from_file_location("generate", Path(__file__).parents[2] / "docs" / "generate.py")
assert spec is not None
assert spec.loader is not None
generate = importlib.util.module_from_spec(spec)
spec.loader.exec_module(generate)


def _tables(part: type[Part]) -> list[type[Part]]:
    return [inner for direct in part.__subclasses__() for inner in (direct, *_tables(direct))]


@pytest.mark.parametrize("table", _tables(Part), ids=lambda table: table.__name__)
def test_every_key_of_a_case_is_explained(table: type[Part]) -> None:
    if table.__name__ in Case.model_json_schema()["$defs"] or table is Case:
        assert set(explanations(table)) >= set(table.model_fields)


def test_the_page_of_the_case_has_every_table() -> None:
    page = generate.case_page()
    for heading in (
        "[machine]",
        "[limits.motion]",
        "[recording.clock]",
        "[controller.sinumerik]",
        "[sensor_frame]",
    ):
        assert f"`{heading}`" in page
    assert "| `strut_velocity_m_s` | number above 0 | required |" in page


def test_every_command_and_option_has_a_line() -> None:
    page = generate.commands_page()
    for heading in ("plan", "look", "identify", "case new", "demo"):
        assert f"# `hexcite {heading}`\n" in page
    assert "Exit codes" in page
    options = [row for row in page.splitlines() if row.startswith("* `--")]
    assert len(options) > 100
    for row in options:
        assert row.partition("`: ")[2], row


def test_every_public_name_of_python_has_a_place() -> None:
    import hexcite

    page = generate.python_page()
    assert all(f"## hx.{name}\n" in page for name in dir(hexcite))


def test_the_page_of_units_has_every_unit_and_every_convention() -> None:
    page = generate.units_page()
    assert all(f"| `{symbol}` | " in page for units in QUANTITIES for symbol in units)
    assert "| `lbf-in` | 0.112984829 |" in page
    assert all(f"| `{name}` | " in page for name in CONVENTIONS)
