"""From cable lengths to poses: tracking, forward kinematics, every pose of a box."""
