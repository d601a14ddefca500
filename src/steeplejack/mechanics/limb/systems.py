"""Screw systems: their order, their reciprocal system, sum and meet, by one policy of rank.

A system of order k is a subspace of twists or of wrenches. Its rank is decided once, here, and free of scale: lengths
are measured from a point of the mechanism in units of a characteristic length, every screw is brought to unit size (a
joint does the same whatever the size of its screw), and a singular value counts as zero when it is at most `RANK` of
the largest. Functions here take screws that are already measured so (`Gauge.twists`, `Gauge.wrenches`); in those units
reciprocity is orthogonality, and an orthonormal basis of the reciprocal system is the null space of the rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

RANK = 1e-8
"""Singular value, of the largest one, up to which directions count as dependent [1]."""

CLOSEST = 1e-14
"""Size of a mechanism below which its points count as one: what rounding leaves of a metre, and no mechanism [m]."""


@dataclass(frozen=True)
class Gauge:
    """Where lengths are measured from and in what unit.

    Attributes:
        origin: A point amid the mechanism, (3,) [m].
        length: Characteristic length [m].
    """

    origin: Array
    length: float

    @classmethod
    def of(cls, points: ArrayLike) -> Gauge:
        """Centre of points (k, 3) [m] and their root mean square distance from it; 1 m where they coincide."""
        places = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if len(places) == 0:
            return cls(np.zeros(3), 1.0)
        # The largest coordinate is taken out first, so that squares of very large or small numbers stay in range.
        size = float(np.abs(places).max())
        if size == 0.0:
            return cls(np.zeros(3), 1.0)
        scaled = places / size
        origin = scaled.mean(axis=0)
        spread = float(np.sqrt(np.mean(np.sum((scaled - origin) ** 2, axis=1))))
        distinct = spread > RANK and spread * size > CLOSEST
        return cls(origin * size, spread * size if distinct else 1.0)

    def twists(self, twists: ArrayLike) -> Array:
        """Twists (..., 6) [rad/s; m/s] in this gauge [rad/s; lengths/s]."""
        screws = np.asarray(twists, dtype=np.float64)
        linear = (screws[..., 3:] - np.cross(self.origin, screws[..., :3])) / self.length
        return np.concatenate((screws[..., :3], linear), axis=-1)

    def wrenches(self, wrenches: ArrayLike) -> Array:
        """Wrenches (..., 6) [N m; N] in this gauge [N lengths; N]."""
        screws = np.asarray(wrenches, dtype=np.float64)
        moment = (screws[..., :3] - np.cross(self.origin, screws[..., 3:])) / self.length
        return np.concatenate((moment, screws[..., 3:]), axis=-1)

    def plain_twists(self, twists: ArrayLike) -> Array:
        """Twists of this gauge back at the origin of the frame, SI: the inverse of `twists`."""
        screws = np.asarray(twists, dtype=np.float64)
        linear = screws[..., 3:] * self.length + np.cross(self.origin, screws[..., :3])
        return np.concatenate((screws[..., :3], linear), axis=-1)

    def plain_wrenches(self, wrenches: ArrayLike) -> Array:
        """Wrenches of this gauge back at the origin of the frame, SI: the inverse of `wrenches`."""
        screws = np.asarray(wrenches, dtype=np.float64)
        moment = screws[..., :3] * self.length + np.cross(self.origin, screws[..., 3:])
        return np.concatenate((moment, screws[..., 3:]), axis=-1)


def order(screws: ArrayLike) -> int:
    """Order of the system that screws (k, 6) span."""
    return len(basis(screws))


def basis(screws: ArrayLike) -> Array:
    """Orthonormal basis (order, 6) of the system that screws (k, 6) span.

    Raises:
        InputError: Not (k, 6) or not finite.
    """
    rank, directions = _split(_unit_rows(screws))
    return directions[:rank]


def reciprocal(screws: ArrayLike) -> Array:
    """Orthonormal basis (6 - order, 6) of all screws reciprocal to given ones (k, 6).

    Of twists it gives wrenches that do no work on any of them (the constraints of a limb with those joints); of
    wrenches the twists they allow.

    Raises:
        InputError: Not (k, 6) or not finite.
    """
    rank, directions = _split(_unit_rows(screws))
    return directions[rank:]


def joined(*systems: Array) -> Array:
    """Basis of the sum of systems (k_i, 6): the motions of joints in series, the constraints of limbs in parallel."""
    return basis(np.concatenate([basis(system) for system in systems]) if systems else np.empty((0, 6)))


def met(*systems: Array) -> Array:
    """Basis of what systems (k_i, 6) share, found as the reciprocal of the sum of their reciprocals."""
    return reciprocal(np.concatenate([reciprocal(system) for system in systems]) if systems else np.empty((0, 6)))


def same(one: Array, other: Array) -> bool:
    """Whether two sets of screws span one system."""
    return order(one) == order(other) == len(joined(one, other))


def row_space(matrix: Array) -> Array:
    """Orthonormal basis (rank, c) of the row space of a matrix (r, c); rows are taken as they are."""
    rank, directions = _split(matrix)
    return directions[:rank]


def null_space(matrix: Array) -> Array:
    """Orthonormal basis (nullity, c) of the null space of a matrix (r, c); rows are taken as they are."""
    rank, directions = _split(matrix)
    return directions[rank:]


def least_kept(matrix: Array) -> float:
    """Smallest singular value of a matrix that counts towards its rank; 0 of a matrix of rank 0."""
    values = np.linalg.svd(matrix, compute_uv=False) if matrix.size else np.zeros(0)
    return float(values[_split(matrix)[0] - 1]) if _split(matrix)[0] else 0.0


def _unit_rows(screws: ArrayLike) -> Array:
    """Screws (k, 6) of unit size; those of size zero stay so."""
    try:
        rows = np.asarray(screws, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("screws", "not an array of numbers", "an array (k, 6)") from None
    if rows.ndim != 2 or rows.shape[1] != 6:
        raise InputError("screws", f"shape {rows.shape}", "an array (k, 6)")
    if not np.isfinite(rows).all():
        raise InputError("screws", "a number that is not finite", "finite screws (k, 6)")
    largest = np.abs(rows).max(axis=1, initial=0.0, keepdims=True)
    rows = np.divide(rows, largest, out=np.zeros_like(rows), where=largest > 0.0)
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.divide(rows, sizes, out=rows, where=sizes > 0.0)


def _split(matrix: Array) -> tuple[int, Array]:
    """Rank of a matrix (r, c), and an orthonormal basis (c, c) whose first rows span its row space."""
    if matrix.size == 0:
        return 0, np.eye(matrix.shape[1])
    _left, values, directions = np.linalg.svd(matrix, full_matrices=True)
    # Rows of unit size have a largest singular value of at least 1; less than that is a matrix of rounding errors.
    return int(np.count_nonzero(values > RANK * max(1.0, values[0]))), directions
