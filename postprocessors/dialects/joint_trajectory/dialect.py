"""ROS 2 `trajectory_msgs/msg/JointTrajectory` as YAML, JSON and script: its functions as a value."""

from cases.controller import ControllerName
from postprocessors.dialects.dialect import Dialect
from postprocessors.dialects.joint_trajectory.forms import JSON, SCRIPT, YAML, in_form
from postprocessors.dialects.joint_trajectory.promises import joint_trajectory_guarantees
from postprocessors.dialects.joint_trajectory.read import read_joint_trajectory
from postprocessors.dialects.joint_trajectory.write import require_same_trajectory, write_joint_trajectory

JOINT_TRAJECTORY = Dialect(
    ControllerName.ROS2,
    (*YAML, JSON, SCRIPT),
    write_joint_trajectory,
    read_joint_trajectory,
    joint_trajectory_guarantees,
    form=in_form,
    same=require_same_trajectory,
    start="the machine must stand at home when the trajectory starts",
)
