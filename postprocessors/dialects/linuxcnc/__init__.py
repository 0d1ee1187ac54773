"""LinuxCNC: axes in mm and degrees, the pose of a platform or the joints of a chain."""
