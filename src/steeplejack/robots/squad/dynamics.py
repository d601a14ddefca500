"""Planar dynamics of the flying platform (Eq. 8), pose ``(x, y, phi)`` at its centre of mass.

One sign convention, that of the statics in Eq. 7: every wrench is the one exerted *on* the platform, so

    M xdd = J^T f + w_weight + w_applied.

The paper's Eq. 8 writes the same with ``g = -w_weight`` and ``w_ext = -w_applied`` on the left. At the centre of mass M
is constant and the Coriolis and centrifugal terms vanish. Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 7-8.

Range of validity: rigid platform, massless cables, motion in the plane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def planar_mass_matrix(mass: float, inertia: float) -> Array:
    """Mass matrix at the centre of mass, ``diag(m, m, I)``.

    Args:
        mass: ``m`` [kg].
        inertia: ``I`` about the axis perpendicular to the plane [kg m2].

    Returns:
        (3, 3) [kg, kg, kg m2].
    """
    return np.diag([mass, mass, inertia])


def planar_weight(mass: ArrayLike, gravity: ArrayLike) -> Array:
    """Wrench of the weight at the centre of mass.

    Args:
        mass: (...) [kg].
        gravity: Of the worksite, (2,) [m/s2].

    Returns:
        ``(fx, fy, mz)`` on the platform, (..., 3) [N, N, N m].
    """
    return np.asarray(mass, dtype=np.float64)[..., None] * np.array([*np.asarray(gravity, dtype=np.float64), 0.0])


def forward_dynamics(
    structure: ArrayLike, tensions: ArrayLike, mass: float, inertia: float, gravity: ArrayLike, applied: ArrayLike = 0.0
) -> Array:
    """Acceleration under cable tensions, ``xdd = M^-1 (J^T f + w_weight + w_applied)``.

    Args:
        structure: ``J^T``, (..., 3, m).
        tensions: (..., m) [N].
        mass: [kg].
        inertia: [kg m2].
        gravity: (2,) [m/s2].
        applied: Wrench on the platform from anything else, wind or tool, (..., 3) [N, N, N m].

    Returns:
        ``(ax, ay, alpha)``, (..., 3) [m/s2, m/s2, rad/s2].
    """
    cables = np.einsum("...im,...m->...i", np.asarray(structure), np.asarray(tensions))
    return (cables + planar_weight(mass, gravity) + np.asarray(applied)) / np.array([mass, mass, inertia])


def inverse_dynamics(
    acceleration: ArrayLike, mass: float, inertia: float, gravity: ArrayLike, applied: ArrayLike = 0.0
) -> Array:
    """Wrench the cables must deliver for an acceleration, ``J^T f = M xdd - w_weight - w_applied``.

    Its negative is the ``wrench`` that `steeplejack.mechanics.cable.distribute` balances with tensions.

    Args:
        acceleration: ``(ax, ay, alpha)``, (..., 3) [m/s2, m/s2, rad/s2].
        mass: [kg].
        inertia: [kg m2].
        gravity: (2,) [m/s2].
        applied: Wrench on the platform from anything else, (..., 3) [N, N, N m].

    Returns:
        ``(fx, fy, mz)`` on the platform, (..., 3) [N, N, N m].
    """
    inertial = np.asarray(acceleration, dtype=np.float64) * np.array([mass, mass, inertia])
    return inertial - planar_weight(mass, gravity) - np.asarray(applied)
