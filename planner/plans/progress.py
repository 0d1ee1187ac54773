"""How a search is getting on, in a line: which start, the best motion until now, and the time that is left."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import NormalDist, fmean, stdev
from typing import Any

import numpy as np

from cases.schema import Case
from identification.estimation.criteria import Criterion, reference_scaling
from identification.model.model import identification_model
from planner.bounds.bound import information_limit
from planner.noise import mean_information
from planner.request import Request
from planner.search.parallel import REFINEMENT, News, Planned, UnderWay
from planner.search.solving import Start

LEAST = 0.05  # of all the work, from which the time that is left is estimated


def expected_best(values: Sequence[float], further: int) -> float:
    """The best value that so many further starts let expect, judged by the mean and the scatter of those until now.

    Args:
        values: values of two or more starts, normally distributed.
        further: number of starts that are still to come.
    """
    count = len(values) + further
    height = NormalDist().inv_cdf((count - 0.375) / (count + 0.25))  # Blom, of the largest of so many
    return max(*values, fmean(values) + height * stdev(values))


@dataclass(frozen=True, slots=True)
class Standing:
    """How a search is getting on: a line for people, and its figures for programs.

    Args:
        line: in words.
        done: number of starts that have ended.
        least: number of starts that there will be at least; None before it is known.
        best: D-efficiency of the best motion until now, or the other criterion that is asked for; None before one.
        left_s: time that is left; None before it can be estimated.
        refining: whether the best starts are refined, after which the search ends.
    """

    line: str
    done: int = 0
    least: int | None = None
    best: float | None = None
    left_s: float | None = None
    refining: bool = False

    def __str__(self) -> str:
        return self.line

    def to_json(self) -> dict[str, Any]:
        """All of it by name."""
        return asdict(self)


class Follower:
    """A listener that shows where a search stands while starts are under way, and as each of them ends.

    Args:
        case: machine and limits, for the D-efficiency.
        remark: shows it.
    """

    def __init__(self, case: Case, remark: Callable[[Standing], None]) -> None:
        self.case, self.remark = case, remark
        self.starts: list[Start] = []
        self.best: tuple[Start | None, float] = (None, 0.0)  # the best one, and its value

    def __call__(self, event: News) -> None:
        """Takes an event of a search, and shows how it is getting on."""
        if isinstance(event, Request):
            self.request, self.model = event, identification_model(self.case, event.model)
            self.remark(Standing("computing the bound of the information"))
            # the plan asks for it too, and finds it in the cache; the scaling is that of all its values
            self.bound = information_limit(self.case, self.model)
            self.scaling = reference_scaling(self.case, self.model)
            self.starts, self.best = [], (None, 0.0)
            return
        if isinstance(event, Planned):
            self.planned, self.began, self.done, self.under_way = event, time.monotonic(), 0, dict[int, float]()
        elif isinstance(event, UnderWay):
            self.under_way[event.seed] = event.share
        elif event is not None:
            self.done += 1
            self.under_way.pop(event.record.seed if isinstance(event, Start) else event.seed, None)
            self.starts += [event] if isinstance(event, Start) else []
        self.remark(self.standing())

    def standing(self) -> Standing:
        """How it is getting on."""
        least, best, seconds_left = (
            max(self.planned.least, self.done),
            self._best() if self.starts else None,
            self._left(),
        )
        refining = self.planned.what == REFINEMENT
        return Standing(self._line(best, seconds_left), self.done, least, best, seconds_left, refining)

    def _line(self, best: float | None, left: float | None) -> str:
        number = min(self.done + 1, max(self.planned.least, self.done))
        least = "" if self.planned.exactly else "at least "
        words = [f"{self.planned.what} {number} of {least}{max(self.planned.least, self.done)}"]
        if best is not None:
            words.append(self._in_words(best))
        if left is not None:
            ending = "its time is over, ending" if math.isfinite(self.planned.until) else "ending"
            words.append(f"about {left:.0f} s left" if left > 0.0 else ending)
        return ", ".join(words)

    def _best(self) -> float:
        """D-efficiency of the best motion that satisfies every limit, or the other criterion that is asked for."""
        best = max(self.starts, key=lambda start: start.record.criterion_value)
        if best is not self.best[0]:
            self.best = best, self._value(best)
        return self.best[1]

    def _in_words(self, value: float) -> str:
        """The value of the best motion, and which share it is of what is to be expected."""
        if self.request.criterion != Criterion.D:
            return f"best {self.request.criterion} {value:.3g}"
        best, words = self.best[0], f"best {value:.3f}"
        assert best is not None
        alike = [start.promise for start in self.starts if start.family.settings == best.family.settings]
        if len(alike) < 2:
            return words
        further = max(self.planned.least - self.done, 0)
        loss = (best.record.criterion_value - expected_best(alike, further)) / len(self.model.names)
        return f"{words} ({min(math.exp(loss), 1.0):.2f} of what its starts let expect)"

    def _value(self, start: Start) -> float:
        """D-efficiency of a motion, or the other criterion that is asked for."""
        if self.request.criterion != Criterion.D:
            return start.record.criterion_value
        information = mean_information(self.model, self.scaling, start.family.motion(start.unknowns))
        return self.bound.efficiency(float(np.linalg.slogdet(information)[1]))

    def _left(self) -> float | None:
        """Time that is left [s]: of what was asked for, else by the pace until now; None before there is one."""
        now = time.monotonic()
        if math.isfinite(self.planned.until):
            return max(self.planned.until - now, 0.0)
        work = self.done + sum(self.under_way.values())
        every = max(self.planned.least, self.done + len(self.under_way))
        if work < LEAST * every:
            return None
        return (now - self.began) * (every - work) / work
