"""Compiled Cholesky factors of the small symmetric matrices that Newton steps and projections are made of."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

TINY = 1e-300
"""Pivot that stands for one of zero, so that damping alone makes no pivot negative."""


@njit(cache=True, error_model="numpy")
def cholesky(matrix: Array, damping: float, factor: Array) -> float:
    """Factor ``matrix + damping I`` from its lower half; ``factor`` may be the matrix itself.

    Returns:
        The least pivot, less the damping, over its diagonal; above 0 where the factor exists.
    """
    n = matrix.shape[0]
    least = np.inf
    for a in range(n):
        for b in range(a + 1):
            total = matrix[a, b]
            if a == b:
                total += damping
            diagonal = total
            for c in range(b):
                total -= factor[a, c] * factor[b, c]
            if a == b:
                if not total > 0.0:
                    return 0.0
                least = min(least, max(total - damping, TINY) / diagonal)
                factor[a, a] = math.sqrt(total)
            else:
                factor[a, b] = total / factor[b, b]
    return least


@njit(cache=True, error_model="numpy")
def substitute(factor: Array, right: Array, out: Array) -> None:
    """Solve ``L L^T out = right``; ``out`` may be the right side itself."""
    n = right.shape[0]
    for a in range(n):
        total = right[a]
        for c in range(a):
            total -= factor[a, c] * out[c]
        out[a] = total / factor[a, a]
    for a in range(n - 1, -1, -1):
        total = out[a]
        for c in range(a + 1, n):
            total -= factor[c, a] * out[c]
        out[a] = total / factor[a, a]
