"""Small vibrations about an equilibrium: natural frequencies and shapes from stiffness and mass matrices.

``K v = omega^2 M v`` with the stiffness of `stiffness` and the mass matrix about the same point in the same axes, both
in (x, y, phi) or in (rotation; displacement). Solved through the Cholesky factor of M, so neither the units of K and M
nor those of their rows matter. Massless cables, no damping; at rest.

Policy. A mass that is not positive, an inertia that is not symmetric or no body has (moments that are not positive, or
one above the sum of the other two) or a mass matrix that is not symmetric positive definite is refused. Of a batch of
stiffnesses those that are undefined have no modes, the others theirs; rotations are taken as `arguments` says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import angles, leading, positive, rotation_matrices, vectors

Array = NDArray[np.float64]

NEUTRAL = 1e-9
"""Share of the largest squared frequency below which a mode counts as neutral, neither stable nor unstable [1]."""

SYMMETRY = 1e-6
"""How far from symmetric a matrix may be and still count as one [1]."""


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


@np.errstate(invalid="ignore", over="ignore")
def natural_modes(stiffness: ArrayLike, mass: ArrayLike) -> Modes:
    """Natural frequencies and shapes of a platform at equilibrium.

    Args:
        stiffness: ``K``, symmetric, (..., n, n).
        mass: ``M``, symmetric positive definite, (..., n, n).

    Returns:
        The modes over the broadcast leading axes.

    Raises:
        InputError: The mass matrix is not symmetric positive definite, the stiffness is not symmetric, or shapes that
            do not fit.
    """
    k = vectors("stiffness", stiffness, "n", "n")
    n = k.shape[-1]
    m = vectors("mass matrix", mass, n, n)
    if k.shape[-2] != n:
        raise InputError("stiffness", f"shape {k.shape}", "(..., n, n)")
    shape = leading(("stiffness", k.shape, 2), ("mass matrix", m.shape, 2))
    k, m = np.broadcast_to(k, (*shape, n, n)), np.broadcast_to(m, (*shape, n, n))
    for where, matrix in (("stiffness", k), ("mass matrix", m)):
        if not _symmetric(matrix):
            raise InputError(where, "not symmetric", "a symmetric matrix")
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(m))
    except np.linalg.LinAlgError:
        inverse = np.full(m.shape, np.nan)
    if not np.isfinite(inverse).all():
        raise InputError("mass matrix", "not positive definite", "a positive mass and inertia")
    reduced = inverse @ k @ np.swapaxes(inverse, -1, -2)
    known = np.asarray(np.isfinite(reduced).all(axis=(-2, -1)))
    squares, basis = np.linalg.eigh(np.where(known[..., None, None], reduced, 0.0))
    squares = np.where(known[..., None], squares, np.nan)
    shapes = np.where(known[..., None, None], np.swapaxes(inverse, -1, -2) @ basis, np.nan)
    return Modes(squares, shapes, squares[..., 0] > NEUTRAL * np.abs(squares).max(axis=-1))


@np.errstate(invalid="ignore", over="ignore")
def planar_mass_matrix(mass: ArrayLike, inertia: ArrayLike, centre: ArrayLike, phi: ArrayLike) -> Array:
    """Mass matrix of a planar platform in ``(x, y, phi)`` about its reference point.

    Args:
        mass: [kg].
        inertia: About the centre of mass [kg m2].
        centre: Centre of mass in the platform frame, (2,) [m].
        phi: Orientation, (...) [rad].

    Returns:
        (..., 3, 3) [kg, kg m, kg m2].

    Raises:
        InputError: Mass or inertia not above 0, or another shape.
    """
    angle, weight, turning = angles("phi", phi), positive("mass", mass), positive("inertia", inertia)
    x, y = _point("centre", centre, 2)
    out = np.zeros((*angle.shape, 3, 3))
    out[..., 0, 0] = out[..., 1, 1] = weight
    out[..., 0, 2] = out[..., 2, 0] = -weight * (np.sin(angle) * x + np.cos(angle) * y)
    out[..., 1, 2] = out[..., 2, 1] = weight * (np.cos(angle) * x - np.sin(angle) * y)
    out[..., 2, 2] = turning + weight * (x * x + y * y)
    return out


@np.errstate(invalid="ignore", over="ignore")
def spatial_mass_matrix(mass: ArrayLike, inertia: ArrayLike, centre: ArrayLike, rotation: ArrayLike) -> Array:
    """Mass matrix of a platform in (angular; linear) about its reference point, world axes.

    Args:
        mass: [kg].
        inertia: About the centre of mass in platform axes, (3, 3) [kg m2].
        centre: Centre of mass in the platform frame, (3,) [m].
        rotation: From platform to world, (..., 3, 3).

    Returns:
        (..., 6, 6) [kg m2, kg m, kg].

    Raises:
        InputError: A mass not above 0, an inertia no body has, another shape, or one matrix that is no rotation.
    """
    turn, weight, own = rotation_matrices("rotation", rotation), positive("mass", mass), _body_inertia(inertia)
    cross = cross_matrix(turn @ _point("centre", centre, 3))
    out = np.zeros((*turn.shape[:-2], 6, 6))
    out[..., :3, :3] = turn @ own @ np.swapaxes(turn, -1, -2) - weight * cross @ cross
    out[..., :3, 3:], out[..., 3:, :3] = weight * cross, -weight * cross
    out[..., 3:, 3:] = weight * np.eye(3)
    return out


def _point(where: str, value: ArrayLike, axes: int) -> Array:
    """One finite point, (axes,)."""
    given = vectors(where, value, axes)
    if given.ndim != 1 or not np.isfinite(given).all():
        raise InputError(where, f"{given.tolist()}", f"{axes} finite coordinates")
    return given


def _body_inertia(value: ArrayLike) -> Array:
    """The inertia matrix (3, 3) of some body: symmetric, its principal moments positive, none above the other two."""
    given = vectors("inertia", value, 3, 3)
    if given.ndim != 2 or not np.isfinite(given).all():
        raise InputError("inertia", f"shape {given.shape}, or a number that is not finite", "(3, 3), finite")
    if not _symmetric(given):
        raise InputError("inertia", "not symmetric", "a symmetric matrix")
    moments = np.linalg.eigvalsh(given)
    if not moments[0] > 0.0 or moments[2] > (moments[0] + moments[1]) * (1.0 + SYMMETRY):
        raise InputError(
            "inertia", f"principal moments {moments.tolist()}", "moments above 0, none above the others' sum"
        )
    return given


def _symmetric(matrices: Array) -> bool:
    """Whether each of (..., n, n) is symmetric to `SYMMETRY`, every entry against its row's and column's diagonal.

    Entries that are not finite pass, and off-diagonal ones larger than the diagonal allows are measured by themselves.
    """
    swapped = np.swapaxes(matrices, -1, -2)
    with np.errstate(invalid="ignore"):
        apart = np.abs(matrices - swapped)
        size = np.maximum(np.abs(matrices), np.abs(swapped))
        diagonal = np.abs(np.diagonal(matrices, axis1=-2, axis2=-1))
        size = np.maximum(size, np.sqrt(diagonal[..., :, None] * diagonal[..., None, :]))
        return not np.any(apart > SYMMETRY * size)


def cross_matrix(vectors: Array) -> Array:
    """Matrices ``[v x]`` with ``[v x] w = v x w``, (..., 3, 3) of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    return np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(*x.shape, 3, 3)
