"""Rounds of a search: starts until further ones gain too little, and refinements of the best of them."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cases.base.units import Array
from cases.schema import Case
from identification.estimation.criteria import Criterion
from identification.model.model import identification_model
from planner.families.family import Family
from planner.request import Request
from planner.search.parallel import REFINEMENT, START, Listener, Planned, Runner, Schedule, enough, gain, most_starts
from planner.search.record import Failed
from planner.search.solving import Start, Task

KEPT = 3  # number of the best orders, periods, numbers of moves and families, at most, that get more starts
CLOSE = 0.03  # share of an efficiency by which others than the best are worse, at most, that get more starts too
PASSABLE = 0.35  # share of an efficiency by which the best of another family is worse, at most, that is refined too
REFINING = 0.4  # share of what is left of a search of some seconds that the refinements of a round have
AHEAD = 8  # starts that may run at a time: what a start is depends on the results of those so many before it


def without_failures(results: Sequence[Start | Failed]) -> list[Start]:
    """Starts that found a motion."""
    return [result for result in results if isinstance(result, Start)]


def _promising(results: Sequence[Start | Failed]) -> list[Start]:
    """Explorations that have not been refined, the most promising first."""
    starts = without_failures(results)
    refined = {s.record.seed for s in starts if s.record.refined}  # no two starts of a search have one seed
    return sorted((s for s in starts if s.record.seed not in refined), key=lambda s: -s.promise)


def _with_other_families(starts: Sequence[Start], count: int, criterion: Criterion, parameters: int) -> list[Start]:
    """The first `count` of explorations, and the best of each other family that may pass them once it is refined.

    Families gain differently by that: on a seven-joint arm splines 40 % of an efficiency, moves 5 %.

    Args:
        starts: explorations, the most promising first.
        parameters: their number u.
    """
    chosen = list(starts[:count])
    for start in starts[count:]:
        behind = -gain(criterion, parameters, starts[0].promise, start.promise)
        if start.family.name not in {other.family.name for other in chosen} and behind <= PASSABLE:
            chosen.append(start)
    return chosen


def _best_when_they_came(results: Sequence[Start | Failed], count: int) -> list[Start]:
    """Explorations than which fewer than `count` of those before them were as good, the most promising first.

    What is refined of some starts is refined of more of them too, so that more starts never give less.
    """
    starts = without_failures(results)
    chosen = [s for k, s in enumerate(starts) if sum(other.promise >= s.promise for other in starts[:k]) < count]
    return sorted(chosen, key=lambda s: -s.promise)


class Round(NamedTuple):
    """What a round of a search came to."""

    results: list[Start | Failed]  # refinements last
    early: bool  # whether Ctrl-C or its time ended it
    late: bool  # whether the time that is left, if there is any, is too short for more


@dataclass(frozen=True, slots=True)
class Rounds:
    """Rounds of a search: starts until further ones gain too little, and refinements of the best of them."""

    request: Request
    case: Case  # case with the limits that its controller enforces, within the margin of their ends
    reference: Case  # case of the reference scaling
    listener: Listener
    run: Runner
    until: float  # when the search is to end, by `time.monotonic` [s]
    known: Array | None  # covariance of u by the noise of earlier results, shape (u, u)

    def one(self, number: int, before: Sequence[Start | Failed]) -> Round:
        """A round: explorations, then refinements of the best until now where there is time for them.

        A start that is stopped takes its time to end: its functions are built, its motion is brought inside the limits.
        Where less than that is left, as measured here, nothing more is begun.

        Args:
            number: number of the round, from 0.
            before: results of earlier rounds.
        """
        request = self.request
        seconds_left = self.until - time.monotonic()
        refining = REFINING * seconds_left if math.isfinite(seconds_left) else 0.0
        schedule = self._explorations(number, self.until - refining, before)
        least, exactly = self._least(), request.starts is not None
        self.listener(Planned(START, least, exactly, schedule.until))
        results, early = self.run(schedule, self.listener)
        late = schedule.late(results)
        ending = max(time.monotonic() - schedule.until, 0.0) if late else 0.0
        count = request.family.refinements(request.criterion)
        if exactly:
            promising = _best_when_they_came(results, count)
        else:
            parameters = len(identification_model(self.case, request.model).names)
            promising = _with_other_families(_promising([*before, *results]), count, request.criterion, parameters)
        refinements = [self._task(s.family, s.record.seed, s.begin) for s in promising]
        early = early and not late  # the end of its time leaves some to refine, or to go on
        if refinements and not early and self.until - time.monotonic() > ending:
            self.listener(Planned(REFINEMENT, len(refinements), True, self.until))
            second, early = self.run(Schedule.of(refinements, self.until), self.listener)
            results = results + second
        return Round(results, early, self.until - time.monotonic() <= ending)

    def _task(self, family: Family, seed: int, begin: Array | None = None) -> Task:
        request = self.request
        return Task(
            self.case,
            request.model,
            family,
            request.criterion,
            seed,
            request.payload,
            begin,
            self.reference,
            request.solver,
            self.known,
        )

    def _least(self) -> int:
        """Number of starts at least. Where there is a choice the first make it; those that follow may gain nothing."""
        request = self.request
        if request.starts is not None:
            return request.starts
        choices = len(request.family.families(self.case, request.duration))
        return max(choices, 1) + request.family.idle(request.criterion)

    def _explorations(self, number: int, until: float, before: Sequence[Start | Failed]) -> Schedule:
        """The starts of a round. Each of several choices has one first; those that follow go to the best of them.

        None begins with less time left than the longest of those before it took: a part of one finds little.
        """
        request = self.request
        idle = request.family.idle(request.criterion)
        families = request.family.families(self.case, request.duration)[: request.starts]
        parameters, most = len(identification_model(self.case, request.model).names), most_starts(request)
        first, least = max(len(families), min(1 + idle, most)), self._least()
        each = max(first, most)
        seeds = seeds_of(request.seed, (number + 1) * each)[number * each :]
        settings = [family.settings for family in families]

        def task(k: int, results: Sequence[Start | Failed]) -> Task | None:
            known = max(first, k + 1 - AHEAD)
            took = [s.record.seconds for s in without_failures([*before, *results]) if not s.record.refined]
            if took and time.monotonic() + max(took) > until:
                return None
            if k >= first and (k >= most or len(results) < known):
                return None
            if k < first:
                family = families[k % len(families)]
            else:
                starts = sorted(without_failures(results[:known]), key=lambda s: -s.promise)
                lost = [-gain(request.criterion, parameters, starts[0].promise, s.promise) for s in starts]
                leading = [s for s, loss in zip(starts, lost, strict=True) if loss <= CLOSE]
                ranked = dict.fromkeys(settings.index(s.family.settings) for s in leading)
                best = [families[n] for n in ranked] or families
                family = best[(k - first) % min(KEPT, len(best))]
            return self._task(family, seeds[k])

        def are_enough(results: Sequence[Start | Failed]) -> bool:
            return len(results) >= least and enough(results, request, parameters)

        return Schedule(task, are_enough, until, self.until)


def seeds_of(seed: int, starts: int) -> list[int]:
    """Seeds of the starts, reproducible from one seed; more starts extend the list."""
    return [int(s.generate_state(1)[0]) for s in np.random.SeedSequence(seed).spawn(starts)]
