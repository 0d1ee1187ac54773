"""Places of values in files of tables."""

import re
from collections.abc import Iterable

from cases.base.phrases import Phrase

Place = tuple[str | int, ...]
"""Keys, and numbers in lists from 0, from the top of a file to a value."""


def place_of(key: str) -> Place:
    """The place of a dotted key whose lists are counted from 1.

    >>> place_of("limits.motion.joints[2].velocity_deg_s")
    ('limits', 'motion', 'joints', 1, 'velocity_deg_s')
    """
    return tuple(int(part) - 1 if part.isdigit() else part for part in re.findall(r"\w+", key))


def placed(place: Iterable[str | int]) -> str:
    """A place as messages and options name it, entries of lists counted from 1: machine.chain.joints[2].name."""
    text = ""
    for part in place:
        text += f"[{part + 1}]" if isinstance(part, int) else f".{part}" if text else part
    return text


def places_of(sentence: Phrase) -> tuple[Place, ...]:
    """Places of the values that a sentence is about; several keys of one sum one by one.

    >>> places_of(phrase("no_common_length", "have no length in common").about("limits.x_mm, y_mm"))
    (('limits', 'x_mm'), ('limits', 'y_mm'))
    """
    apart = list[str]()
    for key in sentence.keys:
        first, *others = key.split(", ")
        table = first.rpartition(".")[0]
        apart += [first, *(f"{table}.{other}" for other in others)]
    return tuple(map(place_of, apart))
