"""What forward kinematics is asked with, checked once: geometry, lengths, starts and tolerance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import numbers, positive
from steeplejack.mechanics.cable.pulleys import in_space, pulley_radii, unit_axes

Array = NDArray[np.float64]
Geometry = tuple[Array, Array, Array, Array]

LARGEST = 1e150
"""Beyond this the square of a length overflows [m]."""


def geometry(
    anchors: ArrayLike, attachments: ArrayLike, radii: ArrayLike | None, axes: ArrayLike | None, d: int
) -> Geometry:
    """The geometry of a robot in space.

    Args:
        anchors: (m, d) [m].
        attachments: (m, d) [m].
        radii: Of the pulleys, (m,) or a scalar [m]; straight cables where not given.
        axes: Swivel axes of the pulleys, (m, d); needed with radii.
        d: 2 in the plane, 3 in space.

    Returns:
        Anchors (m, 3), unit axes (m, 3), radii (m,) and attachments (m, 3).

    Raises:
        InputError: A shape does not fit, a number is not usable, or there are fewer cables than freedoms, whose lengths
            leave the pose open.
    """
    needed = 3 if d == 2 else 6
    fixed = numbers("anchors", anchors)
    if fixed.ndim != 2 or fixed.shape[1] != d or len(fixed) < needed:
        raise InputError("anchors", f"shape {fixed.shape}", f"(m, {d}) with m >= {needed}; with fewer cables `settle`")
    local = numbers("attachments", attachments)
    if local.shape != fixed.shape:
        raise InputError("attachments", f"shape {local.shape}", f"as the anchors, {fixed.shape}")
    for where, points in (("anchors", fixed), ("attachments", local)):
        if not np.all(np.abs(points) < LARGEST):
            raise InputError(where, "not all finite, or too far for a square", "finite points in metres")
    wheels, swivels = _pulleys(radii, axes, len(fixed), d)
    return in_space(fixed), swivels, wheels, in_space(local)


def tolerance_of(tolerance: float | None) -> float | None:
    """A tolerance, which is a number above zero where there is one [m]."""
    return None if tolerance is None else positive("tolerance", tolerance)


def _pulleys(radii: ArrayLike | None, axes: ArrayLike | None, m: int, d: int) -> tuple[Array, Array]:
    """Radii (m,) and unit swivel axes (m, 3)."""
    wheels = pulley_radii(radii, m)
    if not np.all(wheels < LARGEST):
        raise InputError("radii", f"{wheels.tolist()}", "radii whose squares are finite")
    if not wheels.any():
        return wheels, unit_axes(None, m)
    if axes is None or numbers("axes", axes).shape != (m, d):
        found = "none" if axes is None else f"shape {np.shape(axes)}"
        raise InputError("axes", found, f"swivel axes of the pulleys, ({m}, {d})")
    swivels = unit_axes(axes, m)
    if not np.isfinite(swivels[wheels > 0.0]).all():
        raise InputError("axes", "one of length zero or not finite", "swivel axes of any length but zero")
    return wheels, swivels
