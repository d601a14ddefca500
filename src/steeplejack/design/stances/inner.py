"""The inner problem of a stance: the tensions that hold a load best, in closed form.

For cables of unit pull ``u_i`` (columns of the structure matrix's transpose) and a load w, tensions obey
``sum_i f_i u_i + w = 0`` and ``lower <= f <= cap``. Three objectives, each a linear program in the tensions:

- slip margin ``max_f min_i (1 - f_i c_i / L_i)`` with ``c_i = |u_i . tangent_i|`` the share of the pull along the stay
  and ``L_i`` what base i holds along it;
- largest tension ``min_f max_i f_i``;
- capacity margin: by how much the load may change in any direction before no tensions hold it.

The first two ask for the least ``t >= 0`` with ``f_i <= min(cap_i, t scale_i)`` (``scale = L / c``, or 1 N). What the
cables can exert is a zonotope whose facets' normals z do not depend on the bounds (hyperplane shifting: Bouchard,
Gosselin, Moore, J. Mechanisms Robotics 2(1), 2010), so t is the largest over the facets of the root of

    sum_i max(z . u_i, 0) min(cap_i, t scale_i) + min(z . u_i, 0) lower_i = -min_v z . w_v .

The left side is concave, rising and piecewise linear in t: Newton's steps from below end on the root, at most one a
piece. Several loads w_v (the vertices of a wrench set) need each its own tensions; the answer is the worst of them.

Columns have three entries: a force in space, a force and a moment over a length in the plane, or, ``flat``, a force
in the plane and nothing. Any number of cables.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGENERATE = 1e-9
"""Volume of three columns (area of two) over their lengths' product below which they count as dependent [1]."""
SHORT = 1e-12
"""Share of a facet's terms by which its reach may miss the load: rounding."""


@njit(cache=True, error_model="numpy")
def _normal(columns: Array, a: int, b: int, flat: bool) -> tuple[float, float, float]:
    """Normal of the facet along columns a and b; along column a alone where the third direction does not exist."""
    if flat:
        return columns[a, 1], -columns[a, 0], 0.0
    return (
        columns[a, 1] * columns[b, 2] - columns[a, 2] * columns[b, 1],
        columns[a, 2] * columns[b, 0] - columns[a, 0] * columns[b, 2],
        columns[a, 0] * columns[b, 1] - columns[a, 1] * columns[b, 0],
    )


@njit(cache=True, error_model="numpy")
def _demand(loads: Array, z0: float, z1: float, z2: float) -> float:
    """What the worst load asks of the cables along a normal."""
    most = -np.inf
    for v in range(loads.shape[0]):
        most = max(most, -(z0 * loads[v, 0] + z1 * loads[v, 1] + z2 * loads[v, 2]))
    return most


@njit(cache=True, error_model="numpy")
def spans(columns: Array, flat: bool) -> bool:
    """Whether columns (m, 3) span the forces: else no facet bounds what they exert, and nothing is held."""
    m = columns.shape[0]
    for a in range(m):
        for b in range(a + 1, a + 2 if flat else m):
            z0, z1, z2 = _normal(columns, a, b, flat)
            for k in range(a + 1 if flat else b + 1, m):
                volume = abs(z0 * columns[k, 0] + z1 * columns[k, 1] + z2 * columns[k, 2])
                size = 1.0
                for i in (a, b, k):
                    if not (flat and i == b):
                        size *= columns[i, 0] ** 2 + columns[i, 1] ** 2 + columns[i, 2] ** 2
                if volume > DEGENERATE * np.sqrt(size):
                    return True
    return False


@njit(cache=True, error_model="numpy")
def least_scale(columns: Array, flat: bool, loads: Array, lower: Array, cap: Array, scale: Array) -> float:
    """The least t for which tensions within ``lower`` and ``min(cap, t scale)`` hold every load.

    Args:
        columns: Pull of each cable per newton (m, 3).
        flat: Whether the third entry does not exist.
        loads: Vertices of the wrench set (v, 3), without it in the columns' units; at least one.
        lower: Least tensions (m,) [N].
        cap: Largest tensions whatever t (m,) [N].
        scale: Tension per unit of t (m,) [N], positive.

    Returns:
        t; infinite where no tensions within ``cap`` hold the loads.
    """
    m = columns.shape[0]
    if not spans(columns, flat):
        return np.inf
    t = 0.0
    for i in range(m):
        if cap[i] < lower[i]:
            return np.inf
        t = max(t, lower[i] / scale[i])
    for a in range(m):
        for b in range(a + 1, a + 2 if flat else m):
            n0, n1, n2 = _normal(columns, a, b, flat)
            for sign in (-1.0, 1.0):
                z0, z1, z2 = sign * n0, sign * n1, sign * n2
                demand = _demand(loads, z0, z1, z2)
                for _ in range(m + 2):
                    reach, slope, size = 0.0, 0.0, abs(demand)
                    for i in range(m):
                        along = z0 * columns[i, 0] + z1 * columns[i, 1] + z2 * columns[i, 2]
                        if i == a or (i == b and not flat):
                            along = 0.0
                        if along < 0.0:
                            reach += along * lower[i]
                        elif t * scale[i] >= cap[i]:
                            reach += along * cap[i]
                        else:
                            reach += along * scale[i] * t
                            slope += along * scale[i]
                        size += abs(along) * cap[i]
                    if reach >= demand - SHORT * size:
                        break
                    if slope <= 0.0:
                        return np.inf
                    t += (demand - reach) / slope
    return t


@njit(cache=True, error_model="numpy")
def capacity(columns: Array, flat: bool, loads: Array, lower: Array, cap: Array) -> float:
    """Least distance [N] of the loads from a facet of what the cables can exert; negative where a load is outside.

    Arguments as in :func:`least_scale`. ``-inf`` where the columns do not span the forces or a window is empty.
    """
    m = columns.shape[0]
    if not spans(columns, flat):
        return -np.inf
    for i in range(m):
        if cap[i] < lower[i]:
            return -np.inf
    least = np.inf
    for a in range(m):
        for b in range(a + 1, a + 2 if flat else m):
            n0, n1, n2 = _normal(columns, a, b, flat)
            norm = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            if norm < DEGENERATE:  # two parallel columns: their facet is one of another pair
                continue
            for sign in (-1.0, 1.0):
                z0, z1, z2 = sign * n0 / norm, sign * n1 / norm, sign * n2 / norm
                reach = -_demand(loads, z0, z1, z2)
                for i in range(m):
                    along = z0 * columns[i, 0] + z1 * columns[i, 1] + z2 * columns[i, 2]
                    reach += along * (lower[i] if along < 0.0 else cap[i])
                least = min(least, reach)
    return least
