"""Certified workspaces: boxes of poses proved inside or outside, by interval branch and bound to a stated gap.

Every box is decided by bounds that hold at each of its poses (`enclosure`), cut in two where they decide nothing, and
so on, widest doubt first, until the boxes still undecided make up no more than the stated share of what is not
outside. The region's volume then lies between ``inner`` and ``outer``, whatever the rounding did, and every box outside
carries the hyperplane that proves it: of its n - 1 columns the normal ``z`` is, at each pose of the box, a certificate
``z . (structure @ f + wrench) > 0``.

The same engine answers wrench closure and wrench feasibility, planar over ``(x, y, phi)`` and spatial over positions at
one orientation; what is asked is put into `Facets`. A side of the search box without width fixes that coordinate.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import cables, kind, numbers, owned, positive, whole
from steeplejack.mechanics.cable.region import enclosure
from steeplejack.mechanics.cable.region.determinants import CUBIC
from steeplejack.mechanics.cable.region.facets import Facets
from steeplejack.mechanics.cable.region.rounding import stored_rounding

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Question = tuple[
    bool, Array, Array, Array, Array, int, Integers, Integers, Array, Array, Array
]  # what `enclosure` takes first


class Label(IntEnum):
    """What is proved of a box or of a piece of a ray; `advice` says what to do."""

    OUTSIDE = enclosure.OUTSIDE
    INSIDE = enclosure.INSIDE
    UNDECIDED = enclosure.UNDECIDED

    @property
    def advice(self) -> str:
        """One line for a person."""
        return _ADVICE[self]


_ADVICE = {
    Label.OUTSIDE: "no pose in it has the property; the facet proves it",
    Label.INSIDE: "every pose in it has the property",
    Label.UNDECIDED: "the boundary passes through it or near it; ask for a smaller gap",
}


@dataclass(frozen=True, eq=False)
class CertifiedRegion:
    """Boxes that cover the search box, and what is proved of each.

    Attributes:
        boxes: Lower and upper end of each coordinate, (k, 3, 2) [m, m, rad] or [m, m, m]; (k, 6, 2) if `oriented`.
        labels: `Label` of each box by number, (k,).
        facets: Proof of each box outside, (k,): ``2 s + side``, hyperplane ``s`` of the question's ``subsets`` and the
            side all available wrenches stay on, 0 where ``+z_J`` has positive work, else 1; -1 elsewhere. Of `oriented`
            regions the wrench or the orientation that fails.
        inner: Volume proved inside, over the coordinates with width [m2, m2 rad, m3].
        outer: Volume not proved outside [m2, m2 rad, m3].
        evaluations: How many boxes were looked at.
        reached: Whether the gap came down to what was asked for.
    """

    boxes: Array
    labels: Integers
    facets: Integers
    inner: float
    outer: float
    evaluations: int
    reached: bool

    @property
    def gap(self) -> float:
        """Undecided volume over the volume not proved outside [1]; 0 where nothing is left."""
        return (self.outer - self.inner) / self.outer if self.outer > 0.0 else 0.0

    def of(self, label: Label) -> Array:
        """Boxes with one label, (k, 3, 2)."""
        return self.boxes[self.labels == label]


@np.errstate(invalid="ignore", over="ignore")
def certify(facets: Facets, box: ArrayLike, gap: float = 1e-3, most: int = 4_000_000) -> CertifiedRegion:
    """Enclose the region of a search box that has the property asked for.

    Args:
        facets: The question, from `planar_facets` or `spatial_facets`.
        box: Lower and upper end of each coordinate, (3, 2) [m, m, rad] or [m, m, m]; equal ends fix a coordinate.
        gap: Undecided volume to reach, as a share of the volume not proved outside [1].
        most: Boxes to look at before giving up.

    Returns:
        The boxes, and bounds of the volume; ``reached`` is False where ``most`` came first.

    Raises:
        InputError: A search box without volume or not finite, or a gap that is not positive.
    """
    kind("facets", facets, Facets)
    ends = search_box(box)
    low, high = ((end - facets.origin) / facets.units for end in ends)
    question = arguments(facets, low, high)
    slop = 2.0**-50 * (np.abs(facets.origin) / facets.units + np.abs(low) + np.abs(high)) * (high > low)
    root = 0.5 * (high - low)

    def decide(lows: Array, highs: Array) -> tuple[Integers, Integers, Integers]:
        centres = lows + 0.5 * (highs - lows)
        halves = np.maximum(highs - centres, centres - lows) * (1.0 + 2.0**-50) + slop
        labels, proofs, cuts = (np.empty(len(lows), dtype=np.int64) for _ in range(3))
        enclosure.classify(*question, centres, halves, False, root, labels, proofs, cuts)
        return labels, proofs, cuts

    return branch(decide, low, high, facets.units, facets.origin, gap, most)


def branch(
    decide: Callable[[Array, Array], tuple[Integers, Integers, Integers]],
    low: Array,
    high: Array,
    units: Array,
    origin: Array,
    gap: float,
    most: int,
) -> CertifiedRegion:
    """Decide boxes, cut the undecided ones in two, level by level, until the gap is reached.

    Args:
        decide: Labels, proofs and sides to cut, (k,) each, of boxes with these lower and upper corners, (k, d) each.
        low: Lower corner of the search box, (d,), in scaled units.
        high: Upper corner, (d,), in scaled units.
        units: One scaled unit of each coordinate, (d,).
        origin: What scaled coordinates count from, (d,).
        gap: Undecided volume to reach, as a share of the volume not proved outside [1].
        most: Boxes to look at before giving up.

    Returns:
        The boxes in the coordinates of the search box.

    Raises:
        InputError: A gap that is not positive, or no box to look at.
    """
    positive("gap", gap)
    whole("most", most, 1, sys.maxsize)
    wide = high > low
    lows, highs = low[None], high[None]
    done: list[tuple[Array, Array, Integers, Integers]] = []
    inner, evaluations = 0.0, 0
    while True:
        labels, proofs, cuts = decide(lows, highs)
        evaluations += len(lows)
        doubtful = labels == Label.UNDECIDED
        inner += _volume(lows[labels == Label.INSIDE], highs[labels == Label.INSIDE], wide)
        doubt = _volume(lows[doubtful], highs[doubtful], wide)
        reached = doubt <= gap * (inner + doubt)
        if reached or evaluations + 2 * np.count_nonzero(doubtful) > most:
            done.append((lows, highs, labels, proofs))
            break
        done.append((lows[~doubtful], highs[~doubtful], labels[~doubtful], proofs[~doubtful]))
        lows, highs = _halves(lows[doubtful], highs[doubtful], cuts[doubtful])
    lows, highs, labels, proofs = (np.concatenate(part) for part in zip(*done, strict=True))
    boxes = np.stack((lows, highs), axis=-1) * units[:, None] + origin[:, None]
    unit = float(units[wide].prod())
    return CertifiedRegion(boxes, labels, proofs, inner * unit, (inner + doubt) * unit, evaluations, reached)


@np.errstate(invalid="ignore", over="ignore")
def closure_box(anchors: ArrayLike, attachments: ArrayLike) -> Array:
    """A box that holds every position in wrench closure, at any orientation.

    In closure the cable vectors have a positive combination that vanishes, so the position lies in the convex hull of
    the ``A_i - b_i``: in the anchors' box, grown by the longest arm.

    Args:
        anchors: (m, 2) or (m, 3) [m].
        attachments: In the platform frame, same shape [m].

    Returns:
        Lower and upper ends, (2, 2) or (3, 2) [m].

    Raises:
        InputError: Shapes or numbers that cannot be meant.
    """
    size = 2 if numbers("anchors", anchors).shape[-1:] == (2,) else 3
    fixed, local = cables(anchors, attachments, size)
    arm = float(np.linalg.norm(local, axis=-1).max())
    return np.stack((fixed.min(axis=0) - arm, fixed.max(axis=0) + arm), axis=-1)


def search_box(box: ArrayLike, size: int = 3) -> tuple[Array, Array]:
    """Lower and upper corner, (size,) each, of a box (size, 2) that is finite and has a side with width."""
    ends = owned("box", box, size, 2)
    if ends.shape != (size, 2) or not np.isfinite(ends).all() or not (ends[:, 0] <= ends[:, 1]).all():
        raise InputError("box", f"{ends.tolist()}", f"lower and upper end of {size} coordinates, finite, ({size}, 2)")
    if not (ends[:, 0] < ends[:, 1]).any():
        raise InputError("box", "no coordinate with width", "at least one")
    return ends[:, 0].copy(), ends[:, 1].copy()


def arguments(facets: Facets, low: Array, high: Array) -> Question:
    """What `enclosure` needs to know of a question within scaled ends (3,); at one angle the harmonics are summed."""
    polynomials = np.concatenate((facets.volumes, facets.loads.reshape(-1, *facets.volumes.shape[1:])))
    x, y, z = np.maximum(np.abs(low), np.abs(high))
    sizes = [1.0, x, y, x * x, x * y, y * y] if facets.planar else [x**i * y**j * z**k for i, j, k in CUBIC]
    slack = enclosure.ROUNDING * (np.abs(polynomials).sum(axis=2) @ np.array(sizes))
    if not facets.planar:
        slack += stored_rounding(facets, low, high)
    if facets.planar and low[2] == high[2]:
        phi = low[2]
        turns = np.array([1.0, np.cos(phi), np.sin(phi), np.cos(2.0 * phi), np.sin(2.0 * phi)])
        polynomials = (polynomials @ turns)[..., None]
    return (
        facets.planar, facets.anchors, facets.arms, polynomials, slack, len(facets.loads),
        facets.others, facets.volume_of, facets.signs, facets.lower, facets.upper,
    )  # fmt: skip


def _volume(lows: Array, highs: Array, wide: NDArray[np.bool_]) -> float:
    """Volume of boxes over the coordinates with width."""
    return float((highs - lows)[:, wide].prod(axis=1).sum())


def _halves(lows: Array, highs: Array, cuts: Integers) -> tuple[Array, Array]:
    """Both halves of every box, cut at the middle of one side."""
    rows = np.arange(len(lows))
    middles = lows[rows, cuts] + 0.5 * (highs[rows, cuts] - lows[rows, cuts])
    left, right = highs.copy(), lows.copy()
    left[rows, cuts] = right[rows, cuts] = middles
    return np.concatenate((lows, right)), np.concatenate((left, highs))
