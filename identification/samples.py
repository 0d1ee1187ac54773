"""What an estimate is made from: times, forces, regressors at a delay, properties of the noise.

Averaged standstills are such samples, runs that move others. `Conditioning` is what a user asks to be done beforehand.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from cases.sensors import Sensors
from cases.units import Array, Flags, Indices
from identification.estimation.channel_weights import independent_poses
from identification.estimation.fit import Filtered, Fit, Robust, inverse_root, joint_triangle
from identification.estimation.force_noise import long_run_covariance, scores
from identification.finding import Finding
from identification.model import Model
from identification.signals import Filter, Residuals


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples(ABC):
    """What an estimate is made from, whatever the recording was: estimators and checks ask for nothing else."""

    model: Model  # gives A
    t: Array  # times, shape (n,) [s]; of standstills without a clock their numbers from 1
    recorded: Array  # forces as recorded, shape (n, 6) [N, or N and N m]
    forces: Array  # forces as the estimator uses them, shape (n, 6)
    samples: int  # number of recorded samples that they stand for
    window: tuple[Finding, ...] = ()  # findings about the part of the recording that they are from
    scale: Array | float = 1.0  # what forces and A are multiplied by in a fit, shape (n,)
    # names of what is estimated beside the model, the delay last; none where nothing moves
    nuisances: tuple[str, ...] = ()
    # the run in a wider band, where its delay is found beforehand; None where none is, or it is estimated
    wide: "Samples | None" = None
    noise_stated: ClassVar[bool] = False  # whether the noise that a case states explains the residuals
    each: ClassVar[tuple[str, ...]] = ("t", "recorded", "forces")  # fields with an entry for each sample

    @property
    def filtered(self) -> Filtered:
        """Effect of filtering or averaging on white noise of the recorded forces."""
        return Filtered()

    @property
    def noise_correlation(self) -> float:
        """Correlation of white noise between neighbours; 1 where nothing is said of them."""
        return 1.0

    @abstractmethod
    def regressors(self, delay: float) -> Array:
        """A at the instants t_k - delay, shape (n, 6, u)."""

    @abstractmethod
    def linearised(self, delay: float, values: Array) -> Array:
        """A and the columns of the nuisances at values u, shape (n, 6, u + nuisances)."""

    def predicted(self, matrices: Array, values: Array) -> Array:
        """What the model expects of the recorded forces, from A and u, shape (n, 6)."""
        return np.asarray(matrices @ values)

    @abstractmethod
    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Robust | None:
        """Covariance of u for noise that is not white, from A and residuals; None for too few samples."""

    @abstractmethod
    def series(self, delay: float, values: Array) -> Residuals:
        """Recorded forces beside the model's, at most the first `MOST_SAMPLES`."""

    def without(self, left_out: Flags) -> Self:
        """The same without the samples that are marked, shape (n,)."""
        mask = ~left_out
        entries = {name: getattr(self, name)[mask] for name in self.each}
        return replace(self, samples=round(self.samples * float(mask.mean())), **entries)

    def excerpt(self, times: int = 1) -> Self:
        """A part of a long run that stands for all of it, `fair_part`; the samples themselves where that is all."""
        del times
        return self

    def known_columns(self, delay: float, matrices: Array, values: Array) -> Array | None:
        """How A u changes with what was measured beside: the delay and biases of an accelerometer, shape (n, 6, 4)."""
        del delay, matrices, values
        return None

    def refined(self, fit: Fit, basis: Array, w: Array, delay: float) -> Self:
        """The samples with further nuisances that a fit shows to be worth an estimate; as they are where none is.

        Args:
            fit: fit of them; its values begin with u.
            basis: basis of the free parameters, shape (u, free).
            w: W for one sample, shape (6, 6).
            delay: estimated delay [s].
        """
        del fit, basis, w, delay
        return self

    def regressor_noise(self, w: Array, delay: float, sensors: Sensors) -> Array | None:
        """Expected sum of dA^T W dA by stated noise, shape (u, u); None where A does not come from struts."""
        del w, delay, sensors
        return None

    def findings(self, fit: Fit) -> tuple[Finding, ...]:
        """What there is to say of how they were evaluated, after their fit."""
        del fit
        return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Moving(Samples):
    """Samples of a run that moves, behind a low-pass."""

    filter: Filter

    @property
    def step(self) -> float:
        """Time between evaluated samples [s]."""
        return self.filter.step * self.filter.stride

    @property
    def places(self) -> Indices:
        """Places of the evaluated samples in a series of equal steps, shape (n,); gaps and sections leave some out."""
        recorded = np.rint((self.t - self.t[0]) / self.filter.step)
        # Halves go up: where a gap ends between two of the series, no two samples may share a place.
        return np.asarray(np.floor(recorded / self.filter.stride + 0.5), dtype=np.int64)

    @property
    def filtered(self) -> Filtered:
        """Effect of the filter on white noise."""
        return Filtered(self.filter.noise_gain, self.filter.stride)

    @property
    def noise_correlation(self) -> float:
        """Correlation of white noise behind the filter, between evaluated samples."""
        return self.filter.noise_correlation


@dataclass(frozen=True, slots=True, kw_only=True)
class Standstills(Samples):
    """Averaged standstills: nothing moves, nothing is filtered."""

    matrices: Array  # A, shape (n, 6, u)
    scale: Array  # what forces and A of each are multiplied by in a fit, shape (n,)
    clocked: bool = False  # whether they have a clock, so that noise may have memory
    each: ClassVar[tuple[str, ...]] = (*Samples.each, "matrices", "scale")

    def regressors(self, delay: float) -> Array:
        """Weighted A, shape (n, 6, u)."""
        del delay
        return self.matrices * self.scale[:, None, None]

    def linearised(self, delay: float, values: Array) -> Array:
        """Weighted A: there are no nuisances."""
        del values
        return self.regressors(delay)

    def predicted(self, matrices: Array, values: Array) -> Array:
        """What the model expects of the recorded forces, not weighted, shape (n, 6)."""
        return np.asarray(matrices @ values / self.scale[:, None])

    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Robust | None:
        """Covariance of u for independent standstills, or, with a clock, for noise with memory, by Bartlett's kernel.

        One pose depends on the lowest frequencies alone, which a short run does not show: models of the noise that
        extrapolate to them would find memory in white noise, in one of five runs.
        """
        del whitening
        if not self.clocked:
            return Robust(independent_poses(matrices, residuals, weights))
        half = inverse_root(joint_triangle(matrices, residuals, np.sqrt(weights))[:-1, :-1])
        inverse = half @ half.T
        return Robust(inverse @ long_run_covariance(scores(matrices, residuals, weights)) @ inverse)

    def series(self, delay: float, values: Array) -> Residuals:
        """Forces of each standstill beside the model's."""
        del delay
        return Residuals(self.t, self.recorded, self.matrices @ values, None)


@dataclass(frozen=True, slots=True)
class Conditioning:
    """What a user asks to be done to a run."""

    # estimate the lowest structural mode of a moving run with the parameters, behind a low-pass at half its frequency
    flexible: bool = False
    standstills: bool = False  # average the run's standstills, wherever they are


USUAL = Conditioning()
