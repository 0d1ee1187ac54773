"""How much LinuxCNC will stretch a timed path, told before it runs.

It plans a turning path block by block, without look-ahead, so that it could come to rest at the end of each. Over a
block of length L it sustains sqrt(a L / 2), a being the acceleration limit along the block, so that no block takes less
than sqrt(2 L / a); measured on LinuxCNC 2.9.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.schema import Case
from postprocessors.execute.block_limited import least_durations
from postprocessors.execute.linuxcnc.configuration import PURPOSE
from postprocessors.execute.linuxcnc.guarantees import acceleration_headroom
from postprocessors.guarantees import Forecast
from postprocessors.reading.words import Reading
from postprocessors.stretches import Timed, stretches

Array = NDArray[np.float64]

NOTICEABLE = 1.01


class Stretch(NamedTuple):
    """The timed paths of a program under a controller's limits.

    Args:
        factor: predicted duration over planned duration of the excitation.
        block: duration of blocks at which nothing would be stretched any more [s].
        headroom: multiple of the case's acceleration limits at which these blocks would not be stretched.
    """

    factor: float
    block: float
    headroom: float


def predicted_stretch(reading: Reading, case: Case, headroom: float) -> Stretch | None:
    """What becomes of the timed paths that run with the trigger on; None where there are none.

    Args:
        reading: the program.
        case: its acceleration limits.
        headroom: what LinuxCNC gets, as a multiple of them.

    Raises:
        ProgramError: the motion is not defined.
        CaseError: the case has no machine.
    """
    limits = case.need_machine(PURPOSE)[2].motion
    planned: list[Array] = []
    least: list[Array] = []
    for part in stretches(reading):
        if isinstance(part, Timed) and part.trigger:
            times = part.points.times
            planned.append(np.diff(times))
            least.append(least_durations(part.points.at(times).pose, limits.acceleration))
    if not planned:
        return None
    steps, shortest = np.concatenate(planned), np.concatenate(least)
    factor = float(np.maximum(steps, shortest / np.sqrt(headroom)).sum() / steps.sum())
    # way = rate * step: the least duration grows with the root of a block's, so the block must grow with its square.
    ratio = float(np.max(shortest / steps))
    return Stretch(factor, float(steps.max()) * ratio**2 / headroom, ratio**2)


def linuxcnc_forecast(reading: Reading, case: Case) -> Forecast:
    """How much LinuxCNC will stretch a program, as it is set up and under the case's own acceleration limits."""
    headroom = acceleration_headroom(reading, case)
    stretch, own = predicted_stretch(reading, case, headroom), predicted_stretch(reading, case, 1.0)
    if stretch is None or own is None:
        return Forecast()
    remarks = []
    if stretch.factor > NOTICEABLE:
        remarks.append(
            f"LinuxCNC will take {stretch.factor:.2f} times as long for the timed path; it keeps time with blocks of "
            f"{math.ceil(1e3 * stretch.block)} ms (controller.block_ms), with acceleration_headroom = "
            f"{math.ceil(stretch.headroom)}, or plan point-to-point moves"
        )
    if own.factor > NOTICEABLE and headroom > 1.0:
        remarks.append(
            f"under the case's own acceleration limits it would take {own.factor:.2f} times as long "
            f"(acceleration_headroom is {headroom:g}); point-to-point moves keep their time and these limits"
        )
    return Forecast(stretch.factor, tuple(remarks))
