"""Cases with chains and walks in joint coordinates for programs of robots."""

from itertools import pairwise

import numpy as np

from cases.controller import UrScript
from cases.schema import Case, load_case
from identification.motion.motion import Joined
from identification.motion.moves import StraightMove

ROBOT = load_case("ur10_wrist")


def robot() -> Case:
    """The built-in robot with settings of URScript programs."""
    assert ROBOT.controller is not None
    urscript = UrScript(program_name="walk", trigger_output=3)
    return ROBOT.model_copy(update={"controller": ROBOT.controller.model_copy(update={"urscript": urscript})})


def walk(case: Case, moves: int = 3, jerk: bool = True, share: float = 0.95, seed: int = 0) -> Joined:
    """Moves between random places of the motion box, each as fast as a share of its limits allows.

    Args:
        case: with a chain.
        moves: how many.
        jerk: whether the jerk is limited too.
        share: of the limits.
        seed: of the places.
    """
    home, box = case.need_motion("a walk")
    low, high = share * box.coordinates
    places = home + np.random.default_rng(seed).uniform(low, high, (moves + 1, len(home)))
    most = [share * box.rate, share * box.acceleration, share * box.jerk if jerk else np.full(len(home), np.inf)]
    return Joined(tuple(StraightMove.fastest(a, b, *most) for a, b in pairwise(places)))
