"""What the motion of a plan was made with: choices of its family, or the file or plan that it is from."""

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel

from identification.limits.limit import LimitKind


class PlanSettings(BaseModel, strict=True, frozen=True, extra="forbid"):
    """What every motion has; fields are keys of `settings` in `plan.json`, which leaves defaults out."""

    made_for: str | None = None
    """Controller whose time law it has; None where all limits of the case count."""
    without: Literal[LimitKind.JERK] | None = None
    """Family of limits of the case that it leaves out, as was asked for."""

    @property
    def source(self) -> str | None:
        """File or plan that it is from, or what it is in words; None where it was searched."""
        return None

    def to_json(self) -> dict[str, Any]:
        """Its entries in `plan.json`."""
        return self.model_dump(exclude_defaults=True, mode="json")


class FourierSettings(PlanSettings):
    """Order, periods and what leads into them and out of them, of a Fourier series."""

    order: int
    period_s: float
    repeats: int
    run_in_s: float = 0.0
    centred: bool = False


class MoveSettings(PlanSettings):
    """Number of point-to-point moves, and what they last together."""

    moves: int
    duration_s: float


class SplineSettings(PlanSettings):
    """Number of intervals of a spline, and its duration."""

    knots: int
    duration_s: float


class SequenceSettings(PlanSettings):
    """A motion that was made by hand: its file, or what it is where nobody wrote one."""

    sequence: str

    @property
    def source(self) -> str:
        """File or words."""
        return self.sequence


class RetimedSettings(PlanSettings):
    """By what a plan was timed anew."""

    retimed_with: str
    retimed_from: str
    duration_before_s: float

    @property
    def source(self) -> str:
        """Folder of the plan before."""
        return self.retimed_from


class AverageSettings(PlanSettings):
    """How long a machine settles and measures at each pose."""

    settle_s: float
    average_s: float


_BY_KEY: Mapping[str, type[PlanSettings]] = {
    "order": FourierSettings,
    "moves": MoveSettings,
    "knots": SplineSettings,
    "sequence": SequenceSettings,
    "retimed_with": RetimedSettings,
    "settle_s": AverageSettings,
}
"""Kinds of settings by the key that each has alone."""


def settings_of(entries: object) -> PlanSettings:
    """The settings that entries of a `plan.json` hold.

    Raises:
        ValueError: they are of no kind, or damaged; a ValidationError where one of them is.
    """
    kind = next((kind for key, kind in _BY_KEY.items() if isinstance(entries, dict) and key in entries), None)
    if kind is None:
        raise ValueError("settings")
    return kind.model_validate(entries)
