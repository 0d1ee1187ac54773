"""Poses that a user gives as numbers: coordinates of the machine of a case, looked at before anything is computed."""

import numpy as np
from numpy.typing import ArrayLike

from cases.base.errors import Code, HexciteError
from cases.base.units import Array
from cases.schema import Case


def given_poses(values: ArrayLike, case: Case, place: str) -> Array:
    """Poses of a case's machine as an array, shape (n, k) [m or rad].

    Args:
        values: shape (n, k), or (k,) of one pose.
        case: case with a machine and its limits.
        place: argument or function that they were given to, for messages.

    Raises:
        HexciteError: they are not finite numbers, or not of so many coordinates.
        CaseError: the case has no machine or no limits.
    """
    count = len(case.need_motion("poses")[0])
    try:
        poses = np.atleast_2d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise HexciteError(
            place=place,
            problem="poses are not a table of numbers",
            remedy=f"give rows of {count} [m or rad]",
            code=Code.WRONG_KIND,
        ) from None
    if poses.ndim != 2 or poses.shape[1] != count:
        raise HexciteError(
            place=place,
            problem=f"poses of {poses.shape[-1]} coordinates"
            if poses.ndim == 2
            else f"poses in {poses.ndim} dimensions",
            remedy=f"{case.name} has {count} [m or rad]",
            code=Code.WRONG_KIND,
        )
    if not (finite := np.isfinite(poses).all(axis=1)).all():
        raise HexciteError(
            place=place,
            problem=f"pose {int(np.argmin(finite)) + 1} holds something that is not a number",
            remedy="leave it out, or give its coordinates",
            code=Code.WRONG_KIND,
        )
    return poses
