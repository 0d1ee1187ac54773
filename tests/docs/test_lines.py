"""Lines of documents are at most 120 characters long, so that a change is read as what it is."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.docs.test_links import GENERATED

ROOT = Path(__file__).parents[2]
NAMES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CONVENTIONS.md", "examples/README.md")
PAGES = [*(ROOT / name for name in NAMES), *sorted((ROOT / "docs").rglob("*.md"))]
LONGEST = 120
WHOLE = re.compile(r" *\||!\[| {4}")  # rows of tables, pictures and code cannot be broken


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Lines outside of fenced code, with their numbers."""
    fence = ""
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"\s*(`{3,}|~{3,})", line)
        if mark and not fence:
            fence = mark[1]
        elif mark and line.strip() == fence:
            fence = ""
        elif not fence:
            yield number, line


@pytest.mark.parametrize("page", [p for p in PAGES if "_build" not in p.parts and p.name not in GENERATED], ids=str)
def test_no_line_of_prose_is_longer_than_a_screen(page: Path):
    text = page.read_text(encoding="utf-8")
    assert [number for number, line in prose(text) if len(line) > LONGEST and not WHOLE.match(line)] == []
