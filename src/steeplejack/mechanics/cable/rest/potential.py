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

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

SETTLED, LOOSE, UNFINISHED, UNDEFINED = range(4)
STEPS = 20_000
ROUNDS = 60
BALANCE = 1e-11  # [1] residual force over the greatest force of an equilibrium
NEUTRAL = 1e-9  # [1] stiffness over force / size below which a direction is neutral
STIFF = 1e4  # [1] stiffness that stands for an inextensible cable, over load / size
PRETENSION = 1e-2  # [1] strain that stands for the load where there is none
STIFFEST = 1e3  # [1] how far that is raised where multipliers converge slowly; more would only add rounding


@njit(cache=True)
def evaluate(
    anchors: Array,
    axes: Array,
    radii: Array,
    attachments: Array,
    unstressed: Array,
    spring: Array,
    shift: Array,
    forces: Array,
    points: Array,
    moment: float,
    position: Array,
    rotation: Array,
    phi: float,
    gradient: Array,
    hessian: Array,
    tensions: Array,
) -> float:
    """Energy [J], its gradient (6,) and Hessian (6, 6) for a twist (omega; v) in world axes, and tensions (m,) [N]."""
    m = anchors.shape[0]
    arm, point, along, across = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    force, bend, lever = np.empty(3), np.empty((3, 3)), np.zeros((3, 6))
    lever[0, 3] = lever[1, 4] = lever[2, 5] = 1.0
    energy = -moment * phi
    for a in range(6):
        gradient[a] = 0.0
        for b in range(6):
            hessian[a, b] = 0.0
    gradient[2] = -moment
    for i in range(m + forces.shape[0]):
        cable = i < m
        for a in range(3):
            arm[a] = 0.0
            for b in range(3):
                arm[a] += rotation[a, b] * (attachments[i, b] if cable else points[i - m, b])
            point[a] = position[a] + arm[a]
        if cable:
            tensions[i] = 0.0
            if spring[i] == 0.0:
                continue
            length, bent, swung = cable_run(anchors, axes, radii, i, point, along, across)
            tension = shift[i] + spring[i] * (length - unstressed[i])
            if math.isnan(tension):
                return np.nan
            if tension <= 0.0:
                continue
            tensions[i] = tension
            energy += 0.5 * tension * tension / spring[i]
            for a in range(3):
                force[a] = tension * along[a]
                for b in range(3):
                    bend[a, b] = (spring[i] - tension * bent) * along[a] * along[b]
                    bend[a, b] += tension * (swung - bent) * across[a] * across[b]
                bend[a, a] += tension * bent
            lever[0, 1], lever[0, 2] = arm[2], -arm[1]
            lever[1, 0], lever[1, 2] = -arm[2], arm[0]
            lever[2, 0], lever[2, 1] = arm[1], -arm[0]
            for a in range(6):
                for c in range(3):
                    half = 0.0
                    for d in range(3):
                        half += lever[d, a] * bend[d, c]
                    if half != 0.0:
                        for b in range(a + 1):
                            hessian[a, b] += half * lever[c, b]
        else:
            for a in range(3):
                force[a] = forces[i - m, a]
                energy -= force[a] * point[a]
        gradient[0] -= arm[1] * force[2] - arm[2] * force[1]
        gradient[1] -= arm[2] * force[0] - arm[0] * force[2]
        gradient[2] -= arm[0] * force[1] - arm[1] * force[0]
        dot = 0.0
        for a in range(3):
            gradient[3 + a] -= force[a]
            dot += force[a] * arm[a]
        for a in range(3):
            hessian[a, a] += dot
            for b in range(a + 1):
                hessian[a, b] -= 0.5 * (force[a] * arm[b] + arm[a] * force[b])
    for a in range(6):
        for b in range(a):
            hessian[b, a] = hessian[a, b]
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
    stride: float,
    corners: Array,
    position: Array,
    rotation: Array,
    tensions: Array,
    hessian: Array,
    box: Array,
    path_positions: Array,
    path_rotations: Array,
) -> tuple[int, int, int, float, float]:
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
    m, n = anchors.shape[0], freedoms.shape[0]
    shift, stiff, phi, worst = np.zeros(m), spring.copy(), 0.0, np.inf
    gradient, gradient_new, hessian_new = np.empty(6), np.empty(6), np.empty((6, 6))
    tensions_new, position_new, rotation_new = np.empty(m), np.empty(3), np.empty((3, 3))
    model, slopes, step, twist, scale = np.empty((n, n)), np.empty(n), np.empty(n), np.zeros(6), np.empty(n)
    load, size = abs(moment) / gyration, 0.0
    for j in range(forces.shape[0]):
        load += math.sqrt(forces[j, 0] ** 2 + forces[j, 1] ** 2 + forces[j, 2] ** 2)
    for i in range(m):
        if spring[i] > 0.0:
            size = max(size, unstressed[i])
    for a in range(n):
        scale[a] = 1.0 / gyration if freedoms[a] < 3 else 1.0
    box[:, 0], box[:, 1] = np.inf, -np.inf
    _spread(position, rotation, corners, box)
    count, steps, residual, noise, greatest = 0, 0, np.nan, 0.0, load
    if path_positions.shape[0] > 0:
        path_positions[0], path_rotations[0] = position, rotation
        count = 1
    energy = evaluate(
        anchors,
        axes,
        radii,
        attachments,
        unstressed,
        stiff,
        shift,
        forces,
        points,
        moment,
        position,
        rotation,
        phi,
        gradient,
        hessian,
        tensions,
    )
    if not (math.isfinite(energy) and math.isfinite(gyration)):
        return UNDEFINED, steps, count, residual, phi
    if size == 0.0:
        return LOOSE, steps, count, 0.0, phi
    for _round in range(ROUNDS):
        radius, settled = stride, False
        while steps < STEPS:
            steps += 1
            greatest, noise = load, 0.0
            for i in range(m):
                greatest = max(greatest, tensions[i])
                if tensions[i] > 0.0:
                    noise += 1e-15 * stiff[i] * (unstressed[i] + np.max(np.abs(anchors[i])))
            if greatest == 0.0:
                return LOOSE, steps, count, 0.0, phi
            residual = 0.0
            for a in range(n):
                residual += (gradient[freedoms[a]] * scale[a]) ** 2
                for b in range(n):
                    model[a, b] = hessian[freedoms[a], freedoms[b]] * scale[a] * scale[b]
            residual = math.sqrt(residual)
            values, vectors = np.linalg.eigh(model)
            flat = float(NEUTRAL * greatest / size + 1e-13 * abs(values[n - 1]))
            still = BALANCE * greatest + noise
            if residual <= still and values[0] >= -flat:
                settled = True
                break
            for b in range(n):
                slopes[b] = 0.0
                largest = 0
                for a in range(n):
                    slopes[b] += vectors[a, b] * gradient[freedoms[a]] * scale[a]
                    if abs(vectors[a, b]) > abs(vectors[largest, b]):
                        largest = a
                if vectors[largest, b] < 0.0:
                    slopes[b] = -slopes[b]
                    for a in range(n):
                        vectors[a, b] = -vectors[a, b]
            bounded_step(values, slopes, radius, flat, still, step)
            foreseen, length = 0.0, 0.0
            for b in range(n):
                foreseen -= step[b] * (slopes[b] + 0.5 * values[b] * step[b])
                length += step[b] * step[b]
            length = math.sqrt(length)
            for a in range(n):
                twist[freedoms[a]] = 0.0
                for b in range(n):
                    twist[freedoms[a]] += vectors[a, b] * step[b] * scale[a]
            turn(rotation, twist[0], twist[1], twist[2], rotation_new)
            for a in range(3):
                position_new[a] = position[a] + twist[3 + a]
            trial = evaluate(
                anchors,
                axes,
                radii,
                attachments,
                unstressed,
                stiff,
                shift,
                forces,
                points,
                moment,
                position_new,
                rotation_new,
                phi + twist[2],
                gradient_new,
                hessian_new,
                tensions_new,
            )
            left = 0.0
            for a in range(n):
                left += (gradient_new[freedoms[a]] * scale[a]) ** 2
            # Where rounding hides the fall of the energy, the residual has to shrink instead.
            rounding = 1e-13 * (abs(energy) + greatest * size)
            gained = energy - trial
            accepted = gained > 1e-4 * foreseen if foreseen > rounding else left < residual * residual
            if accepted:
                if foreseen > rounding and gained > 0.5 * foreseen:
                    radius = min(stride, max(radius, 2.0 * length))
                elif foreseen > rounding and gained < 0.1 * foreseen:
                    radius = max(0.5 * length, 1e-12 * size)
                energy, phi = trial, phi + twist[2]
                position[:], rotation[:], tensions[:] = position_new, rotation_new, tensions_new
                gradient[:], hessian[:] = gradient_new, hessian_new
                _spread(position, rotation, corners, box)
                if count < path_positions.shape[0]:
                    path_positions[count], path_rotations[count] = position, rotation
                    count += 1
            else:
                radius = 0.25 * length
                if radius < 1e-15 * size:
                    settled = residual <= 1e3 * still
                    break
        if not settled:
            return UNFINISHED, steps, count, residual, phi
        change = 0.0
        for i in range(m):
            if rigid[i] and spring[i] > 0.0:
                change = max(change, abs(tensions[i] - shift[i]))
                shift[i] = tensions[i]
        if change <= BALANCE * greatest + 10.0 * noise:
            return SETTLED, steps, count, residual, phi
        if change > 0.1 * worst:
            for i in range(m):
                if rigid[i]:
                    stiff[i] = min(10.0 * stiff[i], STIFFEST * spring[i])
        worst = change
        energy = evaluate(
            anchors,
            axes,
            radii,
            attachments,
            unstressed,
            stiff,
            shift,
            forces,
            points,
            moment,
            position,
            rotation,
            phi,
            gradient,
            hessian,
            tensions,
        )
    return UNFINISHED, steps, count, residual, phi
