"""What the drives bear while one gripper holds alone, from where the robot's masses are; slow motion.

With the lower gripper holding, the cylinders carry what moves with the mechanism: by virtual work ``J^T f_lower + w =
0`` with ``w_k = g . d(sum m r) / d(pose)_k``. With the upper gripper holding, everything else hangs from the platform.
Moving the robot as one body does no work inside it, so the two differ by the whole weight W as a wrench on the platform
at O2: ``J^T (f_upper - f_lower) = W``. The servo of the linkage carries, about the axis of the lower gripper, what
turns with the mechanism, or what turns with the lower gripper.

The planner keeps the drives within it, and the controller hands the weight over with it: a gripper that lets go while
it still bears the robot drops it onto the other one in the milliseconds its jaws take, and what then swings takes
friction that holding still does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.parameters import PipeClimber
from steeplejack.robots.pipe_climber.statics import actuator_forces
from steeplejack.robots.pipe_climber.weights import first_moments, own_moment

Array = NDArray[np.float64]

STEP = 1e-6
"""Of the differences [m] and [rad]."""


def weight_wrenches(
    robot: PipeClimber, layout: Layout, poses: ArrayLike, beta: ArrayLike = 0.0, payload: float = 0.0
) -> Array:
    """What the cylinders bear of the robot's weight, as a wrench on the platform at O2, for gravity of 1 m/s2.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        poses: (x, w, alpha), (..., 3) [m, m, rad].
        beta: Turn of the linkage, (...) [rad].
        payload: At the middle of the upper gripper [kg].

    Returns:
        (F_x, F_z, M_y) with the lower, then the upper gripper holding, for gravity along X, then along Z of the
        mechanism, (..., 2, 2, 3) [kg, kg, kg m].
    """
    given = np.asarray(poses, dtype=np.float64)
    still = np.append(given, np.zeros((*given.shape[:-1], 1)), axis=-1)
    mass, moment = first_moments(robot, layout, still, payload)
    steps = STEP * np.eye(4)[:3]
    ahead, back = (first_moments(robot, layout, still[..., None, :] + sign * steps, payload)[1] for sign in (1.0, -1.0))
    carried = np.swapaxes((ahead - back)[..., [0, 2]], -1, -2) / (2.0 * STEP)
    forward = moment[..., 0] - own_moment(robot) * (1.0 - np.cos(np.asarray(beta, dtype=np.float64)))
    none = np.zeros_like(forward)
    whole = np.stack((
        np.stack((none + mass, none, moment[..., 2] - mass * given[..., 1]), axis=-1),
        np.stack((none, none + mass, mass * given[..., 0] - forward), axis=-1),
    ), axis=-2)  # fmt: skip
    carried = np.broadcast_to(carried, whole.shape)
    return np.stack((carried, carried - whole), axis=-3)


def holding_forces(
    robot: PipeClimber, layout: Layout, freedoms: ArrayLike, gravity: ArrayLike, payload: float = 0.0
) -> Array:
    """Forces of the cylinders at rest while the lower, and while the upper gripper holds alone.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        freedoms: (x, w, alpha, beta), (..., 4) [m, m, rad, rad].
        gravity: In the frame of the lower gripper (..., 3) [m/s2].
        payload: At the middle of the upper gripper [kg].

    Returns:
        (..., 2, 3), positive where a cylinder pushes [N]; NaN at a singular pose.
    """
    given, pull = np.asarray(freedoms, dtype=np.float64), np.asarray(gravity, dtype=np.float64)
    beta = given[..., 3]
    across = pull[..., 0] * np.cos(beta) + pull[..., 1] * np.sin(beta)  # along X of the mechanism
    each = weight_wrenches(robot, layout, given[..., :3], beta, payload)
    weights = across[..., None, None] * each[..., 0, :] + pull[..., 2, None, None] * each[..., 1, :]
    return actuator_forces(layout, given[..., None, :3], weights)


def servo_torques(
    robot: PipeClimber, layout: Layout, freedoms: ArrayLike, gravity: ArrayLike, payload: float = 0.0
) -> Array:
    """Torques of gravity about the linkage's axis while the lower, and while the upper gripper holds alone.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        freedoms: (x, w, alpha, beta), (..., 4) [m, m, rad, rad].
        gravity: In the frame of the lower gripper (..., 3) [m/s2].
        payload: At the middle of the upper gripper [kg].

    Returns:
        (..., 2), positive where beta grows without the servo [N m].
    """
    given, pull = np.asarray(freedoms, dtype=np.float64), np.asarray(gravity, dtype=np.float64)
    _mass, moment = first_moments(robot, layout, given, payload)
    own = own_moment(robot)
    lower = (moment[..., 0] - own) * pull[..., 1] - moment[..., 1] * pull[..., 0]
    return np.stack((lower, np.broadcast_to(-own * pull[..., 1], lower.shape)), axis=-1)
