"""Whether a run is the motion of its plan, and what was different: what is said of both, compared in path and pace."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from cases.base.phrases import phrase
from cases.base.units import DEG, MM, Array, Indices
from identification.finding import Finding, Kind, note, warning
from identification.findings.plan_comparison import (
    ANOTHER,
    FEWEST,
    NEAR,
    WHOLE,
    PlanComparison,
    Planned,
    in_coordinates,
)
from identification.machines.of_case import machine_of
from identification.motion.motion import Joined, Standstill, Trajectory
from identification.stretches import stretches

LATE = 0.25  # [s] that recorders may miss at either end
SHIFTED = 0.01  # of a coordinate's planned range; beside it the least shifts that are worth a word
LEAST_SHIFT = 0.3 * MM, 0.03 * DEG
SLOWER = 0.05  # difference of pace that is worth a word: controllers need some percent more than planned
OF_A_LAW = 0.3  # difference that other accelerations than planned can make
ACT = 0.1  # and from which on one should act
FASTEST = 0.7  # share of the points that are slower than those at which the pace is taken
UNEVEN = 0.15  # difference of the pace of a part from the plan's, where others have the plan's
LEAST_PART = 0.25  # [s] of a part whose pace is worth a word
EVEN = 0.06  # spread of the pace at the fastest places, up to which it is one
BESIDE = 3  # points beside a pose, between which a run may stand there
PARTS = 20  # of a motion that has none of its own, in which the pace is looked at
SAME_PLACE = 1e-6  # share of the range
AT_AN_END = 0.02  # of the distance of two points: what is nearer to the end of a move is there
MISSED_STAY = 0.5  # share of the planned stay at a pose


def as_planned(best: PlanComparison | None, plan: Planned | Sequence[Planned]) -> tuple[Finding, ...]:
    """What was different from the plan, as findings with numbers; figures alone where nothing was.

    Args:
        best: `closest` of the run.
        plan: plan of the run; or plans that lie beside it, of which one may be that of the run.
    """
    if best is None:
        return ()
    plans = [plan] if isinstance(plan, Planned) else list(plan)
    if isinstance(plan, Planned) or best.share >= ANOTHER:
        return findings_of(best)
    names = ", ".join(one.name for one in plans)
    one = phrase("plan_beside", "the plan beside it")
    which = one if len(plans) == 1 else phrase("plans_beside", "one of the plans beside it")
    figures = {"plan": best.plan.name, "share_of_path": round(best.share, 4)}
    words = "the run is not the motion of {which}, {names}; identify it with its own plan"
    return (note(Kind.PROGRAM, phrase("another_motion", words, which=which, names=names), as_planned=figures),)


def findings_of(comparison: PlanComparison) -> tuple[Finding, ...]:
    """Findings of a comparison; figures alone where nothing was different."""
    name, share = comparison.plan.name, comparison.share
    figures: dict[str, Any] = {"plan": name, "share_of_path": round(share, 4)}
    if share < ANOTHER:
        text = phrase(
            "not_the_plan",
            "the run is not the motion of the plan {name}: {share} % of its path is in the recording; another program "
            "ran, or it was changed after planning",
            name=name,
            share=f"{100 * share:.0f}",
        )
        return (warning(Kind.PROGRAM, text, as_planned=figures),)
    sentences = [*_shifts(comparison, figures), *_differences(comparison, figures), *_paces(comparison, figures)]
    if not sentences:
        return (note(Kind.PROGRAM, as_planned=figures),)
    first, *others = sentences
    return (_of(first, name, as_planned=figures), *(_of(text, name) for text in others))


class _Said(NamedTuple):
    text: str
    act: bool = True


def _of(said: _Said, name: str, **quantity: Any) -> Finding:
    sentence = f"compared with the plan {name}, {said.text}"
    make = warning if said.act else note
    return make(Kind.PROGRAM, sentence, **quantity)


def _shifts(comparison: PlanComparison, figures: dict[str, Any]) -> list[_Said]:
    """What to say of a run whose path is the plan's at another place."""
    _, limits = comparison.case.need_motion("the comparison with a plan")
    poses = comparison.plan.motion.at(comparison.planned.t[comparison.pairs[:, 0]]).coordinates
    measured = in_coordinates(comparison, comparison.pairs[:, 1])
    if measured is None:
        return []
    shifts = np.median(measured - poses, axis=0)
    ranges = np.ptp(comparison.plan.motion.at(comparison.planned.t).coordinates, axis=0)
    least = np.maximum(SHIFTED * ranges, np.where(limits.turns, LEAST_SHIFT[1], LEAST_SHIFT[0]))
    far = np.flatnonzero(np.abs(shifts) > least)
    if not len(far):
        return []
    words = ", ".join(_amount(limits.columns[k], shifts[k], bool(limits.turns[k]), "+") for k in far)
    figures["shift"] = {limits.columns[k]: _in_units(shifts[k], bool(limits.turns[k])) for k in far}
    return [_Said(f"the run is shifted by {words}: home stood elsewhere, or an offset was active")]


def _in_units(value: float, turns: bool) -> float:
    return round(float(value) / (DEG if turns else MM), 4)


def _amount(column: str, value: float, turns: bool, sign: str = "") -> str:
    """A length or angle of a coordinate for people: `x +5 mm`."""
    name, unit = column.rpartition("_")[0], "deg" if turns else "mm"
    return f"{name} {value / (DEG if turns else MM):{sign}.3g} {unit}"


def _differences(comparison: PlanComparison, figures: dict[str, Any]) -> list[_Said]:
    """What to say of parts of the plan that the run does not hold."""
    planned, pairs, matched = comparison.planned, comparison.pairs, comparison.matched
    total, count = comparison.plan.motion.duration, len(matched)
    sentences: list[_Said] = []
    figures["not_run"] = missing = []
    missed = _missed_poses(comparison)
    if missed:
        figures["poses_not_visited"] = missed
        which = f"pose {missed[0]} was" if len(missed) == 1 else f"poses {_listed(missed)} were"
        sentences.append(_Said(f"{which} not visited, or not stayed at as planned (of {len(comparison.plan.poses)})"))
    of_poses = len(comparison.plan.poses) > 0
    first, last = int(pairs[0, 0]), int(pairs[-1, 0])
    least = max(FEWEST, round((1.0 - WHOLE) * count))
    if first >= least and planned.t[first] > LATE and (missed or not of_poses):
        missing.append([0.0, round(float(planned.t[first]), 3)])
        sentences.append(
            _Said(
                f"the recording begins {planned.t[first]:.3g} s into its {total:.3g} s: "
                f"{100 * first / count:.2g} % of the path is missing at its start"
            )
        )
    if count - 1 - last >= least and total - planned.t[last] > LATE and (missed or not of_poses):
        missing.append([round(float(planned.t[last]), 3), round(total, 3)])
        rest = 100 * (count - 1 - last) / count
        sentences.append(
            _Said(f"the run ends at {planned.t[last]:.3g} s of its {total:.3g} s: {rest:.2g} % of the path is missing")
        )
    parts = []
    for k in np.flatnonzero(np.diff(pairs[:, 0]) > FEWEST):
        (i, j), (i_next, j_next) = pairs[k], pairs[k + 1]
        missing.append([round(float(planned.t[i]), 3), round(float(planned.t[i_next]), 3)])
        parts.append((planned.t[i], planned.t[i_next], _astray(comparison, i, i_next, j, j_next)))
    if parts and not missed:
        start, end, how = max(parts, key=lambda part: part[1] - part[0])
        more = f" ({len(parts) - 1} more places)" if len(parts) > 1 else ""
        moves = _moves(comparison.plan.motion, start, end)
        sentences.append(
            _Said(
                f"the run went elsewhere from {start:.3g} to {end:.3g} s of the plan{moves}{how}{more}: the program "
                "was changed after planning, or is another one"
            )
        )
    return sentences


def _moves(motion: Trajectory, start: float, end: float) -> str:
    """Which moves of a plan lie between two of its times."""
    if not isinstance(motion, Joined):
        return ""
    edge = 0.02 * (end - start)
    a, b = (
        int(np.clip(np.searchsorted(motion.starts, t, side="right"), 1, len(motion.parts)))
        for t in (start + edge, end - edge)
    )
    which = f"move {a}" if a == b else f"moves {a} to {b}"
    return f" ({which} of {len(motion.parts)})"


def _astray(comparison: PlanComparison, i: int, i_next: int, j: int, j_next: int) -> str:
    """How far points j .. j_next of the run leave the plan's points i .. i_next, in the coordinate where it is most."""
    _, limits = comparison.case.need_motion("the comparison with a plan")
    planned_path = comparison.planned.drives[i : i_next + 1] + comparison.shift
    its = comparison.run.drives[j : j_next + 1]
    distance = (((planned_path[:, None] - its[None]) / comparison.scale) ** 2).sum(axis=2)
    worst = int(distance.min(axis=1).argmax())
    nearest = int(distance[worst].argmin())
    measured = in_coordinates(comparison, np.array([j + nearest]))
    if measured is None:
        return ""
    pose = comparison.plan.motion.at(comparison.planned.t[[i + worst]]).coordinates[0]
    shift = measured[0] - pose
    size = np.abs(shift) / np.where(limits.turns, DEG, MM)
    k = int(size.argmax())
    return f", by {_amount(limits.columns[k], abs(shift[k]), bool(limits.turns[k]))}"


def _missed_poses(comparison: PlanComparison) -> list[int]:
    """Numbers of the poses, counted from 1, at which the run did not stand half as long as planned."""
    motion, pairs, raw = comparison.plan.motion, comparison.pairs, comparison.raw
    if not len(comparison.plan.poses) or not isinstance(motion, Joined):
        return []
    stays = [k for k, part in enumerate(motion.parts) if isinstance(part, Standstill) and part.average]
    places = machine_of(comparison.case).drives(comparison.plan.poses)
    times, missed = comparison.planned.t[pairs[:, 0]], []
    near = NEAR * comparison.step
    for number, (k, place) in enumerate(zip(stays, places, strict=True), 1):
        begins, ends = motion.starts[k : k + 2]
        before = int(np.searchsorted(times, begins - (ends - begins) / 2.0)) - BESIDE
        behind = int(np.searchsorted(times, ends + (ends - begins) / 2.0)) + BESIDE
        first = comparison.run.t[pairs[before, 1]] if before >= 0 else raw.t[0]
        last = comparison.run.t[pairs[behind, 1]] if behind < len(pairs) else raw.t[-1]
        rows = slice(*np.searchsorted(raw.t, [first, last]))
        away = np.linalg.norm((raw.drives[rows] - comparison.shift - place) / comparison.scale, axis=1)
        stayed = float(np.diff(raw.t[rows])[away[1:] <= near].sum())
        if stayed < MISSED_STAY * (ends - begins):
            missed.append(number)
    return missed


def _listed(numbers: Sequence[int]) -> str:
    listing = ", ".join(map(str, numbers[:6]))
    return f"{listing} and {len(numbers) - 6} more" if len(numbers) > 6 else listing


def _paces(comparison: PlanComparison, figures: dict[str, Any]) -> list[_Said]:
    """What to say of a run that is slower or faster than planned.

    How long parts take is compared. Where all of them are slower, and by one factor where they are fastest, that is the
    override: accelerations, and so the ends of moves, do not follow it on every controller.
    """
    parts = _passed(comparison)
    if not parts:
        return []
    planned, run = sum(part.planned for part in parts), sum(part.run for part in parts)
    ratios = np.array([part.ratio for part in parts])
    longer = run / planned
    figures["times_longer"] = round(longer, 4)
    pace = _pace_where_fastest(comparison)
    if len(comparison.plan.poses):  # standing counts: moves between the poses may be slower
        pace = min(longer, longer if pace is None else pace, key=lambda ratio: abs(np.log(ratio)))
        if abs(pace - 1.0) <= SLOWER:
            return []
        return [_Said(f"the moves between the poses were {_slower(pace)}: override {100.0 / pace:.0f} %", False)]
    odd = (np.abs(ratios - 1.0) > UNEVEN) & (np.array([part.planned for part in parts]) > LEAST_PART)
    if odd.any() and (np.abs(ratios - 1.0) <= SLOWER).sum() >= 2:
        several = max((parts[rows] for rows in stretches(odd)), key=lambda some: sum(part.planned for part in some))
        ratio = sum(part.run for part in several) / sum(part.planned for part in several)
        start, end = several[0].span[0], several[-1].span[1]
        figures["times_longer_of_a_part"] = round(ratio, 4)
        text = f"the run was {_slower(ratio)} from {start:.3g} to {end:.3g} s of the plan, and as fast as planned "
        return [_Said(f"{text}elsewhere: the override was changed meanwhile, or feeds of the program were")]
    if abs(longer - 1.0) <= SLOWER:
        return []
    overrides = sorted(100.0 / ratio for ratio in (longer, longer if pace is None else pace))
    figures["override_percent"] = [round(percent, 1) for percent in overrides]
    one = overrides[1] - overrides[0] <= EVEN * overrides[0]
    override = f"override {100.0 / longer:.0f} %" if one else "override {:.0f} to {:.0f} %".format(*overrides)
    total = comparison.plan.motion.duration
    text = f"the run was {_slower(longer)} (about {longer * total:.3g} s in place of {total:.3g} s)"
    if pace is None and abs(longer - 1.0) <= OF_A_LAW:  # not by one factor, and not by much
        return [
            _Said(f"{text}: the controller accelerates otherwise than planned, or the override was not 100 %", False)
        ]
    return [_Said(f"{text}: {override}, or a program written at that speed", abs(longer - 1.0) > ACT)]


def _slower(ratio: float) -> str:
    return f"{ratio:.2f} times slower than planned" if ratio > 1.0 else f"{1.0 / ratio:.2f} times faster than planned"


class _Part(NamedTuple):
    """A part of the plan, from one change of direction to the next, that was run."""

    span: tuple[float, float]  # start and end in the plan [s]
    planned: float  # time in motion [s]
    run: float  # the same in the run, if it stayed as long as planned [s]

    @property
    def ratio(self) -> float:
        """How many times slower it was run."""
        return self.run / self.planned


def _passed(comparison: PlanComparison) -> list[_Part]:
    """The parts of the plan that were run, or, of a motion that has none, parts of equal duration."""
    motion, pairs, raw = comparison.plan.motion, comparison.pairs, comparison.raw
    edges = motion.starts if isinstance(motion, Joined) else np.linspace(0.0, motion.duration, PARTS + 1)
    machine = machine_of(comparison.case)
    places, between = (
        machine.drives(motion.at(t).coordinates) / comparison.scale for t in (edges, (edges[:-1] + edges[1:]) / 2.0)
    )
    away_from = [np.linalg.norm(other - places[:-1], axis=1) for other in (places[1:], between)]
    groups = np.split(np.arange(len(edges)), 1 + np.flatnonzero(np.maximum(*away_from) > SAME_PLACE))  # stays
    when: list[tuple[int, float, float]] = []
    for number, group in enumerate(groups):
        at = (edges[group[0]] + edges[group[-1]]) / 2.0
        k = int(np.searchsorted(comparison.planned.t[pairs[:, 0]], at))
        if not 0 < k < len(pairs) or pairs[k, 0] - pairs[k - 1, 0] > FEWEST:
            continue
        before, behind = max(k - 2, 0), min(k + 1, len(pairs) - 1)
        start, stop = np.searchsorted(raw.t, comparison.run.t[pairs[[before, behind], 1]])
        away = np.linalg.norm(
            (raw.drives[start : stop + 1] - comparison.shift) / comparison.scale - places[group[0]], axis=1
        )
        if not len(away):
            continue
        there = np.flatnonzero(away <= away.min() + AT_AN_END * comparison.step)
        when.append((number, float(at), float((raw.t[start + there[0]] + raw.t[start + there[-1]]) / 2.0)))
    parts = []
    for (one, at, begin), (other, then, end) in pairwise(when):
        stay = _stay(edges, groups[one]) / 2.0 + _stay(edges, groups[other]) / 2.0
        if other == one + 1 and end - begin > stay and then - at > stay:
            parts.append(_Part((at, then), then - at - stay, end - begin - stay))
    return parts


def _stay(edges: Array, group: Indices) -> float:
    """Time between the first and the last end of a group [s]."""
    return float(edges[group[-1]] - edges[group[0]])


def _pace_where_fastest(comparison: PlanComparison) -> float | None:
    """How many times slower a run was where the plan is fastest; None where that differs from place to place."""
    pairs, planned, run = comparison.pairs, comparison.planned, comparison.run
    both = np.flatnonzero((np.diff(pairs, axis=0) == 1).all(axis=1))
    if len(both) < FEWEST:
        return None
    start = planned.t[pairs[both, 0]]
    of_plan, of_run = np.maximum(np.diff(planned.t)[pairs[both, 0]], 1e-9), np.diff(run.t)[pairs[both, 1]]
    # points are at equal distances: the shortest times are the fastest
    fast = of_plan <= np.quantile(of_plan, 1.0 - FASTEST)
    pace, where = (of_run / of_plan)[fast], start[fast]
    blocks = np.array_split(pace[np.argsort(where)], max(1, min(PARTS, len(pace) // 5)))
    paces = np.array([np.median(block) for block in blocks])
    low, high = np.quantile(paces, [0.1, 0.9])
    return float(np.median(pace)) if high - low <= EVEN * np.median(pace) else None
