"""Small vibrations about an equilibrium: natural frequencies and shapes from stiffness and mass matrices.

``K v = omega^2 M v`` with the stiffness of `stiffness` and the mass matrix about the same point in the same axes, both
in (x, y, phi) or in (rotation; displacement). Solved through the Cholesky factor of M, so neither the units of K and M
nor those of their rows matter. Massless cables, no damping; at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

NEUTRAL = 1e-9
"""Share of the largest squared frequency below which a mode counts as neutral, neither stable nor unstable [1]."""


@dataclass(frozen=True)
class Modes:
    """Natural vibrations, slowest first; leading axes are those of the question.

    Attributes:
        squares: ``omega^2``, (..., n) [1/s2]; negative in a direction the platform runs away in, not a number where
            the stiffness is undefined.
        shapes: Columns ``v``, (..., n, n), with ``v^T M v = 1``.
        stable: Whether every mode has a restoring force, (...).
    """

    squares: Array
    shapes: Array
    stable: NDArray[np.bool_]

    @property
    def frequencies(self) -> Array:
        """Natural frequencies, (..., n) [Hz]; not a number for modes without a restoring force."""
        positive = np.where(self.squares >= 0.0, self.squares, np.nan)
        return np.sqrt(positive) / (2.0 * np.pi)


def natural_modes(stiffness: ArrayLike, mass: ArrayLike) -> Modes:
    """Natural frequencies and shapes of a platform at equilibrium.

    Args:
        stiffness: ``K``, symmetric, (..., n, n).
        mass: ``M``, symmetric positive definite, (..., n, n).

    Returns:
        The modes over the broadcast leading axes.

    Raises:
        InputError: The mass matrix is not positive definite.
    """
    k, m = np.broadcast_arrays(np.asarray(stiffness, dtype=np.float64), np.asarray(mass, dtype=np.float64))
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(m))
    except np.linalg.LinAlgError:
        inverse = np.full(m.shape, np.nan)
    if not np.isfinite(inverse).all():
        raise InputError("mass matrix", "not positive definite", "a positive mass and inertia")
    reduced = inverse @ k @ np.swapaxes(inverse, -1, -2)
    known = np.asarray(np.isfinite(reduced).all(axis=(-2, -1)))
    squares, vectors = np.linalg.eigh(np.where(known[..., None, None], reduced, 0.0))
    squares = np.where(known[..., None], squares, np.nan)
    shapes = np.where(known[..., None, None], np.swapaxes(inverse, -1, -2) @ vectors, np.nan)
    return Modes(squares, shapes, squares[..., 0] > NEUTRAL * np.abs(squares).max(axis=-1))


def planar_mass_matrix(mass: ArrayLike, inertia: ArrayLike, centre: ArrayLike, phi: ArrayLike) -> Array:
    """Mass matrix of a planar platform in ``(x, y, phi)`` about its reference point.

    Args:
        mass: [kg].
        inertia: About the centre of mass [kg m2].
        centre: Centre of mass in the platform frame, (2,) [m].
        phi: Orientation, (...) [rad].

    Returns:
        (..., 3, 3) [kg, kg m, kg m2].
    """
    angle, (x, y) = np.asarray(phi, dtype=np.float64), np.asarray(centre, dtype=np.float64)
    weight = np.asarray(mass, dtype=np.float64)
    out = np.zeros((*angle.shape, 3, 3))
    out[..., 0, 0] = out[..., 1, 1] = weight
    out[..., 0, 2] = out[..., 2, 0] = -weight * (np.sin(angle) * x + np.cos(angle) * y)
    out[..., 1, 2] = out[..., 2, 1] = weight * (np.cos(angle) * x - np.sin(angle) * y)
    out[..., 2, 2] = np.asarray(inertia) + weight * (x * x + y * y)
    return out


def spatial_mass_matrix(mass: ArrayLike, inertia: ArrayLike, centre: ArrayLike, rotation: ArrayLike) -> Array:
    """Mass matrix of a platform in (angular; linear) about its reference point, world axes.

    Args:
        mass: [kg].
        inertia: About the centre of mass in platform axes, (3, 3) [kg m2].
        centre: Centre of mass in the platform frame, (3,) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        (..., 6, 6) [kg m2, kg m, kg].
    """
    turn, weight = np.asarray(rotation, dtype=np.float64), float(np.asarray(mass))
    arm = turn @ np.asarray(centre, dtype=np.float64)
    cross = cross_matrix(arm)
    out = np.zeros((*turn.shape[:-2], 6, 6))
    out[..., :3, :3] = turn @ np.asarray(inertia, dtype=np.float64) @ np.swapaxes(turn, -1, -2) - weight * cross @ cross
    out[..., :3, 3:], out[..., 3:, :3] = weight * cross, -weight * cross
    out[..., 3:, 3:] = weight * np.eye(3)
    return out


def cross_matrix(vectors: Array) -> Array:
    """Matrices ``[v x]`` with ``[v x] w = v x w``, (..., 3, 3) of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(*x.shape, 3, 3)
