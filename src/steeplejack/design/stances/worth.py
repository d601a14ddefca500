"""What one stance is worth at one place of the platform: bases along their stays in, an objective out.

A base stands at ``s_i`` on its stay's axis (a polyline with tangents, evenly spaced nodes, straight between them), its
winch exit off the axis and turned towards the platform: a cable out of the plane of axis and exit twists the base
about its stay. The platform's orientation is given; `held` has the one of its own equilibrium.

Numbers of the machine come in two arrays. ``limits`` (m, 3): of each cable the least and the largest tension [N], and
what its base holds along the stay [N]. ``machine`` (4,): offset of an exit from the axis [m], what a base holds about
its stay [N m], the length that a moment in the plane is divided by [m], the least distance of two bases on a stay [m].
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.design.stances.inner import capacity, least_scale

Array = NDArray[np.float64]

POINT, BODY, SPACE = 0, 1, 2
"""Statics: forces in the plane at one point; forces and the moment in the plane; forces in space."""
SLIP, TENSION, CAPACITY = 0, 1, 2
"""Objectives: slip margin [1], largest tension (negative) [N], capacity margin [N]."""
NOTHING = -1e6
"""Worth below which no tensions in their window hold the platform, whatever the bases hold; more is nearer."""
LEAST_SHARE = 1e-9
"""Share of a pull along the stay [1] below which it never slips a base."""


@njit(cache=True, error_model="numpy")
def stand(axes: Array, tangents: Array, step: Array, s: Array, target: Array, offset: float, out: Array) -> None:
    """Winch exits, tangents and radial arms of bases at ``s``, turned towards a target.

    Args:
        axes: Nodes of each base's stay (m, k, 3) [m], the first at s = 0.
        tangents: Unit tangents there (m, k, 3).
        step: Distance of the nodes of each stay (m,) [m].
        s: Places of the bases (m,) [m].
        target: Where the exits point (3,) [m].
        offset: Of the exit from the axis [m].
        out: Filled with exit, tangent, arm (m, 3, 3).
    """
    last = axes.shape[1] - 2
    for i in range(axes.shape[0]):
        node = min(max(int(np.floor(s[i] / step[i])), 0), last)
        share = s[i] / step[i] - node
        along, size = 0.0, 0.0
        for k in range(3):
            out[i, 0, k] = axes[i, node, k] + share * (axes[i, node + 1, k] - axes[i, node, k])
            out[i, 1, k] = tangents[i, node, k] + share * (tangents[i, node + 1, k] - tangents[i, node, k])
            along += (target[k] - out[i, 0, k]) * out[i, 1, k]
        for k in range(3):
            out[i, 2, k] = target[k] - out[i, 0, k] - along * out[i, 1, k]
            size += out[i, 2, k] ** 2
        size = offset / np.sqrt(size) if size > 0.0 else 0.0
        for k in range(3):
            out[i, 2, k] *= size
            out[i, 0, k] += out[i, 2, k]


@njit(cache=True, error_model="numpy")
def bounds(
    statics: int, stood: Array, position: Array, arms: Array, limits: Array, machine: Array
) -> tuple[Array, Array, Array]:
    """Columns (m, 3), largest tensions (m,) [N] and tensions that take all a base holds along its stay (m,) [N].

    Args:
        statics: `POINT`, `BODY` or `SPACE`.
        stood: From :func:`stand`.
        position: Of the platform (3,) [m].
        arms: Attachments from there (m, 3) [m], turned with the platform.
        limits: See the module.
        machine: See the module.
    """
    m = stood.shape[0]
    columns, cap, scale = np.empty((m, 3)), np.empty(m), np.empty(m)
    for i in range(m):
        square, along = 0.0, 0.0
        for k in range(3):
            columns[i, k] = stood[i, 0, k] - position[k] - arms[i, k]
            square += columns[i, k] ** 2
        size = 1.0 / np.sqrt(square)
        for k in range(3):
            columns[i, k] *= size
            along += columns[i, k] * stood[i, 1, k]
        t, arm = stood[i, 1], stood[i, 2]
        turn = columns[i, 0] * (t[1] * arm[2] - t[2] * arm[1])
        turn += columns[i, 1] * (t[2] * arm[0] - t[0] * arm[2])
        turn = abs(turn + columns[i, 2] * (t[0] * arm[1] - t[1] * arm[0]))
        cap[i] = limits[i, 1] if turn * limits[i, 1] <= machine[1] else machine[1] / turn
        scale[i] = limits[i, 2] / max(abs(along), LEAST_SHARE)
        if statics == BODY:
            columns[i, 2] = (arms[i, 0] * columns[i, 1] - arms[i, 1] * columns[i, 0]) / machine[2]
    return columns, cap, scale


@njit(cache=True, error_model="numpy")
def worth(
    objective: int,
    statics: int,
    stood: Array,
    position: Array,
    arms: Array,
    loads: Array,
    limits: Array,
    machine: Array,
) -> float:
    """The objective at one stance, more is better; below `NOTHING` where nothing holds, and then more is nearer.

    A slip margin below 0 says that the pull along a stay is beyond what its base holds.

    Args:
        objective: `SLIP`, `TENSION` or `CAPACITY`.
        statics: See :func:`bounds`.
        stood: See :func:`bounds`.
        position: See :func:`bounds`.
        arms: See :func:`bounds`.
        loads: Vertices of the wrench set (v, 3) [N], moments in the plane over the machine's length.
        limits: See the module.
        machine: See the module.
    """
    columns, cap, scale = bounds(statics, stood, position, arms, limits, machine)
    flat = statics == POINT
    lower = limits[:, 0]
    if objective == SLIP:
        t = least_scale(columns, flat, loads, lower, cap, scale)
        if t < np.inf:
            return 1.0 - t
    else:
        for i in range(len(cap)):
            cap[i] = min(cap[i], scale[i])
        if objective == CAPACITY:
            return capacity(columns, flat, loads, lower, cap)
        t = least_scale(columns, flat, loads, lower, cap, np.ones(len(cap)))
        if t < np.inf:
            return -t
    return NOTHING + min(max(capacity(columns, flat, loads, lower, cap), NOTHING), 0.0)


@njit(cache=True, error_model="numpy", nogil=True)
def worths(
    objective: int,
    statics: int,
    axes: Array,
    tangents: Array,
    step: Array,
    positions: Array,
    arms: Array,
    loads: Array,
    limits: Array,
    machine: Array,
    stances: Array,
    admitted: NDArray[np.bool_],
) -> Array:
    """Worth (n, c) of c stances (n, c, m) [m] at each of n places, ``-inf`` where they are not admitted (n, c).

    Positions (n, 3), arms (n, m, 3) and limits (n, m, 3) are each place's own, the rest as in :func:`worth` and
    :func:`stand`.
    """
    out = np.full(admitted.shape, -np.inf)
    stood = np.empty((axes.shape[0], 3, 3))
    for j in range(stances.shape[0]):
        for c in range(stances.shape[1]):
            if admitted[j, c]:
                stand(axes, tangents, step, stances[j, c], positions[j], machine[0], stood)
                out[j, c] = worth(objective, statics, stood, positions[j], arms[j], loads, limits[j], machine)
    return out
