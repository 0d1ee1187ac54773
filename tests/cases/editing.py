"""Case files to damage: the text of a built-in case with one passage replaced, or any data written as TOML."""

import json
from pathlib import Path
from typing import Any

from cases.tables import built_in_cases

HEXAPOD = built_in_cases()["hexapod"].read_text(encoding="utf-8")


def edited(folder: Path, old: str, new: str) -> str:
    """A copy of the hexapod's case file in which the first `old` is `new`."""
    assert old in HEXAPOD, old
    file = folder / "case.toml"
    file.write_text(HEXAPOD.replace(old, new, 1), encoding="utf-8")
    return str(file)


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(k)} = {toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, bool | str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


def written(folder: Path, data: dict[str, Any]) -> str:
    """A case file with these tables."""
    file = folder / "case.toml"
    file.write_text("".join(f"{json.dumps(k)} = {toml(v)}\n" for k, v in data.items()), encoding="utf-8")
    return str(file)
