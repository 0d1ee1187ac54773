"""Gauss-Markov estimation (23) to (28), and what every estimator takes and returns.

After one QR of a regression, which also gives the rank, its size no longer matters: W^1/2 (A f) = Q (R c; 0 d) turns
chi^2 of (27) into |c - R u|^2 + d^2 (Golub & Van Loan 2013, section 5.3).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import stdtrit

from cases.base.errors import Code, IdentificationError
from cases.base.phrases import phrase
from cases.base.units import Array, as_html
from cases.sensors import PoseField
from identification.finding import Finding

COVERAGE_FACTOR = 2.0  # k of the expanded uncertainty


class Value(NamedTuple):
    """An estimated quantity: SI value, standard deviation by (28), autocorrelation-robust one, and unit."""

    value: float
    std: float
    std_robust: float
    unit: str

    @property
    def reported(self) -> float:
        """The larger of the two standard deviations, which is what people are shown."""
        return max(self.std, self.std_robust)

    @property
    def expanded(self) -> float:
        """Expanded uncertainty U (k = 2): twice the reported deviation."""
        return COVERAGE_FACTOR * self.reported

    def interval(self, freedom: float, level: float = 0.95) -> tuple[float, float]:
        """Confidence interval from the reported standard deviation: what is printed, and what coverage rates."""
        half = float(stdtrit(freedom, 0.5 + level / 2)) * self.reported
        return self.value - half, self.value + half

    def _repr_html_(self) -> str:
        return as_html(self)


class Filtered(NamedTuple):
    """Effect of a low-pass on white noise before the fit, and how many samples behind it are evaluated."""

    gain: float = 1.0  # variance of filtered noise over that of recorded noise, the sum of the squared kernel
    stride: float = 1  # recorded samples for each one that is evaluated


class Regression(NamedTuple):
    """f = A u + noise: samples one after the other, for parameters u."""

    regressors: Array  # A_j, shape (n, 6, u)
    forces: Array  # shape (n, 6) [N, or N and N m]
    names: Sequence[str]  # names of the u columns
    # so many of the last columns are not parameters of the model: they are estimated too, and cost certainty, but rank
    # and condition are reported without them
    nuisance: int = 0
    filtered: Filtered = Filtered()  # what was done to regressors and forces before
    # channels with the same number have the same noise, which follows from their residuals, shape (6,); None: W = 1
    alike: tuple[int, ...] | None = None

    def residuals(self, values: Array) -> Array:
        """What u leaves of the forces, f - A u, shape (n, 6)."""
        return np.asarray(self.forces - self.regressors @ values)

    def within_span(self) -> "Regression":
        """The same forces by as many unknowns as A determines: residuals are those of u; itself where all are."""
        root, _, _ = compress(self, np.ones(6))
        scale = column_scale(root)
        _, sizes, directions = np.linalg.svd(root * scale)
        rank = int(np.count_nonzero(sizes > self.forces.size * np.finfo(float).eps * sizes[0]))
        if rank == len(scale):
            return self
        spanning = scale[:, None] * directions[:rank].T
        names = [f"combination {k}" for k in range(1, rank + 1)]
        return self._replace(regressors=self.regressors @ spanning, names=names, nuisance=0)

    def whitened(self, whitening: Array | None) -> "Regression":
        """Both sides multiplied with the root of W, shape (6, 6); as they are where it is None."""
        if whitening is None:
            return self
        return self._replace(regressors=whitening @ self.regressors, forces=self.forces @ whitening.T)


class Robust(NamedTuple):
    """Covariance of an estimate where noise is not white."""

    covariance: Array  # covariance of u, shape (u, u)
    findings: tuple[Finding, ...] = ()
    field: PoseField | None = None  # errors that depend on the pose, where the run shows them
    # that for noise which is white before the filter, where a part of it is noise of accelerations, shape (u, u)
    sources: Array | None = None


@dataclass(frozen=True, slots=True)
class Fit:
    """An estimate of u."""

    values: Array  # u, shape (u,)
    # s^2 F^-1, (28), s the white noise, shape (u, u): right where the recorded noise is white; where residuals show
    # noise of the drives' accelerations, its counterpart for that
    covariance: Array
    covariance_robust: Array  # autocorrelation-robust, shape (u, u): right also where it is not
    # standard deviation of white noise of a force by filtered residuals, s0 of (27) where nothing was filtered;
    # dimensionless where weights are given, else [N]
    white_noise: float
    freedom: float  # degrees of freedom of the white noise
    residuals: Array  # f - A u, shape (n, 6) [N, or N and N m]
    weights: Array  # diagonal of W for one sample, shape (6,)
    rank: int  # rank of the scaled regressor
    condition: float  # mu_1 / mu_u of the scaled regressor (26)
    # what the estimator did beside, as a constraint that bound, or a prior that moved it, and what speaks against it,
    # as a prior that disagrees, or a search that did not settle
    findings: tuple[Finding, ...] = ()
    field: PoseField | None = None  # errors that depend on the pose, where the run shows them


_PART = 600  # rows of a QR that stay in the cache
_PIECE = 20_000  # samples whose rows are in memory at once


def compress(regression: Regression, weights: Array) -> tuple[Array, Array, float]:
    """chi^2 of (27) as |c - R u|^2 + d^2: R, shape (u, u), c, shape (u,), and d^2, which no u explains.

    Args:
        weights: diagonal of W for one sample, shape (6,).

    Raises:
        IdentificationError: fewer forces than unknowns.
    """
    samples, sensors, unknowns = regression.regressors.shape
    if samples * sensors <= unknowns:
        raise IdentificationError(
            problem=phrase(
                "few_forces",
                "{samples} samples give {forces} forces for {unknowns} unknowns",
                samples=samples,
                forces=samples * sensors,
                unknowns=unknowns,
            ),
            remedy=phrase("more_or_smaller", "record more or choose a model with fewer parameters"),
            code=Code.TOO_FEW,
        )
    r = joint_triangle(regression.regressors, regression.forces, np.sqrt(weights))
    return r[:-1, :-1], r[:-1, -1], float(r[-1, -1] ** 2)


def joint_triangle(regressors: Array, forces: Array, root: Array) -> Array:
    """R of the QR of all (A_j f_j), rows multiplied by `root`, shape (6,), piece by piece, shape (u + 1, u + 1)."""
    pieces = (slice(k, k + _PIECE) for k in range(0, len(forces), _PIECE))
    weighted = (np.concatenate([regressors[p], forces[p, :, None]], axis=2) * root[:, None] for p in pieces)
    tops = [triangle(rows.reshape(-1, rows.shape[2])) for rows in weighted]
    return tops[0] if len(tops) == 1 else triangle(np.vstack(tops))


def column_scale(root: Array) -> Array:
    """H of (26): one over the norm of each column, 1 where a column is zero, shape (u,)."""
    norms = np.linalg.norm(root, axis=0)
    return np.where(norms > 0.0, 1.0 / np.where(norms > 0.0, norms, 1.0), 1.0)


def determined(root: Array, names: Sequence[str], rows: int, nuisance: int = 0) -> tuple[int, float]:
    """Rank and condition mu_1 / mu_u (26) of the scaled regression, which determines all its parameters.

    Args:
        root: R, or any matrix with R^T R the information, shape (k, u).
        rows: m n of the paper's numerical zero (Fig. 3).
        nuisance: so many of the last columns are not parameters of the model and are not counted.

    Raises:
        IdentificationError: parameters that are not determined, by name.
    """
    count = root.shape[1] - nuisance
    scaled = triangle(root * column_scale(root))[:count, :count]
    singular, directions = np.linalg.svd(scaled)[1:]
    rank = int(np.sum(singular > rows * np.finfo(float).eps * singular[0]))
    if rank < count:
        share = np.abs(directions[rank:]).max(axis=0)
        hidden = [name for name, s in zip(names, share, strict=False) if s > 1e-3]
        raise IdentificationError(
            problem=phrase(
                "not_determined",
                "rank {rank} of {count}: {names} not determined by this run",
                rank=rank,
                count=count,
                names=", ".join(hidden),
            ),
            remedy=phrase("excite_them", "excite them (plan a motion or more poses) or choose a model without them"),
            code=Code.NO_EXCITATION,
        )
    return rank, float(singular[0] / singular[-1])


def inverse_root(root: Array) -> Array:
    """L with L L^T = (R^T R)^-1, shape (u, u), for R of full rank, shape (k, u)."""
    scale = column_scale(root)
    return np.asarray(scale[:, None] * solve_triangular(triangle(root * scale), np.eye(root.shape[1])))


def orthonormal(regressors: Array, weights: Array) -> tuple[Array, Array]:
    """Q of the QR decomposition of W^1/2 A, shape (n, 6, u), and L with L L^T = F^-1, shape (u, u)."""
    weighted = regressors * np.sqrt(weights)[:, None]
    half = inverse_root(weighted.reshape(-1, regressors.shape[2]))
    return weighted @ half, half


def triangle(matrix: Array) -> Array:
    """R of the QR decomposition, shape (u, u), in parts that stay in the cache of the processor.

    The QR of the parts' R is that of the whole, as stable and four times as fast (Demmel, Grigori, Hoemmen & Langou
    2012, SIAM J. Sci. Comput. 34:A206).
    """
    rows, columns = matrix.shape
    parts = rows // _PART
    if parts > 1 and columns < _PART // 4:
        tops = np.asarray(np.linalg.qr(matrix[: parts * _PART].reshape(parts, _PART, columns), mode="r"))
        return triangle(np.vstack([tops.reshape(-1, columns), matrix[parts * _PART :]]))
    return np.asarray(np.linalg.qr(matrix, mode="r"))


def degrees_of_freedom(rows: int, used: float, filtered: Filtered) -> float:
    """Degrees of freedom by which the noise is judged (see `gauss_markov` for filtered data).

    Raises:
        IdentificationError: there are none.
    """
    independent = rows * filtered.gain * filtered.stride
    if independent <= used:
        raise IdentificationError(
            problem=phrase(
                "few_independent",
                "{rows} forces, {independent} of them independent, for {unknowns} unknowns",
                rows=rows,
                independent=f"{independent:.0f}",
                unknowns=f"{used:.0f}",
            ),
            remedy=phrase("longer_or_cutoff", "record longer or raise filter_cutoff_Hz"),
            code=Code.TOO_FEW,
        )
    return independent - used


def gauss_markov(regression: Regression, weights: Array) -> Fit:
    r"""Weighted least squares with W the same diagonal at every sample, (24), (27) and (28).

    .. math::
        \hat{u} = F^{-1} \sum_k A_k^T W f_k, \qquad F = \sum_k A_k^T W A_k, \qquad
        C = s^2 F^{-1}, \qquad s^2 = \frac{\sum_k r_k^T W r_k}{m n - u}, \qquad r_k = f_k - A_k \hat{u}

    for n samples of m = 6 forces that were not filtered.
    Where regressors and forces went through a low-pass that leaves the regressors as they are, the estimate is that of
    the unfiltered problem for all noise in the pass band. White noise of variance s^2 then leaves residuals of
    variance gain s^2, of which every stride-th is used: chi^2 / (m n gain - u / stride) estimates s^2, and s^2 /
    stride F^-1 is the covariance, F being that of the used samples.

    Args:
        weights: diagonal of W for one sample, shape (6,) [1/force^2], or ones.

    Raises:
        IdentificationError: fewer forces than unknowns, parameters that the data do not determine, by name, or no
            degree of freedom.
    """
    (root, right, _), rows, names = compress(regression, weights), regression.forces.size, regression.names
    rank, condition = determined(root, names, rows, regression.nuisance)
    remainders = np.abs(np.diag(root))  # of each column, what the columns before it do not explain
    unseen = np.flatnonzero(remainders <= rows * np.finfo(float).eps * np.linalg.norm(root, axis=0))
    if len(unseen):
        raise IdentificationError(
            problem=phrase(
                "forces_constant", "{name} is not determined: the forces do not change", name=names[unseen[0]]
            ),
            remedy=phrase("check_channels", "check the channels"),
            code=Code.NO_EXCITATION,
        )
    half = inverse_root(root)
    values = np.asarray(solve_triangular(root, right))  # (24)
    residuals, stride = regression.residuals(values), regression.filtered.stride
    freedom = degrees_of_freedom(rows, len(values), regression.filtered)
    white_noise = float(np.sqrt(np.sum(weights * residuals**2) * stride / freedom))  # (27)
    covariance = white_noise**2 / stride * (half @ half.T)  # (28)
    return Fit(values, covariance, covariance, white_noise, freedom, residuals, weights, rank, condition)


def require_alive(forces: Array) -> None:
    """Raises IdentificationError where a channel of two samples or more reads one and the same value, shape (n, 6)."""
    stuck = np.flatnonzero(np.ptp(forces, axis=0) == 0.0)
    if len(stuck):
        raise IdentificationError(
            problem=phrase(
                "channel_stuck",
                "channel {number} reads {value} at every sample",
                number=stuck[0] + 1,
                value=f"{forces[0, stuck[0]]:g}",
            ),
            remedy=phrase("check_cable", "check its cable and amplifier"),
            code=Code.NO_EXCITATION,
        )
