"""The walks of `architecture.md` are true: each function stands in a room that the step names."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = [ROOT / name for name in ("identification", "planner", "postprocessors", "hexcite", "cases")]
ROWS = re.findall(
    r"(?m)^\| ([^|]+) \| ([^|]*`[^|]+) \| ([^|]+) \| [^|]+ \|$", (ROOT / "docs/architecture.md").read_text()
)


def files_of(room: str) -> list[Path]:
    """Sources of a room, which is written from the repository or from its package; NAME is any dialect."""
    places = [ROOT / room, *(package / room for package in PACKAGES), ROOT / "postprocessors" / "dialects"]
    known = places if "NAME" in room else places[:-1]
    found = [place for place in known if place.exists()]
    return [file for place in found for file in ([place] if place.is_file() else sorted(place.rglob("*.py")))]


def test_there_are_two_walks() -> None:
    assert len(ROWS) >= 20


@pytest.mark.parametrize(("step", "functions", "rooms"), ROWS)
def test_a_step_stands_where_the_walk_says(step: str, functions: str, rooms: str) -> None:
    files = {room: files_of(room) for room in re.findall(r"`([^`]+)`", rooms)}
    assert all(files.values()), step
    text = "\n".join(file.read_text(encoding="utf-8") for of_room in files.values() for file in of_room)
    for name in re.findall(r"`([\w.]+)`", functions):
        assert re.search(rf"(?m)^(\s*def {name.rpartition('.')[2]}\(|    {name.rpartition('.')[2]}: )", text), name
