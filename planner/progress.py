"""What a search tells while it runs: the share of the limit that it has reached, and how much longer it takes."""

import math
import time
from collections.abc import Callable

from cases.schema import Case
from identification.model import identification_model
from planner.bounds.kept import box_bound
from planner.noise import expected_noise
from planner.pose_errors import PoseErrors
from planner.request import Request
from planner.search.parallel import News
from planner.search.patience import FEWEST, IDLE, WORTHWHILE, gain
from planner.search.solving import Failed, Start


class Progress:
    """Follows the starts of a search.

    Args:
        request: what is planned.
        case: for which machine.
        remark: shows a line.
    """

    def __init__(self, request: Request, case: Case, remark: Callable[[str], None]) -> None:
        self.request, self.remark, self.bound = request, remark, None
        model = identification_model(case, request.model)
        self.size = len(model.names)
        noise = expected_noise(case, model, request.payload)
        if request.family.optimised and noise.whitening is None and PoseErrors.of(case, noise) is None:
            remark("the limit of information")
            self.bound = box_bound(case, model)
        self.begin(request)

    def begin(self, request: Request) -> None:
        """Another search begins."""
        self.request, self.began = request, time.monotonic()
        self.best: Start | None = None
        self.count = self.since = 0

    def done(self, start: Start | Failed) -> None:
        """A start has ended."""
        if isinstance(start, Start) and start.family.name != self.request.family.name:
            return
        self.count, self.since = self.count + 1, self.since + 1
        if isinstance(start, Start):
            before = -math.inf if self.best is None else self.best.promise
            if gain(self.request.criterion, self.size, before, start.promise) >= WORTHWHILE:
                self.since = 0
            if self.best is None or start.promise > self.best.promise:
                self.best = start
        self.remark(self.words())

    def news(self, word: News) -> None:
        """A start is under way."""
        self.remark(self.words())

    def words(self) -> str:
        """One line."""
        passed = time.monotonic() - self.began
        if self.best is None:
            return f"first starts, {passed:.0f} s"
        if self.bound is not None:
            reached = f"{100 * self.bound.efficiency(self.best.logdet):.1f} % of the limit of information"
        else:
            reached = f"criterion {self.request.criterion} {self.best.score:.4g}"
        return f"{reached} after {self.count} starts, {passed:.0f} s, {self._left(passed)}"

    def _left(self, passed: float) -> str:
        if self.request.seconds is not None:
            return f"{max(0.0, self.request.seconds - passed):.0f} s left"
        if self.request.starts is not None:
            left = self.request.starts - self.count
        else:
            left = max(FEWEST - self.count, IDLE - self.since)
        if left <= 0:
            return "refining the best"
        return f"about {passed / self.count * left:.0f} s left" + (
            "" if self.request.starts else " unless more is found"
        )
