"""Where a program comes from: fingerprints of plan, case and controller settings are in its header.

That of the plan goes on into the recording.
"""

import re

from cases.basis import motion_hash
from cases.schema import Case
from planner.plan import Plan
from planner.plan_folder import DIGITS, fingerprint

_IN_PROGRAM = re.compile(rb"plan hash ([0-9a-f]{%d})" % DIGITS)
_OF_THE_CASE = re.compile(rb"case (\w+), hash ([0-9a-f]{%d}), controller settings ([0-9a-f]{%d})" % (DIGITS, DIGITS))


def plan_line(plan: Plan) -> str:
    """What a program says of its plan."""
    return f"plan hash {fingerprint(plan)}"


def plan_of_program(content: bytes) -> str | None:
    """The fingerprint in a program; None where it names none, or several."""
    found = set(_IN_PROGRAM.findall(content))
    return found.pop().decode() if len(found) == 1 else None


def case_line(case: Case) -> str:
    """What a program says of its case."""
    return f"case {case.name}, hash {motion_hash(case)}, controller settings {case.controller_hash}"


def written_for_another(content: bytes, case: Case) -> str | None:
    """What to know about a program whose header names another state of the case; None where it names this or none."""
    found = set(_OF_THE_CASE.findall(content))
    if len(found) != 1:
        return None
    name, machine, settings = (part.decode() for part in found.pop())
    if name != case.name:
        return f"written for another case, {name}; this is {case.name}"
    if machine != motion_hash(case):
        return f"written for {case.name} with other values in [machine], [workspace] or [limits] than it has now"
    if settings != case.controller_hash:
        return (
            f"written with other settings of [controller] (its header says {settings}, now they are "
            f"{case.controller_hash}): signs and words may mean something else"
        )
    return None
