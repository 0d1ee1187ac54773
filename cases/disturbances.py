"""What disturbs a real machine beyond the noise of its sensors."""

from typing import Annotated

from pydantic import Field

from cases.parts import NonNegative, Part, Positive
from cases.units import DEG, MM


class Disturbances(Part):
    """Imperfections of the simulated machine that no identification model contains.

    One set of values holds for all loads and methods. They are effective values, set so that the residuals come out
    as large as measured ones; the source says whose.
    """

    source: str
    """Where the values come from."""
    mode_Hz: Positive
    """Structural mode between drives and platform, without payload; it falls with the root of the moved mass."""
    mode_damping: Annotated[float, Field(strict=True, gt=0, lt=1)]
    """Share of critical damping."""
    strut_velocity_noise_percent: NonNegative
    """Rms of the struts' velocity ripple, which really moves the platform, as a share of each strut's own velocity."""
    strut_velocity_band_Hz: Positive
    """Highest frequency of that ripple."""
    pose_error_N: NonNegative
    """Rms of the force error that depends on the pose, in each sensor, without payload."""
    pose_error_of_load: NonNegative
    """The same of a payload, as a share of its weight; independent of the error without payload."""
    pose_error_length_mm: Positive
    """Distance over which the error changes, translations."""
    pose_error_angle_deg: Positive
    """The same of rotations."""
    pose_error_seed: Annotated[int, Field(strict=True, ge=0)]
    """Chooses the error of this machine: it belongs to the machine, not to a run."""

    @property
    def ripple(self) -> float:
        """Rms of the struts' velocity ripple over their velocity."""
        return self.strut_velocity_noise_percent / 100.0

    @property
    def pose_error_length(self) -> float:
        """Distance over which the pose error changes [m]."""
        return self.pose_error_length_mm * MM

    @property
    def pose_error_angle(self) -> float:
        """Angle over which the pose error changes [rad]."""
        return self.pose_error_angle_deg * DEG
