"""How far a search for a cause is: each step is logged as it begins, with the time that is left at most."""

import logging
import time
from dataclasses import dataclass
from enum import Enum
from typing import Any

SEARCHING = logging.getLogger("hexcite.causes")
"""Where steps are logged; the attribute `standing` of a record is a `Standing`."""


class Step(Enum):
    """What a search does: its words, and the share of a whole search that lies before it (hexapods and arms, rounded).

    A search ends where one mistake, or two, explain the run, so that later steps may not come.
    """

    READINGS = ("other readings of the file are tried", 0.0)
    ONE = ("one mistake is tried at a time", 0.12)
    READ = ("one mistake is tried beside another reading", 0.26)
    TWO = ("two mistakes are tried at once", 0.33)
    SIZES = ("mistakes of any size are tried beside others", 0.6)
    SEVERAL = ("several channels are tried beside one mistake", 0.75)
    SETTLING = ("sizes are found beside each other", 0.85)
    WHOLE = ("the remedy is tried on the whole run", 0.9)

    def __init__(self, words: str, share: float) -> None:
        self.words = words
        self.share = share


@dataclass(frozen=True, slots=True)
class Standing:
    """Where a search stands.

    Args:
        step: what it does.
        left: time that all steps to come would take [s]; None at the first one.
    """

    step: Step
    left: float | None

    @property
    def line(self) -> str:
        """It as a line for people."""
        return self.step.words if self.left is None else f"{self.step.words}, about {self.left:.0f} s left at most"

    def to_json(self) -> dict[str, Any]:
        """Its entries for programs."""
        left = None if self.left is None else round(self.left, 1)
        return {"step": self.step.name.lower(), "left_s": left, "line": self.line}


class Following:
    """A search that begins now."""

    def __init__(self) -> None:
        self._began = time.monotonic()

    def at(self, step: Step) -> None:
        """Logs that a step begins."""
        seconds = time.monotonic() - self._began
        standing = Standing(step, seconds * (1.0 / step.share - 1.0) if step.share else None)
        SEARCHING.info("%s", standing.line, extra={"standing": standing})
