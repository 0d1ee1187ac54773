"""Results of a machine over time: what leaps from one to the next, and what drifts, beyond its uncertainty.

Sizes that a tolerance is one of are the same in every run of a machine as long as the case states the same tolerances:
two results differ by their own noise, and by what these sizes do otherwise in the other motion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtri

from cases.base.errors import Code, FileProblem, HexciteError
from cases.base.phrases import Phrase, phrase
from cases.base.units import Array
from identification.model.parameters import physical_form
from identification.results.result import PROMINENT, Result
from identification.texts import (
    aligned,
    legible,
    parameter_phrase,
    std_text,
    value_text,
    with_deviation,
)

UNLIKELY = 0.01  # chance that noise alone makes one leap, and one drift, among all that are looked for
FEWEST = 3  # results that show a drift
DAY = 86400.0  # [s]


@dataclass(frozen=True)
class Entry:
    """A result with its time.

    Args:
        when: when its recording was written; of earlier results, which do not say it, when they were.
        result: the result.
        variances: of its physical parameters by its own noise, without tolerances, by name.
        tolerances: what each size of a tolerance does to a physical parameter, by name, shapes (k,) by key.
    """

    when: datetime
    result: Result
    variances: Mapping[str, float]
    tolerances: Mapping[str, Mapping[str, Array]]


@dataclass(frozen=True)
class Leap:
    """A parameter that changed from one result to the next by more than both deviations allow."""

    parameter: str
    before: Entry
    after: Entry
    change: float  # [SI]
    std: float  # of the change

    @property
    def sentence(self) -> Phrase:
        """What leapt, by how much, and when."""
        scale, unit = legible(self.after.result[self.parameter].unit)
        size = with_deviation(self.change * scale, self.std * scale)
        return phrase(
            "leapt",
            "{parameter} leapt by {size} {unit} from {before} to {after}, {times} deviations",
            parameter=parameter_phrase(self.parameter),
            size=size,
            unit=unit,
            before=_day(self.before.when),
            after=_day(self.after.when),
            times=_times(self.change, self.std),
        )

    def __str__(self) -> str:
        return str.__str__(self.sentence)


@dataclass(frozen=True)
class Drift:
    """A parameter that goes one way over all results."""

    parameter: str
    rate: float  # [SI/s]
    std: float
    unit: str

    @property
    def sentence(self) -> Phrase:
        """What drifts, and how fast."""
        scale, unit = legible(self.unit)
        size = with_deviation(self.rate * scale * DAY, self.std * scale * DAY)
        return phrase(
            "drifts_daily",
            "{parameter} drifts by {size} {unit} a day, {times} deviations",
            parameter=parameter_phrase(self.parameter),
            size=size,
            unit=unit,
            times=_times(self.rate, self.std),
        )

    def __str__(self) -> str:
        return str.__str__(self.sentence)


@dataclass(frozen=True, repr=False)
class History:
    """Results of a machine in the order of their times.

    >>> hx.history(["empty-result", "loaded-result"])
    History of hexapod: 2 results from ... to ...
    nothing leaps or drifts beyond its deviation

    Args:
        case: name of the machine's case.
        entries: the results.
        leaps: what changed between two that follow each other.
        drifts: what goes one way over all of them.
        left_out: results that are not among them, each with the reason.
    """

    case: str
    entries: tuple[Entry, ...]
    leaps: tuple[Leap, ...]
    drifts: tuple[Drift, ...]
    left_out: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters that all results have."""
        first, *rest = (entry.result.parameters for entry in self.entries)
        return tuple(name for name in first if all(name in other for other in rest))

    @property
    def words(self) -> Phrase:
        """How many results there are."""
        if len(self.entries) == 1:
            return phrase("single_result", "1 result")
        return phrase("so_many_results", "{count} results", count=len(self.entries))

    @property
    def prominent(self) -> tuple[str, ...]:
        """Those that are shown first."""
        return tuple(name for name in PROMINENT if name in self.names) or self.names[:4]

    @property
    def findings(self) -> tuple[str, ...]:
        """Leaps and drifts, a sentence each."""
        return (*(leap.sentence for leap in self.leaps), *(drift.sentence for drift in self.drifts))

    def to_json(self) -> dict[str, Any]:
        """The history for programs [SI]."""
        return {
            "case": self.case,
            "results": [
                {
                    "when": entry.when.isoformat(),
                    "result": entry.result.source,
                    "recording": entry.result.record.recording,
                    "model": entry.result.record.model,
                    "payload_kg": entry.result.mounted,
                    "s0": entry.result.record.s0,
                    "parameters": {name: v._asdict() for name, v in entry.result.parameters.items()},
                }
                for entry in self.entries
            ],
            "leaps": [
                {
                    "parameter": leap.parameter,
                    "from": leap.before.result.source,
                    "to": leap.after.result.source,
                    "change": leap.change,
                    "std": leap.std,
                }
                for leap in self.leaps
            ],
            "drifts": [
                {"parameter": drift.parameter, "per_day": drift.rate * DAY, "std_per_day": drift.std * DAY}
                for drift in self.drifts
            ],
            "left_out": list(self.left_out),
        }

    def __repr__(self) -> str:
        """Two lines: how many results, and what changed."""
        first, last = self.entries[0].when, self.entries[-1].when
        about = f"History of {self.case}: {self.words} from {_day(first)} to {_day(last)}"
        return "\n".join([about, *(self.findings or ("nothing leaps or drifts beyond its deviation",))])

    def __str__(self) -> str:
        """A table of the results, what changed, and what was left out."""
        return "\n".join([*aligned(*self.rows()), repr(self), *(f"left out: {reason}" for reason in self.left_out)])

    def rows(self) -> list[tuple[str, ...]]:
        """Rows of a table, the head first."""
        head, rows = ["recorded", "recording", "s0"], list[tuple[str, ...]]()
        units = {name: legible(self.entries[0].result[name].unit) for name in self.prominent}
        for name, (_, unit) in units.items():
            head += [f"{name} [{unit}]", "+-"]
        for entry in self.entries:
            cells = [f"{entry.when:%Y-%m-%d %H:%M}", entry.result.record.recording, f"{entry.result.record.s0:.3g}"]
            for name, (scale, _) in units.items():
                value = entry.result[name]
                cells += [value_text(value.value * scale, value.reported * scale), std_text(value.reported * scale)]
            rows.append(tuple(cells))
        return [tuple(head), *rows]


def history(places: Sequence[Path | str] | Path | str, case: str | None = None) -> History:
    """Results of one machine over time, which may lie anywhere.

    >>> past = hx.history(["empty-result", "loaded-result"])
    >>> len(past.entries)
    2

    A leap is a change between two results that follow each other, with the same payload, beyond what their own noise
    and the tolerances allow, or between the means before and after; a drift a straight line over three results or
    more. Noise alone makes one of them in one of a hundred histories, or two. What `pool` wrote is left out where all
    its runs are there by themselves.

    Args:
        places: result folders, or folders in which results are looked for, at any depth.
        case: name of the machine's case, where there are results of several.

    Raises:
        FileProblem: there is no such folder, or no result in it.
        HexciteError: results are of several machines and none is named, or of none of that name.
    """
    paths = [Path(places)] if isinstance(places, str | Path) else [Path(place) for place in places]
    if not paths:
        raise HexciteError(
            place="history",
            problem="nothing is named",
            remedy="name result folders, or folders in which results lie",
            code=Code.MISSING,
        )
    loaded, left_out = _loaded(paths)
    names = sorted({result.record.case for result in loaded})
    if case is None and len(names) > 1:
        raise HexciteError(
            place="case",
            problem=f"results are of {len(names)} machines: {', '.join(names)}",
            remedy="name one of them",
            code=Code.OTHER_SOURCE,
        )
    if case is not None and case not in names:
        raise HexciteError(
            place="case",
            problem=f"no result is of {case!r}",
            remedy=f"name one of {', '.join(names)}",
            code=Code.OTHER_SOURCE,
        )
    of_machine = sorted(
        (_entry(result) for result in loaded if case in (None, result.record.case)), key=lambda entry: entry.when
    )
    alone = frozenset().union(*(e.result.recordings for e in of_machine if e.result.record.pooled is None))
    entries: list[Entry] = []
    for entry in sorted(of_machine, key=lambda entry: entry.result.record.pooled is None):  # pools first
        if entry.result.record.pooled is not None and entry.result.recordings <= alone:
            left_out.append(f"{entry.result.source}: each run that it pools is there by itself")
            continue
        twin = next((e for e in entries if e.result.recordings & entry.result.recordings), None)
        if twin is None:
            entries.append(entry)
        else:
            left_out.append(f"{entry.result.source}: is of the same recording as {twin.result.source}")
    entries.sort(key=lambda entry: entry.when)
    entries_in_order = History(entries[0].result.record.case, tuple(entries), (), (), tuple(left_out))
    leaps = _leaps(entries_in_order)
    changes = _changes_over_all(entries_in_order, {leap.parameter for leap in leaps})
    leaps += [change for change in changes if isinstance(change, Leap)]
    drifts = [change for change in changes if isinstance(change, Drift)]
    return History(
        entries_in_order.case, entries_in_order.entries, tuple(leaps), tuple(drifts), entries_in_order.left_out
    )


def _loaded(paths: Sequence[Path]) -> tuple[list[Result], list[str]]:
    """All results that can be read, and of the others why not."""
    files: dict[Path, None] = {}
    for path in paths:
        if not path.exists():
            raise FileProblem(
                place=path, problem="no such folder", remedy="name folders that hold results", code=Code.MISSING
            )
        result_files = [path] if path.name == "result.json" else sorted(path.rglob("result.json"))
        if not result_files:
            raise FileProblem(
                place=path,
                problem=phrase("no_result_there", "holds no result"),
                remedy=phrase("name_results", "name folders of hexcite identify, or what holds such"),
                code=Code.MISSING,
            )
        files |= dict.fromkeys(file.resolve() for file in result_files)
    results, left_out = list[Result](), list[str]()
    for file in files:
        try:
            results.append(Result.load(file, stale=True))
        except HexciteError as error:
            left_out.append(str(error))
    if not results:
        raise FileProblem(
            place=paths[0],
            problem=f"holds no result that can be read: {left_out[0]}",
            remedy="identify again",
            code=Code.DAMAGED,
        )
    return results, left_out


def _entry(result: Result) -> Entry:
    """A result with its time and the parts of its variances."""
    form, biases = physical_form(result.model), result.biases
    jacobian = form.map(result.values)[1].full()
    common = sum((bias @ bias.T for bias in biases.values()), np.zeros_like(result.covariance))
    std = np.maximum(
        np.diag(jacobian @ result.covariance @ jacobian.T),
        np.diag(jacobian @ (result.covariance_robust - common) @ jacobian.T),
    )
    names = [parameter.name for parameter in form.parameters]
    rows = {
        name: {key: jacobian[k] @ bias for key, bias in biases.items()}
        for k, name in enumerate(names)
    }  # fmt: skip
    recorded_at = result.record.recorded_at
    assert result.file is not None
    when = (
        datetime.fromtimestamp(result.file.stat().st_mtime)
        if recorded_at is None
        else datetime.fromisoformat(recorded_at)
    )
    return Entry(when.astimezone(), result, dict(zip(names, std.tolist(), strict=True)), rows)


def _leaps(of: History) -> list[Leap]:
    """Changes between results that follow each other."""
    pairs = [(a, b) for a, b in pairwise(of.entries) if a.result.mounted == b.result.mounted]
    most, leaps = _most(len(pairs) * len(of.names)), list[Leap]()
    for before, after in pairs:
        for name in of.names:
            change = after.result[name].value - before.result[name].value
            variance = before.variances[name] + after.variances[name] + _by_tolerances(before, after, name)
            if change**2 > most**2 * variance > 0.0:
                leaps.append(Leap(name, before, after, change, float(np.sqrt(variance))))
    return leaps


def _by_tolerances(before: Entry, after: Entry, name: str) -> float:
    """Variance of a change by sizes of tolerances: none where they do the same in both runs."""
    one, other = before.tolerances[name], after.tolerances[name]
    alike = [
        {key: value for key, value in (of.result.record.computed_from or {}).items() if key.startswith("tolerances")}
        for of in (before, after)
    ]
    if alike[0] != alike[1] or any(one[key].shape != other[key].shape for key in one.keys() & other.keys()):
        return float(sum(v @ v for v in (*one.values(), *other.values())))
    parts = [one.get(key, 0.0) - other.get(key, np.zeros(1)) for key in {**one, **other}]
    return float(sum(np.sum(np.square(part)) for part in parts))


def _changes_over_all(of: History, leapt: set[str]) -> list[Leap | Drift]:
    """Parameters without a leap that follow a straight line over time, or one step, whichever fits better.

    Results with the payload of the last one count.
    """
    entries = [entry for entry in of.entries if entry.result.mounted == of.entries[-1].result.mounted]
    t = np.array([(entry.when - entries[0].when).total_seconds() for entry in entries])
    if len(entries) < FEWEST or np.ptp(t) == 0.0:
        return []
    names = [name for name in of.names if name not in leapt]
    most, changes = _most(max(len(names), 1)), list[Leap | Drift]()
    for name in names:
        variances = np.array([entry.variances[name] for entry in entries])
        if not variances.min() > 0.0:
            continue
        values, weights = np.array([entry.result[name].value for entry in entries]), 1.0 / variances
        away = t - np.average(t, weights=weights)
        information = float(weights @ away**2)
        rate, std = float(weights @ (away * values)) / information, information**-0.5
        if abs(rate) <= most * std:
            continue
        steps = [_step(values, weights, k) for k in range(1, len(values))]
        k = int(np.argmax([abs(change) / deviation for change, deviation in steps]))
        if abs(steps[k][0]) / steps[k][1] > abs(rate) / std:
            changes.append(Leap(name, entries[k], entries[k + 1], *steps[k]))
        else:
            changes.append(Drift(name, rate, std, entries[0].result[name].unit))
    return changes


def _step(values: Array, weights: Array, k: int) -> tuple[float, float]:
    """Mean of the values from the k-th on less that of those before, with its deviation."""
    before, after = (np.average(v, weights=w) for v, w in ((values[:k], weights[:k]), (values[k:], weights[k:])))
    return float(after - before), float((1.0 / weights[:k].sum() + 1.0 / weights[k:].sum()) ** 0.5)


def _most(comparisons: int) -> float:
    """Deviations beyond which one of so many is not by noise."""
    return float(-ndtri(UNLIKELY / (2.0 * max(comparisons, 1))))


def _day(when: datetime) -> str:
    return f"{when:%Y-%m-%d %H:%M}"


def _times(value: float, std: float) -> str:
    return f"{abs(value) / std:.2g}"
