"""Programs that measure standing still: the trigger is on in dwells only, the moves between are not excitation."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from postprocessors.proving.stretches import Still, Stretch, Timed, Untimed

Array = NDArray[np.float64]


def measures_at_poses(program: Sequence[Stretch]) -> bool:
    """Whether the trigger is on while the machine stands, and never while it moves."""
    on = [part for part in program if part.trigger and not (isinstance(part, Still) and part.duration == 0.0)]
    return bool(on) and all(isinstance(part, Still) for part in on)


def measured_poses(program: Sequence[Stretch]) -> Array:
    """Poses at which the trigger is on, in order, shape (k, n) [m or rad]; of programs that measure standing still."""
    here: Array | None = None
    poses: list[Array] = []
    for part in program:
        if isinstance(part, Untimed):
            here = part.end
        elif isinstance(part, Timed):
            here = part.points.at([part.points.duration]).pose[0]
        elif part.trigger and part.duration > 0.0 and here is not None:
            poses.append(here)
    return np.array(poses)
