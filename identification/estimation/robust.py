"""Estimates that stay sound where Gauss-Markov's is not: gross errors of the forces, and parameters that no body has.

Huber's M-estimate by iteratively reweighted least squares (IRLS): gross errors count less, none is removed.
Huber & Ronchetti 2009, Robust Statistics, chapter 7. Only errors of the forces are resisted, not those of the
regressor, and one-sided ones still bias: a share e of them by up to about 1.6 e of the noise's standard deviation.

Physically consistent inertia: the least chi^2 among the parameters that some body of positive density has. Wensing,
Kim & Slotine 2018, IEEE Robot. Autom. Lett. 3(1):60: mass, first moment h and inertia belong to such a body if and only
if the pseudo-inertia matrix J = (Sigma h; h^T m), Sigma = 1/2 tr(I) 1 - I, is positive definite. J is linear in u, so
that the problem is convex; its size is that of u, whatever the length of the run.
"""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import fdtrc

from cases.errors import IdentificationError
from cases.units import Array
from identification.estimation.compressed import column_scale, gauss_markov, long_run_covariance, settled
from identification.estimation.fit import EACH, Fit, Regression
from identification.parameters import FIRST_MOMENT, INERTIA, INERTIA_INDEX, MASS

HUBER_K = 1.345  # residuals beyond so many standard deviations count less: 95 % efficiency where noise is Gaussian
MAD_TO_STD = 1.482602218505602  # 1 / Phi^-1(3/4): makes the MAD of Gaussian noise its standard deviation
MEAN_SQUARE_PSI = 0.710165  # E psi(z)^2 for Gaussian z and HUBER_K: makes s0 that of Gaussian noise
ROUNDS = 100
TOLERANCE = 1e-7  # of a standard deviation of each parameter: far below what matters, far above rounding
SILENT = 1e-12  # of the largest force: smaller residuals of a channel are rounding, not noise


def huber(regression: Regression, pooled: bool, alike: Sequence[int] = EACH) -> tuple[Fit, Array]:
    """Huber's M-estimate of u with the scale of the noise estimated in turns.

    Its covariance is the sandwich of Huber 1967 and White 1980, right also where the spread of the forces changes over
    the run; weights are one over the squared normalised MAD of each channel, or ones where the scale is pooled. A
    low-pass smears gross errors, so look for them before it.

    Args:
        pooled: one scale for all channels (identical sensors), else one for each (mixed units).
        alike: number of each channel; where scales are not pooled, equal numbers share one.

    Returns:
        The fit, and the weight of each force, from 0 to 1, shape (n, 6): below 1 for 18 % of Gaussian noise.

    Raises:
        IdentificationError: as `gauss_markov`; or a channel fits without any residual.
    """
    regressors, forces, filtered = regression.regressors, regression.forces, regression.filtered
    samples, sensors, unknowns = regressors.shape
    kind = np.zeros(6, dtype=int) if pooled else np.asarray(alike)
    std = np.array([np.sqrt(np.mean(forces.var(axis=0)[kind == k])) for k in kind])
    spread = np.ones(6) if pooled else np.maximum(std, 1e-12 * max(float(std.max()), 1e-300))
    least = np.zeros(6) if pooled else SILENT * np.abs(forces).max() / spread
    start = gauss_markov(regression, spread**-2.0)
    matrix = (regressors / spread[:, None]).reshape(-1, unknowns)
    scale = column_scale(matrix)
    q, r = np.linalg.qr(matrix * scale)  # in the coordinates v = R u the information is that of the weights alone
    right = (forces / spread).ravel()
    v, rows = q.T @ right, samples * sensors
    # Residuals are smaller than the noise by what the unknowns took, see `gauss_markov` for filtered data.
    shrunk = np.sqrt(rows * filtered.gain * filtered.stride / start.freedom)
    floor = 1e-14 * float(np.linalg.norm(right))
    converged, rounds = False, 0
    while not converged and rounds < ROUNDS:
        residuals = right - q @ v
        noise = _noise(residuals.reshape(-1, 6), kind, least) * shrunk
        attention = _attention(residuals, noise)
        weighted = q * (attention / noise**2)[:, None]
        new = np.linalg.solve(q.T @ weighted, weighted.T @ right)
        converged = bool(np.abs(new - v).max() <= TOLERANCE * noise.min() + floor)
        v, rounds = new, rounds + 1
    residuals = right - q @ v
    noise = _noise(residuals.reshape(-1, 6), kind, least) * shrunk
    psi = np.clip(residuals / noise, -HUBER_K, HUBER_K)
    back = scale[:, None] * solve_triangular(r, np.eye(unknowns))
    spread_of_u = back @ _bread(q, residuals, noise)
    meat = (q * (psi / noise)[:, None] ** 2).T @ q * (rows / start.freedom)
    influence = (q * (psi / noise)[:, None]).reshape(samples, sensors, unknowns).sum(axis=1)
    recorded = noise[:6] * spread / np.sqrt(filtered.gain)  # of the forces before the filter
    values = back @ v
    s0 = float(shrunk * np.sqrt(np.mean(psi**2) / MEAN_SQUARE_PSI))  # Huber's proposal 2, for a scale near it
    fit = Fit(
        values=values,
        covariance=spread_of_u @ meat @ spread_of_u.T,
        covariance_robust=spread_of_u @ long_run_covariance(influence) @ spread_of_u.T,
        s0=s0 * float(recorded[0]) if pooled else s0,
        freedom=start.freedom,
        residuals=regression.residuals(values),
        weights=np.ones(6) if pooled else recorded**-2.0,
        rank=start.rank,
        condition=start.condition,
        findings=settled("robust", converged, rounds),
    )
    return fit, _attention(residuals, noise).reshape(samples, sensors)


def _noise(residuals: Array, kind: NDArray[np.int_], least: Array) -> Array:
    """Normalised MAD about zero, which the offsets make the centre, one value a force, shape (6 n,)."""
    size = np.abs(residuals)
    mad = np.array([np.median(size[:, kind == k]) for k in kind])
    silent = mad <= least
    if silent.any():
        raise IdentificationError(
            f"channel {int(np.argmax(silent)) + 1} fits without any residual; check it, record more, or pool the scales"
        )
    return np.tile(MAD_TO_STD * mad, len(residuals))


def _attention(residuals: Array, noise: Array) -> Array:
    """psi(z) / z of Huber's psi, shape (6 n,)."""
    return np.minimum(1.0, HUBER_K * noise / np.maximum(np.abs(residuals), np.finfo(float).tiny))


def _bread(q: Array, residuals: Array, noise: Array) -> Array:
    """Inverse of the sum of psi' a a^T in the coordinates of q, shape (u, u)."""
    inner = q[np.abs(residuals) <= HUBER_K * noise]
    slope = noise[np.abs(residuals) <= HUBER_K * noise] ** -2.0
    information = (inner * slope[:, None]).T @ inner
    if np.linalg.cond(information) > 1.0 / np.finfo(float).eps:
        raise IdentificationError("too few forces agree with each other for a covariance of the robust estimate")
    return np.asarray(np.linalg.inv(information))


BODY = tuple(p.name for block in (MASS, FIRST_MOMENT, INERTIA) for p in block.parameters)
_NONE = "no consistent body was found"
ACCURACIES = (1e-9, 1e-7)  # of the solver: 1e-9 gives 1e-6 standard deviations, but is not always within its reach


def pseudo_inertia(body: Array) -> Array:
    """J of the ten parameters m, m xC, I11 I12 I13 I22 I23 I33 about the origin of {P}, shape (4, 4)."""
    return np.asarray(np.einsum("kij,k->ij", _BASIS, body))


def _basis() -> Array:
    """J of each unit vector of the ten parameters, shape (10, 4, 4)."""
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1.0
    for axis in range(3):
        basis[1 + axis, axis, 3] = basis[1 + axis, 3, axis] = 1.0
    for k, (i, j) in enumerate(INERTIA_INDEX):
        unit = np.zeros((3, 3))
        unit[i, j] = unit[j, i] = 1.0
        basis[4 + k, :3, :3] = 0.5 * np.trace(unit) * np.eye(3) - unit
    return basis


_BASIS = _basis()


def consistent(regression: Regression, free: Fit, thinnest: float) -> tuple[Fit, float, float]:
    """The consistent estimate nearest to a free one, in chi^2.

    Its covariances, s0 and degrees of freedom are those of the free one: the projection onto a convex set that holds
    the truth brings the estimate nearer to it (in the metric of F), so that the confidence ellipsoid of (28) holds the
    truth at least as often (ours).

    Args:
        free: estimate of a Gauss-Markov estimator; chi^2 rises from it by (u - free)^T F (u - free), F and s0
            being in its covariance.
        thinnest: rms distance of the body's mass from any plane through its centre of gravity, at least [m]. A sheet
            of thickness d has d / sqrt(12); above 0, since a body on the bound has no volume otherwise.

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
    if not 0.0 < thinnest < np.inf:
        raise IdentificationError(f"thinnest = {thinnest:g} m must be above zero")
    index = [names.index(name) for name in BODY]
    basis = _BASIS.copy()
    basis[0, :3, :3] -= thinnest**2 * np.eye(3)  # Sigma_C >= m thinnest^2, as one LMI (Schur complement; ours)
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
