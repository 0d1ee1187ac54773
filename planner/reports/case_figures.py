"""What `hexcite case check` reports beyond "valid": whether home can be, its reach, and values that are suspicious.

Such values come from another machine, or are in mistaken units.
"""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from cases.basis import values
from cases.errors import CaseError
from cases.schema import Case, load_case
from cases.tables import built_in_cases
from identification.limit_proof import prove
from identification.motion import StandingPoses
from identification.precision import share_text
from planner.reach import Reach
from planner.search.feasibility import remedy


def case_figures(case: Case, file: str) -> dict[str, Any]:
    """Name, title, setup and hash; raises CaseError, with the case's file, where home is out of reach."""
    if has_motion_box(case):
        home, _ = case.need_motion("the check of its reach")
        at_home = prove(StandingPoses(np.array([home, home])), case, 1.0)
        if at_home.violations:
            broken = at_home.violations[0]
            hint = "".join(f"; look at {words}" for words in mistaken_units(case))
            key = "machine.home" if case.chain is None else "machine.chain.joints"
            way = f"move home or {remedy(broken, case)}" if case.chain is None else "choose another home"
            raise CaseError(file, key, f"home cannot be: {broken.sentence(timed=False)}; {way}{hint}")
    return {"name": case.name, "title": case.title, "setup": case.setup, "hash": case.hash}


def has_motion_box(case: Case) -> bool:
    """Whether the case describes a machine and the box in which it moves."""
    if case.limits is None:
        return False
    return case.chain is not None or (case.hexapod is not None and case.workspace is not None)


def share_sentences(reach: Reach) -> str:
    """The reachable share of the box's volume, and the limits that the rest exceeds, in a line."""
    worst = f"the worst uses {share_text(reach.worst)} of the limit {reach.worst_limit}"
    if reach.whole:
        return f"The whole motion box is reachable: of {reach.poses} random poses, corners and middles, {worst}."
    exceeded = sorted(reach.exceeded.items(), key=lambda item: -item[1])
    kinds = ", ".join(f"{kind} in {100 * share:.2g} %" for kind, share in exceeded) or "none by a random pose"
    return (
        f"Of the motion box's volume {100 * reach.share:.3g} % is reachable (of {reach.poses} random poses, standard "
        f"error {100 * reach.share_std:.2g} %; with corners and middles {worst}). Exceeded limits: {kinds}."
    )


_TABLES = (
    "machine", "workspace", "limits", "poses", "sensor_frame", "nominal", "simulation", "payloads",
    "controller.sinumerik", "controller.twincat", "controller.setpoints",
)  # fmt: skip


def leftovers(case: Case) -> tuple[str, ...]:
    """Sentences about values that the user should look at, each with its key."""
    if case.name in built_in_cases() and case == load_case(case.name):
        return ()
    return (*_of_other_machines(case), *_of_single_values(case), *mistaken_units(case))


def _of_other_machines(case: Case) -> Iterator[str]:
    """Sentences on tables that equal those of a built-in case, each named once, with the case that has most of them."""
    own = {name: table for name in _TABLES if len(table := values(case, [name])) > 2}  # two values may well be the same
    same = {
        other: [name for name, table in own.items() if table == values(load_case(other), [name])]
        for other in built_in_cases()
        if other != case.name
    }
    previous: set[str] = set()
    for name, tables in sorted(same.items(), key=lambda item: -len(item[1])):
        if names := [table for table in tables if table not in previous]:
            previous |= set(names)
            yield (
                f"{', '.join(names)}: still the values of the built-in case {name}; replace them by your machine's, or "
                "delete tables that it does not need"
            )


def _of_single_values(case: Case) -> Iterator[str]:
    """Sentences on limits and gravity that are hardly meant."""
    joints = () if case.chain is None else case.chain.joints
    without = [joint.name for joint in joints if joint.link is None]
    if without and any(joint.torque_Nm or joint.force_N for joint in joints):
        yield (
            f"machine.chain.joints: torque_Nm and force_N limit nothing, for the link of {', '.join(without)} is not "
            "stated; add its mass, centre of gravity and inertia"
        )
    if case.gravity[2] > 0.0:
        yield (
            f"gravity_m_s2 = {list(case.gravity_m_s2)} points along +z of {{B}}; gravity points down: change its sign, "
            "unless the machine hangs"
        )


_RADIANS, _METRES = "look like radians, give degrees", "look like metres, give millimetres"
_MISTAKEN = (  # keys, the largest value that is taken for a mistake, and what it looks like
    (r"workspace\.\w+_joint_angle_deg|.*\.ring\.half_angle_deg|limits\.motion\.angular_velocity_deg_s", 1.6, _RADIANS),
    (r"limits\.motion\.[abc]_deg", 0.9, _RADIANS),
    (r".*\.strut_length_mm|machine\.home\.z_mm|.*\.ring\.radius_mm|.*\.points_mm", 5.0, _METRES),
)


def mistaken_units(case: Case) -> Iterator[str]:
    """Sentences on angles that look like radians and lengths that look like metres."""
    for key, value in values(case, ("machine", "sensor_frame", "workspace", "limits")).items():
        for pattern, most, words in _MISTAKEN:
            if re.fullmatch(pattern, key) and 0.0 < (largest := float(np.abs(value).max())) <= most:
                yield f"{key}: values up to {largest:g} {words}"
