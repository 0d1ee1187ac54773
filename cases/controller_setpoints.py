"""What a table of setpoints, one row a control cycle, needs to be told."""

from typing import Annotated

from pydantic import Field

from cases.controller_promises import Promises
from cases.parts import Part, Positive
from cases.units import MS


class Setpoints(Part):
    """Settings of setpoint tables for external setpoint generation."""

    cycle_ms: Positive
    """Of the task that feeds them: a whole multiple of the drives' own cycle."""
    most_rows: Annotated[int, Field(strict=True, ge=10)]
    """What its memory holds."""
    controller_keeps: Promises
    """A generator that copies setpoints to the drives usually keeps nothing: `[]`."""

    @property
    def cycle(self) -> float:
        """Control cycle [s]."""
        return self.cycle_ms * MS
