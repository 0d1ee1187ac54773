"""Huber's M-estimate by iteratively reweighted least squares (IRLS): gross errors lose their pull, none is removed.

Huber & Ronchetti 2009, Robust Statistics, chapter 7. Only errors of the forces are resisted, not those of the
regressor, and one-sided ones still bias: a share e of them by up to about 1.6 e of the noise's standard deviation.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from cases.errors import IdentificationError
from identification.estimation.compressed import column_scale
from identification.estimation.estimator import gauss_markov
from identification.estimation.fit import EACH, UNFILTERED, Filtered, Fit, long_run_covariance, settled

Array = NDArray[np.float64]

HUBER_K = 1.345  # residuals beyond so many standard deviations count less: 95 % efficiency where noise is Gaussian
MAD_TO_STD = 1.482602218505602  # 1 / Phi^-1(3/4): makes the MAD of Gaussian noise its standard deviation
MEAN_SQUARE_PSI = 0.710165  # E psi(z)^2 for Gaussian z and HUBER_K: makes s0 that of Gaussian noise
ROUNDS = 100
TOLERANCE = 1e-7  # of a standard deviation of each parameter: far below what matters, far above rounding
SILENT = 1e-12  # of the largest force: what is left of a channel is rounding, not noise


def huber(
    regressors: Array,
    forces: Array,
    names: Sequence[str],
    pooled: bool,
    nuisance: int = 0,
    filtered: Filtered = UNFILTERED,
    alike: Sequence[int] = EACH,
) -> tuple[Fit, Array]:
    """Huber's M-estimate of u with the scale of the noise estimated in turns.

    Its covariance is the sandwich of Huber 1967 and White 1980, right also where the spread of the forces changes over
    the run; weights are one over the squared normalised MAD of each channel, or ones where the scale is pooled.

    Args:
        regressors: A_j, shape (n, 6, u).
        forces: shape (n, 6) [N, or N and N m].
        pooled: one scale for all channels (identical sensors), else one for each (mixed units).
        nuisance: so many of the last columns are not parameters of the model.
        filtered: what was done to both before; a low-pass smears gross errors, so look for them before it.
        alike: number of each channel; where scales are not pooled, equal numbers share one.

    Returns:
        The fit, and the weight that each force kept, from 0 to 1, shape (n, 6): below 1 for 18 % of Gaussian noise.

    Raises:
        IdentificationError: as `gauss_markov`; or a channel fits without any residual.
    """
    samples, sensors, unknowns = regressors.shape
    kind = np.zeros(6, dtype=int) if pooled else np.asarray(alike)
    std = np.array([np.sqrt(np.mean(forces.var(axis=0)[kind == k])) for k in kind])
    spread = np.ones(6) if pooled else np.maximum(std, 1e-12 * max(float(std.max()), 1e-300))
    least = np.zeros(6) if pooled else SILENT * np.abs(forces).max() / spread
    start = gauss_markov(regressors, forces, names, spread**-2.0, nuisance, filtered)
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
        residuals=forces - regressors @ values,
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
        raise IdentificationError("too few forces agree with each other to tell how sure the robust estimate is")
    return np.asarray(np.linalg.inv(information))
