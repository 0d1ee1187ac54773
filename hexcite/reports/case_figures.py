"""What `hexcite case check` reports beyond "valid": whether home can be, its reach, and values that are suspicious.

Such values come from another machine, or are in mistaken units.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from cases.base.errors import CaseError, Code
from cases.base.phrases import NOTHING, Phrase, enumerated, phrase, said
from cases.basis import values
from cases.schema import Case, load_case
from cases.tables import built_in_cases
from identification.limits.limit import LimitKind
from identification.limits.proof import prove
from identification.motion.motion import StandingPoses
from planner.box.reach import Reach
from planner.search.feasibility import remedy, remedy_at_rest


def case_figures(case: Case, file: str) -> dict[str, Any]:
    """Name, title, setup and hash; raises CaseError, with the case's file, where home is out of reach."""
    if has_motion_box(case):
        home, _ = case.need_motion("the check of its reach")
        at_home = prove(StandingPoses(np.array([home, home])), case, 1.0)
        if at_home.violations:
            broken = at_home.violations[0]
            key = "machine.home" if case.chain is None else "machine.chain.joints"
            if case.chain is None:
                way = phrase("move_home_or", "move home or {other}", other=said(remedy(broken, case)))
            elif broken.kind is LimitKind.DISTANCE_BETWEEN_LINKS:
                way = phrase(
                    "home_or_bodies", "choose another home, or make one of the two bodies smaller, or leave it out"
                )
            elif broken.kind in (LimitKind.JOINT_TORQUE, LimitKind.JOINT_FORCE):
                way = phrase(
                    "or_other_home", "{other} or choose another home", other=said(remedy_at_rest(broken, case))
                )
            else:
                way = phrase("other_home", "choose another home")
            hints = [phrase("look_at", "look at {doubt}", doubt=doubt) for doubt in case.doubts]
            raise CaseError(
                file=file,
                key=key,
                problem=phrase("home_cannot_be", "home cannot be: {why}", why=said(broken.sentence(timed=False))),
                remedy=enumerated("semicolon", [way, *hints]),
                code=Code.INFEASIBLE,
            )
    return {"name": case.name, "title": case.title, "setup": case.setup, "hash": case.hash}


def has_motion_box(case: Case) -> bool:
    """Whether the case describes a machine and the box in which it moves."""
    if case.limits is None:
        return False
    return case.chain is not None or (case.hexapod is not None and case.workspace is not None)


def share_sentences(reach: Reach) -> str:
    """The reachable share of the box's volume, and the limits that the rest exceeds, in a line."""
    worst = reach.worst.sentence(timed=False)
    if reach.whole:
        return (
            f"The whole motion box is reachable, by {reach.poses} random poses, corners and middles; closest to a "
            f"limit: {worst}."
        )
    exceeded = sorted(reach.exceeded.items(), key=lambda item: -item[1])
    kinds = ", ".join(f"{kind} in {100 * share:.2g} %" for kind, share in exceeded) or "none by a random pose"
    return (
        f"Of the motion box's volume {100 * reach.share:.3g} % is reachable (of {reach.poses} random poses, standard "
        f"error {100 * reach.share_std:.2g} %; farthest out, corners and middles included: {worst}). Exceeded "
        f"limits: {kinds}."
    )


_TABLES = (
    "machine", "workspace", "limits", "poses", "sensor_frame", "sensors", "recording", "nominal", "simulation",
    "payloads", "controller", "controller.linuxcnc", "controller.sinumerik", "controller.twincat",
    "controller.setpoints", "controller.urscript", "controller.ros2",
)  # fmt: skip


def leftovers(case: Case) -> tuple[Phrase, ...]:
    """Sentences about values that the user should look at, each with its key."""
    if case.name in built_in_cases() and case == load_case(case.name):
        return ()
    return (*_of_the_template(case), *case.remarks)


def _of_the_template(case: Case) -> Iterator[Phrase]:
    """Sentences on values that are still those of the built-in case that a case was begun from, key by key."""
    template = case.template or _likely_template(case)
    if template is None:
        return
    values_of_case, other = (_by_table(values(of, _TABLES)) for of in (case, load_case(template)))
    whole, keys = list[str](), list[str]()
    for table, leaves in sorted(values_of_case.items(), key=lambda item: _TABLES.index(item[0])):
        same = [f"{table}.{key}" for key, value in leaves.items() if other.get(table, {}).get(key) == value]
        if len(same) == len(leaves):
            whole.append(table)
        else:
            keys += [key for key in same if not _is_zero(leaves[key.removeprefix(f"{table}.")])]  # as many are
    done = (
        phrase(
            "delete_template", '; once all values are yours, delete the line template = "{template}"', template=template
        )
        if case.template
        else NOTHING
    )
    if whole:
        yield phrase(
            "tables_of_template",
            "{tables}: still the values of the built-in case {template}; replace them by your machine's, or delete "
            "tables that it does not need{done}",
            tables=", ".join(whole),
            template=template,
            done=done,
        )
    if keys:
        yield phrase(
            "keys_of_template",
            "{keys}: still the values of the built-in case {template}; replace them by your machine's{done}",
            keys=", ".join(keys),
            template=template,
            done=done,
        )


def _is_zero(value: Any) -> bool:
    return not any(value) if isinstance(value, list) else value == 0.0


def _likely_template(case: Case) -> str | None:
    """The built-in case of which a case has the most whole tables; None where it has none."""
    tables = {
        name: table for name in _TABLES if len(table := values(case, [name])) > 2
    }  # two values may well be the same
    whole = {
        other: sum(len(table) for name, table in tables.items() if table == values(load_case(other), [name]))
        for other in built_in_cases()
        if other != case.name
    }
    likely = max(whole, key=lambda other: whole[other])
    return likely if whole[likely] else None


def _by_table(leaves: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Values by the table that they stand in, the innermost of `_TABLES`."""
    tables: dict[str, dict[str, Any]] = {}
    for key, value in leaves.items():
        table = max((t for t in _TABLES if key.startswith(f"{t}.")), key=len)
        tables.setdefault(table, {})[key.removeprefix(f"{table}.")] = value
    return tables
