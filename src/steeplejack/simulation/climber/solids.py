"""The pipe run as bodies: round ones along the centre line, obstacles on the surface, painted marks beside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Solid:
    """A straight round body fixed in the world.

    Attributes:
        kind: "pipe" where grippers may close on it, "obstacle" where nothing may touch it, "mark" for paint.
        shape: With flat ends or with rounded ones.
        start: Middle of one end (3,) [m].
        end: Middle of the other (3,) [m].
        radius: [m].
    """

    kind: Literal["pipe", "obstacle", "mark"]
    shape: Literal["cylinder", "capsule"]
    start: Array
    end: Array
    radius: float
