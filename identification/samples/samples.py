"""What an estimate is made from (times, forces, regressors at a delay, properties of the noise), and the fit to it.

Averaged standstills are such samples, runs that move others.
The delay between forces and motion, where there is one, is estimated with the parameters.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple, Self

import numpy as np
from scipy.linalg import block_diag

from cases.base.errors import Code, IdentificationError
from cases.base.phrases import phrase
from cases.base.units import Array, Flags, Indices
from cases.sensors import Sensors
from identification.estimation.estimators import (
    ALIKE,
    Method,
    estimate_selected,
    full_whitening,
    gauss_markov_of,
    independent_poses,
)
from identification.estimation.fit import Filtered, Fit, Regression, Robust, Value, inverse_root, joint_triangle
from identification.estimation.force_noise import long_run_covariance, scores
from identification.finding import Finding
from identification.machines.machine import Kinematics, Machine
from identification.model.blocks import MASS
from identification.model.model import Model
from identification.model.stated_noise import noise_covariance, whitening_of
from identification.signals import Filter, Residuals

MOST_DELAY = 0.04  # [s] between forces and motion that is looked for, either way
DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-9  # [s]; what remains of the delay is in the nuisance of the fit
CLOSE = 1e-5  # [s] the same where the search began close to it: the square is a hundredth of the noise of the samples
EXCERPTS = (1, 8)  # parts of a long run by which the search begins, see `fair_part`
GAUSS_MARKOV = Method()


class MotionOfSamples(NamedTuple):
    """How the load's frame moves at the samples, and the drives that say so."""

    known: Flags  # samples at which it is known, shape (n,); at others it means nothing
    load: Kinematics  # motion of {P}; its position is zero where only orientations are known
    drives: tuple[Array, Array, Array] | None = None  # place, speed, acceleration, shapes (n, k) [m or rad]
    machine: Machine | None = None  # machine of these drives
    noise: Array | None = None  # white noise of the drives, shape (k,) [m or rad]
    acceleration_noise: Array | None = None  # noise of their accelerations behind the filter of the fit, shape (k,)
    calm: bool = True  # whether next to nothing of the motion is such noise
    by_accelerometer: bool = (
        False  # whether an accelerometer says how {P} accelerates: then gravity and clocks do not matter to it
    )

    def moved(self, place: Array, speed: Array, acceleration: Array) -> Kinematics:
        """The motion of {P} where drives say something else, but near it."""
        assert self.machine is not None
        near = self.load.pose if self.machine.of_pose else None
        return self.machine.kinematics(place, speed, acceleration, near)

    def at(self, rows: Indices | slice) -> "MotionOfSamples":
        """The motion at some of the samples."""
        load = Kinematics(*(of[rows] for of in (self.load.pose, self.load.twist, self.load.twist_rate)))
        drives = None if self.drives is None else (self.drives[0][rows], self.drives[1][rows], self.drives[2][rows])
        return self._replace(known=self.known[rows], load=load, drives=drives)

    @property
    def of_pose(self) -> bool:
        """Whether its machine is one whose coordinates are the pose."""
        return self.machine is not None and self.machine.of_pose


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples(ABC):
    """What an estimate is made from, whatever the recording was: estimators and checks ask for nothing else."""

    model: Model  # gives A
    t: Array  # times, shape (n,) [s]; of standstills without a clock their numbers from 1
    recorded: Array  # forces as recorded, shape (n, 6) [N, or N and N m]
    forces: Array  # forces as the estimator uses them, shape (n, 6)
    recorded_count: int  # number of recorded samples that they stand for
    window: tuple[Finding, ...] = ()  # findings about the part of the recording that they are from
    scale: Array | float = 1.0  # what forces and A are multiplied by in a fit, shape (n,)
    # names of what is estimated beside the model, the delay last; none where nothing moves
    nuisances: tuple[str, ...] = ()
    # the run in a wider band, where its delay is found beforehand; None where none is, or it is estimated
    wide: "Samples | None" = None
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

    def motion(self, delay: float) -> MotionOfSamples | None:
        """How the load moves at the samples; None where that is not known."""
        del delay
        return None

    def columns(self, delay: float, values: Array, names: Sequence[str]) -> Array | None:
        """Columns of a fit at values u in `motion`, by names of parameters and nuisances, shape (n, 6, v).

        None where drives say that motion.
        """
        del delay, values, names
        return None

    def without(self, left_out: Flags) -> Self:
        """The same without the samples that are marked, shape (n,)."""
        mask = ~left_out
        entries = {name: getattr(self, name)[mask] for name in self.each}
        return replace(self, recorded_count=round(self.recorded_count * float(mask.mean())), **entries)

    def excerpt(self, times: int = 1) -> Self:
        """A part of a long run that stands for all of it, `fair_part`; the samples themselves where that is all."""
        del times
        return self

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

    def findings(self, fit: Fit) -> tuple[Finding, ...]:
        """What there is to say of how they were evaluated, after their fit."""
        del fit
        return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingSamples(Samples):
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
    def sources(self) -> Array:
        """Autocovariances behind the filter of what is white before it, as of `Turned`, shape (2, l)."""
        return np.array([self.filter.autocovariance(order) for order in (0, 2)])

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
    standing: MotionOfSamples | None = None  # how the load stands at each
    each: ClassVar[tuple[str, ...]] = (*Samples.each, "matrices", "scale")

    def without(self, left_out: Flags) -> Self:
        """As of all samples; the motion at each is one of their values."""
        remaining = super(Standstills, self).without(left_out)
        return (
            remaining
            if self.standing is None
            else replace(remaining, standing=self.standing.at(np.flatnonzero(~left_out)))
        )

    def regressors(self, delay: float) -> Array:
        """Weighted A, shape (n, 6, u)."""
        del delay
        return self.matrices * self.scale[:, None, None]

    def motion(self, delay: float) -> MotionOfSamples | None:
        """How the load stands at each."""
        del delay
        return self.standing

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


class Fitted(NamedTuple):
    """Samples with their fit."""

    samples: Samples  # samples that were evaluated
    method: Method
    sensors: Sensors  # their noise, where the weights follow from what is stated
    fit: Fit
    delay: Value | None  # how much later than the motion the forces were recorded [s]; None where nothing moves
    residuals: Array  # residuals of the forces as recorded, shape (m, 6)
    whitening: Array | None  # W is its square, where it is given
    w: Array  # W for one sample, shape (6, 6)
    regression: Regression  # A and the nuisances, and the forces as the estimator saw them, not whitened

    @property
    def at(self) -> float:
        """The delay, 0 where nothing moves [s]."""
        return 0.0 if self.delay is None else self.delay.value

    def again(self, samples: Samples) -> "Fitted":
        """The same fit to other samples; a delay that was fixed stays so."""
        fixed = None if self.regression.nuisance == len(self.samples.nuisances) else self.delay
        return fit_samples(samples, self.method, self.sensors, self.at, fixed)


def fit_samples(
    samples: Samples, how: Method, sensors: Sensors, delay: float = 0.0, fixed_delay: Value | None = None
) -> Fitted:
    """The fit by Gauss-Newton over the delay, which stays in the last fit as a nuisance: its uncertainty counts.

    For a long run the search begins with the fit to a part of it.

    Args:
        sensors: they state noise, and weights where the method has none of its own.
        delay: delay to start from [s].
        fixed_delay: a known delay, which is not estimated; its standard deviation is propagated.
    """
    model, nuisance_count = samples.model, len(samples.nuisances) - (fixed_delay is not None)
    delay = delay if fixed_delay is None else fixed_delay.value
    near = None
    for times in EXCERPTS:
        part = samples.excerpt(times)
        if part is not samples:
            with suppress(IdentificationError):  # where a part determines too little, the whole run is fitted at once
                steps = DELAY_STEPS if near is None else 1
                delay, near, _, _ = _converged(part, how, sensors, nuisance_count, delay, near, steps)
    delay, _, regression, whitening = _converged(samples, how, sensors, nuisance_count, delay, near)
    columns, raised = regression.regressors, 1.0
    if how.weights == "full":
        whitening, raised = full_whitening(regression, how.selection(model))
        regression = regression._replace(alike=None)
    white = regression.whitened(whitening)
    how, method_findings = how.settled(white, model)
    basis = block_diag(how.selection(model).basis, np.eye(nuisance_count))
    fit = how.estimate(white, model)
    fit = replace(fit, findings=(*fit.findings, *method_findings))
    if how.robust and not how.priors and how.weights != "huber":
        free = white.regressors if np.array_equal(basis, np.eye(len(basis))) else white.regressors @ basis
        robust = samples.robust_covariance(free, fit.residuals, fit.weights, whitening)
        if robust is not None:
            findings = (*fit.findings, *robust.findings)
            covariance = basis @ robust.covariance @ basis.T
            fit = replace(fit, covariance_robust=covariance, findings=findings, field=robust.field)
            if robust.sources is not None:
                fit = replace(fit, covariance=basis @ robust.sources @ basis.T)
    fit = replace(fit, covariance=raised * fit.covariance, covariance_robust=raised * fit.covariance_robust)
    w = np.diag(fit.weights)
    if whitening is not None:  # the residuals are those of the forces themselves
        w = whitening.T @ whitening
        fit = replace(fit, residuals=regression.residuals(fit.values), weights=np.sum(whitening**2, axis=0))
    require_sense(model, fit)
    has_delay = bool(samples.nuisances) and fixed_delay is None  # the last of the values is a step of the delay
    count = len(regression.names) - has_delay
    residuals = samples.recorded - samples.predicted(columns[:, :, :count], fit.values[:count])
    if fixed_delay is not None:  # an error of it moves the estimate (Schmidt 1966, Adv. Control Syst. 3:293)
        effect = samples.linearised(delay, fit.values[: len(model.names)])[:, :, -1]
        moves = fixed_delay.std * basis @ _gain(columns @ basis, w, effect)
        more = np.outer(moves, moves)
        fit = replace(fit, covariance=fit.covariance + more, covariance_robust=fit.covariance_robust + more)
    if has_delay:
        value = delay + (float(fit.values[-1]) if abs(fit.values[-1]) < CLOSE else 0.0)
        std = float(np.sqrt(max(fit.covariance[-1, -1], fit.covariance_robust[-1, -1])))
        fixed_delay = Value(value, std, std, "s")
    return Fitted(samples, how, sensors, fit, fixed_delay, residuals, whitening, w, regression)


def _converged(
    run: Samples,
    method: Method,
    sensors: Sensors,
    beside: int,
    delay: float,
    near: Array | None = None,
    steps: int = DELAY_STEPS,
) -> tuple[float, Array | None, Regression, Array | None]:
    """Gauss-Newton over the delay [s], from u of a part of the run, `near`: delay, u, regression and its whitening."""
    forces, model, selection, weights = run.forces, run.model, method.selection(run.model), method.weights_for(sensors)
    names, alike = [*model.names, *run.nuisances[:beside]], ALIKE[weights]
    whitening, values, unknowns = None, near, len(model.names)
    if not run.nuisances:
        if weights == "stated" and sensors.force_noise is not None:  # vibration averages out
            whitening = np.diag(1.0 / sensors.force_noise)
        return delay, None, Regression(run.regressors(delay), forces, names, beside, run.filtered, alike), whitening
    for _ in range(steps):
        regression = columns = None  # of a long run there is room for one
        if values is None:
            # The effect of the delay follows from the best forces so far, whatever parameters make them.
            channels, matrices = forces.std(axis=0), run.regressors(delay)
            scale = np.ones(6) if alike is None else 1.0 / np.where(channels > 0.0, channels, 1.0)
            top = joint_triangle(matrices @ selection.basis, forces - matrices @ selection.offset, scale)
            free = np.linalg.lstsq(top[:, :-1], top[:, -1], rcond=forces.size * np.finfo(float).eps)[0]
            values = selection.offset + selection.basis @ free
            del matrices
        if weights == "stated":
            whitening = whitening_of(noise_covariance(model, sensors, values))
        columns = run.linearised(delay, values)[:, :, : unknowns + beside]
        regression = Regression(columns, forces, names, beside, run.filtered, alike)
        estimate = estimate_selected(regression.whitened(whitening), selection, gauss_markov_of).values
        values = estimate[:unknowns]
        if len(run.nuisances) > beside:
            break
        step = float(np.clip(estimate[-1], -MOST_DELAY / 2, MOST_DELAY / 2))
        if abs(step) < (DELAY_TOLERANCE if near is None else CLOSE):
            break
        delay = float(np.clip(delay + step, -MOST_DELAY, MOST_DELAY))
    if abs(delay) >= MOST_DELAY:
        raise IdentificationError(
            problem=phrase(
                "no_delay",
                "no delay up to {most} ms brings forces and motion together",
                most=f"{MOST_DELAY * 1000.0:.0f}",
            ),
            remedy=phrase("record_one_clock", "record them in one run, with one clock"),
            code=Code.NO_CONVERGENCE,
        ).in_doubt()
    assert regression is not None
    return delay, values, regression, whitening


def _gain(regressors: Array, w: Array, effect: Array) -> Array:
    """How a fit weighted by W, shape (6, 6), changes with a unit error that has an effect, shape (n, 6), shape (v,)."""
    root = np.linalg.cholesky(w).T
    weighted = (root @ regressors).reshape(-1, regressors.shape[2])
    half = inverse_root(weighted)
    return np.asarray(half @ ((weighted @ half).T @ (effect @ root.T).ravel()))


def require_sense(model: Model, fit: Fit) -> None:
    """Raises IdentificationError, of the quantity m, where the mass is negative for certain."""
    if MASS not in model.blocks:
        return
    mass = model.names.index("m")
    value, std = float(fit.values[mass]), float(np.sqrt(fit.covariance[mass, mass]))
    if std > 0.0 and value < -3.0 * std:
        error = IdentificationError(
            problem=phrase(
                "negative_mass", "the mass comes out as {mass} +- {std} kg", mass=f"{value:.4g}", std=f"{std:.2g}"
            ),
            remedy=phrase(
                "check_signs",
                "check the sign of the forces, sensor_frame.transducer.sense and gravity_m_s2 of the case",
            ),
            code=Code.MISFIT,
        )
        error.quantity = "m"
        raise error.in_doubt()
