"""The map from the paper to this program is complete, and everything that it names is there."""

import ast
import functools
import re
import shlex
from importlib import import_module
from pathlib import Path
from typing import Any

import click
import pytest
import typer

from hexcite.cli import app

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "reference" / "paper.md"
COLUMNS = 5


def rows() -> list[list[str]]:
    """Cells of every row but those of heads."""
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [row for row in cells if not set(row[0]) <= {"-"} and row[2] != "Function"]


ROWS = rows()
SERVED = [row for row in ROWS if row[2] != "-"]


@pytest.mark.parametrize(
    "what",
    [
        *(f"({number})" for number in range(1, 43)),
        *(f"Table {number}" for number in range(1, 8)),
        *(f"Figure {number}" for number in range(1, 7)),
        "Algorithm 1",
    ],
)
def test_every_equation_table_figure_and_algorithm_of_the_paper_has_its_row(what: str) -> None:
    found = [row for row in ROWS if what in [part.strip() for part in row[0].split(",")]]
    assert len(found) == 1, what


def test_every_row_has_function_command_and_test_or_says_why_not() -> None:
    for row in ROWS:
        assert len(row) == COLUMNS, row
        if row[2] == "-":
            assert row[2:] == ["-"] * 3
            assert "missing" in row[1]
            assert len(row[1]) > 40  # a reason


def _quoted(cell: str) -> str:
    match = re.fullmatch("`([^`]+)`", cell)
    assert match is not None, cell
    return match[1]


@pytest.mark.parametrize("name", sorted({row[2] for row in SERVED}))
def test_what_serves_a_row_can_be_imported(name: str) -> None:
    parts = _quoted(name).split(".")
    for count in range(len(parts), 0, -1):
        try:
            value: Any = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        assert functools.reduce(getattr, parts[count:], value) is not None
        return
    pytest.fail(f"no module of {name}")


@pytest.mark.parametrize("name", sorted({row[4] for row in SERVED}))
def test_the_test_of_a_row_exists(name: str) -> None:
    file, function = _quoted(name).split("::")
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    assert function in {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("line", sorted({row[3] for row in SERVED}))
def test_the_command_of_a_row_is_one_that_hexcite_takes(line: str, tmp_path: Path) -> None:
    """Names in capitals stand for what exists; options and their values are parsed, nothing is run."""
    program, *words = shlex.split(_quoted(line))
    assert program == "hexcite"
    command: Any = typer.main.get_command(app)
    while isinstance(command, click.Group) or hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    command.make_context("hexcite", words, resilient_parsing=False)
