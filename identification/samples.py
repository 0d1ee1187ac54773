"""What an estimate is made from: times, forces, regressors at a delay, properties of the noise.

Averaged standstills are such samples. `Conditioning` is what a user asks to be done to a run beforehand.
"""

from dataclasses import dataclass
from typing import ClassVar, Protocol, Self

import numpy as np

from cases.sensors import Sensors
from cases.units import Array, Flags
from identification.estimation.channel_weights import independent_poses
from identification.estimation.fit import Filtered, Fit, Robust, inverse_root, joint_triangle
from identification.estimation.force_noise import long_run_covariance, scores
from identification.finding import Finding
from identification.model import Model
from identification.signals import Residuals


class Samples(Protocol):
    """What an estimate is made from, whatever the recording was: estimators and checks ask for nothing else."""

    @property
    def model(self) -> Model:
        """The model, which gives A."""

    @property
    def t(self) -> Array:
        """Times, shape (n,) [s]; of standstills their number from 1."""

    @property
    def forces(self) -> Array:
        """Forces as the estimator uses them, shape (n, 6) [N, or N and N m]."""

    @property
    def samples(self) -> int:
        """Number of recorded samples that they stand for."""

    @property
    def window(self) -> tuple[Finding, ...]:
        """Findings about the part of the recording that they are from."""

    @property
    def consecutive(self) -> bool:
        """Whether neighbours follow each other in time, so that a contact is a stretch of them."""

    @property
    def nuisances(self) -> tuple[str, ...]:
        """Names of what is estimated beside the model, the delay last; none where nothing moves."""

    @property
    def wide(self) -> Self | None:
        """The run in a wider band, where its delay is found beforehand; None where none is, or it is estimated."""

    @property
    def scale(self) -> Array | float:
        """What forces and A are multiplied by in a fit, shape (n,), or 1."""

    @property
    def noise_stated(self) -> bool:
        """Whether the noise that a case states explains the residuals."""

    @property
    def filtered(self) -> Filtered:
        """Effect of filtering or averaging on white noise of the recorded forces."""

    @property
    def noise_correlation(self) -> float:
        """Correlation of white noise between neighbours."""

    def regressors(self, delay: float) -> Array:
        """A at the instants t_k - delay, shape (n, 6, u)."""

    def linearised(self, delay: float, values: Array) -> Array:
        """A and the columns of the nuisances at values u, shape (n, 6, u + nuisances)."""

    def residuals(self, matrices: Array, values: Array) -> Array:
        """Recorded forces less the model, A u, shape (m, 6)."""

    def robust_covariance(
        self, matrices: Array, residuals: Array, weights: Array, whitening: Array | None
    ) -> Robust | None:
        """Covariance of u for noise that is not white; None for too few samples."""

    def without(self, left_out: Flags) -> Self:
        """The same without the samples that are marked, shape (n,)."""

    def series(self, delay: float, values: Array) -> Residuals:
        """Recorded forces beside the model's, at most the first `MOST_SAMPLES`."""

    def excerpt(self, times: int = 1) -> Self:
        """A part of a long run that stands for all of it, `fair_part`; the samples themselves where that is all."""

    def known_columns(self, delay: float, matrices: Array, values: Array) -> Array | None:
        """How A u changes with what was measured beside: the delay and biases of an accelerometer, shape (n, 6, 4)."""

    def refined(self, fit: Fit, basis: Array, w: Array, delay: float) -> Self:
        """The samples with further nuisances that a fit shows to be worth an estimate; as they are where none is.

        Args:
            fit: fit of them; its values begin with u.
            basis: basis of the free parameters, shape (u, free).
            w: W for one sample, shape (6, 6).
            delay: estimated delay [s].
        """

    def regressor_noise(self, w: Array, delay: float, sensors: Sensors) -> tuple[Array, float] | None:
        """Effect of stated noise of struts and accelerations on A; None where A does not come from struts.

        D, the expected sum of dA^T W dA, shape (u, u), and the variance of the accelerations of a strut by noise of
        the struts [m^2/s^4].
        """

    def findings(self, fit: Fit, w: Array) -> tuple[Finding, ...]:
        """What there is to say of how they were evaluated, after their fit with W for one sample, shape (6, 6)."""


class PlainSamples:
    """Samples of which nothing is measured beside, and nothing estimated further."""

    __slots__ = ()
    noise_stated: ClassVar[bool] = False

    def excerpt(self, times: int = 1) -> Self:
        """The samples themselves."""
        del times
        return self

    def known_columns(self, delay: float, matrices: Array, values: Array) -> Array | None:
        """None."""
        del delay, matrices, values
        return None

    def refined(self, fit: Fit, basis: Array, w: Array, delay: float) -> Self:
        """The samples themselves."""
        del fit, basis, w, delay
        return self

    def regressor_noise(self, w: Array, delay: float, sensors: Sensors) -> tuple[Array, float] | None:
        """None."""
        del w, delay, sensors
        return None

    def findings(self, fit: Fit, w: Array) -> tuple[Finding, ...]:
        """Nothing."""
        del fit, w
        return ()


@dataclass(frozen=True, slots=True)
class Standstills(PlainSamples):
    """Averaged standstills: nothing moves, nothing is filtered."""

    model: Model
    t: Array  # times, or numbers from 1, shape (n,)
    recorded: Array  # forces, shape (n, 6) [N, or N and N m]
    matrices: Array  # A, shape (n, 6, u)
    scale: Array  # what forces and A of each are multiplied by in a fit, shape (n,)
    clocked: bool = False  # whether they have a clock, so that noise may have memory
    window: ClassVar[tuple[Finding, ...]] = ()
    nuisances: ClassVar[tuple[str, ...]] = ()
    wide: ClassVar[None] = None  # nothing moves
    consecutive: ClassVar[bool] = False  # they may stand in any order
    filtered: ClassVar[Filtered] = Filtered()
    noise_correlation: ClassVar[float] = 1.0  # nothing is said of neighbours

    @property
    def forces(self) -> Array:
        """Weighted forces, shape (n, 6)."""
        return self.recorded * self.scale[:, None]

    @property
    def samples(self) -> int:
        """Number of standstills."""
        return len(self.recorded)

    def regressors(self, delay: float) -> Array:
        """Weighted A, shape (n, 6, u)."""
        del delay
        return self.matrices * self.scale[:, None, None]

    def linearised(self, delay: float, values: Array) -> Array:
        """Weighted A: there are no nuisances."""
        del values
        return self.regressors(delay)

    def residuals(self, matrices: Array, values: Array) -> Array:
        """Recorded forces less the model, not weighted, shape (n, 6)."""
        return np.asarray(self.recorded - matrices @ values / self.scale[:, None])

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

    def without(self, left_out: Flags) -> "Standstills":
        """The standstills that are not marked, shape (n,)."""
        mask = ~left_out
        return Standstills(
            self.model, self.t[mask], self.recorded[mask], self.matrices[mask], self.scale[mask], self.clocked
        )


@dataclass(frozen=True, slots=True)
class Conditioning:
    """What a user asks to be done to a run."""

    # estimate the lowest structural mode of a moving run with the parameters, behind a low-pass at half its frequency
    flexible: bool = False
    standstills: bool = False  # average the run's standstills, wherever they are


USUAL = Conditioning()
