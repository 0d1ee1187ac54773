"""What is known of the body that the sensors carry, as from CAD: `[bounds]` of a case."""

from functools import cached_property

from pydantic import model_validator

from cases.base.phrases import phrase
from cases.base.units import MM, Array
from cases.tables import Part, Range, frozen


class BodyBox(Part):
    """A box along the axes of {P}."""

    x_mm: Range
    """From and to along x."""
    y_mm: Range
    """From and to along y."""
    z_mm: Range
    """From and to along z."""

    @cached_property
    def ends(self) -> Array:
        """Smallest and largest coordinates, shape (2, 3) [m]."""
        return frozen([self.x_mm, self.y_mm, self.z_mm]).T * MM


class Bounds(Part):
    """Limits of the body that the sensors carry, without payloads, as CAD states them; each may be left out. Estimates
    weigh mass and centre of gravity with them, as uniform priors, unless they contradict them; the body that results
    call physical, and that exports of the load take, is within them.
    """

    mass_kg: Range | None = None
    """Smallest and largest mass."""
    centre_of_gravity_mm: BodyBox | None = None
    """Box in {P} that has the centre of gravity inside; `body_mm` stands for it where this is not stated."""
    body_mm: BodyBox | None = None
    """Box in {P} that has the whole body inside: also limits moments of inertia."""

    @model_validator(mode="after")
    def _of_a_body(self) -> "Bounds":
        if self.mass_kg is not None and self.mass_kg[0] < 0.0:
            raise ValueError(
                phrase("mass_below_0", "mass_kg begins at {mass}; no body has less than 0", mass=f"{self.mass_kg[0]:g}")
            )
        return self
