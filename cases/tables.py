"""Tables of TOML files: strict numbers, ranges and points, and one line for each thing that is wrong in a file."""

import difflib
import os
import re
import reprlib
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetPydanticSchema, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails
from pydantic_core.core_schema import CoreSchema, tagged_union_schema

from cases.base.errors import CaseError, Code, FileProblem, first_problems
from cases.base.file_reading import read_whole
from cases.base.phrases import Phrase, enumerated, parts_of, phrase, said
from cases.base.units import DEG, MM, MS, UM, Array


class Part(BaseModel):
    """A table of a case file: unknown keys are errors, values never change after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def __eq__(self, other: object) -> bool:
        """Whether values are equal; arrays that were derived from them do not count."""
        return type(self) is type(other) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with other values, from which all that is derived from them is computed anew."""
        copy = super().model_copy(update=update, deep=deep)
        for name in set(vars(copy)) - set(type(copy).model_fields):
            del vars(copy)[name]
        return copy


_NEEDED: dict[str, Any] = {"needed": True}
NEEDED: Any = Field(default=None, json_schema_extra=_NEEDED)
"""Of a key that a case may be loaded without, but that all evaluations need: forms ask for it."""


def is_needed(field: FieldInfo) -> bool:
    """Whether a table cannot do without a key, or no evaluation can."""
    return field.is_required() or field.json_schema_extra == _NEEDED


def kind_of(one: type[Part], other: type[Part]) -> GetPydanticSchema:
    """The rule that distinguishes a table of one kind, by its own keys, from one of another.

    Tags in angle brackets name the class that a table was read as; messages leave them out.
    """
    distinctive = frozenset(one.model_fields) - frozenset(other.model_fields)

    def tag(table: Any) -> str:
        is_one = not distinctive.isdisjoint(table) if isinstance(table, dict) else isinstance(table, one)
        return f"<{(one if is_one else other).__name__}>"

    def schema(_: Any, handler: Callable[[type[Part]], CoreSchema]) -> CoreSchema:
        return tagged_union_schema({f"<{kind.__name__}>": handler(kind) for kind in (one, other)}, tag)

    return GetPydanticSchema(schema)


LARGEST = 1e15  # beyond any machine, in any unit; sixth powers of it are still numbers
Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=LARGEST)]


def _ordered(value: tuple[float, float]) -> tuple[float, float]:
    low, high = value
    if not low < high:
        raise ValueError(
            phrase(
                "limits_swapped",
                "lower limit {low} is not below upper limit {high}; swap or widen them",
                low=f"{low:g}",
                high=f"{high:g}",
            )
        )
    return value


def _climbing(value: tuple[float, float, float]) -> tuple[float, float, float]:
    first, last, step = value
    if not (first <= last and step > 0.0):
        raise ValueError(
            phrase(
                "not_a_grid",
                "[{first}, {last}, {step}] is not [first, last, step]; step up from first to last",
                first=f"{first:g}",
                last=f"{last:g}",
                step=f"{step:g}",
            )
        )
    return value


Grid = Annotated[tuple[Number, Number, Number], AfterValidator(_climbing)]
"""First value, last value, step."""
Range = Annotated[tuple[Number, Number], AfterValidator(_ordered)]
Vector = tuple[Number, Number, Number]
PositiveVector = tuple[Positive, Positive, Positive]
Six = tuple[Number, Number, Number, Number, Number, Number]


def frozen(values: Any) -> Array:
    """A read-only array of floats."""
    array: Array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


_OWN = {"mm": MM, "um": UM, "deg": DEG, "ms": MS}
_ENDING = re.compile(r"_(mm|um|deg|ms)(_s\d?)?$")


def spelled(pattern: str, words: Phrase) -> AfterValidator:
    """A check of the spelling of a text, by a pattern and in words for people."""

    def checked(text: str) -> str:
        if re.fullmatch(pattern, text) is None:
            raise ValueError(
                phrase("not_spelled", "{value}: is not {words}; correct the value", value=repr(text), words=words)
            )
        return text

    return AfterValidator(checked)


def _one_line(text: str) -> str:
    line = " ".join(text.split())
    if not line.isprintable():
        raise ValueError(
            phrase(
                "control_characters",
                "{value}: holds control characters, which a terminal or a controller would obey; remove them",
                value=repr(text),
            )
        )
    return line


Text = Annotated[str, AfterValidator(_one_line)]
"""Words for people, in one line without control characters; line breaks are blanks."""


def own_units(keys: Iterable[str]) -> Array:
    """SI values of the units that keys and columns end in, shape (keys,); 1 where they are SI, or have none."""
    return np.array([_OWN[match[1]] if (match := _ENDING.search(key)) else 1.0 for key in keys])


def si_value(key: str) -> cached_property[float]:
    """A value of a table in SI."""
    return cached_property(lambda table: float(getattr(table, key) * own_units([key])[0]))


def si(*keys: str | tuple[str, ...]) -> cached_property[Array]:
    """Values of a table in SI, one key after the other, as an array that cannot be changed.

    Of keys in a tuple, which state the same in several units, the one that is stated counts.
    """

    def values(table: Part) -> Array:
        present = [
            next(k for k in key if getattr(table, k) is not None) if isinstance(key, tuple) else key for key in keys
        ]
        pairs = zip(present, own_units(present), strict=True)
        return frozen(np.hstack([np.multiply(getattr(table, key), unit) for key, unit in pairs]))

    return cached_property(values)


BUILT_IN = Path(__file__).parent
CASE_FILE = "case.toml"
Tables = TypeVar("Tables", bound=BaseModel)

_UNIT = re.compile(
    r"_(mm|cm|m|um|in|deg|rad|mrad|kg|g|t|kg_m2|s|ms|us|min|N|kN|Nm|N_m|Nm_m|Hz|kHz|cycles|mm_min|((mm|m|deg|rad)_s[23]?))$"
)
"""The unit at the end of a key, ours and those that users write instead."""


def built_in_cases() -> dict[str, Path]:
    """Names of the cases that ship with hexcite and their files."""
    return {file.parent.name: file for file in sorted(BUILT_IN.glob("*/case.toml"))}


def find_case(name: str) -> Path:
    """The case file that `name` means: a built-in name, a folder with `case.toml`, or a file. Raises CaseError."""
    cases = built_in_cases()
    if name in cases:
        return cases[name]
    file = os.path.join(name, CASE_FILE) if os.path.isdir(name) else name
    if os.path.isfile(file):  # of os.path, which answers "no" to names that no file system takes
        return Path(file)
    if os.path.exists(file):
        raise CaseError(
            file=file,
            problem="is not a file",
            remedy=f"name a folder with a {CASE_FILE}, or such a file",
            code=Code.UNREADABLE,
        )
    close = difflib.get_close_matches(name, cases, n=1)
    hint = f"did you mean {close[0]!r}? " if close else ""
    raise CaseError(
        file=name or "''",
        problem="no such case",
        remedy=f"{hint}built-in cases are {', '.join(cases)}, else name a folder or file",
        code=Code.UNKNOWN,
    )


def lasting_name(name: str) -> str:
    """A name that finds the case again from any folder: built-in ones as they are, files by their whole path."""
    return name if name in built_in_cases() else str(find_case(name).resolve())


MOST_BYTES = 2**20  # of a file of tables; that of a machine has some thousand
DEEPEST = 20  # tables and lists inside each other
MOST_KEYS = 5_000  # of a file of tables; that of a machine has some hundred
_LONG_KEY = re.compile(r"(?<![\w\"'-])(?:[\w\"'-]++[ \t]*\.[ \t]*){50}")
"""A dotted key of so many parts that reading it takes long."""


def read_tables(model: type[Tables], path: Path) -> Tables:
    """Reads a TOML file by the model of its tables; raises CaseError with all that is wrong in it."""
    return tables_of(model, path, content_of_tables(path))


def tables_of(model: type[Tables], path: Path, data: Mapping[str, Any]) -> Tables:
    """Tables by their model; raises CaseError, which names the file that they are for, with all that is wrong."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise _explained(model, path, error) from error


def content_of_tables(path: Path) -> dict[str, Any]:
    """The content of a TOML file as it stands there; raises CaseError where it cannot be read, or is of no machine."""
    try:
        text = read_whole(path, MOST_BYTES).decode("utf-8-sig")
        if match := _LONG_KEY.search(text):
            line = 1 + text.count("\n", 0, match.start())
            raise CaseError(
                file=path, problem=f"line {line} has a key of 50 parts and more", remedy="correct it", code=Code.DAMAGED
            )
        data = tomllib.loads(text)
    except FileProblem as error:
        raise CaseError(file=path, problem=error.problem, remedy=error.remedy, code=Code.UNREADABLE) from error
    except UnicodeDecodeError as error:
        raise CaseError(
            file=path, problem=f"cannot be read ({error})", remedy="give a readable UTF-8 file", code=Code.UNREADABLE
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise CaseError(
            file=path,
            problem=f"is not TOML: {error}",
            remedy="correct that line, numbers have decimal points",
            code=Code.DAMAGED,
        ) from error
    except (ValueError, RecursionError) as error:  # of Python: numbers of thousands of digits, lists in lists in lists
        if isinstance(error, CaseError):
            raise
        line = 1 + max(enumerate(text.splitlines()), key=lambda item: len(item[1]), default=(0, ""))[0]
        what = "lists are too deep" if isinstance(error, RecursionError) else "a number is too long"
        raise CaseError(
            file=path,
            problem=f"{what}, probably in line {line}, the longest",
            remedy="correct that line",
            code=Code.DAMAGED,
        ) from error
    key, count = _too_deep(data)
    if key:
        raise CaseError(
            file=path,
            key=key,
            problem=f"holds more than {DEEPEST} tables or lists inside each other",
            remedy="correct it",
            code=Code.DAMAGED,
        )
    if count > MOST_KEYS:
        raise CaseError(
            file=path,
            problem=f"holds {count} keys, at most {MOST_KEYS} make sense",
            remedy="name the file of a machine",
            code=Code.OUT_OF_RANGE,
        )
    return data


def _too_deep(data: Any) -> tuple[str, int]:
    """The key of what lies too deep, empty where nothing does, and the number of keys."""
    level, count = [(str(key), value) for key, value in data.items()], len(data)
    for _ in range(DEEPEST):
        count += sum(len(value) for _, value in level if isinstance(value, dict))
        level = [
            (key, inner)
            for key, value in level
            for inner in (value.values() if isinstance(value, dict) else value if isinstance(value, list) else ())
        ]
    return level[0][0] if level else "", count


def _explained(model: type[BaseModel], path: Path, error: ValidationError) -> CaseError:
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
    meanings = {
        f"{key.rpartition('.')[0]}.{hint[1] or hint[2]}" for _, key, words in problems if (hint := _HINT.search(words))
    }
    problems = [p for p in problems if p[2] != MISSING or (p[1] not in meanings and f".{p[1]}" not in meanings)]
    problems.sort(key=lambda problem: (problem[0], len(problem[1]) + len(problem[2])))
    at = phrase("at_key", "{key}: {words}", key="", words="")
    lines = first_problems([at.filled(key=key, words=words) if key else words for _, key, words in problems])
    _, key, words = problems[0]
    problem = enumerated("problems", [words, *lines[1:]])
    return CaseError(file=path, key=key, problem=problem, problems=lines, code=Code.WRONG_KIND)


def _name(problem: ErrorDetails) -> str:
    """The name of the entry of a list that a problem is about; empty where it is of none."""
    name = problem["input"].get("name") if isinstance(problem["input"], dict) else None
    of_a_list = problem["loc"] and isinstance(problem["loc"][-1], int)
    return name if of_a_list and isinstance(name, str) else ""


def _together(problems: Iterable[tuple[int, str, Phrase, str]]) -> list[tuple[int, str, Phrase]]:
    """Rank, key and words of each problem; what is true of several entries of a list is one, with all their names."""
    alike: dict[tuple[int, str, Phrase, bool], list[tuple[str, str]]] = {}
    for rank, key, words, name in problems:
        is_named = bool(name) and words.code == NAMED and words.values["name"] == name
        table, _, number = key.removesuffix("]").rpartition("[") if is_named else (key, "", "")
        problem = words.values["problem"] if is_named else words
        alike.setdefault((rank, table, problem, is_named), []).append((number, name))
    return [
        (rank, f"{table}[{', '.join(n for n, _ in of)}]", of_named(", ".join(name for _, name in of), words))
        if is_named
        else (rank, table, words)
        for (rank, table, words, is_named), of in alike.items()
    ]


NAMED = "named"
"""Code of a problem of an entry that has a name."""


def of_named(name: str, problem: Phrase) -> Phrase:
    """A problem of an entry of a list, with its name."""
    return phrase("named", "{name}: {problem}", name=name, problem=problem)


MISSING = phrase("missing", "is missing; add it")
_HINT = re.compile(r"did you mean (\w+)\?|write (\w+)$")


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
