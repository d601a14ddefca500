"""Compiled search for witnesses at one pose: tensions that balance a load, or what is missing of the balance.

A regularised least-squares problem with bounds, solved by Newton steps on its dual. Nothing of how a witness is found
enters a proof.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.cholesky import cholesky, substitute

Array = NDArray[np.float64]

SOFT = 1e-7
"""Weight of the dual variables' square in the search for witnesses, over that of the tensions' [1]."""

LEAST_PIVOT = 1e-15
"""Pivot over its diagonal at which a matrix of witnesses counts as singular [1]."""


@njit(cache=True, error_model="numpy")
def balance(columns: Array, load: Array, window: Array, closure: bool, tight: float, tensions: Array, z: Array) -> bool:
    """Tensions at the middle that balance the load within a window made narrower by ``tight``, and the dual.

    Minimises ``|C f + w|^2 / (2 SOFT) + |(f - middle) / half|^2 / 2`` over the window by Newton steps on the dual:
    ``f = clip(middle + half^2 C^T y)``. Where the balance fails, ``z = -y`` of unit length points at what is missing.
    Wrench closure asks for ``sum f = 1`` in a seventh row instead of a wrench.
    """
    m, n = columns.shape[0], 7 if closure else 6
    c, start, low, high = np.empty((m, n)), np.zeros(n), np.empty(m), np.empty(m)
    middle, half = np.empty(m), np.empty(m)
    for i in range(m):
        half[i] = 1.0 / m if closure else 0.5 * (window[1, i] - window[0, i])
        middle[i] = half[i] if closure else 0.5 * (window[1, i] + window[0, i])
        low[i], high[i] = tight - 1.0, (np.inf if closure else 1.0 - tight)
    _rows(columns, load, middle, half, closure, c, start)
    y, work = np.zeros(n), np.zeros(m)
    _newton(c, start, low, high, y, work)
    left, long = 0.0, 0.0
    for r in range(n):
        missing = start[r]
        for i in range(m):
            missing += c[i, r] * min(max(work[i], low[i]), high[i])
        left = max(left, abs(missing))
    for i in range(m):
        tensions[i] = middle[i] + half[i] * min(max(work[i], low[i]), high[i])
    for r in range(6):
        long += y[r] * y[r]
    for r in range(6):
        z[r] = -y[r] / math.sqrt(long) if long > 0.0 else 0.0
    return left <= 1e2 * SOFT


@njit(cache=True, error_model="numpy")
def _rows(columns: Array, load: Array, middle: Array, half: Array, closure: bool, c: Array, start: Array) -> None:
    """Write columns over half windows (m, n), and what the middles of the windows leave (n,); widest half window 1."""
    widest = half.max()
    for i in range(half.size):
        for r in range(6):
            c[i, r] = columns[i, r, 0] * half[i] / widest
            start[r] += columns[i, r, 0] * middle[i] / widest
        if closure:
            c[i, 6] = half[i] / widest
            start[6] += middle[i] / widest
    for r in range(6):
        start[r] += load[r, 0] / widest
    if closure:
        start[6] -= 1.0 / widest


@njit(cache=True, error_model="numpy")
def _newton(c: Array, start: Array, low: Array, high: Array, y: Array, work: Array) -> None:
    """Dual variables (n,), from zero, and ``work = c y`` (m,), whose clipped values are the tensions."""
    m, n = c.shape
    step, along, gradient, hessian = np.empty(n), np.empty(m), np.empty(n), np.empty((n, n))
    size = max(1.0, np.abs(start).max())
    for _ in range(40):
        for r in range(n):
            gradient[r] = start[r] + SOFT * y[r]
            for s in range(n):
                hessian[r, s] = SOFT if r == s else 0.0
        for i in range(m):
            value = min(max(work[i], low[i]), high[i])
            free = low[i] <= work[i] <= high[i]
            for r in range(n):
                gradient[r] += c[i, r] * value
                if free:
                    for s in range(r + 1):
                        hessian[r, s] += c[i, r] * c[i, s]
        if np.abs(gradient).max() <= 1e-13 * size or not cholesky(hessian, 0.0, hessian) > LEAST_PIVOT:
            return
        substitute(hessian, -gradient, step)
        for i in range(m):
            along[i] = 0.0
            for r in range(n):
                along[i] += c[i, r] * step[r]
        share = _line(y, work, step, along, start, low, high, c)
        for r in range(n):
            y[r] += share * step[r]
        for i in range(m):
            work[i] += share * along[i]


@njit(cache=True, error_model="numpy")
def _line(y: Array, work: Array, step: Array, along: Array, start: Array, low: Array, high: Array, c: Array) -> float:
    """Where along a Newton step the slope of the dual objective vanishes, by bisection of its monotone slope."""
    constant = linear = 0.0
    for r in range(y.size):
        constant += step[r] * (start[r] + SOFT * y[r])
        linear += SOFT * step[r] * step[r]
    a, b, t = 0.0, 1.0, 1.0
    for _ in range(48):
        slope = constant + linear * t
        for i in range(work.size):
            slope += along[i] * min(max(work[i] + t * along[i], low[i]), high[i])
        if slope <= 0.0:
            a = t
        else:
            b = t
        if a == 1.0:
            return 1.0
        t = 0.5 * (a + b)
    return t
