"""Compiled Gauss-Newton for the pose that explains cable lengths; `tracking` and `forward` are its public faces.

Minimises ``sum_i (l_i(x) - l_o,i)^2`` by damped Gauss-Newton (Levenberg-Marquardt) with the analytic derivative
``dl/dx = -J``, over the freedoms of a rigid body in space: all six, or (x, y, phi) of a robot in the plane z = 0. One
compilation serves both. Rotations move along the manifold; lengths of straight cables and over pulleys come from
`pulleys.cable_run`.

Moments are divided by the reach of the attachments, so that rotations and translations compare and nothing depends on
units.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.cholesky import cholesky, substitute
from steeplejack.mechanics.cable.pulleys import cable_run

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Robot = tuple[Array, Array, Array, Array]  # anchors, swivel axes, radii, attachments
State = tuple[Array, Array, Array, Array]  # position, rotation, slopes (m, 6) and errors (m,) there
Normal = tuple[Array, Array, Array, Array, Array]  # gram and its factor (n, n), right side and move (n,), twist (6,)
Course = tuple[Array, Array, Array]  # point, along, across, see `cable_run`

CONVERGED, SINGULAR, UNFINISHED, UNDEFINED = range(4)
ITERATIONS = 100
STEP = 1e-11  # [1] distance still to go over the longest cable, foreseen from the last two steps, that ends the search
DAMPING = 1e-6  # [1] at the start, against unit cable directions
CLEAR = 1e-3  # [1] damped pivot over its diagonal above which the rank need not be looked at again
RANK = 1e-13  # [1] squared sine of the least angle between a freedom and the span of the others that counts as 0


@njit(cache=True, error_model="numpy")
def turn(rotation: Array, x: float, y: float, z: float, out: Array) -> None:
    """Write ``exp([x y z]) rotation`` (3, 3), a rotation vector in world axes [rad], kept orthogonal to rounding."""
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    if angle < 1e-4:
        a, b = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        a, b = math.sin(angle) / angle, (1.0 - math.cos(angle)) / square
    for j in range(3):
        p, q, r = rotation[0, j], rotation[1, j], rotation[2, j]
        u, v, w = y * r - z * q, z * p - x * r, x * q - y * p
        p, q, r = (
            p + a * u + b * (y * w - z * v),
            q + a * v + b * (z * u - x * w),
            r + a * w + b * (x * v - y * u),
        )
        out[0, j], out[1, j], out[2, j] = p, q, r
    # The first column normalised, the second made perpendicular, the third their product.
    size = 1.0 / math.sqrt(out[0, 0] ** 2 + out[1, 0] ** 2 + out[2, 0] ** 2)
    for i in range(3):
        out[i, 0] *= size
    dot = out[0, 0] * out[0, 1] + out[1, 0] * out[1, 1] + out[2, 0] * out[2, 1]
    for i in range(3):
        out[i, 1] -= dot * out[i, 0]
    size = 1.0 / math.sqrt(out[0, 1] ** 2 + out[1, 1] ** 2 + out[2, 1] ** 2)
    for i in range(3):
        out[i, 1] *= size
    out[0, 2] = out[1, 0] * out[2, 1] - out[2, 0] * out[1, 1]
    out[1, 2] = out[2, 0] * out[0, 1] - out[0, 0] * out[2, 1]
    out[2, 2] = out[0, 0] * out[1, 1] - out[1, 0] * out[0, 1]


@njit(cache=True, error_model="numpy")
def _misfit(
    lengths: Array,
    anchors: Array,
    axes: Array,
    radii: Array,
    attachments: Array,
    position: Array,
    rotation: Array,
    reach: float,
    slope: Array,
    errors: Array,
    point: Array,
    along: Array,
    across: Array,
) -> float:
    """Sum of squared errors [m2]; writes errors (m,) and slopes ``dl/d(omega reach; v)`` (m, 6)."""
    total, shrink = 0.0, 1.0 / reach
    for i in range(anchors.shape[0]):
        bx, by, bz = attachments[i, 0], attachments[i, 1], attachments[i, 2]
        rx = rotation[0, 0] * bx + rotation[0, 1] * by + rotation[0, 2] * bz
        ry = rotation[1, 0] * bx + rotation[1, 1] * by + rotation[1, 2] * bz
        rz = rotation[2, 0] * bx + rotation[2, 1] * by + rotation[2, 2] * bz
        x, y, z = position[0] + rx, position[1] + ry, position[2] + rz
        if radii[i] == 0.0:  # a straight cable; the call below would cost as much again
            x, y, z = anchors[i, 0] - x, anchors[i, 1] - y, anchors[i, 2] - z
            length = math.sqrt(x * x + y * y + z * z)
            inverse = 1.0 / length if length > 0.0 else 0.0
            x, y, z = x * inverse, y * inverse, z * inverse
        else:
            point[0], point[1], point[2] = x, y, z
            length, _c, _s = cable_run(anchors, axes, radii, i, point, along, across)
            x, y, z = along[0], along[1], along[2]
        errors[i] = length - lengths[i]
        total += errors[i] * errors[i]
        slope[i, 0] = (rz * y - ry * z) * shrink
        slope[i, 1] = (rx * z - rz * x) * shrink
        slope[i, 2] = (ry * x - rx * y) * shrink
        slope[i, 3], slope[i, 4], slope[i, 5] = -x, -y, -z
    return total


@njit(cache=True, error_model="numpy")
def _normal(slope: Array, errors: Array, freedoms: Ints, row: Array, gram: Array, right: Array) -> None:
    """Lower half of ``J J^T`` (n, n) and ``-J e`` (n,) of the freedoms."""
    n = freedoms.shape[0]
    for a in range(n):
        right[a] = 0.0
        for b in range(a + 1):
            gram[a, b] = 0.0
    for i in range(errors.shape[0]):
        for a in range(n):
            row[a] = slope[i, freedoms[a]]
        for a in range(n):
            right[a] -= row[a] * errors[i]
            for b in range(a + 1):
                gram[a, b] += row[a] * row[b]


@njit(cache=True, error_model="numpy")
def track_each(
    lengths: Array,
    anchors: Array,
    axes: Array,
    radii: Array,
    attachments: Array,
    freedoms: Ints,
    follow: bool,
    positions: Array,
    rotations: Array,
    residuals: Array,
    steps: Ints,
    status: Ints,
) -> None:
    """The nearest minimum of the misfit for every set of lengths.

    Args:
        lengths: Measured, (k, m) [m].
        anchors: (m, 3) [m].
        axes: Unit swivel axes, (m, 3).
        radii: Of the pulleys, (m,) [m].
        attachments: (m, 3) [m].
        freedoms: Which of (omega; v) move, (n,).
        follow: Start each from the answer before it, the first from its own start.
        positions: Starts, replaced by answers, (k, 3) [m].
        rotations: Starts, replaced by answers, (k, 3, 3).
        residuals: Gets ``|l(x) - l_o|``, (k,) [m].
        steps: Gets iterations, (k,).
        status: Gets ``CONVERGED``, ``SINGULAR``, ``UNFINISHED`` or ``UNDEFINED``, (k,).
    """
    m, n = anchors.shape[0], freedoms.shape[0]
    robot = (anchors, axes, radii, attachments)
    here = (np.empty(3), np.empty((3, 3)), np.empty((m, 6)), np.empty(m))
    there = (np.empty(3), np.empty((3, 3)), np.empty((m, 6)), np.empty(m))
    normal = (np.empty((n, n)), np.empty((n, n)), np.empty(n), np.empty(n), np.zeros(6))
    course = (np.empty(3), np.empty(3), np.empty(3))
    reach = 0.0
    for i in range(m):
        reach = max(reach, math.sqrt(attachments[i, 0] ** 2 + attachments[i, 1] ** 2 + attachments[i, 2] ** 2))
    last = 0
    for k in range(lengths.shape[0]):
        begin, size = last if follow else k, 0.0
        for i in range(m):
            size = max(size, abs(lengths[k, i]))
        _copy(positions[begin], rotations[begin], here[0], here[1])
        lever = reach if reach > 0.0 else size
        cost, steps[k], status[k] = _descend(
            lengths[k], size, lever, robot, freedoms, here, there, normal, course, positions[k], rotations[k]
        )
        residuals[k] = math.sqrt(cost) if status[k] != UNDEFINED else np.nan
        if status[k] != UNDEFINED:
            last = k


@njit(cache=True, error_model="numpy")
def _descend(
    lengths: Array,
    size: float,
    lever: float,
    robot: Robot,
    freedoms: Ints,
    here: State,
    there: State,
    normal: Normal,
    course: Course,
    position: Array,
    rotation: Array,
) -> tuple[float, int, int]:
    """Levenberg-Marquardt from the pose ``here`` to the nearest minimum, written to ``position`` and ``rotation``.

    Returns:
        Sum of squared errors [m2], steps and status; ``there``, ``normal`` and ``course`` are space.
    """
    place, turned, slope, errors = here
    place_new, turned_new, slope_new, errors_new = there
    gram, factor, right, move, twist = normal
    cost = _misfit(lengths, *robot, place, turned, lever, slope, errors, *course)
    if not (math.isfinite(cost) and size > 0.0):
        _copy(place, turned, position, rotation)
        return cost, 0, UNDEFINED
    status, steps, damping, before = UNFINISHED, 0, DAMPING, 0.0
    _normal(slope, errors, freedoms, move, gram, right)
    while steps < ITERATIONS:
        steps += 1
        pivot = cholesky(gram, damping, factor)
        while not pivot > 0.0:
            damping = max(10.0 * damping, 1e-12)
            pivot = cholesky(gram, damping, factor)
        substitute(factor, right, move)
        length = _moved(place, turned, move, freedoms, lever, twist, place_new, turned_new)
        trial = _misfit(lengths, *robot, place_new, turned_new, lever, slope_new, errors_new, *course)
        better = trial <= cost
        if better:
            cost = trial
            place, place_new = place_new, place
            turned, turned_new = turned_new, turned
            slope, slope_new = slope_new, slope
            errors, errors_new = errors_new, errors
            damping = max(0.01 * damping, 1e-14)
        else:
            damping = max(min(10.0 * damping, 1e9), 1e-4)
        if length <= STEP * size or length * length <= STEP * size * before:
            if pivot <= CLEAR:
                _normal(slope, errors, freedoms, move, gram, right)
                pivot = cholesky(gram, 0.0, factor)
            status = CONVERGED if pivot > RANK else SINGULAR
            break
        before = 0.0
        if better:
            before = length
            _normal(slope, errors, freedoms, move, gram, right)
    _copy(place, turned, position, rotation)
    return cost, steps, status


@njit(cache=True, error_model="numpy")
def _moved(
    place: Array,
    rotation: Array,
    move: Array,
    freedoms: Ints,
    lever: float,
    twist: Array,
    place_new: Array,
    rotation_new: Array,
) -> float:
    """Write the pose after a step ``(lever omega; v)`` of the freedoms; the step's length [m]."""
    square = 0.0
    for a in range(freedoms.shape[0]):
        twist[freedoms[a]] = move[a]
        square += move[a] * move[a]
    turn(rotation, twist[0] / lever, twist[1] / lever, twist[2] / lever, rotation_new)
    for j in range(3):
        place_new[j] = place[j] + twist[3 + j]
    return math.sqrt(square)


@njit(cache=True)
def _copy(position: Array, rotation: Array, position_out: Array, rotation_out: Array) -> None:
    """Write a pose; loops, because assigning slices costs as much as a cable."""
    for a in range(3):
        position_out[a] = position[a]
        for b in range(3):
            rotation_out[a, b] = rotation[a, b]
