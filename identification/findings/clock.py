"""Clocks that no recorder has: steps that are close to round ones, but are not."""

import math
from typing import NamedTuple

from cases.base.phrases import phrase
from cases.schema import Case
from identification.finding import Finding, Kind, warning
from identification.recording.recording import Recording

CLOSE = 0.02  # relative distance of a step from a round one, within which that is meant
CRYSTAL = 3e-4  # relative error that no crystal of a recorder or computer has
DIGITS = 2  # of round steps and rates


class OddClock(NamedTuple):
    """Time stamps that seem to be stretched."""

    step: float  # between samples [s]
    usual: float  # round step that is close to it [s]

    @property
    def share(self) -> float:
        """By how much the stamps are too far apart."""
        return self.step / self.usual - 1.0


def odd_clock(recording: Recording, case: Case) -> OddClock | None:
    """Steps that differ from round ones by more than clocks do; None where not, or where the case states them.

    Round are steps and rates of two digits, rates that are powers of 2, and the rate that the case states.
    """
    if recording.t is None or len(recording.t) < 3 or case.recording.clock.period_ms is not None:
        return None
    step = recording.step
    power = 2.0 ** round(math.log2(step))
    usual: list[float] = [_round(step), 1.0 / _round(1.0 / step), power, 1.0 / case.recording.rate_Hz]
    nearest = min(usual, key=lambda other: abs(step / other - 1.0))
    return OddClock(step, nearest) if CRYSTAL < abs(step / nearest - 1.0) < CLOSE else None


def _round(value: float) -> float:
    return float(f"{value:.{DIGITS - 1}e}")


def clock_findings(odd: OddClock | None) -> list[Finding]:
    """What to say of an odd clock."""
    if odd is None:
        return []
    usual = f"{odd.usual * 1e3:.6g}"
    sentence = phrase(
        "odd_clock",
        "time stamps are {step} ms apart, {share} % from {usual} ms, and accelerations go with the square of time; +- "
        "allows for it. If the recorder's clock has {usual} ms, set recording.clock.period_ms = {usual}",
        step=f"{odd.step * 1e3:.6g}",
        share=f"{100 * odd.share:+.2g}",
        usual=usual,
    )
    return [warning(Kind.CLOCK, sentence, odd_clock={"step_s": odd.step, "usual_s": odd.usual})]
