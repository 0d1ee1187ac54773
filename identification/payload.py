"""The payload between two identifications: the rigid body that was added from one to the other."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cases.errors import IdentificationError
from identification.model import FIRST_MOMENT, INERTIA, MASS, Block, Model
from identification.parameters import physical_form
from identification.result import Value
from identification.saved import SavedResult

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Payload:
    """A payload.

    Args:
        parameters: mass, centre of gravity in {P} and inertia about it (where both results have it), by name.
        warnings: sentences.
    """

    parameters: dict[str, Value]
    warnings: tuple[str, ...]


def payload_between(before: SavedResult, after: SavedResult, model_before: Model, model_after: Model) -> Payload:
    """The body that has to be added to `before` to get `after`; the two runs are independent.

    Mass, first moments and inertia about the origin of {P} of rigid bodies add, so their differences are those of the
    payload, and covariances add. What two different models blame on mass differs (section 5): then a warning says so.

    Args:
        before: without the payload.
        after: with it.
        model_before: of `before`.
        model_after: of `after`.

    Raises:
        IdentificationError: the difference in mass is not significant, so that there is no centre of gravity.
    """
    shared: tuple[Block, ...] = (MASS, FIRST_MOMENT)
    if INERTIA in model_before.blocks and INERTIA in model_after.blocks:
        shared = (*shared, INERTIA)
    body = Model(after.model, shared, model_after.structure, model_after.gravity)
    old = [model_before.names.index(name) for name in body.names]
    new = [model_after.names.index(name) for name in body.names]
    difference = after.values[new] - before.values[old]
    covariance = after.covariance[np.ix_(new, new)] + before.covariance[np.ix_(old, old)]
    robust = after.covariance_robust[np.ix_(new, new)] + before.covariance_robust[np.ix_(old, old)]
    std = float(np.sqrt(max(covariance[0, 0], robust[0, 0])))
    if not abs(difference[0]) > 3.0 * std:
        raise IdentificationError(
            f"{after.source}: mass differs from {before.source} by {difference[0]:.4g} +- {std:.2g} kg, not by a "
            "payload; name the results without and with payload, in this order"
        )
    warnings = []
    if before.model != after.model:
        warnings.append(f"models {before.model} and {after.model} differ: masses of different models do not compare")
    if before.case_hash != after.case_hash:
        warnings.append("the case was changed between the two identifications")
    if difference[0] < 0.0:
        warnings.append("the mass became smaller: this is what was taken off, as a negative payload")
    form = physical_form(body)
    values, physical = form.of(difference, covariance)
    white, long_run = np.sqrt(np.diag(physical)), np.sqrt(np.diag(form.of(difference, robust)[1]))
    parameters = {
        p.name: Value(float(v), float(s), float(r), p.unit)
        for p, v, s, r in zip(form.parameters, values, white, long_run, strict=True)
    }
    return Payload(parameters, tuple(warnings))
