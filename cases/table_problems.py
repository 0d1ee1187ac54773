"""What is wrong with tables, in words: each problem that pydantic finds, with key, value and remedy, causes first."""

import difflib
import re
import reprlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from cases.base.errors import CaseError, Code, first_problems
from cases.base.phrases import Phrase, enumerated, parts_of, phrase, said

_UNIT = re.compile(
    r"_(mm|cm|m|um|in|deg|rad|mrad|kg|g|t|kg_m2|s|ms|us|min|N|kN|Nm|N_m|Nm_m|Hz|kHz|cycles|mm_min|((mm|m|deg|rad)_s[23]?))$"
)
"""The unit at the end of a key, ours and those that users write instead."""


def explained(model: type[BaseModel], path: Path, error: ValidationError) -> CaseError:
    """All problems in words, causes first: a misspelt key also makes its right name missing, a text is not a number.

    The shortest come first among their kind.
    """
    errors = error.errors(include_url=False)
    # A list whose entries are invalid counts as too short beside them.
    invalid = {problem["loc"][:-1] for problem in errors} | {problem["loc"][:-2] for problem in errors}
    errors = [e for e in errors if e["type"] != "too_short" or e["loc"] not in invalid]
    problems = _together(
        (_rank(problem), _key(problem), words, _name(problem))
        for problem in errors
        for words in parts_of(_words(model, problem))
    )
    meanings = {_within_table(key.rpartition(".")[0], _meant(words)) for _, key, words in problems}
    problems = [p for p in problems if p.words != MISSING or p.key not in meanings]
    problems.sort(key=lambda problem: (problem.rank, len(problem.key) + len(problem.words)))
    lines = first_problems([problem.line for problem in problems])
    first = problems[0]
    problem = enumerated("problems", [first.words, *lines[1:]])
    return CaseError(file=path, key=first.key, problem=problem, problems=lines, code=Code.WRONG_KIND)


class _Problem(NamedTuple):
    """A problem of a value or a table, or of several entries of a list that have the same one."""

    rank: int
    key: str  # dotted, entries of lists counted from 1: [1, 3] of several
    words: Phrase  # they know the keys that it is about, from the top

    @property
    def line(self) -> Phrase:
        """The words with their key."""
        if not self.key:
            return self.words
        return phrase("at_key", "{key}: {words}", key=self.key, words=self.words).about(*self.words.keys)


AT_KEY = "at_key"
"""Code of a problem with its key."""


def _name(problem: ErrorDetails) -> str:
    """The name of the entry of a list that a problem is about; empty where it is of none."""
    name = problem["input"].get("name") if isinstance(problem["input"], dict) else None
    of_a_list = problem["loc"] and isinstance(problem["loc"][-1], int)
    return name if of_a_list and isinstance(name, str) else ""


def _together(problems: Iterable[tuple[int, str, Phrase, str]]) -> list[_Problem]:
    """Problems by rank, key and words; what is true of several entries of a list is one, with all their names."""
    alike: dict[tuple[int, str, Phrase, bool], list[tuple[str, str, tuple[str, ...]]]] = {}
    for rank, key, words, name in problems:
        is_named = bool(name) and words.code == NAMED and words.values["name"] == name
        table, _, number = key.removesuffix("]").rpartition("[") if is_named else (key, "", "")
        problem = words.values["problem"] if is_named else words
        keys = key, *(_within_table(key, inner) for inner in words.keys)
        alike.setdefault((rank, table, problem, is_named), []).append((number, name, keys))
    found = []
    for (rank, table, words, is_named), of in alike.items():
        if is_named:
            table = f"{table}[{', '.join(number for number, _, _ in of)}]"
            words = of_named(", ".join(name for _, name, _ in of), words)
        found.append(_Problem(rank, table, words.about(*(key for *_, keys in of for key in keys if key))))
    return found


def _within_table(table: str, key: str) -> str:
    """A key of a table, from the top of the file."""
    return f"{table}.{key}" if table else key


NAMED = "named"
"""Code of a problem of an entry that has a name."""


def of_named(name: str, problem: Phrase) -> Phrase:
    """A problem of an entry of a list, with its name."""
    return phrase("named", "{name}: {problem}", name=name, problem=problem).about(*problem.keys)


MISSING = phrase("missing", "is missing; add it")


def _meant(words: Phrase) -> str:
    """The key that is meant by one that is not known; empty where none is named."""
    meant = {"unknown_key_near": "near", "other_unit": "keys"}.get(words.code)
    return "" if meant is None else str(words.values[meant])


def _rank(problem: ErrorDetails) -> int:
    """Causes before what may follow from them: unknown keys, wrong values, missing ones, rules of whole tables."""
    return {"extra_forbidden": 0, "missing": 2, "value_error": 3 - bool(problem["loc"])}.get(problem["type"], 1)


def _key(problem: ErrorDetails) -> str:
    """Where a problem is, counted as people count."""
    parts = [part for part in problem["loc"] if not _tag(part) and part != "[key]"]
    return ".".join(str(part) if isinstance(part, str) else f"[{part + 1}]" for part in parts).replace(".[", "[")


def _tag(part: int | str) -> str:
    """The class that a table was read as, which a location holds in angle brackets; empty for a key."""
    return part[1:-1] if isinstance(part, str) and part.startswith("<") else ""


_SHAPES = {
    "float_type": phrase("a_number", "a number, without quotes and with a point"),
    "finite_number": phrase("a_finite_number", "a finite number"),
    "string_type": phrase("a_text", "a text, in quotes"),
    "int_type": phrase("a_whole_number", "a whole number"),
    "tuple_type": phrase("a_list", "a list"),
}
_BOUNDS = {
    "greater_than": phrase("above", "greater than {bound}", bound=""),
    "greater_than_equal": phrase("from", "greater than or equal to {bound}", bound=""),
    "less_than": phrase("below", "less than {bound}", bound=""),
    "less_than_equal": phrase("up_to", "less than or equal to {bound}", bound=""),
}
_LIMITS = {"greater_than": "gt", "greater_than_equal": "ge", "less_than": "lt", "less_than_equal": "le"}
MOST_SHOWN = 4  # keys of a table that a remedy writes out


def _words(model: type[BaseModel], problem: ErrorDetails) -> Phrase:
    """One problem as pydantic found it, with value and remedy."""
    kind, value = problem["type"], problem["input"]
    if kind == "extra_forbidden":
        return _unknown_key(str(problem["loc"][-1]), list(_siblings(model, problem["loc"])))
    if kind == "missing":
        return MISSING
    if kind == "value_error":
        (words,) = problem["ctx"]["error"].args
        return said(words)
    if kind == "model_type":
        return phrase(
            "not_a_table",
            "{value}: is not a table; write {table}",
            value=_shown(value),
            table=_table_shown(model, problem["loc"]),
        )
    if kind in _SHAPES:
        return phrase("not_a", "{value}: is not {what}; write one", value=_shown(value), what=_SHAPES[kind])
    if kind in _BOUNDS:
        bound = _BOUNDS[kind].filled(bound=f"{problem['ctx'][_LIMITS[kind]]:.16g}")
        return phrase(
            "out_of_bounds", "{value}: input should be {bound}; correct the value", value=_shown(value), bound=bound
        )
    if kind in ("literal_error", "enum"):
        return phrase(
            "one_of",
            "{value}: input should be {choices}; correct the value",
            value=_shown(value),
            choices=problem["ctx"]["expected"],
        )
    if kind in ("too_short", "too_long"):
        of = problem["ctx"]
        if "min_length" in of:
            expected = phrase("entries_at_least", "at least {count}", count=of["min_length"])
        else:
            expected = phrase("entries_at_most", "at most {count}", count=of["max_length"])
        return phrase(
            "entries",
            "has {count} entries, {expected} are wanted; correct it (a decimal comma makes two entries)",
            count=of["actual_length"],
            expected=expected,
        )
    message = f"{problem['msg'][0].lower()}{problem['msg'][1:]}"
    return phrase("wrong_value", "{value}: {why}; correct the value", value=_shown(value), why=said(message))


def _table_shown(model: type[BaseModel], location: tuple[int | str, ...]) -> str:
    """The table that is expected at a location, with its first keys."""
    keys = list(_siblings(model, (*location, "")))
    entries = [f"{key} = .." for key in keys[:MOST_SHOWN]] + ([".."] if len(keys) > MOST_SHOWN else [])
    return f"{{ {', '.join(entries)} }}"


def _shown(value: Any) -> str:
    """A value as a message repeats it: what is long is cut."""
    return _BRIEF.repr(value)


_BRIEF = reprlib.Repr()
_BRIEF.maxstring = _BRIEF.maxother = _BRIEF.maxlong = 60


def _unknown_key(key: str, keys: list[str]) -> Phrase:
    if matches := [name for name in keys if _UNIT.sub("", name) == _UNIT.sub("", key)]:
        return phrase(
            "other_unit",
            "has no unit, or another one than is expected here; write {keys}",
            keys=enumerated("or", matches),
        )
    known = ", ".join(sorted(keys))
    if close := difflib.get_close_matches(key, keys, n=1):
        return phrase(
            "unknown_key_near",
            "is an unknown key; did you mean {near}? known keys here are {known}",
            near=close[0],
            known=known,
        )
    return phrase("unknown_key", "is an unknown key; known keys here are {known}", known=known)


def _siblings(model: type[BaseModel], location: tuple[int | str, ...]) -> Iterable[str]:
    """Names of the fields beside the one at `location`."""
    tags = {_tag(part) for part in location}
    for part in location[:-1]:
        if not isinstance(part, str) or part not in model.model_fields:
            continue
        inner = _within(model.model_fields[part].annotation)
        models = [c for c in inner if isinstance(c, type) and issubclass(c, BaseModel)]
        if models:  # of several the one that a tag names
            model = next((c for c in models if c.__name__ in tags), models[0])
    return model.model_fields


def _within(annotation: Any) -> Iterator[Any]:
    yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _within(inner)
