"""The case: one machine, its sensors and its limits, as data, and the errors that every package raises."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cases.errors import HexciteError as HexciteError
    from cases.loading import load_case as load_case
    from cases.schema import Case as Case


def door(package: str, places: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package: names, each imported when it is first used, keep its door light.

    Args:
        places: module -> the names that it gives, separated by blanks.
    """
    module_of = {name: module for module, names in places.items() for name in names.split()}

    def get(name: str) -> object:
        if name not in module_of:
            raise AttributeError(f"{package} has no {name}; it has {', '.join(module_of)}")
        return getattr(import_module(module_of[name]), name)

    return get, lambda: list(module_of)


__getattr__, __dir__ = door(
    __name__, {"cases.errors": "HexciteError", "cases.loading": "load_case", "cases.schema": "Case"}
)
