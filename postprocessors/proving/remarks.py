"""What to know about a program that no limit says: where it begins and ends, and what it leaves switched on."""

from collections.abc import Iterator, Sequence

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.limited import Box
from identification.motion import Array
from postprocessors.proving.stretches import Still, Stretch, Timed, Untimed
from postprocessors.reading.words import Reading, Stand, Switch

AT_HOME = 1e-5 * MM, 1e-6 * DEG  # the last decimal of a program


def remarks(reading: Reading, program: Sequence[Stretch], case: Case) -> tuple[str, ...]:
    """One sentence each.

    Raises:
        CaseError: the case has no machine.
    """
    return tuple(_remarks(reading, program, case))


def _remarks(reading: Reading, program: Sequence[Stretch], case: Case) -> Iterator[str]:
    home, limits = case.need_motion("the check of a program")
    moves = [part for part in program if not isinstance(part, Still)]
    if not moves:
        return
    first = moves[0]
    if isinstance(first, Untimed) and first.start is None:
        yield (
            f"line {first.line}: from wherever the machine stands its way is not known, and neither are struts, joints "
            "and boxes on it; keep it clear"
        )
        if away := _away(first.end, home, limits):
            yield f"line {first.line}: the first move does not go home, {away}"
    elif isinstance(reading.events[0], Stand):
        yield "the machine must stand at home when it starts"
    if away := _away(_end_of(moves[-1]), home, limits):
        yield f"it does not end at home, {away}"
    if reading.unsaid:
        yield (
            f"{', '.join(reading.unsaid)} missing before the first move: offsets that another program left would shift "
            "every pose"
        )
    switches = [event for event in reading.events if isinstance(event, Switch)]
    if not any(event.on for event in switches):
        yield "the trigger is never switched on: a recording would not know what to evaluate"
    elif switches[-1].on:
        yield f"line {switches[-1].line}: the trigger is never switched off again"


def _end_of(part: Timed | Untimed) -> Array:
    return part.end if isinstance(part, Untimed) else part.points.at([part.points.duration]).pose[0]


def _away(pose: Array, home: Array, limits: Box) -> str:
    off = np.abs(pose - home) / np.where(limits.turns, AT_HOME[1], AT_HOME[0])
    if np.all(off <= 1.0):
        return ""
    k = int(np.argmax(off))
    unit, name = (DEG, "deg") if limits.turns[k] else (MM, "mm")
    label = limits.labels[k].upper() if len(limits.labels[k]) == 1 else limits.labels[k]
    return f"where {label} is {home[k] / unit:g} {name}, but to {pose[k] / unit:g} {name}"
