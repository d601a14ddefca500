"""Compiled test whether taut inextensible cables hold a platform where it is, or next to it.

At a rest the gradient of the potential is balanced by the tensions of the taut inextensible cables, whose lengths are
met (Karush, Kuhn and Tucker; Nocedal and Wright, Numerical Optimization, 2006, chapter 12):

    dE + sum_i s_i dl_i = 0,   l_i = L_i,   s_i > 0.

It is a minimum if as many independent cables as freedoms are taut, whatever the curvature, or else if the Hessian is
positive on the motions that do no work on them. `settled_by` solves those equations by Newton's method from a pose and
tensions near them. The multipliers of `potential.descend` converge by a factor that falls to nothing as the cables
become dependent; here dependence costs digits, not steps.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from steeplejack.mechanics.cable.pose.misfit import turn
from steeplejack.mechanics.cable.pulleys import cable_run
from steeplejack.mechanics.cable.rest.curvature import add_cable, arm_of
from steeplejack.mechanics.cable.rest.potential import BALANCE, NEUTRAL, Array, Flags, Ints, Loads, Robot, evaluate
from steeplejack.mechanics.cable.rest.statics import add_wrench

ROUNDS = 40
MET = 1e-14  # [1] error of a length over the length and the anchor's coordinates: rounding
RANK = 1e-9  # [1] least singular value over the greatest of cables that are independent


@njit(cache=True)
def settled_by(
    anchors: Array,
    axes: Array,
    radii: Array,
    attachments: Array,
    unstressed: Array,
    spring: Array,
    rigid: Flags,
    forces: Array,
    points: Array,
    moment: float,
    freedoms: Ints,
    gyration: float,
    reach: float,
    position: Array,
    rotation: Array,
    phi: float,
    tensions: Array,
) -> tuple[float, float]:
    """Move to the rest that taut inextensible cables hold, if there is one within reach.

    Args:
        anchors: (m, 3) [m].
        axes: Unit swivel axes (m, 3).
        radii: Of the pulleys (m,) [m].
        attachments: From the load's centre (m, 3) [m].
        unstressed: ``L`` (m,) [m].
        spring: ``k`` (m,) [N/m], for inextensible cables any; 0 takes a cable away.
        rigid: Which cables are inextensible (m,).
        forces: (j, 3) [N].
        points: Where they act, from the load's centre (j, 3) [m].
        moment: About z, planar robots only [N m].
        freedoms: Which of (omega; v) move (n,).
        gyration: Radius that weighs rotation against translation [m].
        reach: Longest way to the rest [m].
        position: Of the load's centre, replaced by that at rest (3,) [m].
        rotation: Replaced (3, 3).
        phi: Angle turned about z so far [rad].
        tensions: Guess, replaced (m,) [N]; above 0 are the cables taken for taut. Where no inextensible one is, those
            that have no slack at the pose are tried, with the tensions that balance best.

    Returns:
        Residual force [N] and angle turned; not a number where no rest was found: pose and tensions mean nothing then.
    """
    robot, loads = (anchors, axes, radii, attachments, unstressed), (forces, points, moment)
    taut, scale = rigid & (spring > 0.0) & (tensions > 0.0), np.where(freedoms < 3, 1.0 / gyration, 1.0)
    away, work = 0.0, np.where(rigid, 0.0, spring)
    miss, rows = _courses(robot, position, rotation, freedoms, scale)
    if not taut.any():
        taut, tensions[:] = rigid & (spring > 0.0) & (np.abs(miss) <= _rounding(robot)), 0.0
    chosen = np.nonzero(taut)[0]
    stiff = spring.max()
    if chosen.size == 0 or not np.isfinite(rows[chosen]).all():
        return np.nan, phi
    for trial in range(ROUNDS):
        gradient, hessian = _bare(robot, loads, work, taut, tensions, position, rotation, phi, freedoms, scale)
        if not (np.isfinite(gradient).all() and np.isfinite(hessian).all() and np.isfinite(rows[chosen]).all()):
            return np.nan, phi
        grip = np.ascontiguousarray(rows[chosen].T)
        if trial == 0 and not tensions[chosen].any():
            tensions[chosen] = np.linalg.lstsq(grip, -gradient)[0]
            continue
        left = gradient + grip @ tensions[chosen]
        residual = math.sqrt((left * left).sum())
        greatest = np.abs(tensions).max()
        if residual <= BALANCE * greatest and (np.abs(miss) <= _rounding(robot))[chosen].all():
            good = _is_least(robot, spring, rigid, taut, tensions, miss, grip, hessian, greatest)
            return (residual if good else np.nan), phi
        step, change = _newton(hessian, grip, left, miss[chosen], stiff)
        away += math.sqrt((step * step).sum())
        if not away <= reach:
            return np.nan, phi
        tensions[chosen] += change
        phi += _move(step, freedoms, scale, position, rotation)
        miss, rows = _courses(robot, position, rotation, freedoms, scale)
    return np.nan, phi


@njit(cache=True)
def _rounding(robot: Robot) -> Array:
    """Errors of lengths (m,) [m] that are rounding."""
    out = np.empty(robot[4].shape[0])
    for i in range(out.shape[0]):
        out[i] = MET * (robot[4][i] + np.abs(robot[0][i]).max())
    return out


@njit(cache=True)
def _courses(robot: Robot, position: Array, rotation: Array, freedoms: Ints, scale: Array) -> tuple[Array, Array]:
    """Lengths less the unstressed ones (m,) [m], and their slopes in the metric of the mass (m, n)."""
    anchors, axes, radii, attachments, unstressed = robot
    m, n = anchors.shape[0], freedoms.shape[0]
    miss, rows, wrench = np.empty(m), np.empty((m, n)), np.empty(6)
    arm, along, across = np.empty(3), np.empty(3), np.empty(3)
    for i in range(m):
        arm_of(rotation, attachments, i, arm)
        length, _inside, _outside = cable_run(anchors, axes, radii, i, position + arm, along, across)
        miss[i] = length - unstressed[i]
        wrench[:] = 0.0
        add_wrench(-1.0, along, arm, wrench)
        rows[i] = wrench[freedoms] * scale
    return miss, rows


@njit(cache=True)
def _bare(
    robot: Robot, loads: Loads, work: Array, taut: Flags, tensions: Array, position: Array, rotation: Array, phi: float,
    freedoms: Ints, scale: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Gradient of loads and elastic cables (n,), and Hessian (n, n) that has the taut cables at constant tensions too.

    Tensions of the other cables are written.
    """
    anchors, axes, radii, attachments, _unstressed = robot
    n, m = freedoms.shape[0], anchors.shape[0]
    full, curved, pulls, none = np.empty(6), np.empty((6, 6)), np.empty(m), np.zeros(m)
    evaluate(robot, loads, work, none, position, rotation, phi, full, curved, pulls)
    for i in range(m):
        if not taut[i]:
            tensions[i] = pulls[i]
    gradient, hessian = full[freedoms] * scale, np.empty((n, n))
    bend, slack = np.zeros((6, 6)), np.zeros((3, 3))
    arm, along, across = np.empty(3), np.empty(3), np.empty(3)
    for i in range(m):
        if taut[i]:
            arm_of(rotation, attachments, i, arm)
            _length, inside, outside = cable_run(anchors, axes, radii, i, position + arm, along, across)
            add_cable(arm, along, across, inside, outside, tensions[i], 0.0, slack, bend)
    for a in range(n):
        for b in range(n):
            p, q = freedoms[a], freedoms[b]
            hessian[a, b] = (curved[p, q] + bend[p, q]) * scale[a] * scale[b]
    return gradient, hessian


@njit(cache=True)
def _newton(hessian: Array, grip: Array, left: Array, miss: Array, stiff: float) -> tuple[Array, Array]:
    """Step (n,) and change of the tensions (c,) to the root of the linear equations, the smallest where it is not one.

    Forces are taken over a stiffness, so that all rows are lengths.
    """
    n, c = grip.shape
    matrix, wanted, found = np.zeros((n + c, n + c)), np.empty(n + c), np.empty(n + c)
    matrix[:n, :n] = hessian / stiff
    matrix[:n, n:] = grip
    matrix[n:, :n] = grip.T
    wanted[:n], wanted[n:] = -left / stiff, -miss
    found[:] = np.linalg.lstsq(matrix, wanted)[0]
    return found[:n], found[n:] * stiff


@njit(cache=True)
def _move(step: Array, freedoms: Ints, scale: Array, position: Array, rotation: Array) -> float:
    """Move by a step in the metric of the mass; returns the angle about z."""
    twist, before = np.zeros(6), rotation.copy()
    for a in range(freedoms.shape[0]):
        twist[freedoms[a]] = step[a] * scale[a]
    turn(before, twist[0], twist[1], twist[2], rotation)
    position += twist[3:]
    return twist[2]


@njit(cache=True)
def _is_least(
    robot: Robot, spring: Array, rigid: Flags, taut: Flags, tensions: Array, miss: Array, grip: Array, hessian: Array,
    greatest: float,
) -> bool:  # fmt: skip
    """Whether tensions pull, no other inextensible cable is too short, and no motion left lowers the energy."""
    rounding = _rounding(robot)
    for i in range(tensions.shape[0]):
        if taut[i] and not tensions[i] > 0.0:
            return False
        if rigid[i] and spring[i] > 0.0 and not (taut[i] or miss[i] <= rounding[i]):
            return False
    across, sizes, _right = np.linalg.svd(grip, full_matrices=True)
    rank = int((sizes > RANK * sizes[0]).sum())
    if rank == grip.shape[0]:
        return True
    free = np.ascontiguousarray(across[:, rank:])
    values = np.linalg.eigvalsh(free.T @ hessian @ free)
    return bool(values[0] >= -NEUTRAL * greatest / robot[4].max() - 1e-13 * abs(values[-1]))
