"""Units in which drawings and data sheets state a value, beside that of its key."""

import math
import re
from collections.abc import Collection
from typing import NamedTuple


class Spelling(NamedTuple):
    """A way to state a value: in a unit, under a key.

    Args:
        unit: as people write it.
        key: the key of the case file that takes it.
        factor: what the number is multiplied by to be that key's value.
        angle: of joints in pairs, whether it is the half or the included angle; empty of all else.
    """

    unit: str
    key: str
    factor: float = 1.0
    angle: str = ""

    @property
    def name(self) -> str:
        """Of the choice, in forms."""
        return f"{self.key}:{self.unit}"


_TURN = 180.0 / math.pi
_UNITS: tuple[tuple[str, tuple[tuple[str, float], ...]], ...] = (  # end of a key -> its own unit, then others
    ("kg_m2", (("kg m²", 1.0), ("kg cm²", 1e-4), ("kg mm²", 1e-6))),
    ("kg_m", (("kg m", 1.0), ("kg mm", 1e-3))),
    ("mm_min", (("mm/min", 1.0), ("m/min", 1e3), ("mm/s", 60.0))),
    ("mm_s", (("mm/s", 1.0), ("m/s", 1e3), ("mm/min", 1.0 / 60.0))),
    ("deg_s3", (("deg/s³", 1.0), ("rad/s³", _TURN))),
    ("rad_s3", (("rad/s³", 1.0), ("deg/s³", 1.0 / _TURN))),
    ("deg_s2", (("deg/s²", 1.0), ("rad/s²", _TURN))),
    ("rad_s2", (("rad/s²", 1.0), ("deg/s²", 1.0 / _TURN))),
    ("deg_s", (("deg/s", 1.0), ("rad/s", _TURN), ("1/min", 6.0))),
    ("m_s3", (("m/s³", 1.0), ("mm/s³", 1e-3))),
    ("m_s2", (("m/s²", 1.0), ("mm/s²", 1e-3))),
    ("m_s", (("m/s", 1.0), ("mm/s", 1e-3), ("m/min", 1.0 / 60.0))),
    ("percent", (("%", 1.0),)),
    ("ppm", (("ppm", 1.0),)),
    ("deg", (("deg", 1.0), ("rad", _TURN))),
    ("kHz", (("kHz", 1.0),)),
    ("Hz", (("Hz", 1.0), ("kHz", 1e3))),
    ("mm", (("mm", 1.0), ("m", 1e3), ("in", 25.4))),
    ("um", (("µm", 1.0), ("mm", 1e3))),
    ("Nms", (("N m s", 1.0),)),
    ("Nm", (("N m", 1.0), ("N mm", 1e-3), ("kN m", 1e3))),
    ("kg", (("kg", 1.0), ("g", 1e-3))),
    ("ms", (("ms", 1.0), ("s", 1e3))),
    ("N", (("N", 1.0), ("kN", 1e3))),
    ("s", (("s", 1.0), ("ms", 1e-3))),
)
_TWIN = {"rad_s2": "deg_s2", "deg_s2": "rad_s2", "rad_s3": "deg_s3", "deg_s3": "rad_s3"}
_PAIRS = {"half_angle_deg": "half", "included_angle_deg": "included"}


def _ending(key: str) -> str:
    return next((ending for ending, _ in _UNITS if key.endswith(f"_{ending}")), "")


def noun(key: str) -> str:
    """A key without its unit, in words."""
    ending = _ending(key)
    return re.sub(r"_+", " ", key.removesuffix(f"_{ending}") if ending else key).strip()


def spellings(key: str, known: Collection[str]) -> tuple[Spelling, ...]:
    """Ways to state the value of a key, its own first; empty where it has no unit.

    Args:
        known: keys that its table may have; a unit that has a key of its own there is written under that key.
    """
    ending = _ending(key)
    units = dict(_UNITS).get(ending, ())
    if key in _PAIRS:
        others = [other for other in _PAIRS if other != key and other in known]
        return tuple(Spelling(unit, own, factor, _PAIRS[own]) for own in (key, *others) for unit, factor in units)
    ways = [Spelling(unit, key, factor) for unit, factor in units]
    twin = f"{key.removesuffix(ending)}{_TWIN[ending]}" if ending in _TWIN else ""
    return tuple([ways[0], Spelling(dict(_UNITS)[_TWIN[ending]][0][0], twin)] if twin in known else ways)


def same_thing(one: str, other: str) -> bool:
    """Whether two keys state the same in different units, or ways."""
    if one in _PAIRS and other in _PAIRS:
        return True
    first, second = _ending(one), _ending(other)
    return bool(first and second) and one.removesuffix(first) == other.removesuffix(second)
