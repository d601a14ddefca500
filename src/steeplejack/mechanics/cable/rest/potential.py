"""Compiled potential energy of a platform on locked winches, and the descent along it.

    E = sum_i max(0, s_i + k_i (l_i - L_i))^2 / (2 k_i) - sum_j F_j . (p + R c_j) - m phi

Cables of unstressed length ``L_i`` pull with ``t_i = max(0, s_i + k_i (l_i - L_i))`` and never push; forces ``F_j``
(the weight first) act at points ``c_j`` of the platform; a constant moment ``m`` exists in the plane only. An elastic
cable has ``k = EA / L`` and no shift ``s``. An inextensible one is the limit of the method of multipliers: any ``k``
serves, and the shift is raised to the tension until ``l = L`` (Bertsekas, Constrained Optimization, 1982, section 2);
where that is slow, near singular poses, ``k`` is raised too.

Descent: every step minimises the quadratic model within a ball whose metric is the platform's mass (translation of the
centre, rotation times a radius of gyration). That is a linearly implicit Euler step of the flow of a platform whose
every part is damped in proportion to its mass, so with short steps the path is the one of a heavily damped fall, stiff
cables or not, and near the end it is Newton's method. The energy never rises. The quadratic model is solved exactly by
eigenvalues, so negative curvature and saddles need no special cases; off an unstable rest it leaves along the least
eigenvector, its largest component positive.

Everything here is about the load's centre: the caller moves the platform's origin there.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.pose.misfit import turn
from steeplejack.mechanics.cable.pulleys import cable_run
from steeplejack.mechanics.cable.rest.curvature import add_cable, add_turn, arm_of
from steeplejack.mechanics.cable.rest.statics import add_wrench

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
Robot = tuple[Array, Array, Array, Array, Array]
Loads = tuple[Array, Array, float]

SETTLED, LOOSE, UNFINISHED, UNDEFINED = range(4)
STATE = 7
ENERGY, PHI, RESIDUAL, GREATEST, NOISE, LOAD, SIZE = range(STATE)  # of a descent, in one array
STEPS = 20_000
ROUNDS = 60
BALANCE = 1e-11  # [1] residual force over the greatest force of an equilibrium
NEUTRAL = 1e-9  # [1] stiffness over force / size below which a direction is neutral
NOTHING = 1e4  # [1] tension over the rounding of lengths up to which a platform without load has none
STIFF = 1e4  # [1] stiffness that stands for an inextensible cable, over load / size
PRETENSION = 1e-2  # [1] strain that stands for the load where there is none
STIFFEST = 1e3  # [1] how far that is raised where multipliers converge slowly; more would only add rounding


@njit(cache=True)
def evaluate(
    robot: Robot, loads: Loads, spring: Array, shift: Array, position: Array, rotation: Array, phi: float,
    gradient: Array, hessian: Array, tensions: Array,
) -> float:  # fmt: skip
    """Energy [J], its gradient (6,) and Hessian (6, 6) for a twist (omega; v) in world axes, and tensions (m,) [N].

    Args:
        robot: Anchors, axes, radii, attachments and unstressed lengths, as of `descend`.
        loads: Forces, points and moment, as of `descend`.
        spring: ``k`` (m,) [N/m].
        shift: ``s`` (m,) [N].
        position: Of the load's centre (3,) [m].
        rotation: (3, 3).
        phi: Angle turned about z, on which a constant moment works [rad].
        gradient: Written.
        hessian: Written.
        tensions: Written.

    Returns:
        The energy; not a number where a cable has no course.
    """
    anchors, axes, radii, attachments, unstressed = robot
    forces, points, moment = loads
    arm, point, along, across = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    bend, energy = np.empty((3, 3)), -moment * phi
    gradient[:], hessian[:] = 0.0, 0.0
    gradient[2] = -moment
    for i in range(anchors.shape[0]):
        tensions[i] = 0.0
        if spring[i] == 0.0:
            continue
        arm_of(rotation, attachments, i, arm)
        for a in range(3):
            point[a] = position[a] + arm[a]
        length, inside, outside = cable_run(anchors, axes, radii, i, point, along, across)
        tension = shift[i] + spring[i] * (length - unstressed[i])
        if math.isnan(tension):
            return np.nan
        if tension <= 0.0:
            continue
        tensions[i] = tension
        energy += 0.5 * tension * tension / spring[i]
        add_wrench(-tension, along, arm, gradient)
        add_cable(arm, along, across, inside, outside, tension, spring[i], bend, hessian)
    for j in range(forces.shape[0]):
        arm_of(rotation, points, j, arm)
        for a in range(3):
            energy -= forces[j, a] * (position[a] + arm[a])
        add_wrench(-1.0, forces[j], arm, gradient)
        add_turn(1.0, forces[j], arm, hessian)
    return energy


@njit(cache=True)
def bounded_step(values: Array, slopes: Array, radius: float, flat: float, still: float, step: Array) -> None:
    """Minimiser of ``slopes . p + p . diag(values) p / 2`` in the ball ``|p| <= radius``.

    Args:
        values: Eigenvalues, rising, (n,).
        slopes: Gradient along the eigenvectors, (n,).
        radius: Of the ball.
        flat: Size of an eigenvalue that counts as 0.
        still: Size of a slope that counts as 0; nothing moves along a flat direction without a slope.
        step: Gets the step along the eigenvectors, (n,).
    """
    n = values.shape[0]
    low = max(0.0, -values[0])
    size, norm = 0.0, 0.0
    for a in range(n):
        size += slopes[a] * slopes[a]
    high = low + math.sqrt(size) / radius
    damping = low
    for trial in range(60):
        if trial == 0:
            damping = low
        elif low == 0.0 and high > 0.0 and trial < 20:
            damping = 0.1 * high
        else:
            damping = 0.5 * (low + high)
        norm = 0.0
        for a in range(n):
            value = values[a] + damping
            if abs(slopes[a]) <= still and values[a] <= flat:
                step[a] = 0.0
            elif value > 0.0:
                step[a] = -slopes[a] / value
            else:
                step[a] = math.copysign(np.inf, -slopes[a])
            norm += step[a] * step[a]
        norm = math.sqrt(norm)
        if norm > radius:
            low = damping
        elif trial == 0 or norm > 0.9 * radius:
            break
        else:
            high = damping
    if norm > radius:
        for a in range(n):
            step[a] *= radius / norm
        norm = radius
    if values[0] < -flat and norm < 0.9 * radius:
        step[0] = math.copysign(math.sqrt(radius * radius - norm * norm + step[0] * step[0]), step[0])


@njit(cache=True)
def _spread(position: Array, rotation: Array, corners: Array, box: Array) -> None:
    """Widen the boxes (2, 2, 3) of the reference point, which is the first corner, and of the other corners."""
    for c in range(corners.shape[0]):
        which = 0 if c == 0 else 1
        for a in range(3):
            place = position[a]
            for b in range(3):
                place += rotation[a, b] * corners[c, b]
            box[which, 0, a] = min(box[which, 0, a], place)
            box[which, 1, a] = max(box[which, 1, a], place)


@njit(cache=True)
def descend(
    anchors: Array, axes: Array, radii: Array, attachments: Array, unstressed: Array, spring: Array, rigid: Flags,
    forces: Array, points: Array, moment: float, freedoms: Ints, gyration: float, stride: float, corners: Array,
    position: Array, rotation: Array, tensions: Array, hessian: Array, box: Array, path_positions: Array,
    path_rotations: Array,
) -> tuple[int, int, int, float, float]:  # fmt: skip
    """Follow the damped fall from a pose to rest.

    Args:
        anchors: (m, 3) [m].
        axes: Unit swivel axes (m, 3).
        radii: Of the pulleys (m,) [m].
        attachments: From the load's centre (m, 3) [m].
        unstressed: ``L`` (m,) [m].
        spring: ``k`` (m,) [N/m]; 0 takes a cable away.
        rigid: Which cables are inextensible, their ``k`` being any (m,).
        forces: (j, 3) [N].
        points: Where they act, from the load's centre (j, 3) [m].
        moment: About z, planar robots only [N m].
        freedoms: Which of (omega; v) move (n,).
        gyration: Radius that weighs rotation against translation [m].
        stride: Longest step [m].
        corners: Points whose sweep is asked for, the reference point first, from the load's centre (c, 3) [m].
        position: Of the load's centre, start, replaced by the end (3,) [m].
        rotation: Start, replaced by the end (3, 3).
        tensions: Gets (m,) [N].
        hessian: Gets the Hessian at the end, about the load's centre (6, 6).
        box: Gets least and greatest coordinates of the reference point and of the corners (2, 2, 3) [m].
        path_positions: Gets the places of the load's centre, as many as fit (k, 3) [m].
        path_rotations: Gets the rotations (k, 3, 3).

    Returns:
        How it ended, steps taken, poses written, the residual force [N] and the angle turned about z [rad].
    """
    robot = (anchors, axes, radii, attachments, unstressed)
    loads = (forces, points, moment)
    m, n = anchors.shape[0], freedoms.shape[0]
    shift, stiff, worst, change = np.zeros(m), spring.copy(), np.inf, 0.0
    gradient, scale, state, counts = np.empty(6), np.empty(n), np.zeros(STATE), np.zeros(2, np.int64)
    for a in range(n):
        scale[a] = 1.0 / gyration if freedoms[a] < 3 else 1.0
    _measure(forces, moment, gyration, spring, unstressed, state)
    box[:, 0], box[:, 1] = np.inf, -np.inf
    _record(position, rotation, corners, box, path_positions, path_rotations, counts)
    state[ENERGY] = evaluate(robot, loads, stiff, shift, position, rotation, 0.0, gradient, hessian, tensions)
    state[RESIDUAL] = np.nan
    status = LOOSE if state[SIZE] == 0.0 else UNFINISHED
    if not (math.isfinite(state[ENERGY]) and math.isfinite(gyration)):
        status = UNDEFINED
    for _round in range(ROUNDS if status == UNFINISHED else 0):
        status = _relax(
            robot, loads, stiff, shift, freedoms, scale, stride, corners, state, position, rotation, tensions,
            gradient, hessian, box, path_positions, path_rotations, counts,
        )  # fmt: skip
        if status != SETTLED:
            break
        change = _shift(rigid, spring, tensions, shift)
        if change <= BALANCE * state[GREATEST] + 10.0 * state[NOISE]:
            break
        status = UNFINISHED
        if change > 0.1 * worst:
            _stiffen(rigid, spring, stiff)
        worst = change
        state[ENERGY] = evaluate(
            robot, loads, stiff, shift, position, rotation, state[PHI], gradient, hessian, tensions
        )
    residual = 0.0 if status == LOOSE else state[RESIDUAL]
    return status, int(counts[0]), int(counts[1]), residual, state[PHI]


@njit(cache=True)
def _relax(
    robot: Robot, loads: Loads, stiff: Array, shift: Array, freedoms: Ints, scale: Array, stride: float,
    corners: Array, state: Array, position: Array, rotation: Array, tensions: Array, gradient: Array, hessian: Array,
    box: Array, path_positions: Array, path_rotations: Array, counts: Ints,
) -> int:  # fmt: skip
    """Steps within balls of trust until the residual is noise: SETTLED, LOOSE or UNFINISHED."""
    n = freedoms.shape[0]
    gradient_new, hessian_new, tensions_new = np.empty(6), np.empty((6, 6)), np.empty(tensions.shape[0])
    position_new, rotation_new, model = np.empty(3), np.empty((3, 3)), np.empty((n, n))
    slopes, step, twist, radius = np.empty(n), np.empty(n), np.zeros(6), stride
    while counts[0] < STEPS:
        counts[0] += 1
        _weigh(robot, stiff, tensions, state)
        if state[LOAD] == 0.0 and state[GREATEST] <= NOTHING * state[NOISE]:
            return LOOSE
        state[RESIDUAL] = math.sqrt(_reduce(gradient, hessian, freedoms, scale, model))
        values, vectors = np.linalg.eigh(model)
        flat = float(NEUTRAL * state[GREATEST] / state[SIZE] + 1e-13 * abs(values[n - 1]))
        still = BALANCE * state[GREATEST] + state[NOISE]
        if state[RESIDUAL] <= still and values[0] >= -flat:
            return SETTLED
        _along(vectors, gradient, freedoms, scale, slopes)
        bounded_step(values, slopes, radius, flat, still, step)
        foreseen, length = _foreseen(values, slopes, step)
        _move(vectors, step, freedoms, scale, twist, position, rotation, position_new, rotation_new)
        phi = state[PHI] + twist[2]
        trial = evaluate(
            robot, loads, stiff, shift, position_new, rotation_new, phi, gradient_new, hessian_new, tensions_new
        )
        gained = state[ENERGY] - trial
        # Where rounding hides the fall of the energy, the residual has to shrink instead.
        rounding = 1e-13 * (abs(state[ENERGY]) + state[GREATEST] * state[SIZE])
        if not math.isfinite(trial):  # a cable has lost its course: its end is inside the pulley
            accepted = False
        elif foreseen > rounding:
            accepted = gained > 1e-4 * foreseen
        else:
            accepted = _square(gradient_new, freedoms, scale) < state[RESIDUAL] ** 2
        if not accepted:
            radius = 0.25 * length
            if radius < 1e-15 * state[SIZE]:
                return SETTLED if state[RESIDUAL] <= 1e3 * still else UNFINISHED
            continue
        if foreseen > rounding and gained > 0.5 * foreseen:
            radius = min(stride, max(radius, 2.0 * length))
        elif foreseen > rounding and gained < 0.1 * foreseen:
            radius = max(0.5 * length, 1e-12 * state[SIZE])
        state[ENERGY], state[PHI] = trial, phi
        position[:], rotation[:], tensions[:] = position_new, rotation_new, tensions_new
        gradient[:], hessian[:] = gradient_new, hessian_new
        _record(position, rotation, corners, box, path_positions, path_rotations, counts)
    return UNFINISHED


@njit(cache=True)
def _measure(forces: Array, moment: float, gyration: float, spring: Array, unstressed: Array, state: Array) -> None:
    """Write the load, a moment taken over the radius of gyration, and the size, the longest cable that is there."""
    state[LOAD] = abs(moment) / gyration
    for j in range(forces.shape[0]):
        state[LOAD] += math.sqrt(forces[j, 0] ** 2 + forces[j, 1] ** 2 + forces[j, 2] ** 2)
    for i in range(spring.shape[0]):
        if spring[i] > 0.0:
            state[SIZE] = max(state[SIZE], unstressed[i])


@njit(cache=True)
def _weigh(robot: Robot, stiff: Array, tensions: Array, state: Array) -> None:
    """Write the greatest force, and what rounding of the lengths leaves of the residual."""
    state[GREATEST], state[NOISE] = state[LOAD], 0.0
    for i in range(tensions.shape[0]):
        if tensions[i] > 0.0:
            reach = max(abs(robot[0][i, 0]), abs(robot[0][i, 1]), abs(robot[0][i, 2]))
            state[GREATEST] = max(state[GREATEST], tensions[i])
            state[NOISE] += 1e-15 * stiff[i] * (robot[4][i] + reach)


@njit(cache=True)
def _reduce(gradient: Array, hessian: Array, freedoms: Ints, scale: Array, model: Array) -> float:
    """Write the Hessian in the metric of the mass, freedoms only; returns the square of the residual there."""
    for a in range(freedoms.shape[0]):
        for b in range(freedoms.shape[0]):
            model[a, b] = hessian[freedoms[a], freedoms[b]] * scale[a] * scale[b]
    return _square(gradient, freedoms, scale)


@njit(cache=True)
def _square(gradient: Array, freedoms: Ints, scale: Array) -> float:
    """Square of a gradient's size in the metric of the mass."""
    total = 0.0
    for a in range(freedoms.shape[0]):
        total += (gradient[freedoms[a]] * scale[a]) ** 2
    return total


@njit(cache=True)
def _along(vectors: Array, gradient: Array, freedoms: Ints, scale: Array, slopes: Array) -> None:
    """Turn each eigenvector so that its largest component is positive; write the slopes along them."""
    n = freedoms.shape[0]
    for b in range(n):
        largest = 0
        for a in range(n):
            if abs(vectors[a, b]) > abs(vectors[largest, b]):
                largest = a
        sign = -1.0 if vectors[largest, b] < 0.0 else 1.0
        slopes[b] = 0.0
        for a in range(n):
            vectors[a, b] *= sign
            slopes[b] += vectors[a, b] * gradient[freedoms[a]] * scale[a]


@njit(cache=True)
def _foreseen(values: Array, slopes: Array, step: Array) -> tuple[float, float]:
    """By how much the model falls along a step, and the step's length."""
    fall, square = 0.0, 0.0
    for b in range(step.shape[0]):
        fall -= step[b] * (slopes[b] + 0.5 * values[b] * step[b])
        square += step[b] * step[b]
    return fall, math.sqrt(square)


@njit(cache=True)
def _move(
    vectors: Array, step: Array, freedoms: Ints, scale: Array, twist: Array, position: Array, rotation: Array,
    position_new: Array, rotation_new: Array,
) -> None:  # fmt: skip
    """Write the twist (6,) of a step along the eigenvectors, and the pose it leads to."""
    n = freedoms.shape[0]
    for a in range(n):
        twist[freedoms[a]] = 0.0
        for b in range(n):
            twist[freedoms[a]] += vectors[a, b] * step[b] * scale[a]
    turn(rotation, twist[0], twist[1], twist[2], rotation_new)
    for a in range(3):
        position_new[a] = position[a] + twist[3 + a]


@njit(cache=True)
def _shift(rigid: Flags, spring: Array, tensions: Array, shift: Array) -> float:
    """Raise the multipliers of inextensible cables to their tensions; returns the largest change [N]."""
    change = 0.0
    for i in range(tensions.shape[0]):
        if rigid[i] and spring[i] > 0.0:
            change = max(change, abs(tensions[i] - shift[i]))
            shift[i] = tensions[i]
    return change


@njit(cache=True)
def _stiffen(rigid: Flags, spring: Array, stiff: Array) -> None:
    """Ten times the stiffness that stands for inextensible cables, up to `STIFFEST` times its first value."""
    for i in range(spring.shape[0]):
        if rigid[i]:
            stiff[i] = min(10.0 * stiff[i], STIFFEST * spring[i])


@njit(cache=True)
def _record(
    position: Array, rotation: Array, corners: Array, box: Array, path_positions: Array, path_rotations: Array,
    counts: Ints,
) -> None:  # fmt: skip
    """Keep a pose of the path while there is room, and widen the boxes of what it sweeps."""
    _spread(position, rotation, corners, box)
    k = counts[1]
    if k < path_positions.shape[0]:
        path_positions[k], path_rotations[k] = position, rotation
        counts[1] = k + 1
