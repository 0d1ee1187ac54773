"""Data as cases, plans and results hold them, with entries lost, doubled, exchanged or of another kind."""

import copy
import random
from typing import Any

Place = tuple[str | int, ...]
ODD = [None, True, "", "x", "\u00e9", [], {}, 0, -1, 1, 10**6, 1e-12, 1e308, -1e308, float("nan"), float("inf"), [1, 2]]


def places(data: Any, path: Place = ()) -> list[Place]:
    """All entries below some data."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [found for key, value in items for found in ((*path, key), *places(value, (*path, key)))]


def damaged(data: dict[str, Any], draw: random.Random) -> dict[str, Any]:
    """A copy with one entry damaged."""
    data = copy.deepcopy(data)
    place = draw.choice(places(data))
    holder: Any = data
    for key in place[:-1]:
        holder = holder[key]
    key, value = place[-1], holder[place[-1]]
    match draw.randrange(6):
        case 0:
            del holder[key]
        case 1:
            holder[key] = draw.choice(ODD)
        case 2 if isinstance(holder, dict):
            holder[draw.choice([f"{key}_", str(key).upper(), "extra"])] = value
        case 2:
            holder.append(value)
        case 3 if isinstance(value, int | float) and not isinstance(value, bool):
            holder[key] = value * draw.choice([-1, 0, 10, 1e3, 1e-3, 1.001, 3.14159])
        case 4 if isinstance(value, list) and len(value) > 1:
            draw.shuffle(value)
        case 5 if isinstance(holder, dict):
            other = draw.choice(list(holder))
            holder[key], holder[other] = holder[other], holder[key]
        case _:
            holder[key] = [value] if draw.random() < 0.5 else str(value)
    return data
