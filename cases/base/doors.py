"""Doors of packages: names are imported when they are first used; at the library's own, arguments are checked.

Functions there refuse arguments of a wrong type by name, before any work.
"""

import inspect
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import wraps
from importlib import import_module
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import FunctionType, UnionType
from typing import Any, ParamSpec, TypeVar, get_args, get_origin


def door(
    package: str, public: Mapping[str, str], checked: bool = False
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package (PEP 562): names, each imported when it is first used.

    For type checkers the package imports the same names under `TYPE_CHECKING`.

    Args:
        package: name of the package.
        public: public names, and the modules that they are imported from.
        checked: whether functions refuse arguments of another type than their annotations state.
    """
    functions: dict[str, object] = {}

    def get(name: str) -> object:
        if name not in public:
            raise AttributeError(f"{package} has no {name}; it has {', '.join(public)}")
        value = getattr(import_module(public[name]), name)
        if not checked or not isinstance(value, FunctionType):
            return value
        return functions.setdefault(name, _checked(value, package))

    return get, lambda: list(public)


WIDER: dict[type, tuple[type, ...]] = {
    int: (Integral,), float: (Real,), str: (str, PathLike), Path: (str, PathLike), bool: (object,),
}  # fmt: skip
"""What does as well as a type: numbers of NumPy, paths as texts."""
SOURCES = {
    "Case": "hx.load_case loads one",
    "Plan": "hx.plan makes one, hx.Plan.load reads one",
    "Planned": "hx.plan makes a plan, hx.Plan.load reads one",
    "Program": "hx.write makes one, hx.read_program reads one",
    "Recording": "hx.read reads one",
    "Result": "hx.identify makes one, hx.Result.load reads one",
    "FamilySettings": "such as hx.PointToPoint(moves=40)",
}
"""Where a value of a public type comes from."""


Settings = TypeVar("Settings")
Value = TypeVar("Value")
Arguments = ParamSpec("Arguments")


def _checked(function: FunctionType, package: str) -> Callable[..., Any]:
    """A function that raises HexciteError with name, value and wanted type of an argument of another type.

    Types of callables and of entries of mappings are not looked at.
    """
    signature = inspect.signature(function)
    annotations = dict(_annotations(signature))

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        from cases.base.errors import Code, FileProblem, HexciteError, choice

        args, kwargs = tuple(map(_plain, args)), {name: _plain(value) for name, value in kwargs.items()}
        place = function.__qualname__.removesuffix(".__init__")
        for name in kwargs:
            if name not in annotations:
                raise HexciteError(
                    place=f"{place}: {name}",
                    problem="is not an argument",
                    remedy=choice(name, annotations, "choose from"),
                    code=Code.UNKNOWN,
                )
        for name, value in {**signature.bind(*args, **kwargs).arguments, **kwargs}.items():
            if not _fits(value, annotation := annotations.get(name, object)):
                text = repr(value) if len(repr(value)) < 60 else f"a {type(value).__name__}"
                kinds = re.sub(r"\b\w+\.", "", inspect.formatannotation(annotation)).replace("'", "")
                sources = "; ".join(source for kind, source in SOURCES.items() if re.search(rf"\b{kind}\b", kinds))
                raise HexciteError(
                    place=f"{place}: {name} = {text}",
                    problem=f"is not {kinds}",
                    remedy=sources or "give such a value",
                    code=Code.WRONG_KIND,
                )
            if isinstance(value, str | PathLike) and "\0" in str(value):
                raise HexciteError(
                    place=f"{place}: {name}",
                    problem="holds a null character",
                    remedy="no file, name or choice has one",
                    code=Code.WRONG_KIND,
                )
        try:
            return function(*args, **kwargs)
        except OSError as error:
            raise FileProblem.of(error) from error

    call.__module__ = package  # where it is found again by other processes
    return call


def _plain(value: Any) -> Any:
    """A number of NumPy as Python's own, which goes into files; anything else as it is."""
    is_plain = isinstance(value, bool | int | float) or not isinstance(value, Integral | Real)
    return value if is_plain else int(value) if isinstance(value, Integral) else float(value)


def checks(function: Callable[Arguments, Value]) -> Callable[Arguments, Value]:
    """A public method whose arguments of another type than it states are refused as above."""
    return _checked(function, function.__module__)  # type: ignore[arg-type]


def checks_arguments(settings: type[Settings]) -> type[Settings]:
    """A class whose values are made of arguments of the types that it states; others are refused as above."""
    settings.__init__ = _checked(settings.__init__, settings.__module__)  # type: ignore[method-assign, arg-type]
    return settings


def _annotations(signature: inspect.Signature) -> Iterator[tuple[str, Any]]:
    """Parameters with their annotations."""
    for name, parameter in signature.parameters.items():
        if parameter.annotation is not parameter.empty:
            yield name, parameter.annotation


def _fits(value: object, annotation: Any) -> bool:
    """Whether a value has a type; one that is written as a text, not to be imported, is compared by its name."""
    if isinstance(annotation, UnionType):
        return any(_fits(value, part) for part in get_args(annotation))
    if isinstance(annotation, str):
        return any(kind.__name__ in annotation.split(" | ") for kind in type(value).__mro__)
    if (kind := get_origin(annotation)) in (Sequence, Collection, tuple):
        kinds = (list, tuple) if kind is not Collection else (list, tuple, set, frozenset)
        return isinstance(value, kinds) and all(_fits(entry, get_args(annotation)[0]) for entry in value)
    if getattr(kind, "__name__", "") == "ndarray":  # of NumPy, which this door does not import
        return _holds_numbers(value)
    if kind is Mapping:
        return isinstance(value, Mapping)
    if get_origin(annotation) is Callable:
        return callable(value)
    if not isinstance(annotation, type) or get_origin(annotation) is not None:
        return True
    return isinstance(value, WIDER.get(annotation, (annotation,)))


def _holds_numbers(value: object) -> bool:
    """Whether a value is an array of real numbers, or lists of them."""
    if isinstance(value, list | tuple):
        return all(isinstance(entry, Real) or _holds_numbers(entry) for entry in value)
    return getattr(getattr(value, "dtype", None), "kind", "") in tuple("biuf") and hasattr(value, "shape")
