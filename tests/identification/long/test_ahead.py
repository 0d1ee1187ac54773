"""Items made ahead by a thread are those that were asked for, and no more than one of them is made ahead."""

import threading
from collections.abc import Iterator

import pytest

from identification.long.ahead import ahead


def test_items_come_in_their_order_one_ahead_from_another_thread() -> None:
    made: list[int] = []
    threads = set()

    def items() -> Iterator[int]:
        for k in range(50):
            made.append(k)
            threads.add(threading.current_thread().name)
            yield k

    for k, item in enumerate(ahead(items())):
        assert item == k
        assert len(made) <= k + 2
    assert made == list(range(50))
    assert threading.current_thread().name not in threads


def test_an_error_is_raised_behind_the_items_before_it() -> None:
    def items() -> Iterator[int]:
        yield 1
        yield 2
        raise ValueError("line 3")

    source = ahead(items())
    assert [next(source), next(source)] == [1, 2]
    with pytest.raises(ValueError, match="line 3"):
        next(source)


def test_who_stops_asking_stops_the_reader() -> None:
    made: list[int] = []

    def items() -> Iterator[int]:
        for k in range(1000):
            made.append(k)
            yield k

    source = ahead(items())
    assert next(source) == 0
    source.close()
    assert len(made) <= 2
    assert not any(t.name.startswith("reader") and t.is_alive() for t in threading.enumerate())


def test_nothing_gives_nothing() -> None:
    assert list(ahead(iter([]))) == []
