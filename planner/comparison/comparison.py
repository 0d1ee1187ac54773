"""Comparison of plans, runs and results: their groups, and which excitation to prefer."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from cases.basis import bound_hash
from cases.errors import HexciteError
from cases.files import COMPARISON, atomic_folder, check_folder, json_text
from cases.schema import Case
from cases.units import as_html
from planner.comparison.entries import LEVELS, Conditions, Entry, entry_of_plan, read_entry
from planner.plans import Plan

SAME_NOISE = 1.05  # ratio of the noise that two predictions assume, below which they compare
SAME_LOAD = 1e-3  # [kg] difference of the mounted weights below which loads are the same
NO_DIFFERENCE = 1.05  # ratio of standard deviations below which the shorter one is as good


def groups(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Entries that belong together, by the fingerprints that they carry: a plan, its runs and their results.

    A result without its run belongs to the plan of that run; one with it has time and machine from it.
    """
    entry_groups = [[e] for e in entries if e.level == "planned"]
    for run in (e for e in entries if e.level == "executed"):
        _group_of_plan(run, [g for g in entry_groups if g[0].level == "planned"], entry_groups).append(run)
    for result in (e for e in entries if e.level == "identified"):
        runs = [(g, e) for g in entry_groups for e in g if e.level == "executed" and _of_one_run(e, result)]
        if runs:
            home, run = runs[0]
            known = result.conditions._replace(load=run.conditions.load, machine=run.conditions.machine)
            entry = replace(result, duration=run.duration, conditions=known)
            home.insert(max(k for k, e in enumerate(home) if _of_one_run(e, run)) + 1, entry)
        else:
            _group_of_plan(result, entry_groups, entry_groups).append(result)
    return entry_groups


def _of_one_run(one: Entry, other: Entry) -> bool:
    return bool(one.conditions.recordings & other.conditions.recordings)


def _group_of_plan(entry: Entry, known: Sequence[list[Entry]], entry_groups: list[list[Entry]]) -> list[Entry]:
    """The group that begins with an entry's plan, or a new one."""
    for group in known:
        if group[0].conditions.plan == entry.conditions.plan is not None:
            return group
    entry_groups.append([])
    return entry_groups[-1]


def warnings_of(entries: Sequence[Entry]) -> tuple[str, ...]:
    """Reasons why figures do not compare, and warnings of the evaluations of runs and results."""
    warnings = []
    if len({e.model for e in entries}) > 1:
        warnings.append("models differ: criteria of different models do not compare, standard deviations do")
    if len({e.conditions.case.hash for e in entries}) > 1:
        warnings.append("cases differ: the machines are not the same, or the case was changed between")
    noise = [None if (n := e.conditions.noise) is None else f"{n:.3g} N" for e in entries]
    load = [None if (n := e.conditions.load) is None else f"{n:.4g} kg" for e in entries]
    for words, values in (
        ("predictions assume different noise of a force sample, and differ for that too", noise),
        ("different weights are mounted, with which errors of the machine grow", load),
        ("not the same was measured, so that residuals do not compare", [e.conditions.machine for e in entries]),
    ):
        owners: dict[str, list[str]] = {}
        for value, entry in zip(values, entries, strict=True):
            if value is not None:
                owners.setdefault(value, []).append(entry.name)
        if len(owners) > 1:
            warnings.append(f"{words}: " + "; ".join(f"{value} ({', '.join(own)})" for value, own in owners.items()))
    return (*warnings, *(f"{e.name}: {warning}" for e in entries for warning in e.warnings))


@dataclass(frozen=True, slots=True, repr=False)
class Comparison:
    """Excitations before and after running them; saved for people and programs, and made anew, not read back."""

    groups: tuple[tuple[Entry, ...], ...]  # each group: a plan, its runs and their results
    best: str | None  # name of the one to prefer; None where nothing can be compared
    level: str  # origin of the figures: planned, executed or identified
    ratios: Mapping[str, float]  # geometric mean of the standard deviations of each, over the best one's
    sentences: tuple[str, ...]  # reasons

    @property
    def entries(self) -> list[Entry]:
        """All that is compared, in the order of the groups."""
        return [entry for group in self.groups for entry in group]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Reasons why figures do not compare, and warnings of the evaluations."""
        return warnings_of(self.entries)

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
    compared = tuple(tuple(group) for group in entries)
    common = [level for level in reversed(LEVELS) if all(any(e.level == level for e in g) for g in entries)]
    remarks = []
    if common:
        level, selection = str(common[0]), [e for g in entries for e in g if e.level == common[0]]
    else:
        level, selection = "mixed", [max(g, key=lambda e: LEVELS.index(e.level)) for g in entries]
        remarks.append("predictions stand beside identified values: predictions know nothing of the machine's errors")
    alike = under_equal_conditions(selection)
    if len(alike) == 1:
        best, ratios, sentences = _among(selection, level, remarks)
        known = level if len(selection) > 1 else ""
        return Comparison(compared, best, known, ratios, tuple(sentences))
    text = "; ".join(
        f"{', '.join(e.name for e in group)} ({_in_words([e.conditions for e in group])})" for group in alike
    )
    parts = [_among(group, level, remarks) for group in alike if len(group) > 1]
    return Comparison(
        compared,
        parts[0][0] if len(parts) == 1 else None,
        level,
        {name: ratio for _, ratios, _ in parts for name, ratio in ratios.items()},
        (
            f"these were planned or measured under different conditions, and none is preferred across them: {text}",
            *(sentence for *_, sentences in parts for sentence in sentences),
        ),
    )


def under_equal_conditions(entries: Sequence[Entry]) -> list[list[Entry]]:
    """Entries of one machine, one load and one noise each; unknown properties of an entry agree with everything."""
    result: list[list[Entry]] = []
    for entry in entries:
        homes = (g for g in result if all(_comparable(entry.conditions, other.conditions) for other in g))
        if (home := next(homes, None)) is None:
            result.append(home := [])
        home.append(entry)
    return result


def _comparable(one: Conditions, other: Conditions) -> bool:
    if bound_hash(one.case) != bound_hash(other.case):
        return False
    if None not in (one.machine, other.machine) and one.machine != other.machine:
        return False
    if one.load is not None and other.load is not None and abs(one.load - other.load) > SAME_LOAD:
        return False
    if one.noise is None or other.noise is None:
        return True
    if one.case.recording.rate_Hz != other.case.recording.rate_Hz:  # the noise is that of a sample
        return False
    if one.case.sensors.pose_field != other.case.sensors.pose_field:  # one prediction counts errors of the pose
        return False
    return max(one.noise, other.noise) <= SAME_NOISE * min(one.noise, other.noise)


def _in_words(conditions: Sequence[Conditions]) -> str:
    """Machine, load and noise of entries that have them in common."""
    loads = [f"{c.load:.4g} kg mounted" for c in conditions if c.load is not None]
    noises = [f"noise {c.noise:.3g} N {_of_samples(c.case)}" for c in conditions if c.noise is not None]
    machines = [c.machine for c in conditions if c.machine is not None]
    return ", ".join([f"case {conditions[0].case.name}", *machines[:1], *loads[:1], *noises[:1]])


def _of_samples(case: Case) -> str:
    field, rate = case.sensors.pose_field, f"at {case.recording.rate_Hz:g} Hz"
    return rate if field is None else f"{rate} and {field.words} that depends on the pose"


def _among(
    entries: Sequence[Entry], level: str, remarks: Sequence[str]
) -> tuple[str | None, Mapping[str, float], Sequence[str]]:
    """The best of entries that can be compared, ratios and reasons, as in `Comparison`."""
    remarks = list(remarks)
    if len(entries) < 2:
        return None, {}, ["there is nothing to choose from: name two excitations or more"]
    names = [n for n in entries[0].parameters if all(n in e.parameters for e in entries)]
    if not names:
        return None, {}, ["they have no parameter in common"]
    for entry in entries:
        missing = sorted({n for e in entries for n in e.parameters} - set(entry.parameters))
        if missing:
            remarks.append(f"{entry.name} does not determine {', '.join(missing)}: not compared")
    sizes = np.array([_size(e, names) for e in entries])
    order = np.argsort(sizes, kind="stable")
    best, second = entries[order[0]], entries[order[1]]
    ratio = float(np.exp(sizes[order[1]] - sizes[order[0]]))
    times = [e.duration for e in entries]
    if ratio < NO_DIFFERENCE and best.duration and second.duration and second.duration < best.duration:
        best, second = second, best
        reason = (
            f"standard deviations of {second.name} are as small within {100 * (ratio - 1):.0f} %, but it takes longer"
        )
    else:
        reason = f"its {level} standard deviations are smallest: {second.name}'s are {ratio:.2f} times as large"
    reason += f" (geometric mean over {len(names)} parameters)"
    if best.duration is not None and second.duration is not None:
        reason += f", in {best.duration:.1f} s against {second.duration:.1f} s"
    sentences = [f"{best.name}: {reason}", *remarks]
    if best.warnings:
        others = [entries[k].name for k in order if not entries[k].warnings]
        instead = f"; without warnings the best is {others[0]}" if others else ""
        sentences.insert(1, f"see to the warnings of {best.name} before you rely on it{instead}")
    if all(times):
        rates = sizes + 0.5 * np.log([float(t or 1.0) for t in times])
        fastest = entries[int(np.argmin(rates))].name
        if fastest != best.name:
            sentences.append(f"per second of measuring time {fastest} carries most information")
    ratios = {e.name: float(np.exp(s - sizes.min())) for e, s in zip(entries, sizes, strict=True)}
    return best.name, ratios, sentences


def _size(entry: Entry, names: Iterable[str]) -> float:
    deviations = [entry.parameters[n].reported for n in names]
    if not all(d > 0.0 for d in deviations):
        raise HexciteError(entry.name, "a parameter was given, not identified; compare without --fix")
    return float(np.mean(np.log(deviations)))


def compare(things: Sequence[Plan | Path | str], case: Case | None = None, stale: bool = False) -> Comparison:
    """Comparison of cost, information and standard deviations, with the excitation to prefer.

    Args:
        things: plans, and folders of plans, poses, runs and results, in any mix; at least one.
        case: replaces the case that a folder names.
        stale: whether to go on although a case has changed since.

    Raises:
        HexciteError: none is named, one cannot be used, or is named twice.
    """
    if not things:
        raise HexciteError("compare", "nothing is named", "name plans, runs or results, or their folders")
    folders = [Path(thing) for thing in things if not isinstance(thing, Plan)]
    for k, folder in enumerate(folders):
        if any(folder.resolve() == other.resolve() for other in folders[:k]):
            raise HexciteError(folder, "is named twice; name each folder once")
    with threadpool_limits(limits=1, user_api="blas"):
        entries = [
            entry_of_plan(thing, thing.name) if isinstance(thing, Plan) else read_entry(Path(thing), case, stale)
            for thing in things
        ]
    return recommend(groups(entries))
