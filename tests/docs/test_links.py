"""Links of the documents lead somewhere: those of the README too, which the site does not check."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONVENTIONS.md",
    ROOT / "CHANGELOG.md",
    ROOT / "examples/README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
GENERATED = {"commands.md", "python.md", "case.md", "units.md", "formulas.md"}


@pytest.mark.parametrize("page", [p for p in PAGES if "_build" not in p.parts and p.name not in GENERATED], ids=str)
def test_links_to_files_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        generated = Path(target).name in GENERATED  # by `make docs`
        if "://" not in target and not target.startswith("table-") and not generated:
            assert (page.parent / target).exists(), f"{page.name}: {target}"
