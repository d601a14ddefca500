"""Whether freedoms last: walks along a linkage's own freedoms away from its reference configuration.

A mobility counted at one configuration is instantaneous. It is the mobility of the full cycle when it is found again at
configurations reached through finite motion; where it is larger than there, the reference configuration is singular;
and a linkage that cannot leave the reference at all only shakes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steeplejack.mechanics.limb.closure import Closure
from steeplejack.mechanics.limb.systems import null_space

Array = NDArray[np.float64]

WALKS = 4
STEPS = 3
STRIDE = 0.15
"""Length of a step over all joint coordinates [rad or characteristic lengths]."""
PROBE = 0.02
"""Length of the step that tells a freedom that lasts from one that does not, likewise."""
LEFT = 0.1
"""Share of a step that a walk must keep once the loops are closed; directions that only shake lose theirs [1]."""
KEPT = 0.5
"""Share of a probing step that has to be left for its direction to count as a motion [1]."""


class Excursion(NamedTuple):
    """A configuration reached by a walk.

    Attributes:
        coordinates: Of the joints, (f,) [rad; characteristic lengths].
        instantaneous: Mobility by the rank of the loop equations there.
        lasting: How many of those freedoms are directions of finite motion.
    """

    coordinates: Array
    instantaneous: int
    lasting: int


def excursions(closure: Closure, rng: np.random.Generator) -> list[Excursion]:
    """Configurations at the end of walks in random directions among the freedoms; none if it cannot move.

    Args:
        closure: The loop equations.
        rng: Where directions come from.
    """
    found, lasting = list[Excursion](), dict[int, int]()
    for _walk in range(WALKS):
        end = _walked(closure, rng)
        if end is not None:
            tangents = null_space(closure.at(end).jacobian)
            # Walks that end with as many freedoms are on one kind of branch; probing one of them will do.
            if len(tangents) not in lasting:
                lasting[len(tangents)] = _lasting(closure, end, tangents)
            found.append(Excursion(end, len(tangents), lasting[len(tangents)]))
    return found


def _walked(closure: Closure, rng: np.random.Generator) -> Array | None:
    """Coordinates after `STEPS` steps in one direction; None if the linkage did not follow."""
    here = np.zeros(closure.freedoms)
    tangents = null_space(closure.at(here).jacobian)
    if len(tangents) == 0:
        return None
    heading = tangents.T @ rng.normal(size=len(tangents))
    for _step in range(STEPS):
        tangents = null_space(closure.at(here).jacobian)
        onward = tangents.T @ (tangents @ heading)
        size = float(np.linalg.norm(onward))
        if size < 1e-6 * np.linalg.norm(heading):  # the motion turned by a right angle: it was none
            return None
        there = closure.closed(here + onward * (STRIDE / size))
        if there is None or np.linalg.norm(there - here) < LEFT * STRIDE:
            return None
        here, heading = there, there - here
    return here


def _lasting(closure: Closure, here: Array, tangents: Array) -> int:
    """Dimension of the directions in which the linkage keeps a small step."""
    kept = list[Array]()
    for tangent in tangents:
        there = closure.closed(here + PROBE * tangent)
        if there is not None:
            kept.append(tangents @ (there - here) / PROBE)
    if not kept:
        return 0
    return int(np.count_nonzero(np.linalg.svd(np.array(kept), compute_uv=False) > KEPT))
