"""Where a stay may be grasped: a rectangle about its axis (Eq. 19).

The paper bounds the grasp by four lines, two parallel to the axis ``y = a x + b`` and two across it, each offset
vertically: by ``delta`` those along, by ``epsilon`` those across. With the unit direction ``u = (cos t, sin t)`` of the
stay that is a rectangle about a point of the axis, of half sides

    half width  |delta cos t|   across the stay,        half length  |epsilon sin t|   along it.

A vertical line has no vertical offset: the lines along a vertical stay and those across a horizontal one. There the
offset is measured across the line, so that the half width of a vertical stay is ``delta`` and the half length of a
horizontal one ``epsilon``. A stay counts as such where the smaller component of ``u`` is at most `UPRIGHT`. A stay that
is nearly horizontal has, as printed, a region that is short however large ``epsilon``; give its half sides directly.

Source: Zheng et al., CCRobot-S, IEEE T-RO, Eq. 19, with one epsilon either side of the point.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]

UPRIGHT = 1e-9  # [1] component of a unit direction that counts as 0


@dataclass(frozen=True, eq=False)
class GraspRegion:
    """A rectangle about the axis of a stay, with its sides along and across it.

    Attributes:
        point: On the axis, the middle of the rectangle, (2,) [m].
        direction: Of the stay, made a unit vector, (2,) [1].
        half_width: Greatest distance from the axis [m]; 0 for the axis alone.
        half_length: Greatest distance from the point along the axis [m].
    """

    point: Array
    direction: Array
    half_width: float
    half_length: float

    def __post_init__(self) -> None:
        """Refuse what is no rectangle."""
        for name in ("point", "direction"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if value.shape != (2,) or not np.isfinite(value).all():
                raise InputError(f"{name} of the grasp region", f"{value.tolist()}", "two finite numbers")
            object.__setattr__(self, name, value)
        size = float(np.abs(self.direction).max())
        if size == 0.0:
            raise InputError("direction of the grasp region", "0 0", "a vector along the stay")
        unit = self.direction / size
        object.__setattr__(self, "direction", unit / np.linalg.norm(unit))
        for name in ("half_width", "half_length"):
            value = float(getattr(self, name))
            if not 0.0 <= value < math.inf:
                raise InputError(f"{name} of the grasp region", f"{value:g} m", "finite, 0 m or more")
            object.__setattr__(self, name, value)

    @classmethod
    def eq19(cls, point: ArrayLike, direction: ArrayLike, delta: float, epsilon: float) -> GraspRegion:
        """The region of Eq. 19 from its vertical offsets.

        Args:
            point: On the axis, (2,) [m].
            direction: Of the stay, of any length, (2,).
            delta: Vertical offset of the lines along the stay [m].
            epsilon: Vertical offset of the lines across it [m].

        Returns:
            The rectangle.

        Raises:
            InputError: A direction of no length, an offset that is negative, anything not finite.
        """
        for name, offset in (("delta", delta), ("epsilon", epsilon)):
            if not 0.0 <= offset < math.inf:
                raise InputError(name, f"{offset:g} m", "finite, 0 m or more")
        along, up = np.abs(cls(np.array(point), np.array(direction), 0.0, 0.0).direction).tolist()
        width = delta if along <= UPRIGHT else delta * along
        length = epsilon if up <= UPRIGHT else epsilon * up
        return cls(np.array(point), np.array(direction), width, length)

    @property
    def axes(self) -> Array:
        """Unit vectors along the stay and across it, counter-clockwise of it, as rows (2, 2) [1]."""
        (x, y) = self.direction
        return np.array([[x, y], [-y, x]])

    @property
    def corners(self) -> Array:
        """The four corners in order, (4, 2) [m]."""
        signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        return self.placed(signs * [self.half_length, self.half_width])

    def placed(self, coordinates: ArrayLike) -> Array:
        """Positions (..., 2) [m] from coordinates along the axis from the point and across it, (..., 2) [m]."""
        return self.point + np.asarray(coordinates, dtype=np.float64) @ self.axes

    def coordinates(self, positions: ArrayLike) -> Array:
        """Coordinates along the axis from the point and across it, (..., 2) [m], of positions (..., 2) [m]."""
        return (np.asarray(positions, dtype=np.float64) - self.point) @ self.axes.T

    def distance(self, positions: ArrayLike) -> Array:
        """Distance from the axis, perpendicular to it, (...) [m], of positions (..., 2) [m]."""
        return np.abs(self.coordinates(positions)[..., 1])
