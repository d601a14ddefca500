"""Where cables meet each other, the platform or the stays around them.

Everything is at given rotations; cables are straight, cable ``i`` from its anchor ``A_i`` to ``B_i = p + b_i``.

- *Gaps*: distances of cable axes from each other, and of cable axes from the surfaces of stays. A platform that moves
  by ``d`` without turning changes none of them by more than ``|d|``, so regions and rays free of interference are
  certified from distances alone (`interference_region`, `interference_rays`). Pairs that share an end always touch
  there and are left out. Distances of nearly parallel cables are exact to 2e-7 of their length, and certificates leave
  room for it.
- *Crossings*: two cables lie in one plane where ``(A_j - A_i) . (v_i x v_j) = 0``, at one orientation a plane of
  positions, ``normal . p = offset`` with ``normal = (A_j - A_i) x (b_j - b_i)`` (Merlet, Analysis of the Influence of
  Wires Interference on the Workspace of Wire Robots, ARK 2004; Perreault et al., Geometric Determination of the
  Interference-Free Constant-Orientation Workspace of Parallel Cable-Driven Mechanisms, J. Mechanisms Robotics 2,
  031016, 2010). The critical surface of a pair is the part of that plane where the cables, not only their lines, meet.
- *Platform*: the length of a cable inside a convex platform, which its own end touches anyway: 0 where the cable
  leaves the body at once.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import (
    cables,
    finite,
    kind,
    leading,
    owned,
    points,
    positive,
    rotation_matrices,
)
from steeplejack.mechanics.cable.region.boundary import Rays, segments, subdivide
from steeplejack.mechanics.cable.region.certified import CertifiedRegion, branch, search_box
from steeplejack.mechanics.cable.region.clearance import nearest_stay, segment_distance
from steeplejack.spatial.rotation import rotation_matrix

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

PARALLEL = 2.0**-22
"""Error of a distance between nearly parallel cables over their length [1]."""

ON_SURFACE = 1e-9
"""Depth in a platform that counts as its surface, over its size [1]."""

ALONG = 1e-9
"""Sine of the angle to a face below which a cable is parallel to it [1]."""

OUTSIDE, INSIDE, UNDECIDED = range(3)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Cables of a platform at one orientation, and stays beside it.

    Attributes:
        anchors: (m, 3) [m].
        arms: Attachments in world axes, from the reference point, (m, 3) [m].
        pairs: Cables that may meet, (q, 2); those that share an end are left out.
        stays: Axes as polylines, (k, n, 3) [m].
        radii: Their radii, (k,) [m].
        own: The stay each cable's anchor sits on, (m,), not checked against it; -1 for none.
    """

    anchors: Array
    arms: Array
    pairs: Integers
    stays: Array
    radii: Array
    own: Integers

    @staticmethod
    def of(
        anchors: ArrayLike,
        attachments: ArrayLike,
        rotation: ArrayLike,
        stays: ArrayLike | None = None,
        radii: ArrayLike = 0.0,
        own: ArrayLike = -1,
    ) -> Surroundings:
        """Put cables and stays together.

        Args:
            anchors: (m, 3) [m].
            attachments: In the platform frame, (m, 3) [m].
            rotation: From platform to world, (3, 3).
            stays: Axes as polylines, (k, n, 3) [m]; none if None.
            radii: (k,) or a scalar [m].
            own: The stay each cable's anchor sits on, (m,) or a scalar; -1 for none.

        Returns:
            The surroundings.

        Raises:
            InputError: Shapes that do not fit, numbers that are not finite, radii below zero, or no rotation.
        """
        fixed, local = cables(anchors, attachments, 3)
        turned = rotation_matrix(rotation, "rotation")
        if turned.shape != (3, 3):
            raise InputError("rotation", f"shape {turned.shape}", "one rotation matrix (3, 3)")
        axes = np.zeros((0, 2, 3)) if stays is None else finite("stays", stays, 3)
        if axes.ndim != 3 or axes.shape[1] < 2:
            raise InputError("stays", f"shape {axes.shape}", "(k, n, 3) with two points at least")
        sizes, homes = _each("radii", radii, len(axes)), _each("own", own, len(fixed))
        if (sizes < 0.0).any():
            raise InputError("radii", f"{float(sizes.min()):g} m", "zero or more")
        if (homes != np.rint(homes)).any() or (homes < -1).any() or (homes >= max(len(axes), 1)).any():
            raise InputError("own", f"{homes.tolist()}", "the number of a stay a cable, or -1 for none")
        apart = [
            pair
            for pair in itertools.combinations(range(len(fixed)), 2)
            if not any((ends[pair[0]] == ends[pair[1]]).all() for ends in (fixed, local))
        ]
        pairs = np.array(apart, dtype=np.int64).reshape(-1, 2)
        return Surroundings(fixed, np.ascontiguousarray(local @ turned.T), pairs, axes, sizes, homes.astype(np.int64))

    @property
    def arguments(self) -> tuple[Array, Array, Integers, Array, Array, Integers]:
        """What the kernels take."""
        return self.anchors, self.arms, self.pairs, self.stays, self.radii, self.own


def interference_gaps(surroundings: Surroundings, positions: ArrayLike) -> tuple[Array, Integers]:
    """Least gap at every position, and what sets it.

    Args:
        surroundings: Cables and stays.
        positions: (..., 3) [m].

    Returns:
        Least distance of two cables, or of a cable and the surface of a stay, (...) [m], infinite where there is
        nothing to meet and not a number where a position is not finite; and which: pair ``q``, or
        ``len(pairs) + cable * k + stay``, -1 for none, (...).

    Raises:
        InputError: Positions of another shape, or no numbers.
    """
    kind("surroundings", surroundings, Surroundings)
    where = owned("positions", positions, 3)
    flat = where.reshape(-1, 3)
    gaps, causes = np.empty(len(flat)), np.empty(len(flat), dtype=np.int64)
    _gaps(*surroundings.arguments, flat, gaps, causes)
    unknown = ~np.isfinite(flat).all(axis=1)
    gaps[unknown], causes[unknown] = np.nan, -1
    return gaps.reshape(where.shape[:-1]), causes.reshape(where.shape[:-1])


@np.errstate(invalid="ignore", over="ignore")
def interference_region(
    surroundings: Surroundings, box: ArrayLike, clearance: float, gap: float = 0.05, most: int = 4_000_000
) -> CertifiedRegion:
    """Boxes of positions proved free of interference, and proved not to be.

    Args:
        surroundings: Cables and stays.
        box: Lower and upper end of each coordinate, (3, 2) [m].
        clearance: Least gap that counts as free, positive [m].
        gap: Undecided volume to reach, as a share of the volume not proved outside [1].
        most: Boxes to look at before giving up.

    Returns:
        Boxes inside (free), outside (some gap below the clearance; ``facets`` says which) and undecided.

    Raises:
        InputError: A box without volume, or a clearance that is not positive.
    """
    kind("surroundings", surroundings, Surroundings)
    low, high = search_box(box)
    positive("clearance", clearance)

    def decide(lows: Array, highs: Array) -> tuple[Integers, Integers, Integers]:
        size = highs - lows
        labels, causes = np.empty(len(lows), dtype=np.int64), np.empty(len(lows), dtype=np.int64)
        reach = 0.5 * np.linalg.norm(size, axis=1)
        _classify(*surroundings.arguments, 0.5 * (lows + highs), reach, clearance, labels, causes)
        return labels, causes, np.argmax(size, axis=1)

    return branch(decide, low, high, np.ones(3), np.zeros(3), gap, most)


@np.errstate(invalid="ignore", over="ignore")
def interference_rays(
    surroundings: Surroundings, starts: ArrayLike, ends: ArrayLike, clearance: float, tolerance: float = 1e-6
) -> Rays:
    """Cut segments of positions into pieces proved free of interference, proved not to be, and short ones between.

    Args:
        surroundings: Cables and stays.
        starts: (k, 3) or (3,) [m].
        ends: (k, 3) or (3,) [m].
        clearance: Least gap that counts as free, positive [m].
        tolerance: Length of an undecided piece over that of its segment [1].

    Returns:
        The pieces.

    Raises:
        InputError: Segments that are not finite, or a clearance or tolerance that is not positive.
    """
    kind("surroundings", surroundings, Surroundings)
    first, last = segments(starts, ends)
    positive("clearance", clearance)
    positive("tolerance", tolerance)

    def decide(ray: Integers, low: Array, high: Array) -> Integers:
        along = (last - first)[ray]
        centres = first[ray] + (0.5 * (low + high))[:, None] * along
        labels, causes = np.empty(len(ray), dtype=np.int64), np.empty(len(ray), dtype=np.int64)
        reach = 0.5 * (high - low) * np.linalg.norm(along, axis=1)
        _classify(*surroundings.arguments, centres, reach, clearance, labels, causes)
        return labels

    return subdivide(decide, first, last, tolerance)


@np.errstate(invalid="ignore", over="ignore")
def crossing_planes(surroundings: Surroundings) -> tuple[Array, Array]:
    """Planes of positions in which the two cables of each pair lie in one plane.

    Args:
        surroundings: Cables; stays do not matter.

    Returns:
        Normals (q, 3) [m2] and offsets (q,) [m3]: ``normal . p = offset``. A zero normal with a zero offset is a pair
        that lies in one plane everywhere.
    """
    kind("surroundings", surroundings, Surroundings)
    (i, j), anchors, arms = surroundings.pairs.T, surroundings.anchors, surroundings.arms
    between, roots = anchors[j] - anchors[i], anchors - arms
    normals = np.cross(between, arms[j] - arms[i])
    return normals, np.einsum("qk,qk->q", between, np.cross(roots[i], roots[j]))


@np.errstate(invalid="ignore", over="ignore")
def cable_crossings(surroundings: Surroundings, starts: ArrayLike, ends: ArrayLike) -> Array:
    """Where along segments of positions two cables meet: the critical surface of each pair, hit exactly.

    Args:
        surroundings: Cables; stays do not matter.
        starts: (k, 3) or (3,) [m].
        ends: (k, 3) or (3,) [m].

    Returns:
        Share of each segment where the cables of each pair pass through each other, (k, q) [1]; nan where they do not,
        and where they stay in one plane along the whole segment.

    Raises:
        InputError: Segments that are not finite.
    """
    first, last = segments(starts, ends)
    normals, offsets = crossing_planes(surroundings)
    rise, short = (last - first) @ normals.T, offsets - first @ normals.T
    share = np.divide(short, rise, out=np.full(short.shape, np.nan), where=rise != 0.0)
    share[~((share >= 0.0) & (share <= 1.0))] = np.nan
    positions = first[:, None] + share[..., None] * (last - first)[:, None]
    (i, j), anchors, arms = surroundings.pairs.T, surroundings.anchors, surroundings.arms
    one, other = positions + arms[i] - anchors[i], positions + arms[j] - anchors[j]
    between = anchors[j] - anchors[i]
    across = np.cross(one, other)
    size = (across**2).sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = (np.cross(between, other) * across).sum(axis=-1) / size
        along_other = (np.cross(between, one) * across).sum(axis=-1) / size
        meet = (along >= 0.0) & (along <= 1.0) & (along_other >= 0.0) & (along_other <= 1.0)
    return np.where(meet, share, np.nan)


@np.errstate(invalid="ignore", over="ignore")
def platform_overlap(
    anchors: ArrayLike,
    attachments: ArrayLike,
    positions: ArrayLike,
    rotations: ArrayLike,
    normals: ArrayLike,
    offsets: ArrayLike,
) -> Array:
    """Length of every cable inside a convex platform ``{x : normal . x <= offset}`` (Cyrus and Beck, 1978).

    A cable within `ALONG` of a face's direction counts as parallel to it, and one along a face as outside.

    Args:
        anchors: (m, 3) [m].
        attachments: In the platform frame, (m, 3) [m].
        positions: (..., 3) [m].
        rotations: From platform to world, (..., 3, 3).
        normals: Of the faces, outward, unit length, platform frame, (h, 3) [1].
        offsets: Of the faces from the platform's reference point, (h,) [m].

    Returns:
        Lengths, (..., m) [m]; 0 where a cable leaves the platform at once, or does not reach it; not a number where a
        pose is none.

    Raises:
        InputError: Shapes or numbers that cannot be meant, normals not of unit length, or one matrix that is no
            rotation.
    """
    fixed, local = cables(anchors, attachments, 3)
    faces, reach = points("normals", normals, 3), finite("offsets", offsets)
    if not len(faces) or reach.shape != faces.shape[:1]:
        raise InputError("platform", f"{len(faces)} normals and offsets {reach.shape}", "one offset a face")
    if not np.allclose(np.linalg.norm(faces, axis=1), 1.0, rtol=0.0, atol=1e-6):
        raise InputError("normals", "a length other than 1", "unit vectors")
    where, turned = owned("positions", positions, 3), rotation_matrices("rotations", rotations)
    leading(("positions", where.shape, 1), ("rotations", turned.shape, 2))
    away = fixed - where[..., None, :]
    runs = away @ turned - local  # in the platform frame
    depth = reach - local @ faces.T
    size = ON_SURFACE * float(np.abs(reach).max())
    depth = np.where(np.abs(depth) <= size, 0.0, depth)
    rate = runs @ faces.T
    rate = np.where(np.abs(rate) <= ALONG * np.linalg.norm(runs, axis=-1, keepdims=True), 0.0, rate)
    with np.errstate(divide="ignore", invalid="ignore"):
        place = depth / rate
    enter = np.where(rate < 0.0, place, -np.inf).max(axis=-1, initial=0.0)
    leave = np.where(rate > 0.0, place, np.inf).min(axis=-1, initial=1.0)
    missed = ((rate == 0.0) & (depth <= 0.0)).any(axis=-1)
    share = np.where(missed, 0.0, np.maximum(leave - np.maximum(enter, 0.0), 0.0))
    return share * np.linalg.norm(runs, axis=-1)


def box_faces(low: ArrayLike, high: ArrayLike) -> tuple[Array, Array]:
    """Faces of a box-shaped platform.

    Args:
        low: Lower corner in the platform frame, (3,) [m].
        high: Upper corner, (3,) [m].

    Returns:
        Outward normals (6, 3) [1] and offsets (6,) [m].

    Raises:
        InputError: Corners that are no finite points, or a lower one above the upper.
    """
    least, most = finite("low", low, 3), finite("high", high, 3)
    if least.shape != (3,) or most.shape != (3,) or not (least <= most).all():
        raise InputError("box", f"{least.tolist()} to {most.tolist()} m", "a lower and an upper corner, (3,) each")
    return np.concatenate((np.eye(3), -np.eye(3))), np.concatenate((most, -least))


def _each(where: str, values: ArrayLike, count: int) -> Array:
    """One finite number each, (count,)."""
    given = finite(where, values)
    try:
        return np.array(np.broadcast_to(given, (count,)))
    except ValueError:
        raise InputError(where, f"shape {given.shape}", f"a number or ({count},)") from None


@njit(cache=True)
def _least(
    anchors: Array, arms: Array, pairs: Integers, stays: Array, radii: Array, own: Integers, position: Array,
    limit: float, ends: Array,
) -> tuple[float, int, float]:  # fmt: skip
    """Least gap, what sets it, and the longest cable; stops at the first gap below ``limit`` with room to spare."""
    least, cause, longest = np.inf, -1, 0.0
    for i in range(anchors.shape[0]):
        square = 0.0
        for k in range(3):
            ends[i, k] = position[k] + arms[i, k]
            square += (anchors[i, k] - ends[i, k]) ** 2
        longest = max(longest, math.sqrt(square))
    enough = limit - PARALLEL * longest
    for q in range(pairs.shape[0]):
        i, j = pairs[q, 0], pairs[q, 1]
        distance = segment_distance(anchors[i], ends[i], anchors[j], ends[j])
        if distance < least:
            least, cause = distance, q
            if least < enough:
                return least, cause, longest
    gap, cable, stay = nearest_stay(anchors, ends, stays, radii, own, enough)
    if gap < least:
        least, cause = gap, pairs.shape[0] + cable * stays.shape[0] + stay
    return least, cause, longest


@njit(cache=True)
def _gaps(
    anchors: Array, arms: Array, pairs: Integers, stays: Array, radii: Array, own: Integers,
    positions: Array, gaps: Array, causes: Integers,
) -> None:  # fmt: skip
    """Least gap and its cause at every position."""
    ends = np.empty_like(anchors)
    for b in range(positions.shape[0]):
        gaps[b], causes[b], _ = _least(anchors, arms, pairs, stays, radii, own, positions[b], -np.inf, ends)


@njit(cache=True)
def _classify(
    anchors: Array, arms: Array, pairs: Integers, stays: Array, radii: Array, own: Integers,
    centres: Array, reaches: Array, clearance: float, labels: Integers, causes: Integers,
) -> None:  # fmt: skip
    """Decide balls of positions, middles (b, 3) and radii (b,)."""
    ends = np.empty_like(anchors)
    for b in range(centres.shape[0]):
        reach = reaches[b] * (1.0 + PARALLEL)
        least, cause, longest = _least(anchors, arms, pairs, stays, radii, own, centres[b], clearance - reach, ends)
        reach += PARALLEL * longest
        labels[b], causes[b] = UNDECIDED, -1
        if least - reach >= clearance:
            labels[b] = INSIDE
        elif least + reach < clearance:
            labels[b], causes[b] = OUTSIDE, cause
