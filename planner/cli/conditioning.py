"""What a user asks to be done to a moving run beforehand: `--period`, `--harmonics`, `--accelerated`,
`--flexible`."""

import math
import re

from cases.errors import HexciteError
from identification.runs.conditioning import Accelerated, Conditioning, Periodic

AUTO = "auto"
_AMOUNT = re.compile(r"(?P<value>[0-9]*\.?[0-9]+)\s*(?P<unit>%|m/s\^?2|m/s²)")


def read_conditioning(
    period: str | None, harmonics: int | None, accelerated: str | None, flexible: bool = False
) -> Conditioning:
    """The conditioning that options ask for.

    Args:
        period: `auto` or seconds, as typed.
        harmonics: of the series.
        accelerated: share or threshold, as typed.
        flexible: whether a structural mode is estimated.

    Raises:
        HexciteError: not understood, or options that do not go together.
    """
    if harmonics is not None and period is None:
        raise HexciteError(f"--harmonics {harmonics}: is for periodic runs; add --period auto or --period SECONDS")
    if harmonics is not None and harmonics < 1:
        raise HexciteError(f"--harmonics {harmonics}: is no number of harmonics; give 1 or more")
    if accelerated is not None and period is not None:
        raise HexciteError("--accelerated: selects samples, of which --period keeps none apart; leave one of them out")
    if flexible and period is not None:
        raise HexciteError("--flexible: lowers the low-pass, which --period does without; leave one of them out")
    if period is None:
        return Conditioning(accelerated=None if accelerated is None else _amount(accelerated), flexible=flexible)
    return Conditioning(Periodic(None if period == AUTO else _seconds(period), harmonics))


def _seconds(text: str) -> float:
    try:
        value = float(text.removesuffix("s"))
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise HexciteError(f"--period {text}: is no period; give auto or seconds, as --period 3")
    return value


def _amount(text: str) -> Accelerated:
    found = _AMOUNT.fullmatch(text.strip())
    value = float(found["value"]) if found else 0.0
    if found is None or value == 0.0 or (found["unit"] == "%" and value > 100.0):
        raise HexciteError(
            f"--accelerated {text}: is neither a share nor an acceleration; write --accelerated 30% or "
            "--accelerated 3m/s^2"
        )
    return Accelerated(share=value / 100.0) if found["unit"] == "%" else Accelerated(least=value)
