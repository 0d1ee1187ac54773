"""Building blocks of a case file: strict numbers, ranges and points, each with its unit in the key that holds it."""

from collections.abc import Iterable
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field

Array = NDArray[np.float64]


class Part(BaseModel):
    """A table of a case file: unknown keys are errors, values never change after validation."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    def __eq__(self, other: object) -> bool:
        """Equal values; arrays that were derived from them and kept do not count."""
        return type(self) is type(other) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]


def kind_of(one: type[Part], other: type[Part], keys: Iterable[str]) -> Discriminator:
    """What tells a table of one kind, which has some of these keys, from one of another.

    Tags in angle brackets name the class that a table was read as; messages leave them out.
    """
    telling = frozenset(keys)

    def tag(table: Any) -> str:
        own = not telling.isdisjoint(table) if isinstance(table, dict) else isinstance(table, one)
        return f"<{(one if own else other).__name__}>"

    return Discriminator(tag)


LARGEST = 1e15  # beyond any machine, in any unit; sixth powers of it are still numbers
Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=LARGEST)]


def _ordered(value: tuple[float, float]) -> tuple[float, float]:
    low, high = value
    if not low < high:
        raise ValueError(f"lower limit {low:g} is not below upper limit {high:g}; swap or widen them")
    return value


def _six_points(value: tuple[tuple[float, float, float], ...]) -> tuple[tuple[float, float, float], ...]:
    if len(value) != 6:
        raise ValueError(f"has {len(value)} points, a hexapod has 6; list one [x, y, z] for each strut, in strut order")
    return value


def _climbing(value: tuple[float, float, float]) -> tuple[float, float, float]:
    first, last, step = value
    if not (first <= last and step > 0.0):
        raise ValueError(
            f"[{first:g}, {last:g}, {step:g}] is not a range [first, last, step]; step up from first to last"
        )
    return value


Grid = Annotated[tuple[Number, Number, Number], AfterValidator(_climbing)]
"""First value, last value, step."""
Range = Annotated[tuple[Number, Number], AfterValidator(_ordered)]
Vector = tuple[Number, Number, Number]
PositiveVector = tuple[Positive, Positive, Positive]
Six = tuple[Number, Number, Number, Number, Number, Number]
SixPoints = Annotated[tuple[Vector, ...], AfterValidator(_six_points)]


def frozen(values: Any) -> Array:
    """A read-only array of floats."""
    array: Array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


def turned(angles: Array) -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw, shape (3,) [rad]; shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


# Beyond this condition number (moments divided by the size) errors are amplified a thousandfold.
WORST_CONDITION = 1e3


def condition_of_lines(points: Array, directions: Array) -> float:
    """Condition number of six lines, moments divided by the largest distance of a point from the origin.

    Args:
        points: one on each line, shape (6, 3) [m].
        directions: directions of any length but 0, shape (6, 3).
    """
    unit = directions / np.linalg.norm(directions, axis=1)[:, None]
    size = max(float(np.linalg.norm(points, axis=1).max()), 1e-9)
    return float(np.linalg.cond(np.hstack([unit, np.cross(points, unit) / size])))
