"""A platform hanging on four cables in space: the tensions, the orientation and the stiffness of its equilibria.

Four cables cannot hold six freedoms. What they can do is set where the platform hangs: with the platform at ``p``, the
four tensions obey three force equations,

    sum_i t_i u_i + m g = 0,          t = t_p + lambda n,

so one parameter lambda is left (n is the null vector of the 3x4 matrix of cable directions, by cofactors), and the
orientation follows from the moments. For given cable forces ``f_i = t_i u_i`` the potential of a rotation R is
``-sum_i f_i . R b_i - m g . R c``; its least value over all rotations is Wahba's problem (Markley, J. Astronautical
Sciences 36(3), 1988). The directions u_i depend weakly on R (attachment radius over cable length), so alternating the
two converges in a few rounds.

Every function takes one pose and is compiled; shapes are for m cables: anchors (m, 3) [m], attachments (m, 3) [m] in
the platform's frame, tensions (m,) [N], weight (3,) [N] the gravity force, centre (3,) [m] the centre of mass in the
platform's frame. Cables are taut, massless and straight.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.spatial.rotation import turned

Array = NDArray[np.float64]

# Rank test of the 3x4 direction matrix: below this share of the largest possible cofactor (1) the three force
# equations no longer determine the tensions, for example with all cables in one plane.
DEGENERATE = 1e-9


@njit(cache=True, error_model="numpy")
def directions(anchors: Array, attachments: Array, position: Array, rotation: Array) -> tuple[Array, Array]:
    """Unit vectors (m, 3) from attachment to anchor in the world's frame, and lengths (m,) [m]."""
    m = anchors.shape[0]
    u = np.empty((m, 3))
    lengths = np.empty(m)
    for i in range(m):
        square = 0.0
        for k in range(3):
            offset = position[k]
            for j in range(3):
                offset += rotation[k, j] * attachments[i, j]
            u[i, k] = anchors[i, k] - offset
            square += u[i, k] * u[i, k]
        lengths[i] = np.sqrt(square)
        for k in range(3):
            u[i, k] /= lengths[i]
    return u, lengths


@njit(cache=True, error_model="numpy")
def _determinant(a: Array, b: Array, c: Array) -> float:
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@njit(cache=True, error_model="numpy")
def force_family(u: Array, weight: Array) -> tuple[Array, Array, bool]:
    """All tensions of four cables that balance a force: t = particular + lambda * null.

    Args:
        u: Cable directions (4, 3).
        weight: Force to be carried (3,) [N].

    Returns:
        The least-norm particular solution (4,) [N], the unit null vector (4,), and whether the three equations are
        independent.
    """
    null = np.empty(4)
    null[0] = _determinant(u[1], u[2], u[3])
    null[1] = -_determinant(u[0], u[2], u[3])
    null[2] = _determinant(u[0], u[1], u[3])
    null[3] = -_determinant(u[0], u[1], u[2])
    size = np.sqrt(np.sum(null * null))
    if size < DEGENERATE:
        return np.zeros(4), null, False
    null /= size
    # Least norm: t = -U (U^T U)^-1 w with U (4, 3); det(U^T U) is the square of ``size`` (Cauchy-Binet).
    gram = np.zeros((3, 3))
    for i in range(4):
        for j in range(3):
            for k in range(3):
                gram[j, k] += u[i, j] * u[i, k]
    scale = 1.0 / (size * size)
    y0 = _determinant(-weight, gram[1], gram[2]) * scale
    y1 = _determinant(gram[0], -weight, gram[2]) * scale
    y2 = _determinant(gram[0], gram[1], -weight) * scale
    particular = np.empty(4)
    for i in range(4):
        particular[i] = u[i, 0] * y0 + u[i, 1] * y1 + u[i, 2] * y2
    return particular, null, True


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
            if abs(null[i]) < DEGENERATE:
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
def balanced_rotation(forces: Array, attachments: Array, weight: Array, centre: Array, guess: Array) -> Array:
    """The rotation of least potential under given cable forces: Wahba's problem, by Newton's method on the rotations.

    With ``M = sum_i f_i b_i^T + w c^T`` and ``S = M R^T`` the moment left over is the axial vector of ``S - S^T`` and
    the Hessian is ``tr(S) I - (S + S^T) / 2``. The potential has one minimum over the rotations, one maximum and two
    saddles for a general M, so a minimum found is the minimum; where the Hessian is not positive the step follows the
    moment.

    Args:
        forces: Cable forces on the platform (m, 3) [N], world frame.
        attachments: Attachments (m, 3) [m], platform frame.
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m], platform frame.
        guess: Rotation to start from (3, 3).

    Returns:
        Rotation (3, 3) platform to world.
    """
    moment, turn = np.zeros((3, 3)), np.zeros((3, 3))
    size = 0.0
    for k in range(3):
        for j in range(3):
            moment[k, j] = weight[k] * centre[j]
            for i in range(forces.shape[0]):
                moment[k, j] += forces[i, k] * attachments[i, j]
            size += moment[k, j] ** 2
    size = np.sqrt(size)
    rotation = guess.copy()
    step = np.zeros(3)
    for _ in range(60):
        for k in range(3):
            for j in range(3):
                turn[k, j] = 0.0
                for i in range(3):
                    turn[k, j] += moment[k, i] * rotation[j, i]
        trace = turn[0, 0] + turn[1, 1] + turn[2, 2]
        left = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        hessian = np.empty((3, 3))
        for k in range(3):
            for j in range(3):
                hessian[k, j] = -0.5 * (turn[k, j] + turn[j, k])
            hessian[k, k] += trace
        whole = _determinant(hessian[0], hessian[1], hessian[2])
        minor = hessian[0, 0] * hessian[1, 1] - hessian[0, 1] * hessian[1, 0]
        if hessian[0, 0] > 0.0 and minor > 0.0 and whole > 1e-9 * size**3:
            step[0] = _determinant(left, hessian[1], hessian[2]) / whole
            step[1] = _determinant(hessian[0], left, hessian[2]) / whole
            step[2] = _determinant(hessian[0], hessian[1], left) / whole
        else:
            for k in range(3):
                step[k] = left[k] / size
        angle = np.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
        if angle > 1.0:
            step /= angle
        rotation = turned(step, rotation)
        if angle < 1e-13:
            break
    return rotation


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


@njit(cache=True, error_model="numpy")
def _arm(rotation: Array, point: Array) -> tuple[float, float, float]:
    return (
        rotation[0, 0] * point[0] + rotation[0, 1] * point[1] + rotation[0, 2] * point[2],
        rotation[1, 0] * point[0] + rotation[1, 1] * point[1] + rotation[1, 2] * point[2],
        rotation[2, 0] * point[0] + rotation[2, 1] * point[1] + rotation[2, 2] * point[2],
    )


@njit(cache=True, error_model="numpy")
def residual(
    attachments: Array,
    weight: Array,
    centre: Array,
    rotation: Array,
    u: Array,
    tensions: Array,
) -> Array:
    """What is missing to equilibrium: moment about the platform's origin [N m] and force [N] (6,), world frame.

    Args:
        attachments: Attachments (m, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        rotation: Platform orientation (3, 3).
        u: Cable directions (m, 3), see :func:`directions`.
        tensions: Tensions (m,) [N].
    """
    out = np.zeros(6)
    m = attachments.shape[0]
    for i in range(m + 1):
        if i < m:
            a0, a1, a2 = _arm(rotation, attachments[i])
            f0, f1, f2 = tensions[i] * u[i, 0], tensions[i] * u[i, 1], tensions[i] * u[i, 2]
        else:
            a0, a1, a2 = _arm(rotation, centre)
            f0, f1, f2 = weight[0], weight[1], weight[2]
        out[0] += a1 * f2 - a2 * f1
        out[1] += a2 * f0 - a0 * f2
        out[2] += a0 * f1 - a1 * f0
        out[3] += f0
        out[4] += f1
        out[5] += f2
    return out


@njit(cache=True, error_model="numpy")
def stiffness(
    attachments: Array,
    weight: Array,
    centre: Array,
    rotation: Array,
    u: Array,
    lengths: Array,
    tensions: Array,
    cable_stiffness: Array,
) -> Array:
    """Hessian (6, 6) of the potential with locked winches, for a (rotation; translation) about the platform's origin.

    ``K = sum_i k_i j_i j_i^T + K_t``: the elastic part along the cables (j_i the derivative of length i) and the
    tension part, which alone stiffens the platform out of the plane of its cables:
    ``t_i / l_i D_i^T (I - u_i u_i^T) D_i`` with ``D_i = [-(r_i x), I]``, and ``(f . r) I - (f r^T + r f^T) / 2`` in the
    rotations for every force f at an arm r, the weight at the centre of mass included.

    Args:
        attachments: Attachments (m, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        rotation: Platform orientation (3, 3).
        u: Cable directions (m, 3), see :func:`directions`.
        lengths: Cable lengths (m,) [m].
        tensions: Tensions (m,) [N].
        cable_stiffness: k_i = EA / L_i (m,) [N/m]; zeros give the Hessian at constant tension.
    """
    out = np.zeros((6, 6))
    across, lever = np.zeros((3, 3)), np.zeros((3, 6))
    arm, force = np.zeros(3), np.zeros(3)
    lever[0, 3] = lever[1, 4] = lever[2, 5] = 1.0
    m = attachments.shape[0]
    for i in range(m + 1):
        arm[0], arm[1], arm[2] = _arm(rotation, attachments[i] if i < m else centre)
        dot = 0.0
        for k in range(3):
            force[k] = tensions[i] * u[i, k] if i < m else weight[k]
            dot += force[k] * arm[k]
        for j in range(3):
            out[j, j] += dot
            for k in range(3):
                out[j, k] -= 0.5 * (force[j] * arm[k] + arm[j] * force[k])
        if i == m:
            break
        lever[0, 1], lever[0, 2] = arm[2], -arm[1]
        lever[1, 0], lever[1, 2] = -arm[2], arm[0]
        lever[2, 0], lever[2, 1] = arm[1], -arm[0]
        tight = tensions[i] / lengths[i]
        for j in range(3):
            for k in range(3):
                across[j, k] = (cable_stiffness[i] - tight) * u[i, j] * u[i, k] + (tight if j == k else 0.0)
        for j in range(6):
            for k in range(6):
                total = 0.0
                for p in range(3):
                    for q in range(3):
                        total += lever[p, j] * across[p, q] * lever[q, k]
                out[j, k] += total
    return out


@njit(cache=True, error_model="numpy")
def least_pivot(matrix: Array) -> float:
    """Least pivot of L D L^T of a symmetric matrix (n, n): above 0 exactly where it is positive definite."""
    n = matrix.shape[0]
    work = matrix.copy()
    least = np.inf
    for k in range(n):
        least = min(least, work[k, k])
        if work[k, k] <= 0.0:
            return work[k, k]
        for i in range(k + 1, n):
            factor = work[i, k] / work[k, k]
            for j in range(k + 1, n):
                work[i, j] -= factor * work[k, j]
    return least
