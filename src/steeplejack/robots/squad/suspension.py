"""The platform hanging on its four cables in space, in the leaning plane of the stays: tensions and orientation.

Four cables cannot hold six freedoms. What they can do is set where the platform hangs: with the platform at ``p``, the
four tensions obey three force equations,

    sum_i t_i u_i + m g = 0,          t = t_p + lambda n,

so one parameter lambda is left (n is the null vector of the 3x4 matrix of cable directions, by cofactors), and the
orientation follows from the moments: of least potential under the cable forces (`statics.balanced_rotation`). The
directions u_i depend weakly on it (attachment radius over cable length), so alternating the two converges in a few
rounds. Where the platform goes from there with its winches locked, slack cables and all, is `equilibrium.settle`'s.

Every function takes one pose and is compiled; anchors (4, 3) [m] are winch exits, attachments (4, 3) [m] in the
platform's frame, weight (3,) [N] is the gravity force, centre (3,) [m] the centre of mass in the platform's frame.
Cables are taut, massless and straight.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.degeneracy import TOLERANCE, decide, surely_regular
from steeplejack.mechanics.cable.rest.statics import balanced_rotation, determinant, directions

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def force_family(u: Array, weight: Array) -> tuple[Array, Array, bool]:
    """All tensions of four cables that balance a force: t = particular + lambda * null.

    Args:
        u: Cable directions (4, 3).
        weight: Force to be carried (3,) [N].

    Returns:
        The least-norm particular solution (4,) [N], the unit null vector (4,), and whether the three equations are
        independent, as `degeneracy` defines it (not so, for example, with all cables in one plane).
    """
    null = np.empty(4)
    null[0] = determinant(u[1], u[2], u[3])
    null[1] = -determinant(u[0], u[2], u[3])
    null[2] = determinant(u[0], u[1], u[3])
    null[3] = -determinant(u[0], u[1], u[2])
    size = np.sqrt(np.sum(null * null))
    if not (size > 0.0 and (surely_regular(size, np.sum(u * u), 3) or _independent(u))):
        return np.zeros(4), null, False
    null /= size
    # Least norm: t = -U (U^T U)^-1 w with U (4, 3); det(U^T U) is the square of ``size`` (Cauchy-Binet).
    gram = np.zeros((3, 3))
    for i in range(4):
        for j in range(3):
            for k in range(3):
                gram[j, k] += u[i, j] * u[i, k]
    scale = 1.0 / (size * size)
    y0 = determinant(-weight, gram[1], gram[2]) * scale
    y1 = determinant(gram[0], -weight, gram[2]) * scale
    y2 = determinant(gram[0], gram[1], -weight) * scale
    particular = np.empty(4)
    for i in range(4):
        particular[i] = u[i, 0] * y0 + u[i, 1] * y1 + u[i, 2] * y2
    return particular, null, True


@njit(cache=True, error_model="numpy")
def _independent(u: Array) -> bool:
    """Whether the three rows of the transposed matrix (4, 3) are independent, by their singular values."""
    rows = np.empty((3, 4))
    for i in range(4):
        for k in range(3):
            rows[k, i] = u[i, k]
    return decide(rows, np.ones(3), np.empty((3, 4)), np.empty((3, 3)), np.empty(3)) == 3


@njit(cache=True, error_model="numpy")
def interval(particular: Array, null: Array, lower: Array, upper: Array) -> tuple[float, float, int, int]:
    """Lambda with ``lower <= particular + lambda * null <= upper``.

    Returns:
        Both ends, and the bounds (4,) [N] that set them: the cable's index, plus 4 for an upper bound. The interval is
        empty when the first end is the larger; the two bounds then exclude each other.
    """
    low, high, at_low, at_high = -np.inf, np.inf, -1, -1
    for i in range(4):
        if lower[i] > upper[i]:
            return 1.0, 0.0, i, i + 4
        for side in range(2):
            bound = lower[i] if side == 0 else upper[i]
            gap = bound - particular[i]
            if abs(null[i]) < TOLERANCE:
                if (gap > 0.0) == (side == 0) and gap != 0.0:
                    return 1.0, 0.0, i + 4 * side, i + 4 * side
                continue
            value = gap / null[i]
            if (null[i] > 0.0) == (side == 0):
                if value > low:
                    low, at_low = value, i + 4 * side
            elif value < high:
                high, at_high = value, i + 4 * side
    return low, high, at_low, at_high


@njit(cache=True, error_model="numpy")
def upper_bounds(u: Array, pull: Array, upper: Array) -> tuple[Array, NDArray[np.int64]]:
    """Largest tension of each cable under linear limits, and which limit sets it.

    Args:
        u: Cable directions (4, 3).
        pull: Rows ``(d, limit)`` (k, 4, 4): cable i must obey ``t_i |u_i . d| <= limit`` for each of k limits.
        upper: Largest tensions (4,) [N].

    Returns:
        Bounds (4,) [N] and the limit behind each (4,): -1 for ``upper`` itself, else the row k.
    """
    bound = upper.copy()
    which = np.full(4, -1)
    for k in range(pull.shape[0]):
        for i in range(4):
            share = abs(u[i, 0] * pull[k, i, 0] + u[i, 1] * pull[k, i, 1] + u[i, 2] * pull[k, i, 2])
            if share * bound[i] > pull[k, i, 3]:
                bound[i] = pull[k, i, 3] / share
                which[i] = k
    return bound, which


@njit(cache=True, error_model="numpy")
def choose(particular: Array, null: Array, low: float, high: float, target: Array) -> Array:
    """Tensions of the family nearest to ``target`` [N] in norm, within the interval: unique, continuous in the pose."""
    value = np.sum((target - particular) * null)
    return particular + min(max(value, low), high) * null


@njit(cache=True, error_model="numpy")
def hang(
    anchors: Array,
    attachments: Array,
    weight: Array,
    centre: Array,
    position: Array,
    guess: Array,
    lower: Array,
    pull: Array,
    upper: Array,
    target: Array,
) -> tuple[Array, Array, float]:
    """The equilibrium at a position under bounds on tension, nearest to target tensions.

    Args:
        anchors: Winch exits (4, 3) [m].
        attachments: Attachments (4, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        position: Platform position (3,) [m].
        guess: Rotation to start from (3, 3).
        lower: Least tensions (4,) [N].
        pull: Linear limits (k, 4, 4), see :func:`upper_bounds`.
        upper: Largest tensions (4,) [N].
        target: Tensions to stay near to (4,) [N].

    Returns:
        Rotation (3, 3) platform to world; tensions (4,) [N]; and the room: the width of the interval of lambda [N],
        negative where no equilibrium respects the bounds (the tensions then lie between the two that exclude each
        other). ``-inf`` where the cables do not determine a balance.
    """
    rotation = guess.copy()
    tensions = np.zeros(4)
    room = -np.inf
    forces = np.empty((4, 3))
    for _ in range(40):
        u, _lengths = directions(anchors, attachments, position, rotation)
        particular, null, independent = force_family(u, weight)
        if not independent:
            return rotation, tensions, -np.inf
        bound, _which = upper_bounds(u, pull, upper)
        low, high, _a, _b = interval(particular, null, lower, bound)
        room = high - low
        if room < 0.0:
            low = high = 0.5 * (low + high)
        tensions = choose(particular, null, low, high, target)
        for i in range(4):
            for k in range(3):
                forces[i, k] = tensions[i] * u[i, k]
        before = rotation
        rotation = balanced_rotation(forces, attachments, weight, centre, before)
        change = np.max(np.abs(rotation - before))
        if change < 1e-12:
            break
    return rotation, tensions, room
