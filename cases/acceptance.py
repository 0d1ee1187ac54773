"""What a result has to be, to be accepted: limits of a case, `[accept]`."""

from pydantic import model_validator

from cases.base.phrases import phrase
from cases.tables import NonNegative, Part, Positive, Vector


class LargestDeviations(Part):
    """Largest reported deviations of parameters, by their kinds; those that are left out are not asked for."""

    mass_kg: Positive | None = None
    """Of the mass."""
    centre_of_gravity_mm: Positive | None = None
    """Of each coordinate of the centre of gravity."""
    inertia_kg_m2: Positive | None = None
    """Of each moment and product of inertia about the centre of gravity."""
    offset_N: Positive | None = None
    """Of the offset of each channel of force."""
    offset_Nm: Positive | None = None
    """Of the offset of each channel of moment."""


class Reference(Part):
    """A body that was weighed or measured otherwise, with expanded uncertainties (k = 2)."""

    mass_kg: Positive | None = None
    """Its mass."""
    mass_U_kg: Positive | None = None
    """Expanded uncertainty (k = 2) of its mass."""
    centre_of_gravity_mm: Vector | None = None
    """Its centre of gravity in {P}."""
    centre_of_gravity_U_mm: Positive | None = None
    """Expanded uncertainty (k = 2) of each of its coordinates."""

    @model_validator(mode="after")
    def _with_uncertainty(self) -> "Reference":
        pairs = ("mass_kg", "mass_U_kg"), ("centre_of_gravity_mm", "centre_of_gravity_U_mm")
        for value, expanded in pairs:
            if (getattr(self, value) is None) != (getattr(self, expanded) is None):
                raise ValueError(
                    phrase(
                        "value_and_U",
                        "give {value} and {expanded}, or neither: E_n needs the uncertainty of the reference",
                        value=value,
                        expanded=expanded,
                    ).about(value, expanded)
                )
        if self.mass_kg is None and self.centre_of_gravity_mm is None:
            raise ValueError(
                phrase(
                    "mass_or_centre", "give mass_kg and mass_U_kg, or centre_of_gravity_mm and centre_of_gravity_U_mm"
                )
            )
        return self


class Acceptance(Part):
    """Limits by which `hexcite accept` and `identify` judge a result: passed or failed."""

    noise_times: Positive = 1.5
    """Largest noise of a channel by its residuals, as a multiple of what [sensors] states."""
    mass_percent: Positive = 25.0
    """Largest difference of the mass from that of [nominal]."""
    path_percent: Positive = 95.0
    """Smallest share of the plan's path that is in the run."""
    duration_percent: NonNegative = 5.0
    """Largest difference of the duration from that of the plan."""
    path_error_mm: Positive | None = None
    """Largest distance of the executed path from the planned one, where the run says it."""
    deviations: LargestDeviations | None = None
    """Largest deviations of parameters."""
    reference: Reference | None = None
    """A reference that the parameters have to agree with, E_n at most 1."""
