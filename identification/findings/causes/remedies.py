"""What to write into a case file: the keys in which an edited case differs from it, with their values."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from cases.base.errors import Remedy, Write
from cases.base.phrases import NOTHING, Phrase, enumerated, phrase
from cases.base.units import Array
from cases.schema import Case
from identification.texts import std_text

DIGITS = 6  # of numbers that a remedy states
MOST_KEYS = 12  # that a sentence lists

Path = tuple[str | int, ...]


Places = Callable[[Path], Sequence[Path]]
"""Where in a case file a key of the case stands."""
Deviations = Callable[[Sequence[Path]], Sequence[Array]]
"""Standard deviations of what an edited case has at some places, shapes as there; 0 of what was not estimated."""


def as_it_stands(path: Path) -> Sequence[Path]:
    """A key stands where the case has it."""
    return [path]


def keys_to_write(
    case: Case, edited: Case, deviations: Deviations | None = None, places: Places = as_it_stands
) -> Phrase:
    """The keys that lead from a case to another, by table, as they stand in a file; empty where none differs.

    Args:
        case: as it is.
        edited: as it is mended.
        deviations: of values that were estimated.
        places: where in the file each key is to be written.
    """
    tables: dict[str, list[tuple[str, str]]] = {}
    written = list(_differences(case.model_dump(mode="json"), edited.model_dump(mode="json")))
    stds = [np.zeros(())] * len(written) if deviations is None else deviations([path for path, _ in written])
    for (path, value), std in zip(written, stds, strict=True):
        text = "" if value is None else f" = {_toml(value)}{_plus_minus(std)}"
        for place in places(path):
            table, key = _place(place, case)
            tables.setdefault(table, []).append((key, text))
    parts = [_in_table(table, entries) for table, entries in tables.items()]
    return phrase("write", "write {keys}", keys=enumerated("and", parts)) if parts else NOTHING


def _plus_minus(std: Array) -> str:
    """A standard deviation behind the value that it is of; empty where it was not estimated."""
    return f" (± {', '.join(std_text(each) for each in np.ravel(std))})" if np.any(std > 0.0) else ""


def numbers_of(case: Case, places: Sequence[Path]) -> list[Array]:
    """The numbers that a case has at some places, shapes as there; 0 of what is not a number."""
    values = case.model_dump(mode="json")
    return [_numeric(_at(values, place)) for place in places]


def _numeric(value: Any) -> Array:
    with suppress(TypeError, ValueError):
        return np.array(value, dtype=float)
    return np.zeros(())


def remedy(
    words: str, case: Case, edited: Case, deviations: Deviations | None = None, places: Places = as_it_stands
) -> tuple[Remedy, ...]:
    """The keys that lead from a case to another, for programs that write them; none where no key differs.

    Args:
        words: what is wrong with the case, a clause.
        case: as it is.
        edited: as it is mended.
        deviations: of values that were estimated.
        places: where in the file each key is to be written.
    """
    before, after = case.model_dump(mode="json"), edited.model_dump(mode="json")
    paths = dict.fromkeys(path[:-1] if isinstance(path[-1], int) else path for path, _ in _differences(before, after))
    stds = [np.zeros(())] * len(paths) if deviations is None else deviations(list(paths))
    keys = tuple(
        Write(place, _rounded(_at(before, path), _at(after, path)), std.tolist() if np.any(std > 0.0) else None)
        for path, std in zip(paths, stds, strict=True)
        for place in places(path)
    )
    return (Remedy(words, keys),) if keys else ()


def _at(values: Any, place: Path) -> Any:
    """The value at a place; None where there is none."""
    for part in place:
        values = values.get(part) if isinstance(values, dict) else None if values is None else values[part]
    return values


def _rounded(before: Any, after: Any) -> Any:
    """A value with its new numbers as a sentence states them."""
    if before == after:
        return after
    if isinstance(after, float):
        return float(f"{after:.{DIGITS}g}") + 0.0
    if isinstance(after, list):
        entries = before if isinstance(before, list) and len(before) == len(after) else [None] * len(after)
        return [_rounded(*pair) for pair in zip(entries, after, strict=True)]
    if isinstance(after, dict):
        table = before if isinstance(before, dict) else {}
        return {key: _rounded(table.get(key), value) for key, value in after.items() if value is not None}
    return after


def _in_table(table: str, entries: Sequence[tuple[str, str]]) -> Phrase:
    """Keys of a table with what stands behind each; a key that goes has nothing there."""
    of_joint = table.startswith(_JOINT)
    if table and len(entries) == 1 and not of_joint:
        key, text = entries[0]
        return _entry(f"{table}.{key}", text)
    keys = enumerated("comma", [_entry(key, text) for key, text in entries])
    if of_joint:
        name = table.removeprefix(_JOINT).removesuffix(_OF_JOINTS)
        return phrase("in_joint", "in joint {name} of machine.chain.joints: {keys}", name=name, keys=keys)
    return phrase("in_table", "in [{table}]: {keys}", table=table, keys=keys) if table else keys


def _entry(key: str, text: str) -> Phrase:
    return phrase("one_key", "{key}{text}", key=key, text=text) if text else phrase("no_key", "no {key}", key=key)


_JOINT, _OF_JOINTS = "joint ", " of machine.chain.joints"


def _differences(before: Any, after: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Places where two values differ, with what the second has there: None where it has nothing."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in {**before, **after}:
            yield from _differences(before.get(key), after.get(key), (*path, key))
    elif _tables(before) and _tables(after) and len(before) == len(after):
        for k, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from _differences(old, new, (*path, k))
    elif before != after:
        yield path, after


def _tables(value: Any) -> bool:
    """Whether a value is a list of tables or of points, whose entries are compared one by one."""
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], dict | list | tuple)


def _place(path: Path, case: Case) -> tuple[str, str]:
    """Table and key of a place, entries of lists counted from 1 or by the name of a joint."""
    words = [str(part) if isinstance(part, str) else f"[{part + 1}]" for part in path]
    if path[:3] == ("machine", "chain", "joints") and case.chain is not None and isinstance(path[3], int):
        return f"{_JOINT}{case.chain.joints[path[3]].name}{_OF_JOINTS}", ".".join(words[4:])
    if isinstance(path[-1], int):
        return _joined(words[:-2]), words[-2] + words[-1]
    return _joined(words[:-1]), words[-1]


def _joined(words: Sequence[str]) -> str:
    """Keys with points between them, an entry of a list behind its key: `recording.files[1].columns`."""
    return ".".join(words).replace(".[", "[")


def _toml(value: Any) -> str:
    """A value as a case file has it, numbers rounded."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(_rounded(None, value))
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items() if inner is not None) + " }"
    return str(value)
