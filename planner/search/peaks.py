"""Where along a motion a limit is used most."""

from enum import Enum


class Peak(Enum):
    """Where along a motion a limit is used most."""

    POSE = "where the pose is extreme"
    VELOCITY = "where rates are largest"
    ACCELERATION = "where accelerations are largest"
