"""What the cylinders bear while one gripper holds alone, from the robot's masses.

With the lower gripper holding, the cylinders carry what moves with the mechanism: by virtual work
``J^T f_lower + w = 0`` with ``w_k = g . d(sum m r) / d(pose)_k``, masses and places in the lower gripper's frame. With
the upper gripper holding, everything else hangs from the platform. Moving the robot as one body does no work inside
it, so the two differ by the whole weight W as a wrench on the platform at O2: ``J^T (f_upper - f_lower) = W``.

A gripper that lets go while it still bears the robot drops the weight onto the other one in the few milliseconds its
jaws take, and what then swings takes friction that holding still does not. So the cylinders shift the load first.
"""

from __future__ import annotations

import math

import numpy as np

from steeplejack.control.climber.signals import Array
from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.statics import actuator_forces
from steeplejack.robots.pipe_climber.weights import first_moments

STEP = 1e-6  # [m] and [rad] of the differences


def holding_forces(robot: PipeClimber, layout: Layout, freedoms: Array, gravity: Array, payload: float = 0.0) -> Array:
    """Forces of the cylinders at rest while the lower, and while the upper gripper holds alone.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        freedoms: (x, w, alpha, beta), (4,) [m, m, rad, rad].
        gravity: In the frame of the lower gripper (3,) [m/s2].
        payload: At the middle of the upper gripper [kg].

    Returns:
        (2, 3), positive where a cylinder pushes [N].
    """
    x, w, _alpha, beta = freedoms
    ahead, back = (
        first_moments(robot, layout, freedoms + sign * STEP * np.eye(4)[:3], payload)[1] for sign in (1.0, -1.0)
    )
    carried = (ahead - back) @ gravity / (2.0 * STEP)
    mass, moment = first_moments(robot, layout, freedoms, payload)
    cosine, sine = math.cos(beta), math.sin(beta)
    across = np.array([cosine, sine, 0.0])  # X of the mechanism in the lower gripper's frame
    force_x, force_z = mass * float(gravity @ across), mass * float(gravity[2])
    turn = (moment[2] - mass * w) * force_x / mass - (float(moment @ across) - mass * x) * force_z / mass
    whole = np.array([force_x, force_z, turn])
    return actuator_forces(layout, freedoms[:3], np.stack((carried, carried - whole)))
