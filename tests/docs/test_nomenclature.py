"""The nomenclature is true: each letter and noun is defined where it says, and types of the walks have one."""

import importlib
import re
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).parents[2] / "docs"
ROWS = re.findall(r"(?m)^\| (.+?) \| (.+?) \| `([\w.]+)` \|$", (DOCS / "nomenclature.md").read_text(encoding="utf-8"))


def found(path: str) -> Any:
    """What a dotted path names: a module's name, or a field or property of a class; AttributeError where nothing is."""
    parts = path.split(".")
    names = 2 if parts[-2][0].isupper() else 1
    thing: Any = importlib.import_module(".".join(parts[:-names]))
    for name in parts[-names:]:
        fields = getattr(thing, "__annotations__", {})
        thing = fields[name] if name in fields and isinstance(thing, type) else getattr(thing, name)
    return thing


@pytest.mark.parametrize(("noun", "meaning", "path"), ROWS)
def test_a_noun_is_defined_where_it_says(noun: str, meaning: str, path: str) -> None:
    assert noun
    assert meaning
    assert found(path) is not None


def test_every_row_is_read_and_no_noun_stands_twice() -> None:
    lines = [line for line in (DOCS / "nomenclature.md").read_text(encoding="utf-8").splitlines() if "`" in line]
    assert len([line for line in lines if line.startswith("| ")]) == len(ROWS) > 50
    nouns = [noun for noun, _, _ in ROWS]
    assert len(nouns) == len(set(nouns))


def test_types_of_both_walks_are_explained() -> None:
    """What each step of `architecture.md` gives, from a file to the result, from a request to the run."""
    _, *walks = (DOCS / "architecture.md").read_text(encoding="utf-8").split("| step | function | room | gives |")
    lines = [line for walk in walks for line in walk.split("\n\n")[0].splitlines()[2:]]
    types = {name for line in lines for name in re.findall(r"`([A-Z]\w+)`", line.split("|")[4])}
    known = {path.rpartition(".")[2] for _, _, path in ROWS}
    assert types - known == {"ColumnTable", "PlanComparison"}  # of readers alone, and a plan beside its run
    assert len(types & known) > 15


@pytest.mark.parametrize("path", ["identification.signals.Fliter", "cases.schema.Case.nothing_at_all"])
def test_a_place_that_is_gone_is_noticed(path: str) -> None:
    with pytest.raises(AttributeError):
        found(path)
