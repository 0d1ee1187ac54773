"""Starts that come with hexcite: one good motion of each family, in units in which other machines can use it.

Good motions of different machines are alike: in half widths of their boxes (Fourier series, splines), in longest steps
(point-to-point). A search that begins from one ends higher than from random starts, and sooner; random starts follow.
`tests/bench/shipped_starts.py` has searched for them on the built-in hexapod.
"""

import json
from functools import cache
from pathlib import Path

import numpy as np

from cases.schema import Case
from identification.machine import machine_of
from planner.families.family import Array, Family

FILE = Path(__file__).with_name("shipped.json")


def shipped_start(family: Family, case: Case) -> Array | None:
    """Unknowns of a family from which a search begins, limits of the machine apart; None where nothing fits it."""
    if not machine_of(case).of_pose or family.shipped not in _shipped():
        return None
    return family.like(_shipped()[family.shipped])


@cache
def _shipped() -> dict[str, Array]:
    """Names of families -> their tables, shape (n, columns)."""
    tables = json.loads(FILE.read_text(encoding="utf-8"))
    return {name: np.array(tables[name]["table"]) for name in tables}
