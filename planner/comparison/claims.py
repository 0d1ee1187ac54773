"""Claims about the methods of a validation, each answered by the figures of the run."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from planner.comparison.error_budget import BODY, SUSPICIOUS, cause_of
from planner.comparison.methods import METHODS
from planner.comparison.trials import Trial

TIMING = 1.005  # ratio of durations that counts as the same time: a controller's own ramps


class Claim(NamedTuple):
    """A claim and its answer."""

    claim: str  # as a statement
    holds: bool  # whether the figures bear it out
    figures: str  # figures in words

    def sentence(self) -> str:
        """In one line."""
        return f"{'yes' if self.holds else 'NO'}: {self.claim} ({self.figures})"


def claims_of(trials: Sequence[Trial]) -> list[Claim]:
    """Answers to the questions of the paper's comparison, for the methods that were run."""
    bare = {s.method: s for s in trials if s.weights == 0}
    claims = [
        claim
        for ours in _of_role("ours")
        for theirs in (*_of_role("moving"), *_of_role("standing"))
        if ours in bare and theirs in bare
        for claim in _smaller(bare[ours], bare[theirs])
    ]
    if any(s.truth for s in trials):
        claims.append(_inside(trials))
    return claims


def _of_role(role: str) -> list[str]:
    return [name for name, method in METHODS.items() if method.role == role]


def _smaller(ours: Trial, theirs: Trial) -> list[Claim]:
    """Standard deviations of one method against another's, or of a second of both where the other stands still.

    Those of motions are compared by (28) at each method's own s0, as the paper reports them; by those that allow for
    noise with memory and errors of the pose, which are themselves estimates from one run; and, on a simulated machine,
    by the true ones.
    """
    one, other = ours.estimate.physical, theirs.estimate.physical
    shared = [n for n in other if n in one]
    start = f"{ours.method} reports smaller standard deviations of all {len(shared)} parameters than {theirs.method}"
    times = f"; {_seconds(ours)} against {_seconds(theirs)}"
    quick = None in (ours.duration, theirs.duration) or (ours.duration or 0.0) <= TIMING * (theirs.duration or 0.0)

    def claim(words: str, ratio: Callable[[str], float], more: str = "", fair: bool = True) -> Claim:
        ratios = {n: ratio(n) for n in shared}
        worst, typical = max(shared, key=ratios.__getitem__), float(np.exp(np.mean(np.log(list(ratios.values())))))
        figures = f"{typical:.2f} times as large on average, {worst} at worst with {ratios[worst]:.2f}"
        larger = ", ".join(n for n, value in ratios.items() if value >= 1.0)
        return Claim(words, fair and not larger, figures + (f"; not smaller: {larger}" if larger else "") + more)

    if METHODS[theirs.method].role == "standing":
        share = 1.0
        if ours.duration and theirs.duration:
            share = float(np.sqrt(ours.duration / theirs.duration))
        words = f"{start} for a second of measuring"
        return [claim(words, lambda n: share * one[n].reported / other[n].reported, times)]
    claims = [
        claim(
            f"{start} in no more time, by (28) at each method's own s0",
            lambda n: one[n].std / other[n].std, times, quick,
        ),
        claim(
            f"{start} also where noise with memory and errors of the pose are allowed for",
            lambda n: one[n].reported / other[n].reported, _honest(ours, theirs), quick,
        ),
    ]  # fmt: skip
    if ours.scatter and theirs.scatter:
        words = (
            f"the true standard deviations of {ours.method}, over machines whose errors of the pose differ, are "
            f"smaller than those of {theirs.method} for all {len(shared)} parameters"
        )
        claims.append(claim(words, lambda n: ours.scatter[n] / theirs.scatter[n]))
    return claims


def _honest(*trials: Trial) -> str:
    """Ratio of deviations that allow for noise with memory and errors of the pose to the true ones, in words."""
    if not all(s.scatter for s in trials):
        return ""
    words = []
    for trial in trials:
        shares = [v.reported / trial.scatter[n] for n, v in trial.estimate.physical.items()]
        words.append(f"{min(shares):.2f} to {max(shares):.2f} times the true ones for {trial.method}")
    return f"; estimated from one run they are {' and '.join(words)}"


def _seconds(trial: Trial) -> str:
    return "unknown time" if trial.duration is None else f"{trial.duration:.2f} s"


def _inside(trials: Sequence[Trial]) -> Claim:
    errors = [(s, n, e) for s in trials for n in BODY if (e := s.error(n)) is not None]
    off = [(s, n, e) for s, n, e in errors if abs(e) > SUSPICIOUS]
    causes: dict[str, int] = {}
    for s, n, _ in off:
        if s.budget:
            causes[cause_of(s.budget[n])] = causes.get(cause_of(s.budget[n]), 0) + 1
    words = f"{len(errors) - len(off)} of {len(errors)} are"
    if off:
        worst = max(off, key=lambda entry: abs(entry[2]))
        words += f"; the worst is {worst[1]} of {worst[0].method} at {worst[0].load:.0f} kg with {worst[2]:+.1f}"
    if causes:
        words += "; causes of the others: " + ", ".join(f"{c} ({n})" for c, n in causes.items())
    return Claim(
        f"mass, centre of gravity and inertia lie within {SUSPICIOUS:g} reported standard deviations of the truth",
        not off,
        words,
    )


def off_rows(trials: Sequence[Trial]) -> list[list[str]]:
    """Rows of estimates that are off: error and its parts, in reported standard deviations, and its cause."""
    rows = []
    for trial in trials:
        for name, parts in trial.budget.items():
            error = trial.error(name)
            if error is None or abs(error) <= SUSPICIOUS:
                continue
            shares = [f"{part:+.1f}" for part in trial.parts_in_std(name).values()]
            off = [trial.method, f"{trial.load:.0f} kg", name, _off(trial, name), f"{error:+.1f}"]
            rows.append([*off, *shares, cause_of(parts)])
    return rows


OFF_COLUMNS = ("method", "load", "parameter", "error", "in std", "mode", "pose", "noise", "ripple", "left out", "cause")


def _off(trial: Trial, name: str) -> str:
    """The error in words: per cent for masses and inertias, millimetres for coordinates, which may be about zero."""
    error = trial.estimate.physical[name].value - trial.truth[name]
    return f"{error * 1e3:+.2f} mm" if name[1:] == "C" else f"{100 * error / trial.truth[name]:+.2f} %"
