"""The orders that cables get into, in words and with the remedy: exchanged pairs, shifts, and changed signs."""

from collections.abc import Iterator, Sequence
from itertools import product

from cases.recording_format import STRUTS
from cases.schema import Case

Order = tuple[tuple[int, int], ...]
"""For each of six columns the place in which it was recorded, counted from 0, and its sign there, 1 or -1."""

STRAIGHT: Order = tuple((k, 1) for k in range(6))


def mistakes(order: Order) -> int:
    """Number of columns that are exchanged or have the other sign."""
    return sum(entry != straight for entry, straight in zip(order, STRAIGHT, strict=True))


def words(order: Order, what: str) -> str:
    """What is wrong where an order is the right one; `what` are struts or force channels."""
    negative = [k + 1 for k, (_, sign) in enumerate(order) if sign < 0]
    if len(negative) == 6:
        return f"the signs of all {what} are turned"
    if len(negative) == 1:
        return f"the sign of {what[:-1]} {negative[0]} is turned"
    if negative:
        return f"the signs of {what} {', '.join(map(str, negative))} are turned"
    places = [place for place, _ in order]
    if places == [5, 4, 3, 2, 1, 0]:
        return f"{what} are in reverse order"
    exchanges = [k for k, place in enumerate(places) if place != k]
    if all(places[places[k]] == k for k in exchanges):
        pairs = [f"{k + 1} and {places[k] + 1}" for k in exchanges if k < places[k]]
        return f"{what} {', '.join(pairs)} are exchanged"
    return f"{what} are shifted by {places[0]} place{'s' * (places[0] > 1)}"


def orders_of(turned: bool) -> Iterator[Order]:
    """Exchanged pairs, up to three at once, shifts, and signs where they may be `turned`."""
    exchanged = (tuple((place, 1) for place in places) for places in _exchanges(range(6)))
    yield from (order for order in exchanged if order != STRAIGHT)
    for shift in (1, 2, 4, 5):  # a shift by 3 exchanges pairs
        yield STRAIGHT[shift:] + STRAIGHT[:shift]
    if turned:
        yield from (tuple(enumerate(signs)) for signs in product((1, -1), repeat=6) if -1 in signs)


def _exchanges(free: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Orders of six that exchange disjoint pairs of `free` and leave the rest in place."""
    if not free:
        yield tuple(range(6))
        return
    first, *rest = free
    yield from _exchanges(rest)
    for other in rest:
        for order in _exchanges([k for k in rest if k != other]):
            places = list(order)
            places[first], places[other] = other, first
            yield tuple(places)


SIDES = {"force": "force channels", "strut": "struts"}


def remedy(case: Case, side: str, order: Order) -> str:
    """What to write into the case where this order of a side is the right one."""
    if any(sign < 0 for _, sign in order):
        if side == "strut":
            return "turn these entries of recording.drives.sign in the case"
        if case.sensor_frame.bars is not None:
            return "exchange both ends of these bars in sensor_frame.bars, or turn the signs in the recorder"
        if case.sensor_frame.transducer is not None and not any(sign > 0 for _, sign in order):
            return "set the other sensor_frame.transducer.sense, or turn the signs in the recorder"
        return "turn the signs in the recorder"
    if side == "strut" and case.recording.drives is not None:
        numbers = [case.recording.drives.order[place] for place, _ in order]
        return f"write recording.drives.order = {numbers}"
    names = STRUTS if side == "strut" else case.sensor_frame.channels
    entries = [
        f'{names[k]} = "{case.recording.file_name(names[place])}"' for k, (place, _) in enumerate(order) if place != k
    ]
    return f"write in [recording.columns]: {', '.join(entries)}"
