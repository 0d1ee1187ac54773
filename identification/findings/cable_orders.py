"""The orders that cables get into, in words and with the remedy: exchanged pairs, shifts, and changed signs."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from cases.recording_format import STRUTS
from cases.schema import Case


class Order(NamedTuple):
    """An order of six columns: what was recorded as column `places[k]` belongs to k, with a sign."""

    places: tuple[int, ...]
    signs: tuple[int, ...] = (1,) * 6

    @property
    def mistakes(self) -> int:
        """Number of columns that are exchanged or have the other sign."""
        return sum(place != k or sign < 0 for k, (place, sign) in enumerate(zip(self.places, self.signs, strict=True)))

    def words(self, what: str) -> str:
        """What is wrong where this order is the right one; `what` are struts or force channels."""
        negative = [k + 1 for k, sign in enumerate(self.signs) if sign < 0]
        if len(negative) == 6:
            return f"the signs of all {what} are turned"
        if len(negative) == 1:
            return f"the sign of {what[:-1]} {negative[0]} is turned"
        if negative:
            return f"the signs of {what} {', '.join(map(str, negative))} are turned"
        if self.places == tuple(range(5, -1, -1)):
            return f"{what} are in reverse order"
        exchanges = [k for k, place in enumerate(self.places) if place != k]
        if all(self.places[self.places[k]] == k for k in exchanges):
            pairs = [f"{k + 1} and {self.places[k] + 1}" for k in exchanges if k < self.places[k]]
            return f"{what} {', '.join(pairs)} are exchanged"
        return f"{what} are shifted by {self.places[0]} place{'s' * (self.places[0] > 1)}"


STRAIGHT = Order(tuple(range(6)))


def orders_of(turned: bool) -> Iterator[Order]:
    """Exchanged pairs, up to three at once, shifts, and signs where they may be `turned`."""
    yield from (Order(places) for places in _exchanges(STRAIGHT.places) if places != STRAIGHT.places)
    for shift in (1, 2, 4, 5):  # a shift by 3 exchanges pairs
        yield Order(tuple((k + shift) % 6 for k in range(6)))
    if turned:
        yield from (Order(STRAIGHT.places, signs) for signs in product((1, -1), repeat=6) if -1 in signs)


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
    if any(sign < 0 for sign in order.signs):
        if side == "strut":
            return "turn these entries of recording.drives.sign in the case"
        if case.sensor_frame.bars is not None:
            return "exchange both ends of these bars in sensor_frame.bars, or turn the signs in the recorder"
        if case.sensor_frame.transducer is not None and not any(sign > 0 for sign in order.signs):
            return "set the other sensor_frame.transducer.sense, or turn the signs in the recorder"
        return "turn the signs in the recorder"
    if side == "strut" and case.recording.drives is not None:
        numbers = [case.recording.drives.order[place] for place in order.places]
        return f"write recording.drives.order = {numbers}"
    names = STRUTS if side == "strut" else case.sensor_frame.channels
    theirs = [case.recording.file_name(names[place]) for place in order.places]
    entries = [
        f'{ours} = "{name}"' for k, (ours, name) in enumerate(zip(names, theirs, strict=True)) if order.places[k] != k
    ]
    return f"write in [recording.columns]: {', '.join(entries)}"
