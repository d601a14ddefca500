"""Distances between straight cables, a platform's centre and the stays around them; all other gaps come from here.

Exact to rounding for crossing, touching, overlapping, parallel and zero-length segments; where two directions differ by
less than 1e-7 rad but are not parallel, to that angle times the length.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True)
def segment_distance(a: Array, b: Array, c: Array, d: Array) -> float:
    """Least distance [m] between the segments a-b and c-d (3,), parallel and zero-length ones included.

    The unconstrained closest points of the two lines, clamped in turn (Ericson, Real-Time Collision Detection, 5.1.9).
    """
    u0, u1, u2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    v0, v1, v2 = d[0] - c[0], d[1] - c[1], d[2] - c[2]
    w0, w1, w2 = a[0] - c[0], a[1] - c[1], a[2] - c[2]
    uu = u0 * u0 + u1 * u1 + u2 * u2
    vv = v0 * v0 + v1 * v1 + v2 * v2
    uv = u0 * v0 + u1 * v1 + u2 * v2
    uw = u0 * w0 + u1 * w1 + u2 * w2
    vw = v0 * w0 + v1 * w1 + v2 * w2
    determinant = uu * vv - uv * uv
    s = 0.0
    if determinant > 1e-14 * uu * vv:
        s = min(max((uv * vw - vv * uw) / determinant, 0.0), 1.0)
    t = (uv * s + vw) / vv if vv > 0.0 else 0.0
    if t < 0.0 or t > 1.0 or vv == 0.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((uv * t - uw) / uu, 0.0), 1.0) if uu > 0.0 else 0.0
    x = w0 + s * u0 - t * v0
    y = w1 + s * u1 - t * v1
    z = w2 + s * u2 - t * v2
    return np.sqrt(x * x + y * y + z * z)


@njit(cache=True)
def polyline_distance(a: Array, b: Array, nodes: Array) -> float:
    """Least distance [m] from the segment a-b to a polyline (n, 3)."""
    least = np.inf
    for j in range(nodes.shape[0] - 1):
        distance = segment_distance(a, b, nodes[j], nodes[j + 1])
        if distance < least:
            least = distance
    return least


@njit(cache=True)
def nearest_stay(
    anchors: Array, ends: Array, stays: Array, radii: Array, own: NDArray[np.int64], enough: float
) -> tuple[float, int, int]:
    """Least gap of cables to the surfaces of stays [m], and which cable and stay; negative inside a stay.

    Args:
        anchors: Winch exits (m, 3) [m].
        ends: Attachments in the world (m, 3) [m].
        stays: Axes of the stays as polylines (k, n, 3) [m].
        radii: Radii of the stays (k,) [m].
        own: The stay that each cable's base sits on (m,); that cable is not checked against it.
        enough: Gap below which the search stops [m].

    Returns:
        Gap, cable and stay; infinite, -1 and -1 where there is none to meet.
    """
    least, cable, stay = np.inf, -1, -1
    for i in range(anchors.shape[0]):
        for k in range(stays.shape[0]):
            if own[i] != k:
                gap = polyline_distance(anchors[i], ends[i], stays[k]) - radii[k]
                if gap < least:
                    least, cable, stay = gap, i, k
                    if least < enough:
                        return least, cable, stay
    return least, cable, stay


@njit(cache=True)
def cable_gap(anchors: Array, ends: Array, stays: Array, radii: Array, own: NDArray[np.int64]) -> tuple[float, float]:
    """Least gap of the cables and of the platform's centre to the surfaces of the stays [m].

    Args:
        anchors: Winch exits (m, 3) [m].
        ends: Attachments in the world (m, 3) [m].
        stays: Axes of the stays as polylines (k, n, 3) [m].
        radii: Radii of the stays (k,) [m].
        own: The stay that each cable's base sits on (m,); that cable is not checked against it.

    Returns:
        Least gap over cables and stays, and least gap of the platform's centre (mean of the attachments).
    """
    body, centre = np.inf, np.zeros(3)
    for i in range(ends.shape[0]):
        centre += ends[i] / ends.shape[0]
    for k in range(stays.shape[0]):
        body = min(body, polyline_distance(centre, centre, stays[k]) - radii[k])
    return nearest_stay(anchors, ends, stays, radii, own, -np.inf)[0], body
