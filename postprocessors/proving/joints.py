"""Where two polynomial pieces meet: what steps there passes within one cycle of the controller."""

from collections.abc import Iterable

import numpy as np

from identification.limited import Box
from identification.limits import LimitCheck, Status
from identification.motion import Array
from identification.trajectories.polynomial import PolynomialMotion


def joint_checks(motion: PolynomialMotion, limits: Box, cycle: float, clock: float) -> Iterable[LimitCheck]:
    """Accelerations and jerks that steps between pieces amount to, at rest before the first and after the last.

    A step dv of a rate within a cycle c is an acceleration of dv / c and, up and down again, a jerk of 2 dv / c^2; a
    step da of an acceleration is a jerk of da / c.

    Args:
        motion: pieces one after the other.
        limits: of accelerations and jerks.
        cycle: of the controller [s].
        clock: when the motion starts [s].
    """
    rest = np.zeros((1, len(limits.labels)))
    dv, da = (
        np.abs(np.vstack([motion.at_starts(order), rest]) - np.vstack([rest, motion.at_ends(order)]))
        for order in (1, 2)
    )
    times = motion.times + clock
    yield from _worst("acceleration", "m/s^2", "rad/s^2", dv / cycle, limits.acceleration, times, limits)
    yield from _worst("jerk", "m/s^3", "rad/s^3", np.maximum(da / cycle, 2 * dv / cycle**2), limits.jerk, times, limits)


def _worst(
    name: str, linear: str, angular: str, values: Array, most: Array, times: Array, limits: Box
) -> Iterable[LimitCheck]:
    for kind, unit, axes in ((name, linear, ~limits.turns), (f"angular {name}", angular, limits.turns)):
        if not axes.any():
            continue
        ratio = np.nan_to_num(values[:, axes] / most[axes], nan=np.inf)
        row, column = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        k = int(np.flatnonzero(axes)[column])
        yield LimitCheck(
            f"{kind} ({limits.labels[k]}, step between blocks)",
            float(values[row, k]),
            float(most[k]),
            unit,
            float(ratio[row, column]),
            float(times[row]),
            Status.PROVEN,
        )
