"""What is done to a moving run before the estimate, beyond the low-pass that every run passes."""

from dataclasses import dataclass
from typing import NamedTuple


class Periodic(NamedTuple):
    """Evaluate a repeating run by Fourier series.

    Args:
        period: of the run [s]; None: to be found.
        harmonics: of the series; None: as many as stand out of the noise.
    """

    period: float | None = None
    harmonics: int | None = None


@dataclass(frozen=True, slots=True)
class Conditioning:
    """What a user asks to be done.

    Args:
        periodic: by Fourier series instead of the low-pass.
        flexible: estimate the lowest structural mode with the parameters, behind a low-pass at half its frequency.
    """

    periodic: Periodic | None = None
    flexible: bool = False


USUAL = Conditioning()
