"""By how much more the forces of a run are smoothed than its motion, estimated where the run can tell.

Forces and struts pass the same filter, but were not sampled alike. Where accelerations leap within a sampling step T,
as those of controllers without limit of jerk do, forces sampled pointwise are those of a motion smoothed by -T^2/12 to
T^2/24 more than the struts, by where in a step they are sampled; averaging over the step, or a low-pass before the
sampling, adds half its variance. To first order f = A u + b d^2(A u)/dt^2: beside the delay, the first moment of the
smoothing, b, half the second, is one more unknown. Left out, it draws the mass of a clean ten-second run by two of its
standard deviations.

The lowest structural mode of a machine, seen in a run: forces grow with frequency beyond what the motion asks for.

A platform behind a spring of circular frequency w feels accelerations amplified by 1 / (1 - (f/w)^2), to first order
f = A u - w^-2 d^2(A u)/dt^2: the smoothing of `identification.runs.smoothing` with a negative sign. The series holds
well below the mode alone, so that the low-pass is set to half of it.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from identification.estimation.compressed import inverse_root
from identification.estimation.fit import Fit
from identification.findings import Finding, Kind, note
from identification.runs.evaluation import Run

Array = NDArray[np.float64]

SAMPLED = 1.0 / 12.0  # of T^2: the largest b that sampling alone makes
CLEAR = 3.0  # standard deviations of b from which it is told


class Smoothing(NamedTuple):
    """Half the second moment, b, by which forces are smoothed more than the motion, and its deviation [s^2]."""

    value: float
    std: float

    @property
    def finding(self) -> Finding:
        """What is to be told of it; people only where it is clear."""
        sentence = (
            f"forces are {'smoothed' if self.value > 0.0 else 'sharpened'} against the motion by "
            f"{self.value * 1e6:+.3g} +- {self.std * 1e6:.2g} ms^2, half a second moment (leaps between samples, "
            "averaging or a low-pass of the channels): estimated and compensated"
        )
        clear = abs(self.value) >= CLEAR * self.std
        return note(Kind.CLOCK, sentence if clear else "", smoothing_s2=self._asdict())


def smoothed(run: Run, fit: Fit, basis: Array, w: Array, delay: float) -> Run:
    """The run with its smoothing to be estimated, where that is worth it; as it is elsewhere.

    It is where the run tells b more closely than sampling can make it; elsewhere leaving it out draws parameters by
    less than estimating it would widen them. The value of b is not looked at, so that the choice draws nothing.

    Args:
        fit: fit of it; its values begin with u.
        basis: basis of the free parameters, shape (u, free).
        w: W for one sample, shape (6, 6).
        delay: estimated delay [s].
    """
    part, (size, free) = run.excerpt(), basis.shape
    matrices, share = part.regressors(delay), len(part.rows) / len(run.rows)
    expected = matrices @ fit.values[:size]
    # Differences of evaluated samples are near enough to choose by: at the cut-off they see seven tenths of the bend.
    even = np.diff(part.rows) == run.filter.stride
    inner = 1 + np.flatnonzero(even[1:] & even[:-1])
    if len(inner) <= free:
        return run
    slope = (expected[inner + 1] - expected[inner - 1]) / (2.0 * run.step)
    bend = (expected[inner + 1] - 2.0 * expected[inner] + expected[inner - 1]) / run.step**2
    rows = np.linalg.cholesky(w).T @ np.dstack([matrices[inner] @ basis, slope, bend])
    triangle = np.asarray(np.linalg.qr(rows.reshape(-1, free + 2), mode="r"))
    if np.abs(np.diag(triangle)).min() == 0.0:  # nothing bends, as in a standstill
        return run
    std = fit.s0 * np.sqrt(share / run.filter.stride) * float(np.linalg.norm(inverse_root(triangle)[-1]))
    return replace(run, smoothing=True) if std < SAMPLED * run.filter.step**2 else run


def smoothing_of(run: Run, fit: Fit) -> Smoothing:
    """What a fit of a run with its smoothing found."""
    place = len(run.model.parameters) + run.nuisances.index("smoothing")
    std = max(float(fit.covariance[place, place]), float(fit.covariance_robust[place, place])) ** 0.5
    return Smoothing(float(fit.values[place]), std)


SHARE = 0.5  # of the mode's frequency: there the first term that is left out is a sixteenth


def mode_found(found: Smoothing, case: Case) -> list[Finding]:
    """What is to be told of the mode that sharpens the forces so, behind the low-pass of a case."""
    entries = {"smoothing_s2": found._asdict()}
    if -found.value < CLEAR * found.std:
        sentence = "no structural mode is seen: the forces do not grow with frequency; identify without --flexible"
        return [note(Kind.MODEL, sentence, **entries)]
    frequency = float(1.0 / (2.0 * np.pi * np.sqrt(-found.value)))
    std = frequency * found.std / (2.0 * -found.value)
    sentence = f"a structural mode at {frequency:.3g} +- {std:.2g} Hz amplifies the forces: estimated and "
    sentence += f"compensated, behind a low-pass at {case.recording.filter_cutoff_Hz:.3g} Hz"
    return [note(Kind.MODEL, sentence, **entries, structural_mode_Hz={"value": frequency, "std": std})]


def below(case: Case, told: Any) -> Case | None:
    """The case with a low-pass at half the mode that an estimate was told of; None where it is as low already.

    Args:
        told: `structural_mode_Hz` of the estimate; None where none is seen.
    """
    cutoff = case.recording.filter_cutoff_Hz
    if told is None or cutoff is None or cutoff <= SHARE * told["value"]:
        return None
    recording = case.recording.model_copy(update={"filter_cutoff_Hz": SHARE * float(told["value"])})
    return case.model_copy(update={"recording": recording})
