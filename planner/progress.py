"""How a search is getting on, in a line: which start, the best motion until now, and the time that is left."""

import math
import time
from collections.abc import Callable, Sequence
from statistics import NormalDist, fmean, stdev

import numpy as np

from cases.schema import Case
from identification.criteria import Criterion, reference_scaling
from identification.model import identification_model
from planner.bounds.information_limit import information_limit
from planner.noise import mean_information
from planner.request import Request
from planner.search.parallel import News, Planned, UnderWay
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


class Follower:
    """A listener that shows a line while starts are under way, and as each of them ends.

    Args:
        case: machine and limits, for the D-efficiency.
        remark: shows the line.
    """

    def __init__(self, case: Case, remark: Callable[[str], None]) -> None:
        self.case, self.remark = case, remark
        self.starts: list[Start] = []
        self.best: tuple[Start | None, str] = (None, "")  # the best one, and its value in words

    def __call__(self, event: News) -> None:
        """Takes an event of a search, and shows how it is getting on."""
        if isinstance(event, Request):
            self.request, self.model = event, identification_model(self.case, event.model)
            self.remark("computing the bound of the information")
            # the plan asks for it too, and finds it in the cache; the scaling is that of all its values
            self.bound = information_limit(self.case, self.model)
            self.scaling = reference_scaling(self.case, self.model)
            self.starts, self.best = [], (None, "")
            return
        if isinstance(event, Planned):
            self.planned, self.began, self.done, self.under_way = event, time.monotonic(), 0, dict[int, float]()
        elif isinstance(event, UnderWay):
            self.under_way[event.seed] = event.share
        elif event is not None:
            self.done += 1
            self.under_way.pop(event.record.seed if isinstance(event, Start) else event.seed, None)
            self.starts += [event] if isinstance(event, Start) else []
        self.remark(self.line())

    def line(self) -> str:
        """How it is getting on."""
        number = min(self.done + 1, max(self.planned.least, self.done))
        least = "" if self.planned.exactly else "at least "
        words = [f"{self.planned.what} {number} of {least}{max(self.planned.least, self.done)}"]
        if self.starts:
            words.append(self._best())
        if (left := self._left()) is not None:
            words.append(f"about {left:.0f} s left")
        return ", ".join(words)

    def _best(self) -> str:
        """The best motion that satisfies every limit, and which share it is of what is to be expected."""
        best = max(self.starts, key=lambda start: start.record.criterion_value)
        if best is not self.best[0]:
            self.best = best, self._value(best)
        alike = [start.promise for start in self.starts if start.family.settings == best.family.settings]
        if len(alike) < 2 or self.request.criterion != Criterion.D:
            return self.best[1]
        further = max(self.planned.least - self.done, 0)
        loss = (best.record.criterion_value - expected_best(alike, further)) / len(self.model.names)
        return f"{self.best[1]} ({min(math.exp(loss), 1.0):.2f} of what its starts let expect)"

    def _value(self, start: Start) -> str:
        """D-efficiency of a motion, or the other criterion that is asked for."""
        if self.request.criterion != Criterion.D:
            return f"best {self.request.criterion} {start.record.criterion_value:.3g}"
        information = mean_information(self.model, self.scaling, start.family.motion(start.unknowns))
        return f"best {self.bound.efficiency(float(np.linalg.slogdet(information)[1])):.3f}"

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
