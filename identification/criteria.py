"""Observability criteria A, D, K, N of an information matrix (Table 4), as values to maximise.

With mu_1 >= ... >= mu_u the singular values of the scaled regressor, F = A^T A has the eigenvalues mu^2. Values of
different motions are comparable in one scaling only: the reference scaling (CONVENTIONS).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from cases.schema import Case
from identification.evaluate import over_samples
from identification.model import Model

Array = NDArray[np.float64]


class Criterion(NamedTuple):
    """A criterion: `of` maps singular values, shape (u,), descending, to a value that is better the larger it is."""

    letter: str
    meaning: str
    of: Callable[[Array], float]


CRITERIA = {
    "A": Criterion("A", "average variance, -trace F^-1 (30)", lambda mu: -float(np.sum(mu**-2.0))),
    "D": Criterion("D", "volume of the confidence ellipsoid, log det F (31)", lambda mu: 2.0 * float(np.log(mu).sum())),
    "K": Criterion("K", "condition, -mu_1 / mu_u (32)", lambda mu: -float(mu[0] / mu[-1])),
    "N": Criterion("N", "noise amplification, mu_u^2 / mu_1 (33)", lambda mu: float(mu[-1] ** 2 / mu[0])),
}


def singular_values(information: Array, names: Sequence[str]) -> Array:
    """Singular values of the scaled regressor behind an information matrix, descending, shape (u,).

    Args:
        information: F = A^T W A in a scaling, shape (u, u).
        names: names of the parameters, for the message.

    Raises:
        IdentificationError: F is singular; the message names the parameters that are not determined.
    """
    values, directions = np.linalg.eigh(information)
    # F squares the regressor: its eigenvalues are known to u eps of the largest.
    zero = len(names) * np.finfo(float).eps * values[-1]
    free = values <= zero
    if free.any():
        share = np.abs(directions[:, free]).max(axis=1)
        hidden = [name for name, s in zip(names, share, strict=True) if s > 1e-3]
        raise IdentificationError(
            f"rank {int((~free).sum())} of {len(names)}: {', '.join(hidden)} not determined; "
            "excite them or choose a model without them"
        )
    return np.asarray(np.sqrt(values[::-1]))


STATES = 20_000
SEED = 0


class BoxStates(NamedTuple):
    """States of the motion box, one row each: coordinates, rates and accelerations, shapes (n, k)."""

    pose: Array
    rates: Array
    accelerations: Array


def uniform_states(case: Case, count: int, seed: int) -> BoxStates:
    """Independent uniform states of the motion box of a case.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    home, box = case.need_motion("the reference scaling")
    shape = (count, len(home))
    draw = np.random.default_rng(seed)
    pose = home + draw.uniform(box.pose[0], box.pose[1], shape)
    rates = draw.uniform(-box.rate, box.rate, shape)
    return BoxStates(pose, rates, draw.uniform(-box.acceleration, box.acceleration, shape))


def reference_scaling(case: Case, model: Model) -> Array:
    """H*: one over the RMS of each regressor column, over 20 000 seeded uniform states of the box, shape (u,).

    The paper's own scaling (26) depends on the motion at hand, so that criteria of two motions could not be compared.
    """
    states = uniform_states(case, STATES, SEED)
    matrices = over_samples(model.coordinate_regressor, *states)[0]
    return np.asarray(1.0 / np.sqrt(np.einsum("nij,nij->j", matrices, matrices) / STATES))


def information(model: Model, scaling: Array, states: BoxStates) -> Array:
    """Mean of H A^T A H over states (equal sensors, W = 1), shape (u, u)."""
    matrices = over_samples(model.coordinate_regressor, *states)[0].reshape(-1, len(scaling)) * scaling
    return np.asarray(matrices.T @ matrices / len(states.pose))
