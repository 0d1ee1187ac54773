"""What a `joint_trajectory_controller` guarantees beyond its points."""

import math

from cases.schema import Case
from postprocessors.proof.guarantees import SEVEN_SEGMENTS, Guarantees
from postprocessors.reading import Reading

SHORTEST_POINTS = 1e-3  # least distance of points of a joint trajectory [s]: rounding of closer ones would add jerks


def joint_trajectory_guarantees(reading: Reading, case: Case) -> Guarantees:
    """Guarantees for quintic pieces through stated positions, rates and accelerations: all proven, nothing enforced."""
    name = "joint_trajectory_controller"
    remedy = "leave out points that are closer to the one before"
    return Guarantees(
        case, name, SHORTEST_POINTS, math.inf, SEVEN_SEGMENTS, follows_paths=True, resolution=0.0, timing_remedy=remedy
    )
