"""When a search has had enough starts.

It ends when starts stop paying: as soon as the last ones, as many as the family waits for (`idle`), did not raise the
best by `WORTHWHILE`, or the first `FAILURES` all failed. They are counted in an order that does not depend on which of
them was done first. `--starts N` asks for N of them instead, `--seconds S` for as many as that time allows.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

from planner.request import Request
from planner.search.solving import Failed, Start

MOST = 40  # starts, by default; with `--seconds` there is no such end
FAILURES = 3  # in a row from the first on
WORTHWHILE = 0.005  # of an efficiency
EXPLORING = 0.6  # share of `--seconds` that goes into explorations, where their best are refined afterwards
ENDLESS = 1000


@dataclass(frozen=True, slots=True)
class Patience:
    """How long a round of starts goes on."""

    criterion: str  # letter of Table 4
    parameters: int  # their number u
    most: int  # starts
    until: float | None  # when to stop, on the monotonic clock [s]; None where time does not count
    exploring_until: float | None  # when to stop exploring
    counts: bool  # whether the round ends when starts stop paying
    idle: int  # starts in a row without a gain that end it then
    refined: int  # how many of the explored motions are refined

    @classmethod
    def of(cls, request: Request, parameters: int) -> "Patience":
        """That of a request, from now on."""
        now = time.monotonic()
        most = request.starts or (MOST if request.seconds is None else ENDLESS)
        until = exploring = None
        refined = request.family.refinements(request.criterion)
        if request.seconds is not None:
            share = EXPLORING if refined else 1.0
            until, exploring = now + request.seconds, now + share * request.seconds
        counts = request.starts is None and request.seconds is None
        idle = request.family.idle(request.criterion)
        return cls(request.criterion, parameters, most, until, exploring, counts, idle, refined)

    def exploring(self) -> "Patience":
        """For the explorations."""
        return replace(self, until=self.exploring_until)

    def over(self) -> bool:
        """Whether time is up."""
        return self.until is not None and time.monotonic() >= self.until

    def enough(self, results: Sequence[Start | Failed]) -> bool:
        """Whether more starts are not worth their time.

        Args:
            results: results of all starts until now, in the order of their seeds.
        """
        if len(results) >= self.most:
            return True
        if not self.counts:
            return False
        best, since = -math.inf, 0
        for result in results:
            since += 1
            if isinstance(result, Start) and gain(self.criterion, self.parameters, best, result.promise) >= WORTHWHILE:
                best, since = result.promise, 0
        return since >= (FAILURES if best == -math.inf else self.idle)


def gain(criterion: str, parameters: int, old: float, new: float) -> float:
    """By which share a criterion is better, as an efficiency (D) or as the ratio of the variances it stands for."""
    if old == -math.inf or new == -math.inf:
        return math.inf if new > old else 0.0
    if criterion == "D":
        return math.expm1((new - old) / parameters)
    return abs(old / new) - 1.0 if new < 0.0 else new / old - 1.0
