"""How much of a gripper's grip the robot's weight takes when that gripper holds alone: force and moment over its pads.

See `robots.pipe_climber.pads` for what a grip holds. The weight is taken larger by what the ramps of a move add to it,
``1 + v / (ramp g)``; on one straight the use of a grip is a convex function of the weight's moment, which grows with
the distance of the grippers, so chords between a few distances bound it from above.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.climb.limits import Machine
from steeplejack.robots.pipe_climber.pads import grip_body, grip_use
from steeplejack.robots.pipe_climber.weights import grip_loads

Array = NDArray[np.float64]


def surge(machine: Machine, gravity: Array) -> float:
    """Weight with the acceleration of a ramp, in parts of the weight [1]."""
    size = float(np.linalg.norm(gravity))
    cylinders, gait = machine.robot.cylinders, machine.robot.gait
    return 1.0 + cylinders.speed / (gait.ramp * size) if size > 0.0 else 1.0


def alone(machine: Machine, freedoms: Array, gravity: Array, radii: Array) -> Array:
    """Use of the lower and of the upper gripper's grip, each holding alone.

    Args:
        machine: With its pads, masses and payload.
        freedoms: (x, w, alpha, beta), (k, 4) [m, m, rad, rad].
        gravity: In the lower gripper's frame, (k, 3) [m/s2].
        radii: Of the pipe at the lower and the upper gripper, (k, 2) [m].

    Returns:
        (k, 2), above 1 where it slips or tilts.
    """
    loads = grip_loads(machine.robot, machine.layout, freedoms, gravity, machine.payload)
    use = np.empty((len(freedoms), 2))
    for end in range(2):
        for radius in np.unique(radii[:, end]):
            mine = radii[:, end] == radius
            use[mine, end] = grip_use(grip_body(machine.robot, float(radius)), loads[mine, end])
    return use * surge(machine, gravity[0]) if len(use) else use
