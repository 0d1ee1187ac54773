"""Progress that is shown at most once a second: what works shows it far more often than a notebook or log can bear."""

import math
import time
from collections.abc import Callable
from typing import TypeVar

EVERY = 1.0  # [s]
Progress = TypeVar("Progress")


def seldom(show: Callable[[Progress], None]) -> Callable[[Progress], None]:
    """A function that passes on its argument, the first one and then at most once a second; others it leaves out."""
    last = -math.inf

    def passing(what: Progress) -> None:
        nonlocal last
        if (now := time.monotonic()) - last >= EVERY:
            last = now
            show(what)

    return passing
