"""What a fit leaves of a run, by which everything that it may miss is judged."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from cases.base.units import Array, Indices
from identification.estimation.alternatives import Remainder
from identification.samples.moving import FORGOTTEN
from identification.samples.samples import Fitted, MovingSamples, Samples, Standstills
from identification.signals import fair_part

EXCERPT = 0.25  # of `fair_part` of a long run, by which it is judged: enough for effects far below what matters


def excerpt_of(fitted: Fitted) -> tuple[Fitted, Indices]:
    """A fit by a part of a long run that stands for it, and the samples that it is."""
    count = len(fitted.fit.residuals)
    part = fair_part(count, EXCERPT)
    if len(part) == count:
        return fitted, part
    left_out = np.ones(count, dtype=bool)
    left_out[part] = False
    fit, regression = fitted.fit, fitted.regression
    regression = regression._replace(regressors=regression.regressors[part], forces=regression.forces[part])
    fit = replace(fit, residuals=fit.residuals[part], freedom=fit.freedom * len(part) / count)
    return fitted._replace(samples=fitted.samples.without(left_out), regression=regression, fit=fit), part


def free_basis(fitted: Fitted) -> Array:
    """Basis of what was free in a fit: parameters, then nuisances, shape (v, free)."""
    return np.asarray(
        block_diag(fitted.method.selection(fitted.samples.model).basis, np.eye(fitted.regression.nuisance))
    )


def remainder_of(fitted: Fitted, smooth: Array | None = None) -> Remainder:
    """What a fit without priors leaves.

    Args:
        smooth: its regressors without noise of the drives, shape (n, 6, v); where not known, those that it had.
    """
    samples, basis, regressors = fitted.samples, free_basis(fitted), fitted.regression.regressors
    places = np.arange(len(samples.t))
    coloured = not isinstance(samples, Standstills) or samples.clocked
    if coloured:  # stretches between gaps are so far apart that noise is independent
        places = np.r_[0, np.cumsum(np.clip(np.diff(_places(samples)), 1, FORGOTTEN))]
    return Remainder.of(
        regressors @ basis,
        (regressors if smooth is None else smooth) @ basis,
        fitted.fit.residuals,
        fitted.w,
        places,
        coloured=coloured,
        freedom=fitted.fit.freedom,
    )


def _places(samples: Samples) -> Indices:
    """Places of samples with a clock in a series of equal steps, shape (n,)."""
    if isinstance(samples, MovingSamples):
        return samples.places
    step = max(float(np.median(np.diff(samples.t))), 1e-9)
    return np.asarray(np.rint((samples.t - samples.t[0]) / step), dtype=np.int64)
