"""Arguments of public functions: one of a wrong type is refused by its name before any work."""

import inspect
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import wraps
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, ParamSpec, TypeVar, get_args, get_origin, get_type_hints

from cases.errors import HexciteError

P = ParamSpec("P")
T = TypeVar("T")

LISTS = (Sequence, Collection, tuple)
WIDER: dict[type, tuple[type, ...]] = {
    int: (Integral,), float: (Real,), str: (str, PathLike), Path: (str, PathLike), bool: (object,),
}  # fmt: skip
"""What does as well as a type: numbers of NumPy, paths as texts."""
WORDS = {int: "a whole number", float: "a number", str: "a text", Path: "a path", NoneType: "None"}
SOURCES = {
    "Case": "hx.load_case loads one",
    "Plan": "hx.plan makes one, hx.Plan.load reads one",
    "Program": "hx.write makes one, hx.read_program reads one",
    "Recording": "hx.read reads one",
    "Result": "hx.identify makes one, hx.Result.load reads one",
    "FamilySettings": "such as hx.PointToPoint(moves=40)",
}
"""Where a value of a public type comes from."""


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """A function that refuses arguments of another type than its annotations state.

    It then raises HexciteError with name, value and wanted type of the argument. Annotations that are texts, types of
    callables and of entries of mappings are not looked at.
    """
    signature = inspect.signature(function)
    annotations = dict(_annotations(signature))

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        for name, value in {**signature.bind(*args, **kwargs).arguments, **kwargs}.items():
            if not _fits(value, wanted := annotations.get(name, object)):
                raise wrong_type(function.__name__, name, value, wanted)
        return function(*args, **kwargs)

    return call


def wrong_type(function: str, name: str, value: object, wanted: Any) -> HexciteError:
    """The error of an argument of a wrong type.

    Args:
        wanted: type that it should have, or the type's name; several as a union or a list of names.
    """
    text = repr(value) if len(repr(value)) < 60 else f"a {type(value).__name__}"
    types = wanted if isinstance(wanted, list) else get_args(wanted) or [wanted]
    sources = [SOURCES[key] for kind in types if (key := getattr(kind, "__name__", kind)) in SOURCES]
    words = " or ".join(map(_words, types)) if isinstance(wanted, list) else _words(wanted)
    return HexciteError(f"{function}: {name} = {text}", f"is not {words}", "; ".join(sources) or "give such a value")


def _annotations(signature: inspect.Signature) -> Iterator[tuple[str, Any]]:
    """Parameters with their annotations, those of further keyword arguments from their typed dictionary."""
    for name, parameter in signature.parameters.items():
        if parameter.kind is inspect.Parameter.VAR_KEYWORD:
            yield from get_type_hints(get_args(parameter.annotation)[0]).items()
        else:
            yield name, parameter.annotation


def _fits(value: object, annotation: Any) -> bool:
    if isinstance(annotation, UnionType):
        return any(_fits(value, part) for part in get_args(annotation))
    if get_origin(annotation) in LISTS:
        entries = value if isinstance(value, list | tuple) else ()
        listed = isinstance(value, Iterable) and not isinstance(value, str)
        return listed and all(_fits(entry, get_args(annotation)[0]) for entry in entries)
    if not isinstance(annotation, type) or get_origin(annotation) is not None:
        return True
    return isinstance(value, WIDER.get(annotation, (annotation,)))


def _words(annotation: Any) -> str:
    """A type in words."""
    if isinstance(annotation, UnionType):
        return " or ".join(map(_words, get_args(annotation)))
    if get_origin(annotation) in LISTS:
        return f"a list, each entry {_words(get_args(annotation)[0])}"
    return WORDS.get(annotation) or f"a {getattr(annotation, '__name__', annotation)}"
