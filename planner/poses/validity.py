"""Whether the machine can stand at a pose: the paper's is_valid (strut lengths, joint angles, singularity distance).

Written once in CasADi: the filter of candidates evaluates it, the refinement of poses differentiates it. The proof of a
finished plan (`identification.limits`) shares nothing with it.
"""

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cases.schema import Case
from cases.units import DEG
from identification.evaluate import over_samples
from identification.hexapod import Hexapod
from identification.keep_out import distances
from identification.pose import rotation

Array = NDArray[np.float64]

ROUNDING = 1e-9  # poses on the very edge of the workspace are valid
REASONS = (
    *(f"strut {k} too short" for k in range(1, 7)),
    *(f"strut {k} too long" for k in range(1, 7)),
    *(f"base joint {k} beyond its angle" for k in range(1, 7)),
    *(f"platform joint {k} beyond its angle" for k in range(1, 7)),
    "too close to a singularity",
    *("x below the workspace", "x above the workspace", "y below the workspace", "y above the workspace"),
)


def validity_margins(case: Case) -> ca.Function:
    """Pose -> margins, shape (29,), each a share of its limit; the pose is valid where none is below 0.

    In the order of `REASONS`: strut lengths from below and above over the range of lengths; cosines of the angles at
    base and platform less those of their limits; determinant of J_Hex^-1 over that at home less the smallest share;
    position in the XY range over its width.

    Raises:
        CaseError: the case lacks machine, workspace or poses.
    """
    machine, workspace, _ = case.need_machine("the validity of poses")
    hexapod = Hexapod.of(case)
    pose = ca.SX.sym("pose", 6)
    lengths, jacobian = hexapod.inverse_jacobian(pose)
    normal = rotation(pose[3:])[:, 2]
    directions = jacobian[:, :3]  # unit vectors along the struts, row by row
    at_base = directions[:, 2] - float(np.cos(workspace.base_joint_angle_deg * DEG))
    at_platform = directions @ normal - float(np.cos(workspace.platform_joint_angle_deg * DEG))
    shortest, longest = workspace.strut_length
    home = np.linalg.det(hexapod.inverse_jacobian(machine.home.vector)[1].full())
    apart = ca.det(jacobian) / float(home) - case.need_poses("the validity of poses").singularity_distance
    in_range = []
    for axis, (low, high) in enumerate((workspace.x_mm, workspace.y_mm)):
        value = (pose[axis] - machine.home.vector[axis]) / 1e-3
        in_range += [(value - low) / (high - low), (high - value) / (high - low)]
    width = longest - shortest
    margins = ca.vertcat(
        (lengths - shortest) / width, (longest - lengths) / width, at_base, at_platform, apart, *in_range
    )
    return ca.Function("validity_margins", [pose], [ca.densify(margins)], {"cse": True})


def margins_of(case: Case, poses: Array) -> Array:
    """Margins of poses, shape (n, 29)."""
    return over_samples(validity_margins(case), poses)[0]


def keep_out_distances(case: Case, poses: Array) -> Array:
    """Distance of platform, struts and tools from the nearest keep-out box, shape (n,) [m].

    Below 0 inside one; along the axis that separates them most; infinite where the case has no such box.
    """
    machine, workspace, _ = case.need_machine("the validity of poses")
    turn, origin, base = Rotation.from_euler("xyz", poses[:, 3:]).as_matrix(), poses[:, :3], machine.base.points
    strut = origin[:, None] + machine.platform.points @ turn.transpose(0, 2, 1) - base
    nearest = np.full(len(poses), np.inf)
    for box in workspace.keep_out:
        nearest = np.minimum(nearest, distances(box, workspace, origin, turn, base, strut).min(axis=1))
    return nearest


def valid_poses(case: Case, poses: Array) -> NDArray[np.bool_]:
    """Whether the machine can stand at each pose, shape (n,)."""
    inside = np.all(margins_of(case, poses) >= -ROUNDING, axis=1)
    return np.asarray(inside & (keep_out_distances(case, poses) >= 0.0))
