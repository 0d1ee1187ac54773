"""Other treatments of a moving run, as the paper tried them, each for its effect beside the default."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cases.base.doors import checks_arguments
from cases.base.errors import Code, IdentificationError, option
from cases.base.options import documented
from cases.base.units import Array, Flags
from cases.schema import Case
from identification.machines.of_case import machine_of
from identification.model.model import Model
from identification.options import TreatmentOptions
from identification.recording.recording import Recording
from identification.samples.moving import MovingRun
from identification.samples.moving_window import moving_run

NOT_PERIODIC = 2e-3  # rms of what a Fourier series leaves of a coordinate, over the largest range of its like
MOST_HARMONICS = 50
WIDEST = 0.2  # of the samples a second: the widest low-pass behind which positions are differentiated


@checks_arguments
@documented(TreatmentOptions)
@dataclass(frozen=True, slots=True)
class Treatment(TreatmentOptions):
    """How a moving run is treated; what is None is as by default.

    >>> hx.Treatment(cutoff=60.0, accelerated=0.3).words
    'samples with at least 30 % of the largest acceleration, a low-pass at 60 Hz'

    Args:
        OPTIONS

    Raises:
        IdentificationError: a value means nothing.
    """

    def __post_init__(self) -> None:
        if self.accelerated is not None and not 0.0 < self.accelerated < 1.0:
            raise IdentificationError(
                place=f"accelerated {self.accelerated:g}",
                problem="is not a share",
                remedy="give one between 0 and 1",
                code=Code.OUT_OF_RANGE,
            )
        if self.period is not None and not (math.isfinite(self.period) and self.period > 0.0):
            raise IdentificationError(
                place=f"period {self.period:g} s",
                problem="is not a duration",
                remedy="give that of the motion",
                code=Code.OUT_OF_RANGE,
            )
        if not 1 <= self.harmonics <= MOST_HARMONICS:
            problem = f"is outside 1 to {MOST_HARMONICS}"
            raise IdentificationError(
                place=f"harmonics {self.harmonics}",
                problem=problem,
                remedy="give as many as the motion has",
                code=Code.OUT_OF_RANGE,
            )
        if self.cutoff is not None and not self.cutoff > 0.0:
            raise IdentificationError(
                place=f"cutoff {self.cutoff:g} Hz",
                problem="is not a frequency",
                remedy="give one above 0",
                code=Code.OUT_OF_RANGE,
            )

    @property
    def words(self) -> str:
        """What is done, in words."""
        parts = []
        if self.accelerated is not None:
            parts.append(f"samples with at least {100 * self.accelerated:.3g} % of the largest acceleration")
        if self.period is not None:
            parts.append(f"motion as a Fourier series of period {self.period:g} s with {self.harmonics} harmonics")
        if self.cutoff is not None:
            wide = f"the widest low-pass ({WIDEST:g} of the samples a second)"
            parts.append(f"a low-pass at {self.cutoff:g} Hz" if math.isfinite(self.cutoff) else wide)
        return ", ".join(parts) or "as by default"

    def run(self, recording: Recording, case: Case, model: Model) -> MovingRun:
        """The samples of a moving run.

        Raises:
            IdentificationError: nothing moves, no struts are known, or the motion is not such a series.
            RecordingError: the run cannot be evaluated.
        """
        if recording.t is None or recording.drives is None:
            raise IdentificationError(
                place=recording.source,
                problem="treatments are for runs that move, by drives or joints",
                remedy="leave them out",
                code=Code.NOT_SUPPORTED,
            )
        if self.cutoff is not None:
            cutoff = min(self.cutoff, WIDEST / recording.step)
            tables = case.recording.model_copy(update={"filter_cutoff_Hz": cutoff})
            case = case.model_copy(update={"recording": tables})
        samples = moving_run(recording, case, model)
        if self.period is not None:
            samples = moving_run(self._periodic(recording, case, samples), case, model)
        if self.accelerated is None:
            return samples
        rates = samples.kinematics(0.0).twist_rate
        sizes = np.array([np.linalg.norm(rates[:, axes], axis=1) for axes in (slice(0, 3), slice(3, 6))])
        most = np.maximum(sizes.max(axis=1, keepdims=True), np.finfo(float).tiny)
        return samples.without(np.max(sizes / most, axis=0) < self.accelerated)

    def _periodic(self, recording: Recording, case: Case, samples: MovingRun) -> Recording:
        """The run with the motion of its excitation replaced by the Fourier series (34) of each coordinate."""
        assert recording.t is not None
        assert recording.drives is not None
        assert self.period is not None
        machine, margin = machine_of(case), samples.filter.margin
        first, last = int(samples.rows[0]) + margin, int(samples.rows[-1]) + margin
        rows = first + np.flatnonzero(~recording.bad[first : last + 1])
        angle = 2.0 * np.pi * (recording.t[rows, None] - recording.t[first]) * np.arange(1, self.harmonics + 1)
        basis = np.hstack([np.ones((len(rows), 1)), np.sin(angle / self.period), np.cos(angle / self.period)])
        coordinates = machine.coordinates(recording.drives[rows])
        series = basis @ np.linalg.lstsq(basis, coordinates, rcond=None)[0]
        _require_periodic(recording, coordinates, series, machine.turns if not machine.of_pose else TURNS, self)
        struts = recording.drives.copy()
        struts[rows] = machine.drives(series)
        return replace(recording, drives=struts)

    def to_json(self) -> dict[str, Any]:
        """Its entries, in the units of the options."""
        cutoff = None if self.cutoff is None else self.cutoff if math.isfinite(self.cutoff) else "none"
        series = None if self.period is None else {"period_s": self.period, "harmonics": self.harmonics}
        return {"words": self.words, "accelerated": self.accelerated, "fourier": series, "cutoff_Hz": cutoff}


TURNS = np.array([False, False, False, True, True, True])  # of a pose, which coordinates are angles


def _require_periodic(
    recording: Recording, coordinates: Array, series: Array, turns: Flags, treatment: Treatment
) -> None:
    """Raises IdentificationError where a series leaves more of the coordinates, shapes (n, k), than it may."""
    deviation = np.sqrt(np.mean((coordinates - series) ** 2, axis=0))
    for of_kind in (~turns, turns):
        if not of_kind.any():
            continue
        share = float(
            deviation[of_kind].max() / max(float(np.ptp(coordinates[:, of_kind], axis=0).max()), np.finfo(float).tiny)
        )
        if share > NOT_PERIODIC and deviation[of_kind].max() > 1e-5:
            raise IdentificationError(
                place=recording.source,
                problem=f"a Fourier series of period {treatment.period:g} s with {treatment.harmonics} "
                f"harmonics is off the motion by {100 * share:.2g} % of its range (rms), at most "
                f"{100 * NOT_PERIODIC:g} % are a filter",
                remedy=f"give the period and the harmonics of the plan, or leave {option('period')} out",
                code=Code.MISFIT,
            )
