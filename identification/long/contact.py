"""A contact that lasts for a large part of a run draws the fit so far that its residuals no longer show where it is.

Least trimmed squares (Rousseeuw 1984, J. Am. Stat. Assoc. 79:871) resists up to half of the samples. As a contact is
a stretch of time, the search begins from fits to stretches of time, and each sample is judged with its neighbours.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from identification.estimation.compressed import column_scale

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

SHARE = 0.5  # of the samples that a fit must explain
STRETCHES = (0.25, 0.4)  # of the run, that a search begins from
STARTS = 7  # of each length
ROUNDS = 20  # concentration steps, each of which lowers the trimmed sum of squares
TOGETHER = 0.1  # [s] of neighbours that a sample is judged with
FEWEST = 5.0  # times as many forces as unknowns, to begin from


class Trimmed(NamedTuple):
    """A fit to the half of the samples that agree best.

    Args:
        residuals: of all samples, shape (n, 6).
        explained: the samples of the fit, shape (n,).
    """

    residuals: Array
    explained: Rows


def least_trimmed_squares(regressors: Array, forces: Array, w: Array, step: float) -> Trimmed | None:
    """The best of many searches; None where samples are too few.

    Args:
        regressors: A_j at ascending times, shape (n, 6, u).
        forces: shape (n, 6) [N, or N and N m].
        w: W for one sample, shape (6, 6).
        step: usual time between samples [s].
    """
    root = np.linalg.cholesky(w).T
    matrices, right = root @ regressors, forces @ root.T
    samples, sensors, unknowns = matrices.shape
    scale = column_scale(matrices.reshape(-1, unknowns))
    matrices = matrices * scale
    kept, width = int(np.ceil(SHARE * samples)), max(1, round(TOGETHER / step))
    best: tuple[float, Array, Rows] | None = None
    for share in STRETCHES:
        length = round(share * samples)
        if length * sensors < FEWEST * unknowns:
            continue
        for begin in np.linspace(0, samples - length, STARTS).astype(int):
            rows = np.zeros(samples, dtype=bool)
            rows[begin : begin + length] = True
            found = _concentrated(matrices, right, rows, kept, width)
            if best is None or found[0] < best[0]:
                best = found
    if best is None:
        return None
    return Trimmed(forces - regressors @ (scale * best[1]), best[2])


def _concentrated(matrices: Array, right: Array, rows: Rows, kept: int, width: int) -> tuple[float, Array, Rows]:
    """Fits and keeps what fits best, in turns: the trimmed sum, the values and the samples."""
    unknowns = matrices.shape[2]
    objective = np.inf
    values: Array = np.zeros(unknowns)
    for _ in range(ROUNDS):
        stacked = matrices[rows].reshape(-1, unknowns)
        values = np.asarray(np.linalg.lstsq(stacked, right[rows].ravel(), rcond=None)[0], dtype=np.float64)
        left = np.sum((right - matrices @ values) ** 2, axis=1)
        smooth = uniform_filter1d(left, width, mode="nearest")
        rows = np.asarray(smooth <= np.partition(smooth, kept - 1)[kept - 1], dtype=bool)
        new = float(left[rows].sum())
        if not new < objective * (1.0 - 1e-6):
            break
        objective = new
    return objective, values, rows
