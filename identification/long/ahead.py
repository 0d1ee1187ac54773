"""What is read next while the last is still worked on: readers of text wait for the disk and leave a processor free."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")


def ahead(items: Iterator[Item]) -> Iterator[Item]:
    """The same items in the same order; the next one is made by a thread meanwhile, and no more than that.

    What making an item raises is raised where that item is asked for.
    """
    with ThreadPoolExecutor(1, "reader") as reader:
        coming = reader.submit(_next, items)
        while (found := coming.result()) is not None:
            coming = reader.submit(_next, items)
            yield found[0]


def _next(items: Iterator[Item]) -> tuple[Item] | None:
    for item in items:
        return (item,)
    return None
