"""Keys of cases of earlier versions: they are read, do nothing, and a sentence says so."""

from collections.abc import Mapping
from typing import Any

from cases.base.phrases import Phrase, phrase

LEFT: Mapping[str, Phrase] = {
    "controller.sinumerik.moves": phrase("earlier_moves", "is of an earlier version: moves are written at a feed"),
    "controller.virtual_look_ahead": phrase(
        "earlier_look_ahead", "is of an earlier version: the virtual controller follows paths as written"
    ),
}
"""Keys that were valid in an earlier version, with what holds today."""


def earlier_keys(tables: Mapping[str, Any]) -> list[str]:
    """Those of `LEFT` that stand in some tables, dotted."""
    return [key for key in LEFT if _stands(tables, key.split("."))]


def without_earlier_keys(tables: Mapping[str, Any]) -> dict[str, Any]:
    """The same tables without the keys of `LEFT`."""
    return _without(tables, "")


def _stands(tables: Any, path: list[str]) -> bool:
    for part in path:
        if not isinstance(tables, Mapping) or part not in tables:
            return False
        tables = tables[part]
    return True


def _without(tables: Mapping[str, Any], place: str) -> dict[str, Any]:
    remaining = {key: value for key, value in tables.items() if f"{place}{key}" not in LEFT}
    return {key: _without(v, f"{place}{key}.") if isinstance(v, Mapping) else v for key, v in remaining.items()}
