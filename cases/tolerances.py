"""How far a machine may be from its case: what a drawing and data sheets promise, not what a run shows."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, PlainSerializer, model_validator
from pydantic_core import PydanticKnownError

from cases.base.phrases import phrase
from cases.tables import LARGEST, NonNegative, Part

KINDS = {
    "joints_mm": "drawing",
    "bars_mm": "drawing",
    "joint_zeros_deg": "drawing",
    "joint_zeros_mm": "drawing",
    "links_mm": "drawing",
    "gain_percent": "gains",
    "common_gain_percent": "gains",
    "sensor_mm": "alignment",
    "sensor_deg": "alignment",
    "gravity_deg": "gravity",
    "gravity_percent": "gravity",
    "encoder_scale_ppm": "encoders",
    "clock_ppm": "clock",
}
"""Kinds of tolerances by their keys."""

BOUNDS, PRIORS = "bounds", "priors"  # key of what is known of the body, and its kind


def kind_of(key: str) -> str:
    """What deviations of a kind are by: of a tolerance, or of [bounds]."""
    return PRIORS if key == BOUNDS else KINDS[key]


TYPICAL = {
    "joints_mm": 0.03,
    "bars_mm": 0.05,
    "sensor_mm": 0.1,
    "sensor_deg": 0.1,
    "joint_zeros_deg": 0.02,
    "joint_zeros_mm": 0.02,
    "links_mm": 0.2,
    "encoder_scale_ppm": 20.0,
    "gain_percent": 0.2,
    "common_gain_percent": 0.05,
    "gravity_deg": 0.05,
    "gravity_percent": 0.01,
    "clock_ppm": 50.0,
}
"""Values to begin from: parts ground to a few hundredths, a load cell's class and its reference, a spirit level, g by
latitude and height, a quartz."""


def tolerable_keys(
    turns: Sequence[bool], struts: bool, bars: bool, transducer: bool, known: bool, moves: bool
) -> tuple[str, ...]:
    """Keys of tolerances that a machine has something for, in the order of `KINDS`.

    Args:
        turns: of each joint of a chain, whether it turns; none where there is no chain.
        struts: whether it is a hexapod.
        bars: whether sensors are in bars, and
        transducer: whether one sensor measures force and moment.
        known: whether its case says how it moves.
        moves: whether the frame of the sensors does.
    """
    has = {
        "joints_mm": struts,
        "bars_mm": bars,
        "sensor_mm": transducer,
        "sensor_deg": transducer,
        "joint_zeros_deg": any(turns),
        "joint_zeros_mm": not all(turns),
        "links_mm": len(turns) > 1,
        "encoder_scale_ppm": known,
        "clock_ppm": moves,
    }
    return tuple(key for key in KINDS if has.get(key, True))


class Spread(Part):
    """A standard deviation, or a limit that nothing exceeds; exactly one of them."""

    std: NonNegative | None = None
    """Standard deviation."""
    limit: NonNegative | None = None
    """Largest deviation to either side, all within alike (rectangular): its deviation is the limit over root three."""

    @model_validator(mode="after")
    def _one_of_them(self) -> "Spread":
        if (self.std is None) == (self.limit is None):
            raise ValueError(
                phrase(
                    "std_or_limit", "give a standard deviation, such as 0.03, or {{ limit = 0.05 }}, not both or none"
                )
            )
        return self

    @property
    def deviation(self) -> float:
        """The standard deviation."""
        return self.std if self.std is not None else (self.limit or 0.0) / float(np.sqrt(3.0))


def _spread(value: Any) -> Any:
    """The table of a deviation that is written as a number; what is wrong with the number is said at its own key."""
    if isinstance(value, dict | Spread):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticKnownError("float_type")
    if not np.isfinite(value):
        raise PydanticKnownError("finite_number")
    if value < 0.0:
        raise PydanticKnownError("greater_than_equal", {"ge": 0.0})
    if value > LARGEST:
        raise PydanticKnownError("less_than_equal", {"le": LARGEST})
    return {"std": float(value)}


def _as_written(value: Spread | None) -> Any:
    return None if value is None else value.std if value.limit is None else {"limit": value.limit}


Tolerance = Annotated[Spread, BeforeValidator(_spread), PlainSerializer(_as_written)]


class Tolerances(Part):
    """Deviations of the machine from its case, each of its own sign and size: `0.03`, a standard deviation, or
    `{ limit = 0.05 }`. What is not stated is not counted, and results say so."""

    joints_mm: Tolerance | None = None
    """Each coordinate of each joint of base and platform."""
    bars_mm: Tolerance | None = None
    """Each coordinate of each end of the bars."""
    sensor_mm: Tolerance | None = None
    """Each coordinate of the origin of a force/torque sensor, against where the case has it."""
    sensor_deg: Tolerance | None = None
    """The axes of a force/torque sensor, about each of them."""
    joint_zeros_deg: Tolerance | None = None
    """The zero of each joint of a chain that turns."""
    joint_zeros_mm: Tolerance | None = None
    """The zero of each joint of a chain that slides."""
    links_mm: Tolerance | None = None
    """Each coordinate of the place of each joint of a chain but the first, against the one before it: lengths of links,
    and how far axes are apart."""
    encoder_scale_ppm: Tolerance | None = None
    """The scale of each encoder."""
    gain_percent: Tolerance | None = None
    """The gain of each channel by itself."""
    common_gain_percent: Tolerance | None = None
    """A gain that all channels have in common: no run shows it, masses are wrong by as much."""
    gravity_deg: Tolerance | None = None
    """The direction of gravity, about each horizontal axis: the machine is not level."""
    gravity_percent: Tolerance | None = None
    """The size of gravity."""
    clock_ppm: Tolerance | None = None
    """The rate of the clock that recorded the run."""

    def stated(self) -> Iterator[tuple[str, float]]:
        """Keys with their standard deviations, in the units of the keys."""
        for name in type(self).model_fields:
            if (spread := getattr(self, name)) is not None:
                yield name, spread.deviation
