"""Physically consistent inertia: the least chi^2 among the parameters that some body of positive density has.

Wensing, Kim & Slotine 2018, IEEE Robot. Autom. Lett. 3(1):60: mass, first moment h and inertia belong to such a body
if and only if the pseudo-inertia matrix J = (Sigma h; h^T m), Sigma = 1/2 tr(I) 1 - I, is positive definite. J is
linear in u, so that the problem is convex; its size is that of u, whatever the length of the run.
"""

import warnings
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from scipy.special import fdtrc

from cases.errors import IdentificationError
from cases.units import Array
from identification.estimation.fit import Fit, Regression
from identification.finding import Kind, note, warning
from identification.parameters import FIRST_MOMENT, INERTIA, MASS, pseudo_inertia

# [m] rms distance of a body's mass from any plane through its centre of gravity, at least: of a sheet of thickness d
# d / sqrt(12), thinner than any tool or workpiece; above 0, since a body on the bound has no volume otherwise
THINNEST = 1e-3
UNLIKELY = 1e-3  # chance of so inconsistent an estimate below which it is reported
BODY = tuple(p.name for block in (MASS, FIRST_MOMENT, INERTIA) for p in block.parameters)
_NONE = "no consistent body was found"
ACCURACIES = (1e-9, 1e-7)  # of the solver: 1e-9 gives 1e-6 standard deviations, but is not always within its reach


def consistent(regression: Regression, free: Fit) -> tuple[Fit, float, float]:
    """The consistent estimate nearest to a free one, in chi^2.

    Its covariances, s0 and degrees of freedom are those of the free one: the projection onto a convex set that holds
    the truth brings the estimate nearer to it (in the metric of F), so that the confidence ellipsoid of (28) holds the
    truth at least as often (ours).

    Args:
        free: estimate of a Gauss-Markov estimator; chi^2 rises from it by (u - free)^T F (u - free), F and s0
            being in its covariance.

    Returns:
        The estimate, the rise of chi^2 by the constraint over s0^2, 0 where it did not bind, and the probability that
        noise makes a consistent body look as inconsistent as this or more, at most: a tiny one says that the model or
        the data are wrong, not that it is chance.

    Raises:
        IdentificationError: the model has no inertia, so that any positive mass is consistent; or no body is found.
    """
    names = list(regression.names)
    missing = [name for name in BODY if name not in names]
    if missing:
        raise IdentificationError(
            f"{', '.join(missing)} not in the model; physical consistency needs all of {', '.join(BODY)}: models 6 to 9"
        )
    index = [names.index(name) for name in BODY]
    basis = np.array([pseudo_inertia(unit) for unit in np.eye(len(BODY))])
    basis[0, :3, :3] -= THINNEST**2 * np.eye(3)  # Sigma_C >= m thinnest^2, as one LMI (Schur complement; ours)
    start = np.einsum("kij,k->ij", basis, free.values[index])
    if np.linalg.eigvalsh(start)[0] >= 0.0:
        return free, 0.0, 1.0
    # The covariance of the body alone moves the rest along: what is inconsistent has ten unknowns, in all models.
    root = _root(free.covariance)
    root = root @ np.linalg.qr(root[index].T)[0]
    step = _nearest(start, np.einsum("kij,kr->rij", basis, root[index]))
    values = free.values + root @ step
    if np.linalg.eigvalsh(pseudo_inertia(values[index]))[0] <= 0.0:
        raise IdentificationError(_NONE, "the data want a mass below zero; check the sense of the sensor")
    rise, freedoms = float(step @ step), np.linalg.matrix_rank(root[index] / _unit(free.covariance)[index, None])
    # The truth is consistent: it is at least as far from the free estimate as the nearest consistent one.
    p_value = float(fdtrc(freedoms, free.freedom, rise / freedoms))
    return replace(free, values=values, residuals=regression.residuals(values)), rise, p_value


def consistent_of(regression: Regression, free: Fit) -> Fit:
    """The same, and whether the constraint bound."""
    fit, rise, p_value = consistent(regression, free)
    sentence = "consistent: the estimate is that of a real body, the constraint did not bind"
    if rise:
        sentence = f"consistent: the constraint bound and raised chi^2 by {rise:.3g} s0^2; chance does so in at most "
        sentence += f"{100 * p_value:.2g} % of runs"
    findings = (*fit.findings, note(Kind.ESTIMATOR, sentence))
    if rise and p_value < UNLIKELY:
        far = "no real body is near what the data say; model or data are wrong"
        findings = (*findings, warning(Kind.ESTIMATOR, far))
    return replace(fit, findings=findings)


def _unit(covariance: Array) -> Array:
    """Standard deviation of each parameter, 1 where it is fixed, shape (u,)."""
    std = np.sqrt(np.diag(covariance))
    return np.where(std > 0.0, std, 1.0)


def _root(covariance: Array) -> Array:
    """S with S S^T = covariance, shape (u, r), r < u where parameters are fixed."""
    unit = _unit(covariance)
    variances, directions = np.linalg.eigh(covariance / np.outer(unit, unit))
    significant = variances > len(unit) * np.finfo(float).eps * variances[-1]
    return np.asarray(unit[:, None] * directions[:, significant] * np.sqrt(variances[significant]))


def _nearest(start: Array, slopes: Array) -> Array:
    """The shortest z, shape (r,), with start + sum z_k slopes_k, shapes (4, 4) and (r, 4, 4), positive semidefinite."""
    # Loaded here: it takes a second, and most estimates are consistent without it. Its types stop half way.
    cp: Any = import_module("cvxpy")

    # A congruence keeps definiteness; kg, kg m and kg m^2 become numbers about 1.
    size = 1.0 / np.sqrt(np.abs(np.diag(start)) + np.linalg.norm(np.diagonal(slopes, axis1=1, axis2=2), axis=0))
    scaled, flat = start * np.outer(size, size), (slopes * np.outer(size, size)).reshape(len(slopes), 16)
    z = cp.Variable(len(slopes))
    matrix = cp.reshape(flat.T @ z, (4, 4), order="C") + scaled
    problem = cp.Problem(cp.Minimize(cp.sum_squares(z)), [matrix >> 0])
    for accuracy in ACCURACIES:
        tolerances = {"tol_gap_abs": accuracy, "tol_gap_rel": accuracy, "tol_feas": accuracy}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what cvxpy warns of is in the status
                problem.solve(solver=cp.CLARABEL, **tolerances)
        except cp.SolverError as error:
            raise IdentificationError(f"{_NONE}: Clarabel: {error}".splitlines()[0]) from error
        if problem.status == cp.OPTIMAL:
            return np.asarray(z.value, dtype=float)
    raise IdentificationError(_NONE, f"Clarabel ends with {problem.status}; the free estimate is too far from any body")
