"""Observability criteria A, D, K, N of an information matrix (Table 4), as values to maximise.

With mu_1 >= ... >= mu_u the singular values of the scaled regressor, F = A^T A has the eigenvalues mu^2. Values of
different motions are comparable in one scaling only: the reference scaling (CONVENTIONS).

Of a set of poses to stand at, F is the sum of A^T A over the set.
"""

from collections.abc import Sequence
from enum import StrEnum
from typing import NoReturn

import numpy as np

from cases.base.errors import Code, HexciteError, IdentificationError, choice
from cases.base.units import Array
from cases.schema import Case
from identification.machines.casadi_batch import over_samples
from identification.machines.executed import RATE, Execution
from identification.model.model import Model, regressors


class Criterion(StrEnum):
    r"""Criteria of Table 4, by their letters, as values that are better the larger they are.

    .. math::
        A = -\mathrm{trace} F^{-1}, \qquad D = \log\det F, \qquad
        K = -\frac{\mu_1}{\mu_u}, \qquad N = \frac{\mu_u^2}{\mu_1}

    with the singular values :math:`\mu_1 \geq \dots \geq \mu_u` of the scaled regressor, (30) to (33).
    """

    A = "A"
    D = "D"
    K = "K"
    N = "N"

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        """Refuses what is not a letter of Table 4."""
        raise HexciteError(problem=f"criterion {value!r} is unknown", remedy=choice(str(value), cls), code=Code.UNKNOWN)

    def of_eigenvalues(self, squares: Array) -> Array:
        """Its value by mu^2, the eigenvalues of F, ascending and above 0, shape (..., u) -> (...)."""
        if self is Criterion.A:  # average variance, -trace F^-1 (30)
            return np.asarray(-np.sum(1.0 / squares, axis=-1))
        if self is Criterion.D:  # volume of the confidence ellipsoid, log det F (31)
            return np.asarray(np.log(squares).sum(axis=-1))
        if self is Criterion.K:  # condition, -mu_1 / mu_u (32)
            return np.asarray(-np.sqrt(squares[..., -1] / squares[..., 0]))
        return np.asarray(squares[..., 0] / np.sqrt(squares[..., -1]))  # noise amplification, mu_u^2 / mu_1 (33)

    def of_singular_values(self, mu: Array) -> float:
        """Its value by the singular values of the scaled regressor, descending, shape (u,)."""
        return float(self.of_eigenvalues(mu[::-1] ** 2))

    def of(self, information: Array) -> Array:
        """Its value of one or more informations, shape (..., u, u) -> (...); -inf where singular."""
        if self is Criterion.D:
            return _log_det(information)
        squares = np.maximum(np.linalg.eigvalsh(information), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(squares[..., 0] > 0.0, self.of_eigenvalues(squares), -np.inf)

    @property
    def losses_grow(self) -> bool:
        """Whether a pose of a set costs the more, the fewer others are left."""
        return self is Criterion.D

    def after_removal(self, information: Array, regressors: Array) -> Array:
        """Value without each pose, F - A_j^T A_j, shape (k,), of its regressors A_j, shape (k, 6, u)."""
        if self is not Criterion.D:
            return self.of(information - regressors.transpose(0, 2, 1) @ regressors)
        weighted = (regressors.reshape(-1, len(information)) @ np.linalg.inv(information)).reshape(regressors.shape)
        remainder = np.eye(6) - weighted @ regressors.transpose(0, 2, 1)  # log det F + log det(1 - A F^-1 A^T)
        return np.asarray(_log_det(information) + _log_det(remainder))


def singular_values(information: Array, names: Sequence[str]) -> Array:
    """Singular values of the scaled regressor behind an information matrix, descending, shape (u,).

    `information` is F = A^T W A in a scaling, shape (u, u). Raises IdentificationError where F is singular, with the
    parameters that are not determined.
    """
    values, directions = np.linalg.eigh(information)
    # F squares the regressor: its eigenvalues are known to u eps of the largest.
    zero = len(names) * np.finfo(float).eps * values[-1]
    free = values <= zero
    if free.any():
        share = np.abs(directions[:, free]).max(axis=1)
        hidden = [name for name, s in zip(names, share, strict=True) if s > 1e-3]
        raise IdentificationError(
            problem=f"rank {int((~free).sum())} of {len(names)}: {', '.join(hidden)} not determined",
            remedy="excite them or choose a model without them",
            code=Code.NO_EXCITATION,
        )
    return np.asarray(np.sqrt(values[::-1]))


STATES = 20_000
SEED = 0


def box_middle(case: Case) -> tuple[Array, Array]:
    """Middle of the box of coordinates and half of its width, shapes (n,) [m or rad]."""
    home, limits = case.need_motion("planning")
    low, high = limits.coordinates
    return home + (low + high) / 2, np.asarray((high - low) / 2)


def uniform_states(case: Case, count: int, seed: int) -> tuple[Array, Array, Array]:
    """Independent uniform states of the motion box of a case: coordinates, rates and accelerations, shapes (n, k)."""
    home, box = case.need_motion("the reference scaling")
    shape = (count, len(home))
    draw = np.random.default_rng(seed)
    pose = home + draw.uniform(box.coordinates[0], box.coordinates[1], shape)
    rates = draw.uniform(-box.rate, box.rate, shape)
    return pose, rates, draw.uniform(-box.acceleration, box.acceleration, shape)


def reference_scaling(case: Case, model: Model) -> Array:
    r"""H*: one over the RMS of each regressor column, over 20 000 seeded uniform states of the box, shape (u,).

    .. math::
        H^*_j = \left( \frac{1}{N} \sum_{k=1}^{N} \sum_{i=1}^{6} A_{ij}^2(q_k, \dot{q}_k, \ddot{q}_k) \right)^{-1/2}

    The paper's own scaling (26) depends on the motion at hand, so that criteria of two motions could not be compared.
    """
    states = uniform_states(case, STATES, SEED)
    matrices = over_samples(model.coordinate_regressor, *states)[0]
    return np.asarray(1.0 / np.sqrt(np.einsum("nij,nij->j", matrices, matrices) / STATES))


def information(model: Model, scaling: Array, states: tuple[Array, Array, Array]) -> Array:
    r"""Mean of :math:`H A^T A H` over states (equal sensors, W = 1), shape (u, u)."""
    matrices = over_samples(model.coordinate_regressor, *states)[0].reshape(-1, len(scaling)) * scaling
    return np.asarray(matrices.T @ matrices / len(states[0]))


def pose_regressors(model: Model, poses: Array) -> Array:
    """Regressors A of (21) for standing still at coordinates, shape (n, k) [m or rad], shape (n, 6, u).

    Raises IdentificationError where the model has parameters that standstills cannot excite.
    """
    if model.needs_motion:
        raise IdentificationError(
            problem=f"model {model.number} contains inertia, which standstills cannot excite",
            remedy="choose a model from 0 to 5",
            code=Code.NO_EXCITATION,
        )
    return over_samples(model.coordinate_regressor, poses, 0.0 * poses, 0.0 * poses)[0]


def candidate_scaling(regressors: Array) -> Array:
    """Reference scaling of pose sets: one over the RMS of each column over the candidates, or 1, shape (u,)."""
    mean_square = np.mean(np.sum(regressors**2, axis=1), axis=0)
    return np.asarray(1.0 / np.sqrt(np.where(mean_square > 0.0, mean_square, 1.0)))


def total_information(regressors: Array) -> Array:
    """Sum of A^T A over poses, shape (u, u)."""
    rows = regressors.reshape(-1, regressors.shape[2])
    return np.asarray(rows.T @ rows)


def _log_det(matrices: Array) -> Array:
    sign, logdet = np.linalg.slogdet(matrices)
    return np.where(sign > 0, logdet, -np.inf)


def executed_information(model: Model, scaling: Array, execution: Execution, windows: Array, cutoff: float) -> Array:
    r"""Mean of :math:`H A^T A H` over an executed excitation behind the evaluation's filter, W = 1, shape (u, u).

    Ripple that a controller adds is filtered off by the evaluation, and must not count as information. `scaling` is the
    diagonal of H; windows of the excitation have the shape (k, 2) [s], `cutoff` is that of the low-pass [Hz].
    """
    from identification.signals import Filter  # SciPy, which programs that are only read do without

    low_pass = Filter(cutoff, 1.0 / RATE)
    t = np.arange(int(execution.duration * RATE) + 1) / RATE
    struts = execution.drives(t)
    inside = t[low_pass.margin : -low_pass.margin]
    rows = np.zeros(len(inside), dtype=bool)
    for start, end in windows:
        rows |= (inside >= start) & (inside < end)
    motion = [low_pass.apply(struts, order)[rows] for order in range(3)]
    matrices = regressors(model, execution.machine.kinematics(*motion)).reshape(-1, len(scaling)) * scaling
    return np.asarray(matrices.T @ matrices / rows.sum())
