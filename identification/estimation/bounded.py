"""Bounds of a body as a prior of its estimate: uniform between them, by its mean and variance (GUM, 4.3.7).

A mass or a coordinate of the centre of gravity that is somewhere in a range has its middle as mean and half of its
width over root three as deviation. Estimate and prior are weighed by their variances; what an estimate knows much
better than its range stays as it is. Where the estimate contradicts a range, the range is not used: then it is of
another body, as where a payload was mounted, or wrong.
"""

from typing import NamedTuple

import numpy as np

from cases.base.units import Array
from cases.bounds import Bounds
from identification.estimation.covariances import Free, larger_of
from identification.model.blocks import MASS
from identification.model.model import Model
from identification.model.parameters import physical_form

ROUNDS = 5  # of Gauss and Newton: centres of gravity are quotients
CONTRADICTS = 3.0  # deviations of the estimate beyond an end of a range, from which the range is not used
WORTH = 0.99  # of a deviation, to which a range has to lower one to be used


class Bounded(NamedTuple):
    """An estimate and what bounds make of it."""

    values: Array  # of the fit with the prior, shape (v,)
    kept: Array  # what of errors of the fit stays in them, shape (v, v)
    biases: Array  # by one deviation of the prior of each range, shape (v, k)
    names: tuple[str, ...]  # parameters that have a range


def bounded(
    model: Model, values: Array, covariance: Array, robust: Array, bounds: Bounds | None, judged: bool = True
) -> Bounded | None:
    """Values of a fit with bounds of the body as prior; None where there are none, or they tell nothing.

    Args:
        model: model of the first of the values.
        values: those of the fit, shape (v,).
        covariance: by (28), shape (v, v).
        robust: by all that counts, shape (v, v).
        bounds: of the body.
        judged: whether ranges that the values contradict are left out; those of a plan are of a nominal body.
    """
    if bounds is None or MASS not in model.blocks:
        return None
    form, count = physical_form(model), len(model.names)
    names = [p.name for p in form.parameters]
    free = Free.of(covariance)
    wide = larger_of(free.down @ covariance @ free.down.T, free.down @ robust @ free.down.T)
    every = free.lift @ wide @ free.lift.T

    def at(u: Array) -> tuple[Array, Array]:  # physical parameters and their slopes by the values
        physical, slope = (v.full() for v in form.map(u[:count]))
        return physical[:, 0], np.hstack([slope, np.zeros((len(slope), len(u) - count))])

    first, slope = at(values)
    used, middles, deviations = [], [], []
    for name, (low, high) in _ranges(bounds):
        k = names.index(name)
        std = float(np.sqrt(slope[k] @ every @ slope[k]))
        agrees = low - CONTRADICTS * std <= first[k] <= high + CONTRADICTS * std
        if std > 0.0 and (agrees or not judged):
            used.append(k)
            middles.append(0.5 * (low + high))
            deviations.append((high - low) / np.sqrt(12.0))
    if not used:
        return None
    u, goals = values, np.array(middles)
    for _ in range(ROUNDS):
        now, slope = at(u)
        rows = slope[used]
        gain = np.linalg.solve(rows @ every @ rows.T + np.diag(np.square(deviations)), rows @ every).T
        u = values + gain @ (goals - now[used] - rows @ (values - u))
    reduction = np.eye(len(values)) - gain @ rows
    before, after = np.diag(every), np.diag(reduction @ every)
    if not np.any(after[before > 0.0] < WORTH**2 * before[before > 0.0]):
        return None
    return Bounded(u, reduction, gain * deviations, tuple(names[k] for k in used))


def _ranges(bounds: Bounds) -> list[tuple[str, tuple[float, float]]]:
    """Ranges of physical parameters [SI], by their names; a centre of gravity is where the body is."""
    ranges = [] if bounds.mass_kg is None else [("m", bounds.mass_kg)]
    box = bounds.centre_of_gravity_mm or bounds.body_mm
    if box is not None:
        ranges += [(n, (float(a), float(b))) for n, a, b in zip(("xC", "yC", "zC"), *box.ends, strict=True)]
    return ranges
