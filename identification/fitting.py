"""A fit to samples: the delay between forces and motion, where there is one, is estimated with the parameters."""

from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from cases.errors import IdentificationError
from cases.sensors import Sensors
from cases.units import Array
from identification.estimation.estimators import ALIKE, Method, estimate_selected, gauss_markov_of, method
from identification.estimation.fit import Fit, Regression, Value, inverse_root, joint_triangle
from identification.model import Model, noise_covariance, whitening_of
from identification.parameters import MASS, Selection, offset_columns
from identification.runs.evaluation import MOST_DELAY
from identification.samples import Samples

DELAY_STEPS = 8
DELAY_TOLERANCE = 1e-9  # [s]; what remains of the delay is in the nuisance of the fit
CLOSE = 1e-5  # [s] the same where the search began close to it: the square is a hundredth of the noise of the samples
TURNS = 3  # of weights and parameters; the weights need the parameters to a percent only
EXCERPTS = (1, 8)  # parts of a long run by which the search begins, see `fair_part`
SANDWICHED = ("gauss-markov", "consistent")  # whose robust covariance is the sandwich of the weights alone
GAUSS_MARKOV = method()


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
    model, beside = samples.model, len(samples.nuisances) - (fixed_delay is not None)
    delay = delay if fixed_delay is None else fixed_delay.value
    near = None
    for times in EXCERPTS:
        part = samples.excerpt(times)
        if part is not samples:
            with suppress(IdentificationError):  # where a part determines too little, the whole run is fitted at once
                steps = DELAY_STEPS if near is None else 1
                delay, near, _, _ = _converged(part, how, sensors, beside, delay, near, steps)
    delay, _, regression, whitening = _converged(samples, how, sensors, beside, delay, near)
    columns, white = regression.regressors, regression.whitened(whitening)
    basis = block_diag(how.selection(model).basis, np.eye(beside))
    fit = how.estimate(white, model)
    if how.name in SANDWICHED and not how.priors:
        free = white.regressors if np.array_equal(basis, np.eye(len(basis))) else white.regressors @ basis
        robust = samples.robust_covariance(free, fit.residuals, fit.weights, whitening)
        if robust is not None:
            findings = (*fit.findings, *robust.findings)
            covariance = basis @ robust.covariance @ basis.T
            fit = replace(fit, covariance_robust=covariance, findings=findings, field=robust.field)
    w = np.diag(fit.weights)
    if whitening is not None:  # the residuals are those of the forces themselves
        w = whitening.T @ whitening
        fit = replace(fit, residuals=regression.residuals(fit.values), weights=np.sum(whitening**2, axis=0))
    require_sense(model, fit)
    has_delay = bool(samples.nuisances) and fixed_delay is None  # the last of the values is a step of the delay
    own = len(regression.names) - has_delay
    residuals = samples.recorded - samples.predicted(columns[:, :, :own], fit.values[:own])
    more = np.zeros_like(fit.covariance)
    if how.biases is not None:
        offsets = offset_columns(model)
        moves = -basis @ _gain(columns @ basis, w, columns[:, :, offsets])
        moves[offsets] += np.eye(6)
        more += moves @ how.biases.covariance @ moves.T
    unknowns, effects = len(model.names), None
    if how.biases is not None or fixed_delay is not None:
        effects = samples.known_columns(delay, columns[:, :, :unknowns], fit.values[:unknowns])
    if effects is not None:
        moves = basis @ _gain(columns @ basis, w, effects)
        if how.biases is not None:
            covariance = np.array(how.biases.require_accelerometer().covariance_m2_s4)
            more += moves[:, 1:] @ covariance @ moves[:, 1:].T
        if fixed_delay is not None:
            more += fixed_delay.std**2 * np.outer(moves[:, 0], moves[:, 0])
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
        still = run.regressors(delay)
        if weights == "stated":
            whitening = _whitening_from(still, forces, selection, model, sensors)
        return delay, None, Regression(still, forces, names, beside, run.filtered, alike), whitening
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
            f"no delay up to {MOST_DELAY * 1e3:.0f} ms brings forces and motion together; are they "
            "of one run, and struts and forces in the order of the case?"
        )
    assert regression is not None
    return delay, values, regression, whitening


def _gain(regressors: Array, w: Array, columns: Array) -> Array:
    """How a fit weighted by W, shape (6, 6), changes with unit errors along columns, shape (n, 6, k), shape (v, k)."""
    root = np.linalg.cholesky(w).T
    weighted = (root @ regressors).reshape(-1, regressors.shape[2])
    half = inverse_root(weighted)
    return np.asarray(half @ ((weighted @ half).T @ (root @ columns).reshape(-1, columns.shape[2])))


def _whitening_from(matrices: Array, forces: Array, selection: Selection, model: Model, sensors: Sensors) -> Array:
    """Root of W by stated noise, with u from the data themselves in turns with it, shape (6, 6)."""
    assert sensors.force_noise is not None
    whitening = np.diag(1.0 / sensors.force_noise)
    for _ in range(TURNS):
        target = (forces - matrices @ selection.offset) @ whitening.T
        reduced = (whitening @ matrices @ selection.basis).reshape(-1, selection.basis.shape[1])
        free = np.linalg.lstsq(reduced, target.ravel(), rcond=None)[0]
        whitening = whitening_of(noise_covariance(model, sensors, selection.offset + selection.basis @ free))
    return whitening


def require_sense(model: Model, fit: Fit) -> None:
    """Raises IdentificationError, of the quantity m, where the mass is negative for certain."""
    if MASS not in model.blocks:
        return
    mass = model.names.index("m")
    value, std = float(fit.values[mass]), float(np.sqrt(fit.covariance[mass, mass]))
    if std > 0.0 and value < -3.0 * std:
        error = IdentificationError(
            f"the mass comes out as {value:.4g} +- {std:.2g} kg; check the sign of the forces, "
            "sensor_frame.transducer.sense and gravity_m_s2 of the case"
        )
        error.quantity = "m"
        raise error
