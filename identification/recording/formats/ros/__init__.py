"""ROS: bags, their topics and frames, and messages as text."""
