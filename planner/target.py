"""The shortest motion whose predicted standard deviations meet given targets."""

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cases.errors import HexciteError, InfeasiblePlan
from cases.schema import Case
from identification.model import identification_model
from identification.parameters import physical_form
from planner.plan import Plan
from planner.request import LONGEST, Request

UNITS = {
    "kg": ("kg", 1.0),
    "g": ("kg", 1e-3),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "kgm2": ("kg m^2", 1.0),
    "N": ("N", 1.0),
    "N/m": ("N/m", 1.0),
    "Nm/m": ("N m/m", 1.0),
    "Nm": ("N m", 1.0),
}
NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
ROUNDS = 4  # of shortening: each lands within a few percent of what the information rate promises
RESERVE = 1.03  # shorter motions carry a little less information a second: turning round at the ends takes its time
WORTHWHILE = 0.97  # share of the duration below which another plan is worth its time
SHORTEST = 2.0  # [s]


class Target(NamedTuple):
    """A standard deviation that shall not be exceeded.

    Args:
        name: of the physical parameter.
        std: [SI].
        text: as the user wrote it.
        unit: in which the user wrote it.
    """

    name: str
    std: float
    text: str
    unit: str


def parse_targets(words: tuple[str, ...], case: Case, model: int) -> tuple[Target, ...]:
    """Targets such as m=0.05kg or zC=0.3mm.

    Raises:
        HexciteError: not of this form, an unknown parameter, or a unit that is not the parameter's.
    """
    known = {p.name: p.unit for p in physical_form(identification_model(case, model)).parameters}
    targets = []
    for word in words:
        match = re.fullmatch(rf"(\w+)=({NUMBER}) *([A-Za-z][A-Za-z0-9/^ ]*)", word.strip())
        if match is None:
            raise HexciteError(f"target {word!r} is not of the form m=0.05kg; name, number and unit")
        name, number, unit = match[1], match[2], match[3].replace("^", "").replace(" ", "")
        if name not in known:
            raise HexciteError(f"target {word!r}: model {model} has no {name}; choose {', '.join(known)}")
        if unit not in UNITS or UNITS[unit][0] != known[name]:
            units = ", ".join(u for u, (base, _) in UNITS.items() if base == known[name])
            raise HexciteError(f"target {word!r}: {name} is not measured in {match[3]}; choose {units}")
        std = float(number) * UNITS[unit][1]
        if not (np.isfinite(std) and std > 0.0):
            raise HexciteError(f"target {word!r}: {number} is no positive number")
        targets.append(Target(name, std, word, unit))
    return tuple(targets)


def shortest_plan(request: Request, case: Case, make: Callable[[Request], Plan]) -> Plan:
    """Plans at the request's duration, the longest allowed, then shorter ones as long as the targets are met.

    Every plan is optimal by the request's criterion for its duration; the shortest of these that meets the targets need
    not be the shortest of all motions.

    Raises:
        HexciteError: a target that cannot be read.
        InfeasiblePlan: a target is not met; the message says what is reached, and about how long would do.
    """
    targets = parse_targets(request.targets, case, request.model)

    def use(plan: Plan) -> tuple[float, Target]:
        """The largest share of a target that a plan needs, and which."""
        return max((plan.predicted_std[t.name] / t.std, t) for t in targets)

    best = make(request)
    needed, target = use(best)
    if needed > 1.0:
        reached = best.predicted_std[target.name] / UNITS[target.unit][1]
        longer = request.allowed_duration(float(np.ceil(request.duration * needed**2 * RESERVE)))
        remedy = f"allow --duration {longer:g} or a wider target"
        if longer > LONGEST:
            remedy = f"even the longest motion, {LONGEST:g} s, would not do: set a wider target"
        raise InfeasiblePlan(
            f"target {target.text} is out of reach in {request.duration:g} s: the best found has "
            f"{reached:.3g} {target.unit}; {remedy}"
        )
    too_short = SHORTEST / 2
    for _ in range(ROUNDS):
        duration = max(best.motion.duration * use(best)[0] ** 2 * RESERVE, SHORTEST)
        if duration <= too_short:
            duration = (too_short + best.motion.duration) / 2
        duration = request.allowed_duration(duration)
        if duration > WORTHWHILE * best.motion.duration or best.interrupted:
            break
        trial = make(request.lasting(duration))
        if use(trial)[0] <= 1.0:
            best = trial
        else:
            too_short = duration
    return best
