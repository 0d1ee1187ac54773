"""What to know about a program that no limit says: where it begins and ends, and what it leaves switched on."""

from collections.abc import Iterator, Sequence

import numpy as np

from cases.schema import Case
from cases.units import DEG, MM
from identification.motion import Array
from postprocessors.proving.stretches import Still, Stretch, Timed, Untimed
from postprocessors.reading.words import Reading, Stand, Switch

AT_HOME = np.repeat([1e-5 * MM, 1e-6 * DEG], 3)  # the last decimal of a program
_WORDS = "XYZABC"


def remarks(reading: Reading, program: Sequence[Stretch], case: Case) -> tuple[str, ...]:
    """One sentence each.

    Args:
        reading: the program.
        program: the same as stretches.
        case: gives home.

    Raises:
        CaseError: the case has no machine.
    """
    return tuple(_remarks(reading, program, case))


def _remarks(reading: Reading, program: Sequence[Stretch], case: Case) -> Iterator[str]:
    home = case.need_machine("the check of a program")[0].home.vector
    moves = [part for part in program if not isinstance(part, Still)]
    if not moves:
        return
    first = moves[0]
    if isinstance(first, Untimed) and first.start is None:
        yield (
            f"line {first.line}: from wherever the machine stands its way is not known, and neither are struts, joints "
            "and boxes on it; keep it clear"
        )
        if away := _away(first.end, home):
            yield f"line {first.line}: the first move does not go home, {away}"
    elif isinstance(reading.events[0], Stand):
        yield "the machine must stand at home when it starts"
    if away := _away(_end_of(moves[-1]), home):
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


def _away(pose: Array, home: Array) -> str:
    off = np.abs(pose - home)
    if np.all(off <= AT_HOME):
        return ""
    k = int(np.argmax(off / AT_HOME))
    unit, name = (MM, "mm") if k < 3 else (DEG, "deg")
    return f"where {_WORDS[k]} is {home[k] / unit:g} {name}, but to {pose[k] / unit:g} {name}"
