"""Names that a package offers, each imported when it is first used: the door stays light."""

from collections.abc import Callable, Mapping
from importlib import import_module


def door(package: str, places: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package.

    Args:
        package: its name.
        places: module -> the names that it gives, separated by blanks.
    """
    module_of = {name: module for module, names in places.items() for name in names.split()}

    def get(name: str) -> object:
        if name not in module_of:
            raise AttributeError(f"{package} has no {name}; it has {', '.join(module_of)}")
        return getattr(import_module(module_of[name]), name)

    return get, lambda: list(module_of)
