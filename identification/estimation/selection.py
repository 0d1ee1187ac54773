"""Partial identification (section 4): some parameters are known or left out, the rest is estimated.

A known centre of gravity ties a first moment to the mass, and a known central inertia ties an inertia to the first
moments by the parallel-axis theorem, so that u = u0 + B v with the parameters v that are left: the problem stays
linear, and every estimator of stacked data serves it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.estimation.fit import Estimator, Fit
from identification.model import Model
from identification.parameters import physical_form

Array = NDArray[np.float64]

_FIRST_MOMENTS = ("mxC", "myC", "mzC")
_CENTRE = ("xC", "yC", "zC")


@dataclass(frozen=True, slots=True)
class Selection:
    """Which parameters of a model are estimated, and how u follows from them: u = offset + basis @ free."""

    names: tuple[str, ...]  # names of the free parameters, in the order of (17)
    offset: Array  # u0, shape (u,)
    basis: Array  # B, shape (u, free)


def require_names(given: Iterable[str], valid: Sequence[str]) -> None:
    """Raises IdentificationError, listing the valid names, where one of those given is none of them."""
    for name in given:
        if name not in valid:
            raise IdentificationError(f"{name!r} is not a parameter here; choose from {', '.join(valid)}")


def symmetric_platform(model: Model) -> dict[str, float]:
    """The reduction of section 5 for a symmetric platform: five parameters less, two where there is no inertia."""
    names = [p.name for p in physical_form(model).parameters]
    return {name: 0.0 for name in (*names, *model.names) if name in ("xC", "yC", "I12", "I13", "I23")}


def select(model: Model, known: Mapping[str, float], dropped: Iterable[str] = ()) -> Selection:
    """Chooses what is estimated.

    Args:
        known: values of parameters by linear (m, mxC, I11..) or physical name (xC, IC11..) [SI]; they are taken as
            exact (uncertain ones: `priors`). A central inertia needs a known centre of gravity with it, else the
            problem is not linear (then: `nonlinear`).
        dropped: linear parameters whose columns are left out, as if their value were zero.

    Raises:
        IdentificationError: a name that the model does not have, with those that it has; a value that is not finite;
            a parameter given twice; nothing left to estimate.
    """
    form, dropped = [p.name for p in physical_form(model).parameters], tuple(dropped)
    require_names(known, list(dict.fromkeys([*model.names, *form])))
    require_names(dropped, model.names)
    for name, value in known.items():
        if not np.isfinite(value) or (name == "m" and value <= 0.0):
            raise IdentificationError(
                f"{name} = {value:g} cannot be a known value; give a finite number, a mass above 0"
            )
    constants = {**known, **dict.fromkeys(dropped, 0.0)}
    pairs = list(zip(model.names, form, strict=True))
    for linear, physical in pairs:
        if (linear in known) + (physical in known and physical != linear) + (linear in dropped) > 1:
            raise IdentificationError(f"{linear} is given twice (as {physical}, or also left out); give it once")
    names = tuple(linear for linear, physical in pairs if linear not in constants and physical not in constants)
    if not names:
        raise IdentificationError("all parameters are known; leave at least one to estimate")
    rows = _rows(pairs, constants, names)
    return Selection(names, rows[:, 0], rows[:, 1:])


def _rows(pairs: Sequence[tuple[str, str]], constants: Mapping[str, float], names: Sequence[str]) -> Array:
    """(u0 B), shape (u, 1 + free), built in the order of (17): mass, first moments, inertia."""
    rows: dict[str, Array] = {}
    one = np.eye(1 + len(names))
    for linear, physical in pairs:
        if linear in constants:
            rows[linear] = constants[linear] * one[0]
        elif physical not in constants:
            rows[linear] = one[1 + names.index(linear)]
        elif physical in _CENTRE:
            rows[linear] = constants[physical] * rows["m"]
        else:
            rows[linear] = constants[physical] * one[0] + _parallel_axis(physical, constants, rows)
    return np.array(list(rows.values()))


def _parallel_axis(name: str, constants: Mapping[str, float], rows: Mapping[str, Array]) -> Array:
    """The row of m S(xC)^T S(xC) for ICij, with one factor of each product xC m xC known."""
    centre = [_known_centre(axis, constants) for axis in range(3)]
    i, j = int(name[2]) - 1, int(name[3]) - 1
    if i == j:
        others = [(axis, axis) for axis in range(3) if axis != i]
        sign = 1.0
    else:
        others = [(i, j) if centre[i] is not None else (j, i)]
        sign = -1.0
    row = np.zeros_like(rows["m"])
    for a, b in others:
        factor = centre[a]
        if factor is None:
            centres = " and ".join(_CENTRE[axis] for axis, _ in others)
            raise IdentificationError(
                f"{name} can only be fixed together with {centres}, on which its parallel-axis term depends; fix these "
                f"too, fix {name.replace('C', '')}, or use the non-linear form"
            )
        row = row + sign * factor * rows[_FIRST_MOMENTS[b]]
    return row


def _known_centre(axis: int, constants: Mapping[str, float]) -> float | None:
    moment, centre = _FIRST_MOMENTS[axis], _CENTRE[axis]
    if centre in constants:
        return constants[centre]
    if constants.get(moment) == 0.0:
        return 0.0
    return constants[moment] / constants["m"] if moment in constants and "m" in constants else None


def estimate_selected(
    regressors: Array, forces: Array, names: Sequence[str], selection: Selection, estimator: Estimator
) -> Fit:
    """Estimates the free parameters and gives back all of u, with no variance along what is known.

    Args:
        regressors: A_j of the full model, shape (n, 6, u); columns beyond it (a delay) stay free.
        forces: shape (n, 6) [N, or N and N m].
        selection: selection of the model that the regressors belong to.

    Returns:
        The estimator's Fit with values (u,) and covariances (u, u); rank and condition are those of the free ones.

    Raises:
        IdentificationError: as the estimator does.
    """
    unknowns, beyond = len(selection.offset), regressors.shape[2] - len(selection.offset)
    basis = np.zeros((unknowns + beyond, len(selection.names) + beyond))
    basis[:unknowns, : len(selection.names)] = selection.basis
    basis[unknowns:, len(selection.names) :] = np.eye(beyond)
    offset = np.r_[selection.offset, np.zeros(beyond)]
    fit = estimator(regressors @ basis, forces - regressors @ offset, [*selection.names, *names[unknowns:]])
    return replace(
        fit,
        values=offset + basis @ fit.values,
        covariance=basis @ fit.covariance @ basis.T,
        covariance_robust=basis @ fit.covariance_robust @ basis.T,
    )
