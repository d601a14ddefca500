"""A bay of a fan: two boundary stays that carry the bases, interior stays to be inspected, and one face of the fan.

A place of the platform is ``(eta, s, d)``: across the bay in stays (2.5 is midway between the third and the fourth
stay of the bay, boundary included), along the stays by arc length from the lower anchorage [m], and off the stay's
axis along the outward normal of the face [m].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.squad.parameters import Squad
from steeplejack.worksite import Fan, Stay

Array = NDArray[np.float64]
Face = Literal["under", "upper"]


@dataclass(frozen=True)
class Bay:
    """Stays between and including two boundary stays, seen from one face."""

    fan: str
    stays: tuple[Stay, ...]
    face: Face
    assumed_radius: float  # [m] used where a stay's diameter is unknown
    sign: float  # of tangent x across, so that it points away from the stays

    @classmethod
    def of(cls, fan: Fan, first: int, last: int, face: Face, squad: Squad) -> Bay:
        """The bay from stay number ``first`` to ``last``, both boundary stays; unknown radii count as the largest."""
        stays = tuple(fan.between(first, last))
        plain = cls(fan.id, stays, face, 0.5 * squad.base.stay_diameter[1], 1.0)
        normals = plain.normal(np.linspace(1.0, len(stays) - 2.0, 7), 0.5 * plain.reach)
        under = -1.0 if np.mean(normals[:, 2]) > 0.0 else 1.0
        return cls(fan.id, stays, face, plain.assumed_radius, under if face == "under" else -under)

    @property
    def reach(self) -> float:
        """Length of the shortest stay [m]: the largest ``s`` that exists on every stay."""
        return min(stay.length for stay in self.stays)

    @property
    def interior(self) -> range:
        """Positions of the interior stays within the bay."""
        return range(1, len(self.stays) - 1)

    def radius(self, k: int) -> float:
        """Radius of a stay, or the assumed one where it is unknown [m]."""
        radius = self.stays[k].radius
        return self.assumed_radius if radius is None else radius

    def axis(self, eta: Array | float, s: Array | float) -> Array:
        """Point (..., 3) [m] on the ruled surface through the stays' axes."""
        eta, s = np.broadcast_arrays(np.asarray(eta, float), np.asarray(s, float))
        low = np.clip(np.floor(eta).astype(int), 0, len(self.stays) - 2)
        share = (eta - low)[..., None]
        out = np.empty((*eta.shape, 3))
        for k in np.unique(low):
            here = low == k
            f = share[here]
            out[here] = (1.0 - f) * self.stays[k].position(s[here]) + f * self.stays[k + 1].position(s[here])
        return out

    def normal(self, eta: Array | float, s: Array | float) -> Array:
        """Unit normal (..., 3) of the face, pointing away from the stays."""
        eta, s = np.broadcast_arrays(np.asarray(eta, float), np.asarray(s, float))
        step = 0.5
        left, right = np.maximum(eta - 1.0, 0.0), np.minimum(eta + 1.0, len(self.stays) - 1.0)
        across = self.axis(right, s) - self.axis(left, s)
        along = self.axis(eta, s + step) - self.axis(eta, s - step)
        normal = np.cross(along, across)
        return self.sign * normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def place(self, eta: Array | float, s: Array | float, d: Array | float) -> Array:
        """World position (..., 3) [m] of a place of the platform."""
        return self.axis(eta, s) + np.asarray(d, float)[..., None] * self.normal(eta, s)

    def frame(self, eta: float, s: float) -> Array:
        """Rotation (3, 3): z towards the stays, y up along them, x across."""
        z = -self.normal(eta, s)
        along = self.axis(eta, s + 0.5) - self.axis(eta, s - 0.5)
        y = along - (along @ z) * z
        y /= np.linalg.norm(y)
        return np.column_stack([np.cross(y, z), y, z])

    @cached_property
    def carriers(self) -> tuple[int, int, int, int]:
        """Boundary stay of each base: cables 1 and 4 go to the platform's -x side, 1 and 2 are the lower ones.

        The platform's camera looks along +z at the stays, so the face decides which boundary stay lies at -x.
        """
        middle = 0.5 * (len(self.stays) - 1)
        x = self.frame(middle, 0.5 * self.reach)[:, 0]
        across = self.axis(middle + 0.5, 0.5 * self.reach) - self.axis(middle - 0.5, 0.5 * self.reach)
        last = len(self.stays) - 1
        left, right = (0, last) if float(x @ across) > 0.0 else (last, 0)
        return left, right, right, left
