"""The order of poses that travels fastest: from home through all of them and back home.

A travelling salesman's tour by nearest neighbours from several first poses, improved by reversing stretches (2-opt,
Croes 1958) and moving short stretches elsewhere (Or 1976) until neither helps: good, and not proven to be the best.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

STARTS = 12  # first poses that are tried
FEW_STARTS, MANY = 1, 100  # of more poses than that, for their tours take long to improve
LONGEST_STRETCH = 3
GAIN = 1e-9  # [s] below, rounding would turn tours in circles


def shortest_order(times: Array) -> Index:
    """Order of visit, starting and ending with 0 (home), shape (n + 1,).

    Args:
        times: symmetric, row and column 0 are home, shape (n, n), n >= 2 [s]; infinite where there is no way.
    """
    finite = np.where(np.isfinite(times), times, 1e6)
    count = len(times)
    starts = STARTS if count <= MANY else FEW_STARTS
    firsts = np.argsort(finite[0, 1:])[:: max(1, (count - 1) // starts)][:starts] + 1
    tours = [_improved(_nearest(finite, int(first)), finite) for first in firsts]
    best = min(tours, key=lambda tour: (duration(tour, finite), tuple(tour)))
    return np.array(best)


def duration(order: Index | list[int], times: Array) -> float:
    """Time of travel in an order [s], by the times between places, shape (n, n) [s]."""
    way = np.asarray(order)
    return float(times[way[:-1], way[1:]].sum())


def _nearest(times: Array, first: int) -> list[int]:
    tour, left = [0, first], set(range(1, len(times))) - {first}
    while left:
        following = min(left, key=lambda k: (times[tour[-1], k], k))
        tour.append(following)
        left.remove(following)
    return [*tour, 0]


def _improved(tour: list[int], times: Array) -> list[int]:
    way = np.array(tour)
    while True:
        changed = _reversed(way, times)
        if changed is None:
            changed = _moved(way, times)
        if changed is None:
            return [int(k) for k in way]
        way = changed


def _reversed(way: Index, times: Array) -> Index | None:
    """The best reversal of a stretch i+1 .. j; None where none helps."""
    a, b = way[:-1], way[1:]
    along = times[a, b]
    gain = along[:, None] + along[None, :] - times[np.ix_(a, a)] - times[np.ix_(b, b)]
    gain = np.triu(gain, 2)
    i, j = np.unravel_index(int(np.argmax(gain)), gain.shape)
    if gain[i, j] <= GAIN:
        return None
    return np.concatenate([way[: i + 1], way[i + 1 : j + 1][::-1], way[j + 1 :]])


def _moved(way: Index, times: Array) -> Index | None:
    """The best move of a stretch of up to three poses to another place, either way round; None where none helps."""
    best, found = GAIN, None
    for length in range(1, min(LONGEST_STRETCH, len(way) - 2) + 1):
        for i in range(1, len(way) - length):
            stretch = way[i : i + length]
            rest = np.concatenate([way[:i], way[i + length :]])
            freed = times[way[i - 1], stretch[0]] + times[stretch[-1], way[i + length]]
            freed -= times[way[i - 1], way[i + length]]
            for piece in (stretch, stretch[::-1]):
                cost = times[rest[:-1], piece[0]] + times[piece[-1], rest[1:]] - times[rest[:-1], rest[1:]]
                place = int(np.argmin(cost))
                if freed - cost[place] > best:
                    best = float(freed - cost[place])
                    found = np.concatenate([rest[: place + 1], piece, rest[place + 1 :]])
    return found
