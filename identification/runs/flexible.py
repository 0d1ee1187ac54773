"""The lowest structural mode of a machine, seen in a run: forces grow with frequency beyond what the motion asks for.

A platform behind a spring of circular frequency w feels accelerations amplified by 1 / (1 - (f/w)^2), to first order
f = A u - w^-2 d^2(A u)/dt^2: the smoothing of `identification.runs.smoothing` with a negative sign. The series holds
well below the mode alone, so that the low-pass is set to half of it.
"""

from typing import Any, NamedTuple

import numpy as np

from cases.schema import Case
from identification.finding import Finding, Kind, note
from identification.runs.smoothing import CLEAR, Smoothing

SHARE = 0.5  # of the mode's frequency: there the first term that is left out is a sixteenth


class Mode(NamedTuple):
    """Frequency of a structural mode and its standard deviation [Hz]."""

    frequency: float
    std: float


def mode_found(found: Smoothing, case: Case) -> list[Finding]:
    """What is to be told of the mode that sharpens the forces so, behind the low-pass of a case."""
    entries = {"smoothing_s2": found._asdict()}
    mode = mode_of(found)
    if mode is None:
        told = "no structural mode is seen: the forces do not grow with frequency; identify without --flexible"
        return [note(Kind.MODEL, told, **entries)]
    told = f"a structural mode at {mode.frequency:.3g} +- {mode.std:.2g} Hz amplifies the forces: estimated and "
    told += f"compensated, behind a low-pass at {case.recording.filter_cutoff_Hz:.3g} Hz"
    return [note(Kind.MODEL, told, **entries, structural_mode_Hz={"value": mode.frequency, "std": mode.std})]


def mode_of(found: Smoothing) -> Mode | None:
    """The mode that sharpens the forces so; None where they are not clearly sharpened."""
    if -found.value < CLEAR * found.std:
        return None
    frequency = 1.0 / (2.0 * np.pi * np.sqrt(-found.value))
    return Mode(float(frequency), float(frequency * found.std / (2.0 * -found.value)))


def below(case: Case, told: Any) -> Case | None:
    """The case with a low-pass at half the mode that an estimate was told of; None where it is as low already.

    Args:
        case: with a filter.
        told: `structural_mode_Hz` of the estimate; None where none is seen.
    """
    cutoff = case.recording.filter_cutoff_Hz
    if told is None or cutoff is None or cutoff <= SHARE * told["value"]:
        return None
    recording = case.recording.model_copy(update={"filter_cutoff_Hz": SHARE * float(told["value"])})
    return case.model_copy(update={"recording": recording})
