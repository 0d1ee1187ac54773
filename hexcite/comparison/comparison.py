"""Comparison of plans, runs and results: their groups, and which excitation to prefer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from cases.base.atomic import atomic_folder
from cases.base.errors import Code, HexciteError
from cases.base.folder_kinds import COMPARISON
from cases.base.output_places import check_folder
from cases.base.text_formats import json_text
from cases.base.units import as_html
from cases.basis import bound_hash
from cases.schema import Case
from hexcite.comparison.entries import Conditions, Entry, entry_of_plan, read_entry
from planner.plans.plan import Plan

NO_DIFFERENCE = 1.05  # ratio of standard deviations below which the shorter one is as good


def groups(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Entries that belong together, by the fingerprints that they carry: a plan, its runs and their results."""
    entry_groups: list[list[Entry]] = []
    for entry in sorted(entries, key=lambda e: e.level != "planned"):
        homes = (g for g in entry_groups if any(_of_one_excitation(entry.conditions, o.conditions) for o in g))
        if (home := next(homes, None)) is None:
            entry_groups.append(home := [])
        home.append(entry)
    return entry_groups


def _of_one_excitation(one: Conditions, other: Conditions) -> bool:
    return one.plan == other.plan is not None or bool(one.recordings & other.recordings)


@dataclass(frozen=True, slots=True, repr=False)
class Comparison:
    """Excitations before and after running them; saved for people and programs, and made anew, not read back."""

    groups: tuple[tuple[Entry, ...], ...]  # each group: a plan, its runs and their results
    best: str | None  # name of the one to prefer; None where nothing can be compared
    level: str  # origin of the figures: planned, identified, or mixed
    ratios: Mapping[str, float]  # geometric mean of the standard deviations of each, over the best one's
    sentences: tuple[str, ...]  # reasons

    @property
    def entries(self) -> list[Entry]:
        """All that is compared, in the order of the groups."""
        return [entry for group in self.groups for entry in group]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the evaluations, and whether models differ."""
        differ = "models differ: criteria of different models do not compare, standard deviations do"
        warnings = [differ] if len({e.model for e in self.entries}) > 1 else []
        of_each: dict[str, list[str]] = {}
        for entry in self.entries:
            for warning in entry.warnings:
                of_each.setdefault(warning, []).append(entry.name)
        return (*warnings, *(f"{', '.join(names)}: {warning}" for warning, names in of_each.items()))

    def to_json(self) -> dict[str, Any]:
        """Entries of `comparison.json`."""
        advice = {"best": self.best, "level": self.level, "ratios": self.ratios, "sentences": self.sentences}
        return {
            "rows": [e.to_json() for e in self.entries],
            "groups": [[e.name for e in g] for g in self.groups],
            "recommendation": advice,
            "warnings": list(self.warnings),
        }

    def write(self, folder: Path) -> None:
        """Writes comparison.json into an existing folder."""
        (folder / "comparison.json").write_text(json_text(self.to_json()), encoding="utf-8")

    def save(self, folder: Path | str, overwrite: bool = False) -> None:
        """Makes a folder with comparison.json."""
        check_folder(Path(folder), COMPARISON, overwrite=overwrite)
        with atomic_folder(Path(folder), COMPARISON, overwrite) as part:
            self.write(part)

    def __repr__(self) -> str:
        """The entries, warnings and the recommendation."""
        lines = [f"Comparison of {', '.join(entry.name for entry in self.entries)}"]
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join([*lines, *(f"recommendation: {sentence}" for sentence in self.sentences)])

    _repr_html_ = as_html


def recommend(entries: Sequence[Sequence[Entry]]) -> Comparison:
    """Groups with the excitation of the smallest standard deviations, by the best evidence that all of them have."""
    entries, remarks = _joined(entries)
    different = list[str]()
    common = [level for level in ("identified", "planned") if all(any(e.level == level for e in g) for g in entries)]
    level = common[0] if common else "mixed"
    selection = [e for g in entries for e in g if e.level == (level if common else g[-1].level)]
    if rivals := _models_of_one_run(selection):
        selection = [e for e in selection if e not in rivals]
        words = "are models of one run, among which deviations do not choose: identify the run with all models, for "
        different.append(f"{', '.join(e.name for e in rivals)} {words}what each predicts of samples left out")
    if not common:
        remarks.append("predictions stand beside identified values: predictions know nothing of the machine's errors")
    alike = under_equal_conditions(selection)
    if len(alike) > 1:
        text = "; ".join(
            f"{', '.join(e.name for e in group)} ({', '.join(filter(None, _properties(group[0])))})" for group in alike
        )
        words = "these were planned or measured under different conditions, and none is preferred across them"
        different.append(f"{words}: {text}")
    rated = [_among(group, level) for group in alike if len(group) > 1 or len(alike) == 1]
    reasons = [sentence for *_, sentences in rated for sentence in sentences]
    return Comparison(
        groups=tuple(tuple(group) for group in entries),
        best=rated[0][0] if len(rated) == 1 else None,
        level=level,
        ratios={name: ratio for _, ratios, _ in rated for name, ratio in ratios.items()},
        sentences=(*different, *reasons, *remarks),
    )


def _joined(entries: Sequence[Sequence[Entry]]) -> tuple[list[list[Entry]], list[str]]:
    """The groups with each run in the entries of its results, and sentences that say so.

    A run has figures of the execution, a result has none until then.
    """
    joined, sentences = list[list[Entry]](), list[str]()
    for group in entries:
        runs = {e.name: [o for o in group if not o.notes and _of_one_run(o, e)] for e in group if e.notes}
        sentences += [
            f"{run} is the run of {', '.join(o.name for o in entries_of_run)}, and stands there"
            for run, entries_of_run in runs.items()
            if entries_of_run
        ]
        rest = [e for e in group if not runs.get(e.name)]
        run_of = {o.name: e for e in group for o in runs.get(e.name, ())}
        executed = [(e, run_of.get(e.name, e)) for e in rest]
        joined.append([replace(e, notes=run.notes, measured=run.measured) for e, run in executed])
    return joined, sentences


def _of_one_run(one: Entry, other: Entry) -> bool:
    return bool(one.conditions.recordings & other.conditions.recordings)


def _models_of_one_run(entries: Sequence[Entry]) -> list[Entry]:
    """The entries that are other models of the same run as another one."""
    return [e for e in entries if any(_of_one_run(e, o) and e.model != o.model for o in entries)]


def under_equal_conditions(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Entries of one machine, one load and one noise each; unknown properties of an entry agree with everything."""
    result: list[list[Entry]] = []
    for entry in entries:
        homes = (g for g in result if all(_alike(_properties(entry), _properties(other)) for other in g))
        if (home := next(homes, None)) is None:
            result.append(home := [])
        home.append(entry)
    return result


def _alike(one: Sequence[str | None], other: Sequence[str | None]) -> bool:
    return all(a == b or None in (a, b) for a, b in zip(one, other, strict=True))


def _properties(entry: Entry) -> tuple[str | None, ...]:
    """Case, machine, load and noise in words; None where they are unknown."""
    case, noise, load, machine, *_ = entry.conditions
    words = None
    if noise is not None:
        words = f"noise {noise:.3g} N at {case.recording.rate_Hz:g} Hz"
        if (field := case.sensors.pose_field) is not None:
            words += f" and {field.words} that depends on the pose"
    limits = bound_hash(case)[:6]  # of machine and limits
    return f"case {case.name} ({limits})", machine, None if load is None else f"{load:.4g} kg mounted", words


def _among(entries: Sequence[Entry], level: str) -> tuple[str | None, dict[str, float], list[str]]:
    """The best of entries that can be compared, ratios and reasons, as in `Comparison`."""
    if len(entries) < 2:
        return None, {}, ["there is nothing to choose from: name two excitations or more"]
    deviations = [{n: v.reported for n, v in e.parameters.items() if v.reported > 0.0} for e in entries]
    names = [n for n in deviations[0] if all(n in of_entry for of_entry in deviations)]
    if not names:
        return None, {}, ["they have no parameter in common"]
    remarks = []
    for entry, of_entry in zip(entries, deviations, strict=True):
        if missing := sorted({n for other in deviations for n in other} - set(of_entry)):
            remarks.append(f"{entry.name} does not determine {', '.join(missing)}: not compared")
    sizes = np.array([np.mean(np.log([of_entry[n] for n in names])) for of_entry in deviations])
    order = np.argsort(sizes, kind="stable")
    best, second = entries[order[0]], entries[order[1]]
    ratio = float(np.exp(sizes[order[1]] - sizes[order[0]]))
    if ratio < NO_DIFFERENCE and (second.duration or np.inf) < (best.duration or 0.0):
        best, second, ratio = second, best, 1.0 / ratio  # as good, and shorter
    reason = f"{second.name}'s {level} standard deviations are {ratio:.2f} times as large"
    reason += f" (geometric mean over {len(names)} parameters)"
    if best.duration is not None and second.duration is not None:
        reason += f", in {best.duration:.1f} s against {second.duration:.1f} s"
    sentences = [f"{best.name}: {reason}"]
    if best.warnings:
        sentences.append(f"see to the warnings of {best.name} before you rely on it")
    times = [e.duration for e in entries]
    if all(times):
        fastest = entries[int(np.argmin(sizes + 0.5 * np.log([float(t or 1.0) for t in times])))].name
        if fastest != best.name:
            remarks.append(f"per second of measuring time {fastest} carries most information")
    ratios = {e.name: float(np.exp(s - sizes.min())) for e, s in zip(entries, sizes, strict=True)}
    return best.name, ratios, [*sentences, *remarks]


def compare(things: Sequence[Plan | Path | str], case: Case | None = None, stale: bool = False) -> Comparison:
    """Comparison of cost, information and standard deviations, with the excitation to prefer.

    >>> [entry.name for entry in hx.compare(["plan", "empty"]).entries]
    ['plan', 'empty']

    Args:
        things: plans, and folders of plans, poses, runs and results, in any mix; at least one.
        case: replaces the case that a folder names.
        stale: whether to go on although a case has changed since.

    Raises:
        HexciteError: none is named, one cannot be used, or is named twice.
    """
    if not things:
        raise HexciteError(
            place="compare",
            problem="nothing is named",
            remedy="name plans, runs or results, or their folders",
            code=Code.MISSING,
        )
    identities = [id(thing) if isinstance(thing, Plan) else Path(thing).resolve() for thing in things]
    if twice := [thing for thing, own in zip(things, identities, strict=True) if identities.count(own) > 1]:
        place = twice[0].name if isinstance(twice[0], Plan) else Path(twice[0]).resolve()
        raise HexciteError(place=place, problem="is named twice", remedy="name each once", code=Code.CONTRADICTION)
    with threadpool_limits(limits=1, user_api="blas"):
        entries = [
            entry_of_plan(thing, thing.name) if isinstance(thing, Plan) else read_entry(Path(thing), case, stale)
            for thing in things
        ]
    return recommend(groups(_told_apart(entries)))


def _told_apart(entries: Sequence[Entry]) -> list[Entry]:
    """The same entries, each with a name of its own: plans in memory may have the same, and are numbered then."""
    names = [entry.name for entry in entries]
    counts = [names[: k + 1].count(name) for k, name in enumerate(names)]
    return [
        replace(entry, name=f"{entry.name} ({count})") if count > 1 else entry
        for entry, count in zip(entries, counts, strict=True)
    ]
