"""Tables of TOML files: strict numbers, ranges and points, and one line for each thing that is wrong in a file."""

import difflib
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetPydanticSchema, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core.core_schema import CoreSchema, tagged_union_schema

from cases.base.errors import CaseError, Code, FileProblem
from cases.base.file_reading import read_whole
from cases.base.phrases import Phrase, phrase
from cases.base.units import DEG, MM, MS, UM, Array
from cases.table_problems import explained


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
        raise explained(model, path, error) from error


def content_of_tables(path: Path) -> dict[str, Any]:
    """The content of a TOML file as it stands there; raises CaseError where it cannot be read, or is of no machine."""
    try:
        content = read_whole(path, MOST_BYTES)
    except FileProblem as error:
        raise CaseError(file=path, problem=error.problem, remedy=error.remedy, code=Code.UNREADABLE) from error
    return tables_in(content, path)


def tables_in(content: bytes, path: Path) -> dict[str, Any]:
    """The tables in the content of a TOML file; raises CaseError, which names the file that they are for."""
    try:
        text = content.decode("utf-8-sig")
        if match := _LONG_KEY.search(text):
            line = 1 + text.count("\n", 0, match.start())
            raise CaseError(
                file=path, problem=f"line {line} has a key of 50 parts and more", remedy="correct it", code=Code.DAMAGED
            )
        data = tomllib.loads(text)
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
