"""Observability criteria A, D, K, N of an information matrix (Table 4), as values to maximise.

With mu_1 >= ... >= mu_u the singular values of the scaled regressor, F = A^T A has the eigenvalues mu^2. Values of
different motions are comparable in one scaling only: the reference scaling (CONVENTIONS).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError

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
