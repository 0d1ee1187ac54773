"""ROS 2 `trajectory_msgs/msg/JointTrajectory` as YAML."""
