"""What a user asks to be done to a moving run beforehand: `--period`, `--harmonics`, `--flexible`."""

import math

from cases.errors import HexciteError
from identification.samples import Conditioning, Periodic

AUTO = "auto"


def read_conditioning(period: str | None, harmonics: int | None, flexible: bool = False) -> Conditioning:
    """The conditioning that options ask for.

    Args:
        period: `auto` or seconds, as typed.
        harmonics: of the series.
        flexible: whether a structural mode is estimated.

    Raises:
        HexciteError: not understood, or options that do not go together.
    """
    if harmonics is not None and period is None:
        raise HexciteError(f"--harmonics {harmonics}: is for periodic runs; add --period auto or --period SECONDS")
    if harmonics is not None and harmonics < 1:
        raise HexciteError(f"--harmonics {harmonics}: is no number of harmonics; give 1 or more")
    if flexible and period is not None:
        raise HexciteError("--flexible: lowers the low-pass, which --period does without; leave one of them out")
    if period is None:
        return Conditioning(flexible=flexible)
    return Conditioning(Periodic(None if period == AUTO else _seconds(period), harmonics))


def _seconds(text: str) -> float:
    try:
        value = float(text.removesuffix("s"))
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise HexciteError(f"--period {text}: is no period; give auto or seconds, as --period 3")
    return value
