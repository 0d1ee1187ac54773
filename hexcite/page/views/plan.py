"""The stage Plan: what was planned, and what is predicted of it."""

import math
import re
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from markupsafe import Markup

from cases.base.errors import HexciteError
from cases.schema import load_case
from hexcite.page.actions.common import Context
from hexcite.page.forms import BY_HAND, EFFORTS, FAMILIES
from hexcite.page.stages import Made, Workspace, workspace
from hexcite.page.views.common import Query, best_alike, chosen_plan, limits, unit_shown
from hexcite.page.words import Words
from hexcite.reports.page import script_json
from identification.texts import legible, std_text


def shown(context: Context, there: Workspace, query: Query) -> dict[str, Any]:
    """What the stage Plan shows of a machine, for its template."""
    plan = chosen_plan(there.plans, query.get("plan"))
    others = [p for p in there.plans if plan is not None and p.name != plan.name and p.fresh]
    others = sorted(others, key=lambda other: not other.by_hand)[:2]
    by_hand = context.jobs.latest(context.machine.key, "plan", BY_HAND)
    return {
        "lacks": context.machine.lacks("plan"),
        "families": FAMILIES,
        "efforts": tuple(EFFORTS),
        "known": [result.name for result in there.results if result.fresh],
        "kinds": _kinds(there.plans, plan),
        "by_hand": "" if by_hand is None or by_hand.state == "done" else " ".join(by_hand.messages[-1:]),
        "by_hand_runs": by_hand is not None and not by_hand.over,
        "dialects": context.machine.dialects,
        "chosen": plan,
        "facts": None if plan is None else _facts(plan),
        "better": None if plan is None else _better(there.plans, plan),
        "notes": [] if plan is None else _sentences(context.words, plan, "notes"),
        "weaknesses": [] if plan is None else _sentences(context.words, plan, "weaknesses"),
        "plans": [(p, _facts(p)) for p in there.plans],
        "predicted": None if plan is None else _predicted(context, [plan, *others]),
        "limits": limits(context.words, plan.record.get("limits", {})) if plan is not None else [],
    }


def _facts(plan: Made) -> dict[str, Any]:
    record = plan.record
    efficiency = record.get("d_efficiency")
    return {
        "family": record.get("family", ""),
        "seconds": f"{record['duration_s']:.3g}" if isinstance(record.get("duration_s"), int | float) else "",
        "efficiency": f"{efficiency:.3f}" if isinstance(efficiency, float) else "",
        "made_for": str((record.get("settings") or {}).get("made_for") or ""),
        "interrupted": bool(record.get("interrupted")),
        "mass": f"{_deviation('kg', record.get('predicted_std', {}).get('m'))} {legible('kg')[1]}",
    }


def _better(plans: Sequence[Made], plan: Made) -> tuple[str, str] | None:
    """Name and information of a plan that was asked for alike and tells more; None where there is none."""
    best = best_alike(plans, plan)
    return None if best is plan else (best.name, _facts(best)["efficiency"])


MOST_SENTENCES = 6  # that a reader takes in


def _sentences(words: Words, plan: Made, name: str) -> list[Markup]:
    """Sentences of a plan, by their codes."""
    return words.clauses(plan.record.get(name), plan.record.get(f"{name}_phrases"))[:MOST_SENTENCES]


def _kinds(plans: Sequence[Made], plan: Made | None) -> list[tuple[str, str]]:
    """Kinds of motion, each with the share of the information that the best plan or the latest trial of it has."""
    efficiencies = {} if plan is None else plan.record.get("tried") or {}
    rows = []
    for family in FAMILIES[1:]:
        reached = [p.record.get("d_efficiency") for p in plans if p.fresh and p.record.get("family") == family]
        shares = [float(share) for share in (*reached, efficiencies.get(family)) if isinstance(share, float)]
        rows.append((family, f"{max(shares):.3f}" if shares else ""))
    return rows


OFFSET = "f_q0_"  # of a parameter, with the number of its channel behind
_UNITS = (
    ("m", "kg"), ("[xyz]C", "m"), ("IC..|k", "kg m^2"), ("[dh]", "kg m"), ("k0|K1_.*", "N/m"), ("k1", "N m/m"),
    ("k2|K4_.*", "N"), ("k3", "N m"), ("K3_.*", "N s^2/m"),
)  # fmt: skip
"""Names of physical parameters, and their SI units: the model would say them, but takes long to be built."""


def _unit(name: str, moments: bool = False) -> str:
    """The SI unit of a physical parameter, by its letters; `moments`: whether channels 4 to 6 are moments."""
    if name.startswith(OFFSET):
        return "N m" if moments and int(name.removeprefix(OFFSET)) > 3 else "N"
    return next((unit for names, unit in _UNITS if re.fullmatch(names, name)), "")


def _deviation(unit: str, value: object) -> str:
    if not isinstance(value, int | float) or not math.isfinite(value):
        return "–"
    return std_text(value * legible(unit)[0])


def _predicted(context: Context, plans: Sequence[Made]) -> dict[str, Any]:
    """Predicted deviations of plans side by side, a row a parameter."""
    case = context.machine.case
    moments = case is not None and case.sensor_frame.has_moments
    stds = [plan.record.get("predicted_std") or {} for plan in plans]
    names = list(dict.fromkeys(name for std in stds for name in std))
    units = {name: _unit(name, moments) for name in names}
    rows = []
    for name, unit in units.items():
        known = [float(std[name]) if isinstance(std.get(name), int | float) else math.inf for std in stds]
        least = min(known) if len(known) > 1 and max(known) > min(known) else -1.0
        cells = [(_deviation(unit, std.get(name)), own == least) for std, own in zip(stds, known, strict=True)]
        rows.append((context.words.parameter(name), unit_shown(unit)[1], cells))
    return {"heads": [plan.name for plan in plans], "rows": rows}


def scene(context: Context, name: str) -> str | None:
    """The machine along a plan as JSON, with how far each limit is used; None where there is no such plan."""
    folder = workspace(context.root, context.machine)
    plan = next((each for each in folder.plans if each.name == name), None)
    if plan is None or context.machine.case is None:
        return None
    machine = context.machine
    source = str(machine.file) if machine.own else machine.key
    return _scene(context.words, str(context.root / name), plan.fingerprint, source, context.machine.case.hash)


@lru_cache(8)
def _scene(words: Words, folder: str, fingerprint: str, source: str, case_hash: str) -> str | None:
    from hexcite.reports.plan import scene_of  # these two with what plans and fits, which the stage does without
    from planner.plans.plan import Plan

    try:
        case = load_case(source)
        entries = scene_of(Plan.load(folder, case, stale=True)).to_json()
        if entries.get("used"):
            names = [words.limit_of(name) for name in entries["used"]["names"]]
            entries["used"] = {**entries["used"], "names": names}
        return str(script_json(entries))
    except HexciteError:
        return None  # damaged: the command that uses it says so
