"""Names of earlier versions in users' Python code: they work, with a warning that says today's name."""

import warnings
from collections.abc import Callable
from dataclasses import is_dataclass
from functools import wraps
from typing import Any, TypeVar

Kind = TypeVar("Kind", bound=type)


def renamed(**names: str) -> Callable[[Kind], Kind]:
    """A class whose attributes, and fields of a dataclass, are also known by their earlier names.

    Each use of one raises a DeprecationWarning where the user's code says it. Type checkers know today's names alone.

    Args:
        names: today's name by the earlier one.
    """

    def with_earlier_names(kind: Kind) -> Kind:
        for old, new in names.items():
            setattr(kind, old, _property(kind, old, new))
        if is_dataclass(kind):
            kind.__init__ = _taking(kind, names)  # type: ignore[method-assign]
        return kind

    return with_earlier_names


def _warn(kind: type, old: str, new: str) -> None:
    warnings.warn(f"{kind.__name__}.{old} is called {new} today", DeprecationWarning, stacklevel=3)


def _property(kind: type, old: str, new: str) -> property:
    def get(self: object) -> Any:
        _warn(kind, old, new)
        return getattr(self, new)

    return property(get, doc=f"Earlier name of `{new}`.")


def _taking(kind: type, names: dict[str, str]) -> Callable[..., None]:
    """The construction of a dataclass, also of keywords by their earlier names; these come first in `replace`."""
    constructor: Callable[..., None] = kind.__init__  # type: ignore[misc]

    @wraps(constructor)
    def make(self: object, *args: Any, **fields: Any) -> None:
        for old in names.keys() & fields.keys():
            _warn(kind, old, names[old])
            fields[names[old]] = fields.pop(old)
        constructor(self, *args, **fields)

    return make
