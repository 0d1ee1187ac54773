"""Covariance of an estimate where errors depend on the pose: those of encoders, joints, frame and geometry.

Noise that is stationary in time is another thing: where a motion returns to a place these are the same again, and
where it stays they do not average out. They are described as a random field over the struts' lengths, as in kriging
with a trend (Cressie 1993, Statistics for Spatial Data, section 3.4), beside noise with memory: its correlation of
Matern's form with smoothness 3/2 (Stein 1999, Interpolation of Spatial Data), its size and length by restricted
likelihood. Akaike's criterion says whether there is such a field at all; without one, nothing here counts.

Struts are one unit for places and turns, and say what encoders, screws and joints do. A field that changes over half
of the run's reach, or more, looks like a parameter, and the run cannot show it.
"""

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.special import gammaincinv, ndtri

from cases.base.units import Array
from cases.sensors import PoseField
from identification.estimation.fit import Robust
from identification.estimation.force_noise import LEAST_SAMPLES, Turned, autoregressive, slow_noises, toeplitz
from identification.estimation.pose_field import matern, squared_distances
from identification.finding import Kind, note

UNSEEN = 1e-9  # of the largest singular value or eigenvalue, below which there is only rounding
JITTER = 1e-9  # white noise beside all others, as a share of their variance
SETTLED = 1e-6  # relative change of the likelihood: thousandths, and what is decided is a difference of two
MOST_STEPS = 100


def independent(taken: Array) -> Array:
    """Columns of a fit that depend on no others, shape (m, s, r), for those that may do so, shape (m, s, u)."""
    basis, size, _ = np.linalg.svd(taken.reshape(-1, taken.shape[2]), full_matrices=False)
    return np.asarray(basis[:, size > UNSEEN * size[0]].reshape(*taken.shape[:2], -1))


def _solved(noise: Array, taken: Array, covariance: Array) -> tuple[Array, Array, Array, float]:
    """Of P = V^-1 - H H^T: V^-1, shape (m, m), H, shape (m, s, r), P times the residuals, log sqrt(determinants)."""
    count, channels = noise.shape
    jittered = covariance + JITTER * np.trace(covariance) / count * np.eye(count)
    factor, lower = cho_factor(jittered, lower=True)
    inverse = cho_solve((factor, lower), np.eye(count))
    columns = (inverse @ taken.reshape(count, -1)).reshape(taken.shape)
    inner = np.linalg.cholesky(np.tensordot(taken, columns, ((0, 1), (0, 1))))
    spanned = solve_triangular(inner, columns.reshape(-1, len(inner)).T, lower=True).T.reshape(columns.shape)
    rest = np.tensordot(spanned, noise, ((0, 1), (0, 1)))
    solution = inverse @ noise
    logdet = channels * np.log(np.diag(factor)).sum() + np.log(np.diag(inner)).sum()
    return inverse, spanned, solution - spanned @ rest, float(logdet)


def shares_by_channel(noise: Array, taken: Array, kernels: Array, shares: Array) -> Array:
    """Shares of noises in each channel, shape (s, c).

    Args:
        noise, taken: as in `likeliest`.
        kernels: covariances of the noises, shape (c, m, m).
        shares: shares that are the likeliest for all channels alike, shape (c,).
    """
    from scipy.optimize import nnls

    inverse, spanned, answer, _ = _solved(noise, taken, np.tensordot(shares, kernels, 1))
    channels, count = noise.shape[1], len(kernels)
    weighed = inverse @ kernels
    power = np.einsum("ms,cms->sc", answer, np.tensordot(kernels, answer, 1))
    products = np.tensordot(kernels, spanned, 1)  # K_c H, shape (c, m, s, r)
    within = np.einsum("msu,cmsv->scuv", spanned, products, optimize=True)
    information = np.einsum("kcuv,ldvu->kcld", within, within, optimize=True)
    whole = np.einsum("aij,bji->ab", weighed, weighed, optimize=True)
    for k in range(channels):
        through = inverse @ products[:, :, k]
        cross_terms = np.tensordot(products[:, :, k], through, ((1, 2), (1, 2)))
        information[k, :, k, :] += whole - 2.0 * cross_terms
    square = information.reshape(channels * count, -1)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(square), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh((square + square.T) / 2.0 * np.outer(scale, scale))
    significant = values > UNSEEN * values[-1]
    root = np.sqrt(values[significant])
    found_shares, _ = nnls(
        (vectors[:, significant] * root).T, vectors[:, significant].T @ (scale * power.ravel()) / root
    )
    return np.asarray((found_shares * scale).reshape(channels, count))


INSTANTS = 150  # of the run, at which the field is looked for; more cost time by their cube without more information
WAVES = 256  # number of waves that make a field of force errors
COUNTED = 1e-5  # share of a channel's variance, below which a noise does not count
SHARES = (1e-8, 1e3)  # of a channel's variance: the fit may leave a thousandth
LENGTHS = (0.005, 0.5)  # of the median distance between instants
BEGIN = (0.5, 0.01, 0.5, 0.1)  # shares of near and slow noise and of the field, and its length, to begin with
UNKNOWNS = 2  # of a field: Akaike's price
FREEDOM = 3  # degrees of freedom of the Student t that is the spectrum of Matern's 3/2


def covariance_by_pose(found: Turned, struts: Array, residuals: Array | None = None) -> Robust | None:
    """Covariance of u for errors of the pose and noise with memory; None where nothing speaks for errors of the pose.

    Args:
        found: residuals, in turned channels.
        struts: lengths at their samples, shape (n, 6) [m].
        residuals: those of the forces, shape (n, 6) [N], by which the field is reported; None of whitened ones.
    """
    samples = len(found.noise)
    if samples < LEAST_SAMPLES:
        return None
    rows = np.arange(samples)[(samples - 1) % -(-samples // INSTANTS) // 2 :: -(-samples // INSTANTS)]
    squared = squared_distances(struts[rows], struts[rows])
    reach = float(np.sqrt(np.median(squared[np.triu_indices(len(squared), 1)])))
    if reach == 0.0:
        return None
    noise, explained = found.noise[rows], independent(found.taken[rows])
    series, mask, scale = found.series(found.noise), found.series(np.ones(samples)), samples / found.freedom
    near = np.mean([autoregressive(channel, mask, scale)[0] for channel in series.T], axis=0)
    memories = [near, *slow_noises(found.length)]
    lags = np.abs(found.places[rows][:, None] - found.places[rows])
    kernels = np.array([m[lags] for m in memories])
    _, without = likeliest(noise, explained, kernels)
    shares, value = likeliest(noise, explained, kernels, np.sqrt(squared) / reach)
    if without - value <= UNKNOWNS:
        return None
    length = reach * float(shares[-1])
    field = matern(np.sqrt(squared) / length)[0]
    # Between channels slow noises differ as a whole: a single channel has next to no information on them.
    memories = [memories[0], np.tensordot(shares[1:-2], memories[1:], 1)]
    alike = np.array([memories[0][lags], memories[1][lags], field])
    begin = np.array([shares[0], 1.0, shares[-2]])
    by_channel = np.zeros((found.noise.shape[1], len(begin)))
    counts = begin * alike[:, 0, 0] > COUNTED
    by_channel[:, counts] = shares_by_channel(noise, explained, alike[counts], begin[counts])
    meat = _field_covariance(found, struts / length, by_channel[:, -1])
    answer = found.series(found.answer)
    for share, memory in zip(by_channel[:, :-1].T, memories, strict=True):
        response = toeplitz(memory, answer.reshape(len(answer), -1)).reshape(answer.shape)
        meat += found.share * np.tensordot(answer * share[:, None], response, ((0, 1), (0, 1)))
    share = float(by_channel[:, -1].mean())  # of the field over the residuals; above 1 where the fit took some
    finding = note(
        Kind.NOISE,
        f"errors depend on the pose, {np.sqrt(share):.2g} times as large as the residuals, for the parameters take a "
        "part of them: std_robust allows for them",
    )
    reported = None if residuals is None else PoseField(float(np.sqrt(share * np.mean(residuals**2))), length)
    return Robust(found.covariance(meat), (finding,), reported)


def likeliest(noise: Array, taken: Array, kernels: Array, distances: Array | None = None) -> tuple[Array, float]:
    """Shares of noises of the largest restricted likelihood, and minus the logarithm of that; as `likelihood`."""
    from scipy.optimize import minimize  # half a second, which those that simulate or plan can do without

    begin, bounds = [BEGIN[0], *[BEGIN[1]] * (len(kernels) - 1)], [SHARES] * len(kernels)
    if distances is not None:
        begin, bounds = [*begin, *BEGIN[2:]], [*bounds, SHARES, LENGTHS]
    options, arguments = {"maxiter": MOST_STEPS, "ftol": SETTLED, "maxcor": 20}, (noise, taken, kernels, distances)
    best = minimize(likelihood, np.log(begin), arguments, "L-BFGS-B", jac=True, bounds=np.log(bounds), options=options)
    return np.exp(best.x), float(best.fun)


def likelihood(
    logarithms: Array, noise: Array, taken: Array, kernels: Array, distances: Array | None
) -> tuple[float, Array]:
    """Minus the logarithm of the restricted likelihood, and its slope.

    Args:
        logarithms: logarithms of the noises' shares, shape (c,), of the field's after them, and of its length.
        noise: residuals of some samples, in channels with independent noise, shape (m, s).
        taken: `independent` columns that the fit may have taken any multiple of, shape (m, s, r).
        kernels: covariances of the noises, shape (c, m, m).
        distances: distances of the samples, shape (m, m); None where there is no field.
    """
    count, flat, shares = len(kernels), kernels.reshape(len(kernels), -1), np.exp(logarithms)
    covariance = (shares[:count] @ flat).reshape(kernels.shape[1:])
    if distances is not None:
        alike, longer = matern(distances / shares[-1])
        covariance += shares[-2] * alike
    inverse, spanned, answer, half_logdet = _solved(noise, taken, covariance)
    span = spanned.reshape(len(covariance), -1)
    slope = (noise.shape[1] * inverse - span @ span.T - answer @ answer.T) / 2.0
    gradient = shares[:count] * (flat @ slope.ravel())
    if distances is not None:
        gradient = np.r_[gradient, shares[-2] * np.sum(slope * alike), shares[-2] * np.sum(slope * longer)]
    return half_logdet + float(np.sum(noise * answer)) / 2.0, gradient


def _field_covariance(data: Turned, places: Array, shares: Array) -> Array:
    """Covariance of half^-1 u by a field of variance `shares` in each channel, at places in lengths of the field."""
    # As a sum of waves with the field's spectrum (Rahimi and Recht 2007), at the points of a Kronecker sequence, so
    # that the length of the run does not count.
    offsets = places - places.mean(axis=0)
    waves = spectrum_of(places.shape[1])
    meat = np.zeros((data.answer.shape[2],) * 2)
    for block in np.array_split(waves, 16):  # of a long run all would fill the memory
        phase = offsets @ block.T
        for part in (np.cos(phase), np.sin(phase)):
            response = np.tensordot(data.answer, part, ((0,), (0,)))  # shape (6, u, waves)
            meat += np.tensordot(response * shares[:, None, None], response, ((0, 2), (0, 2)))
    return meat / len(waves)


def spectrum_of(dimensions: int) -> Array:
    """Wave vectors of Matern's 3/2, a Student t distribution, shape (WAVES, dimensions) [rad a length]."""
    root = 2.0
    for _ in range(60):  # the real root of x^(d + 2) = x + 1
        root = (1.0 + root) ** (1.0 / (dimensions + 2))
    steps = root ** -np.arange(1.0, dimensions + 2.0)
    points = (0.5 + np.arange(1.0, WAVES + 1.0)[:, None] * steps) % 1.0
    chi_squared = 2.0 * gammaincinv(FREEDOM / 2.0, points[:, -1])
    return np.asarray(ndtri(points[:, :-1]) / np.sqrt(chi_squared / FREEDOM)[:, None])
