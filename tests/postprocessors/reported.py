"""What a reader reports of a program, block by block, before it is grouped into stretches."""

from collections.abc import Callable
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from postprocessors.reading import Arc, Grouping, Reading, TimedBlock, Untimed


class Move(NamedTuple):
    """A straight move, or an arc."""

    end: np.ndarray
    duration: float | None
    feed: float | None
    exact: bool
    arc: Arc | None = None
    crawl: bool = False  # to home, from within the tolerance of its check


class Pause(NamedTuple):
    """A dwell."""

    duration: float


class Switch(NamedTuple):
    """A switch of the trigger."""

    on: bool
    at_once: bool


class _Log(Grouping):
    def __init__(self, file: str, *words: str) -> None:
        super().__init__(file, *words)
        self.reports: list[Any] = []

    def block(self, block: TimedBlock, exact: bool = False) -> None:
        _, duration, end, _ = block
        self.reports.append(Move(end, duration, None, exact))

    def move(self, move: Untimed, exact: bool) -> None:
        self.reports.append(Move(move.end, None, move.feed, exact, move.arc, move.within is not None))

    def pause(self, line: int, duration: float, switches: bool = False) -> None:
        self.reports.append(Pause(duration))

    def switch(self, line: int, on: bool, at_once: bool) -> None:
        self.reports.append(Switch(on, at_once))

    def reading(self, blocks: int) -> Reading:
        return Reading(self.file, tuple(self.reports), blocks)


def reports(read: Callable[..., Reading], *arguments: Any) -> tuple[Any, ...]:
    """What a reader of a language with modal words reports of a program."""
    with patch("postprocessors.dialects.modal.Grouping", _Log):
        return read(*arguments).stretches
