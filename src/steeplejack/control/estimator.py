"""The platform's pose from cable lengths, measured tensions and the places of the bases.

Four lengths cannot fix six freedoms; what they leave open, the equilibrium decides. The estimate minimises

    sum_i (l_i(x) - L_i (1 + t_i / EA))^2 / sigma_l^2  +  |W(x, t) - m a|^2 / sigma_W^2

over the pose x: geometry in the plane of the cables (Eq. 18 of the paper, with the cables' stretch compensated from the
measured tensions), balance of forces and moments out of it. One Gauss-Newton step per control step, started from the
last estimate, tracks the platform: at 0.25 m/s it moves 0.25 mm in between.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.rest.statics import directions, residual, tension_stiffness
from steeplejack.spatial.rotation import turned

Array = NDArray[np.float64]

FRICTION_RATE = 0.005  # [m/s] of winch rate over which Coulomb friction changes sign


@njit(cache=True)
def observe(
    pull: Array,
    pay_rate: Array,
    paid: Array,
    planned: Array,
    momentum: Array,
    offset: Array,
    constants: Array,
    dt: float,
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Measured tensions and loaded cable lengths from winch encoders and motor currents.

    Tensions follow from motor pull, friction and the rotor's momentum,
    ``tau dt_hat/dt = F + friction + m_r dv/dt - t_hat``, without differentiating the rate v: the momentum enters
    through ``t_hat = z + m_r v / tau``. Stretch is compensated by the planned tension plus its slowly filtered
    difference to the measured one.

    Args:
        pull: Motor pulls at the cable (4,) [N].
        pay_rate: Winch rates, positive paying out (4,) [m/s].
        paid: Unstressed cable out (4,) [m].
        planned: Planned tensions (4,) [N].
        momentum: State z of the observer (4,) [N].
        offset: Slow difference between measured and planned tension (4,) [N].
        constants: Winch friction [N], reflected rotor mass [kg], time constants of tension and stretch [s], EA [N].
        dt: Time step [s].

    Returns:
        Tensions (4,) [N], new z, new offset, the tensions that stretch the cables (4,) [N], loaded lengths (4,) [m]
        and their rates (4,) [m/s].
    """
    friction, reflected, tau, slow, elasticity = constants
    tension, z, shift, carried = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    lengths, rates = np.empty(4), np.empty(4)
    for i in range(4):
        impulse = reflected / tau * pay_rate[i]
        felt = pull[i] + friction * np.tanh(pay_rate[i] / FRICTION_RATE)
        tension[i] = momentum[i] + impulse
        z[i] = momentum[i] + (felt - tension[i]) * dt / tau
        shift[i] = offset[i] + (tension[i] - planned[i] - offset[i]) * dt / (slow + dt)
        carried[i] = planned[i] + shift[i]
        stretch = 1.0 + carried[i] / elasticity
        lengths[i], rates[i] = paid[i] * stretch, pay_rate[i] * stretch
    return tension, z, shift, carried, lengths, rates


@njit(cache=True)
def estimate(
    position: Array,
    rotation: Array,
    exits: Array,
    exit_rates: Array,
    attachments: Array,
    lengths: Array,
    rates: Array,
    tensions: Array,
    load: Array,
    centre: Array,
    weights: Array,
) -> tuple[Array, Array, Array, float]:
    """One Gauss-Newton step of the pose estimate.

    Args:
        position: Last estimate (3,) [m].
        rotation: Last estimate (3, 3).
        exits: Winch exits (4, 3) [m].
        exit_rates: Their velocities (4, 3) [m/s].
        attachments: Attachments (4, 3) [m], platform frame.
        lengths: Loaded cable lengths (4,) [m], stretch included.
        rates: Their rates (4,) [m/s].
        tensions: Measured tensions (4,) [N].
        load: Gravity force less mass times the reference's acceleration (3,) [N].
        centre: Centre of mass (3,) [m].
        weights: sigma of a length [m], of a force [N], of a moment [N m].

    Returns:
        Position (3,), rotation (3, 3), velocity of the platform (6,) (rotation; translation) [rad/s; m/s], and the
        root mean square of what the lengths leave unexplained [m].
    """
    u, now = directions(exits, attachments, position, rotation)
    rows = np.empty((10, 6))
    errors, speeds = np.empty(10), np.zeros(10)
    square = 0.0
    for i in range(4):
        a0 = (
            rotation[0, 0] * attachments[i, 0] + rotation[0, 1] * attachments[i, 1] + rotation[0, 2] * attachments[i, 2]
        )
        a1 = (
            rotation[1, 0] * attachments[i, 0] + rotation[1, 1] * attachments[i, 1] + rotation[1, 2] * attachments[i, 2]
        )
        a2 = (
            rotation[2, 0] * attachments[i, 0] + rotation[2, 1] * attachments[i, 1] + rotation[2, 2] * attachments[i, 2]
        )
        rows[i, 0] = -(a1 * u[i, 2] - a2 * u[i, 1]) / weights[0]
        rows[i, 1] = -(a2 * u[i, 0] - a0 * u[i, 2]) / weights[0]
        rows[i, 2] = -(a0 * u[i, 1] - a1 * u[i, 0]) / weights[0]
        moving = 0.0
        for k in range(3):
            rows[i, 3 + k] = -u[i, k] / weights[0]
            moving += u[i, k] * exit_rates[i, k]
        errors[i] = (lengths[i] - now[i]) / weights[0]
        speeds[i] = (rates[i] - moving) / weights[0]
        square += (lengths[i] - now[i]) ** 2
    missing = residual(attachments, load, centre, rotation, u, tensions)
    hessian = tension_stiffness(attachments, load, centre, rotation, u, now, tensions)
    for j in range(6):
        sigma = weights[2] if j < 3 else weights[1]
        errors[4 + j] = missing[j] / sigma
        for k in range(6):
            rows[4 + j, k] = hessian[j, k] / sigma
    normal = rows.T @ rows
    right = np.empty((6, 2))
    right[:, 0] = rows.T @ errors
    right[:, 1] = rows.T @ speeds
    solution: Array = np.linalg.solve(normal, right)  # pyright: ignore[reportAssignmentType]
    step: Array = solution[:, 0].copy()
    velocity: Array = solution[:, 1].copy()
    return position + step[3:], turned(step[:3], rotation), velocity, float(np.sqrt(square / 4.0))
