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
        cycle: cycle of the controller [s].
        clock: when the motion starts [s].
    """
    rest = np.zeros((1, len(limits.rate)))
    dv, da = (
        np.abs(np.vstack([motion.at_starts(order), rest]) - np.vstack([rest, motion.at_ends(order)]))
        for order in (1, 2)
    )
    times = motion.times + clock
    yield from _worst("acceleration", "m/s^2", "rad/s^2", dv / cycle, limits.acceleration, limits, times)
    yield from _worst("jerk", "m/s^3", "rad/s^3", np.maximum(da / cycle, 2 * dv / cycle**2), limits.jerk, limits, times)


def _worst(
    name: str,
    linear: str,
    angular: str,
    values: Array,
    most: Array,
    limits: Box,
    times: Array,
) -> Iterable[LimitCheck]:
    for kind, unit, own in ((name, linear, ~limits.turns), (f"angular {name}", angular, limits.turns)):
        if not own.any():
            continue
        ratio = np.where(own, np.nan_to_num(values / most, nan=np.inf), -1.0)
        row, k = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        yield LimitCheck(
            f"{kind} ({limits.labels[k]}, step between blocks)",
            float(values[row, k]),
            float(most[k]),
            unit,
            float(ratio[row, k]),
            float(times[row]),
            Status.PROVEN,
        )
