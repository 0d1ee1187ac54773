"""What planning, runs and evaluation ask of a machine: from its coordinates to the frame that carries the load.

Coordinates are what motions are planned in, drives what encoders measure: the pose and the struts of a hexapod, for a
chain both the positions of its joints. Whoever asks for less than a hexapod's struts takes a machine from here, and so
knows no kind of machine; a new kind is a class with the members that these have in common, and a line in `machine_of`.
"""

import numpy as np
from numpy.typing import NDArray

from cases.errors import CaseError
from cases.schema import Case
from identification.hexapod import Hexapod
from identification.serial_chain import SerialChain
from identification.symbolic import over_samples

Array = NDArray[np.float64]

Machine = Hexapod | SerialChain
"""A machine that moves the frame of the load.

It has `count` coordinates; `of_pose` says whether they are the pose of that frame, `turns` which drives measure angles.
`frame` and `shares` are expressions for the search. `drives` and `coordinates` follow from each other, `positions` are
those of the frame. `kinematics` is the motion of the frame by that of the drives; it may start from poses near by, as
`earlier` has them. `elastic` says whether its sensors err with the pose as the error terms K1 to K5 say.
"""


def machine_of(case: Case) -> Machine:
    """The machine of a case.

    Raises:
        CaseError: the case has no machine, or one that does not move the sensors.
    """
    return SerialChain.of(case) if case.chain is not None else Hexapod.of(case)


def machine_if_any(case: Case) -> Machine | None:
    """The machine of a case; None where it has none that can be planned for."""
    try:
        return machine_of(case)
    except CaseError:
        return None


def kinetic(
    case: Case, pose: Array, rates: Array, accelerations: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Motion of what has limits of rates and accelerations beside the coordinates, along a motion in these.

    Args:
        pose: coordinates, shape (n, c); `rates` and `accelerations` are their derivatives.

    Returns:
        Velocities [m/s] and accelerations [m/s^2] of the k = 6 struts of a hexapod, shapes (n, k), and the limits of
        both, shapes (k,); a chain has none, k = 0.

    Raises:
        CaseError: the case has no machine or no limits.
    """
    if case.chain is not None:
        none = np.zeros((len(pose), 0))
        return (none, none), (none[:0].ravel(), none[:0].ravel())
    limits = case.need_machine("the motion of struts")[2]
    _, velocities, second = over_samples(Hexapod.of(case).strut_motion, pose, rates, accelerations)
    six = np.ones(6)
    return (velocities, second), (limits.strut_velocity_m_s * six, limits.strut_acceleration_m_s2 * six)
