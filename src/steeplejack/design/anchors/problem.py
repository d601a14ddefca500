"""Anchor reconfiguration as data: which anchors may stand where along their stays, for which poses of the platform.

An anchor on a straight stay has one freedom, its offset along x from its present place, so a configuration is four
offsets: ``A_i(v_i) = A_i + v_i d_i`` with ``d_i = (1, slope_i)``. Source: Zheng et al., CCRobot-S, IEEE T-RO,
Eq. 21 and 26-28, with Eq. 26 read as a window about the place of Table III.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reconfiguration:
    """Movable anchors, the platform and the poses it is to take.

    Attributes:
        anchors: Present places of the four anchors, (4, 2) [m].
        directions: Change of an anchor's place with its offset, (4, 2) [1]; ``(1, slope)`` of its stay.
        attachments: In the platform frame, (4, 2) [m].
        windows: Least and largest offset of each anchor along x, (4, 2) [m]; (0, 0) for one that stays.
        poses: ``(x, y, phi)``, (k, 3) [m, m, rad].
    """

    anchors: Array
    directions: Array
    attachments: Array
    windows: Array
    poses: Array

    def __post_init__(self) -> None:
        """Refuse what is not four anchors, four attachments, four windows and a path."""
        for name, shape in (("anchors", (4, 2)), ("directions", (4, 2)), ("attachments", (4, 2)), ("windows", (4, 2))):
            values = np.array(getattr(self, name), dtype=np.float64)
            if values.shape != shape or not np.isfinite(values).all():
                raise InputError(name, f"shape {values.shape}", f"finite numbers of shape {shape}")
            object.__setattr__(self, name, values)
        poses = np.atleast_2d(np.array(self.poses, dtype=np.float64))
        if poses.ndim != 2 or poses.shape[1] != 3 or not len(poses) or not np.isfinite(poses).all():
            raise InputError("poses", f"shape {poses.shape}", "at least one finite pose (x, y, phi)")
        object.__setattr__(self, "poses", poses)
        for index, (low, high) in enumerate(self.windows):
            if low > high:
                raise InputError(f"window of anchor {index + 1}", f"{low:g} to {high:g} m", "least before largest")

    def placed(self, offsets: ArrayLike) -> Array:
        """Anchors at offsets along x.

        Args:
            offsets: (..., 4) [m].

        Returns:
            Places, (..., 4, 2) [m].
        """
        return self.anchors + np.asarray(offsets, dtype=np.float64)[..., None] * self.directions
