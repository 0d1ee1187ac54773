"""Values advise in words for a notebook, the page and a terminal; the command line names the options behind them."""

import ast
import re
from pathlib import Path
from typing import Any

import pytest
import typer

import hexcite as hx
from hexcite.cli import app
from hexcite.cli.advice import OPTIONS, advice
from hexcite.texts.sentences import SENTENCES
from tests.hexcite.command_line import call

OPTION = re.compile(r"(?<![\w-])--[a-z]")
"""An option as it is typed."""


@pytest.fixture(scope="module")
def result(chain: dict[str, Any], shared: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a run whose plan does not lie beside it."""
    folder = tmp_path_factory.mktemp("result")
    run = folder / "bare.csv"
    run.write_bytes((shared / "recording" / "recording.csv").read_bytes())
    call("identify", run, "--case", "hexapod", "-o", folder / "result")
    return folder / "result"


def test_a_verdict_names_no_option_and_the_command_does(result: Path) -> None:
    verdict = hx.accept(hx.Result.load(result))
    assert any("its plan" in reason for reason in verdict.unjudged)
    assert not OPTION.search(f"{verdict!r} {verdict.to_json()}")
    ended = call("accept", result)
    assert "its plan" in ended.out
    assert re.search(r"options for that: .*--plan", ended.out)
    assert not OPTION.search(str(call("accept", result, "--json").json()))


COMMAND = re.compile(r"hexcite \w+|^(?:post|plan) --|in a terminal by|im Terminal mit")
"""A whole command, which is the same for every reader."""
SYSTEM = Path("postprocessors/controllers/linuxcnc/isolation.py")
"""Runs commands of the system."""


def test_no_text_of_the_library_holds_an_option_as_it_is_typed() -> None:
    """In no language: errors say by `option` which argument they mean, values need none."""
    found = list[str]()
    for package in ("cases", "identification", "planner", "postprocessors", "hexcite"):
        for file in sorted({*Path(package).rglob("*.py")} - {SYSTEM}):
            if {"cli", "page"} & {*file.parts}:  # which type commands
                continue
            nodes = [*ast.walk(ast.parse(file.read_text(encoding="utf-8")))]
            docstrings = {node.value for node in nodes if isinstance(node, ast.Expr)}
            texts = {node: node.value for node in nodes if isinstance(node, ast.Constant) and node not in docstrings}
            found += [
                f"{file}, line {node.lineno}: {text}"
                for node, text in texts.items()
                if isinstance(text, str) and OPTION.search(text) and not COMMAND.search(text)
            ]
    assert found == []


def test_what_is_advised_by_option_is_a_sentence() -> None:
    assert OPTIONS.keys() <= SENTENCES.keys()


def test_every_option_that_is_advised_is_one_of_a_command() -> None:
    group = typer.main.get_command(app)
    known = {name for command in group.commands.values() for each in command.params for name in each.opts}  # type: ignore[attr-defined]
    assert {words.split()[0] for words in OPTIONS.values()} <= known


def test_options_are_named_once_with_the_values_of_their_sentences() -> None:
    harmonics = {"code": "needless_harmonics", "values": {"order": "2", "share": "99.8"}}
    moves = {"code": "short_ways", "values": {"other": {"code": "less_moves", "values": {}}, "share": "40"}}
    assert advice({"notes": [harmonics, harmonics], "deep": {"weak": [moves]}}) == (
        "options for that: --order 2, --moves",
    )
    assert advice({"code": "not_proven", "values": {"text": "--starts"}}) == ()
