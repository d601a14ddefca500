"""Wrench closure and feasibility of whole regions as signs of polynomials, with exact coefficients.

With columns left un-normalised, ``c_i = l_i a_i``, every determinant of n columns is a low polynomial of the pose (see
`determinants`). ``n - 1`` columns ``J`` span a hyperplane with normal ``z_J`` (for n = 3 their cross product), and
``z_J . c_i`` is the determinant of ``J`` and ``i``. Where the structure matrix has rank n,

- wrench closure holds exactly where, for every independent ``J``, the ``z_J . c_i`` take both strict signs;
- tensions ``lower <= f <= upper`` balance a wrench ``w`` exactly where, for every independent ``J`` and either sign,
  ``max_f +-z_J . (structure f + w) >= 0``: the facets of the zonotope of available wrenches (Bouchard, Gosselin and
  Moore, On the Ability of a Cable-Driven Robot to Generate a Prescribed Set of Wrenches, J. Mechanisms Robotics 2,
  011010, 2010; Gouttefarde and Krut, Characterization of Parallel Manipulator Available Wrench Set Facets, ARK 2010).

A condition that fails is a certificate, ``z = +-z_J``.

Degeneracy. "This determinant is zero everywhere" is a fact of whole numbers here, not a tolerance: a ``J`` whose
determinants all vanish (cables that share both ends, four through one point in space) spans no hyperplane and is left
out. A robot whose determinants all vanish is singular everywhere and is refused. A pose where some cable has no length
is never decided for feasibility. At poses of lower rank inside a feasible region tensions exist (the feasible set is
closed), though an arbitrarily small disturbance may not be resisted.

What counts as given, exactly: anchors, limits and wrenches as stored; planar attachments as stored, turned by phi;
spatial arms as the product, without rounding, of attachments as stored and the rotation with its entries as multiples
of 2^-53. So attachments on one line are on one line at every orientation. In space every bound also allows for the
rounding with which anchors, attachments and rotation were stored (`rounding`), so determinants that would vanish but
for it are never decided. Lengths and forces are in units of a power of two near
the largest, and positions count from the anchors' middle, so units and origin do not matter.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import finite, open_limits, points
from steeplejack.mechanics.cable.region import determinants
from steeplejack.spatial.rotation import rotation_matrix

Array = NDArray[np.float64]

MOST_DETERMINANTS = 6_000
"""In whole numbers, a few milliseconds each in space [1]."""
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Facets:
    """A question about a robot as polynomials of the pose, in scaled units; `certify` and `certified_rays` answer it.

    Attributes:
        planar: Whether the pose is ``(x, y, phi)``; else it is ``(x, y, z)`` at one orientation.
        length: One scaled unit of length, a power of two [m].
        origin: Pose that scaled poses count from, (3,) [m]; zero for phi.
        anchors: Scaled, from the origin, (m, 2) or (m, 3).
        arms: Attachments, scaled, (m, 2) in the platform frame or (m, 3) in world axes.
        volumes: Coefficients of the determinants of n columns, (t, 6, 5) planar or (t, 20, 1) spatial.
        loads: Coefficients of the determinants of n - 1 columns and a wrench, (k, s, ...); k = 0 for wrench closure.
        subsets: The n - 1 cables of every hyperplane, (s, n - 1).
        others: The cables beside them, (s, m - n + 1).
        volume_of: Which determinant each of those makes with the subset, (s, m - n + 1).
        signs: And its sign, (s, m - n + 1).
        lower: Least tensions over the force unit, (m,); none for wrench closure.
        upper: Greatest tensions over the force unit, (m,); none for wrench closure.
        wrenches: Scaled, (k, 3) or (k, 6); none for wrench closure.
    """

    planar: bool
    length: float
    origin: Array
    anchors: Array
    arms: Array
    volumes: Array
    loads: Array
    subsets: Integers
    others: Integers
    volume_of: Integers
    signs: Array
    lower: Array
    upper: Array
    wrenches: Array

    @property
    def limited(self) -> bool:
        """Whether the question is feasibility within tension limits; else it is wrench closure."""
        return self.lower.size > 0

    @property
    def units(self) -> Array:
        """One scaled unit of each coordinate of the pose, (3,) [m, m, rad] or [m, m, m]."""
        return np.array([self.length, self.length, 1.0 if self.planar else self.length])


def planar_facets(
    anchors: ArrayLike,
    attachments: ArrayLike,
    wrenches: ArrayLike | None = None,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
) -> Facets:
    """Wrench closure of a planar robot over ``(x, y, phi)``, or with limits its feasibility.

    Args:
        anchors: (m, 2), m >= 4; with limits m >= 3 [m].
        attachments: In the platform frame, (m, 2) [m].
        wrenches: Wrenches ``(fx, fy, mz)`` on the platform that must each be balanced, (k, 3) or (3,) [N, N, N m]; with
            limits, zero if None.
        lower: Least tensions, (m,) or a scalar [N].
        upper: Greatest tensions, (m,) or a scalar, above the least [N].

    Returns:
        The question as polynomials.

    Raises:
        InputError: Shapes or numbers that cannot be meant, a robot that is singular at every pose, or cables that make
            more than `MOST_DETERMINANTS`: from 35 on, with limits from 34.
    """
    fixed, local = points("anchors", anchors, 2), points("attachments", attachments, 2)
    limits = _limits(lower, upper, len(fixed))
    sets = _Sets.of(fixed, local, 3, limits is not None)
    geometry = _Geometry.of(fixed, local)
    volumes = determinants.planar_volumes(geometry.roots, geometry.offsets, geometry.shift, sets.wholes)
    loads, given = np.empty((0, len(sets.subsets), 6, 5)), np.empty((0, 3))
    if limits is not None:
        given, scaled, wrench_shift = _wrenches(wrenches, 3, (2,), limits, geometry)
        loads = np.array(
            [
                determinants.planar_loads(*geometry.exact, sets.subsets, [fx, fy, mz], wrench_shift)
                for fx, fy, mz in scaled
            ]
        )
    return _facets(True, geometry, sets, volumes, loads, limits, given)


def spatial_facets(
    anchors: ArrayLike,
    attachments: ArrayLike,
    rotation: ArrayLike,
    wrenches: ArrayLike | None = None,
    lower: ArrayLike | None = None,
    upper: ArrayLike | None = None,
) -> Facets:
    """Wrench closure of a spatial robot over ``(x, y, z)`` at one orientation, or with limits its feasibility.

    Args:
        anchors: (m, 3), m >= 7; with limits m >= 6 [m].
        attachments: In the platform frame, (m, 3) [m].
        rotation: From platform to world, (3, 3).
        wrenches: Wrenches (moment; force) on the platform, moments about its reference point, that must each be
            balanced, (k, 6) or (6,) [N m, N]; with limits, zero if None.
        lower: Least tensions, (m,) or a scalar [N].
        upper: Greatest tensions, (m,) or a scalar, above the least [N].

    Returns:
        The question as polynomials.

    Raises:
        InputError: Shapes or numbers that cannot be meant, a robot that is singular at every position, or cables that
            make more than `MOST_DETERMINANTS`: from 16 on, with limits from 15.
    """
    fixed, local = points("anchors", anchors, 3), points("attachments", attachments, 3)
    turned = rotation_matrix(rotation, "rotation")
    if turned.shape != (3, 3):
        raise InputError("rotation", f"shape {turned.shape}", "one rotation matrix (3, 3)")
    limits = _limits(lower, upper, len(fixed))
    sets = _Sets.of(fixed, local, 6, limits is not None)
    geometry = _Geometry.of(fixed, local, turned)
    volumes = determinants.spatial_volumes(geometry.roots, geometry.offsets, geometry.shift, sets.wholes)
    loads, given = np.empty((0, len(sets.subsets), 20, 1)), np.empty((0, 6))
    if limits is not None:
        given, scaled, wrench_shift = _wrenches(wrenches, 6, (0, 1, 2), limits, geometry)
        loads = np.array(
            [determinants.spatial_loads(*geometry.exact, sets.subsets, load, wrench_shift) for load in scaled]
        )
    return _facets(False, geometry, sets, volumes, loads, limits, given)


@dataclass(frozen=True)
class _Sets:
    """Which cables make which determinants."""

    wholes: list[tuple[int, ...]]
    subsets: list[tuple[int, ...]]
    others: list[list[int]]

    @staticmethod
    def of(anchors: Array, attachments: Array, rows: int, limited: bool) -> _Sets:
        count, least = len(anchors), rows + (0 if limited else 1)
        if len(attachments) != count or count < least:
            raise InputError(
                "cables", f"{count} anchors and {len(attachments)} attachments", f"as many of each, {least} at least"
            )
        determinants = math.comb(count, rows) + limited * math.comb(count, rows - 1)
        if determinants > MOST_DETERMINANTS:
            other = "`planar_feasibility_map`" if rows == 3 else "`certify_poses`"
            raise InputError(
                "cables", f"{count}, which make {determinants} determinants", f"{MOST_DETERMINANTS} at most; {other}"
            )
        subsets = list(itertools.combinations(range(count), rows - 1))
        others = [[i for i in range(count) if i not in subset] for subset in subsets]
        return _Sets(list(itertools.combinations(range(count), rows)), subsets, others)


@dataclass(frozen=True)
class _Geometry:
    """Anchors and arms in units of a power of two, from the anchors' middle, as doubles and as integers."""

    length: float
    origin: Array
    anchors: Array
    arms: Array
    roots: determinants.Points
    offsets: determinants.Points
    shift: int

    @staticmethod
    def of(anchors: Array, attachments: Array, rotation: Array | None = None) -> _Geometry:
        origin = anchors.min(axis=0) + 0.5 * np.ptp(anchors, axis=0)
        reach = max(float(np.abs(anchors - origin).max()), float(np.abs(attachments).max()))
        if not 0.0 < reach < math.inf:
            raise InputError("anchors", f"within {reach:g} m of each other", "apart, at finite distance")
        length = _power(reach)
        local = attachments / length
        exact = determinants.differences(local) if rotation is None else determinants.turned(local, rotation)
        (roots, offsets), shift = determinants.integers(
            determinants.differences(anchors / length, origin / length), exact
        )
        arms = local if rotation is None else np.ascontiguousarray(local @ rotation.T)
        return _Geometry(length, origin, (anchors - origin) / length, arms, roots, offsets, shift)

    @property
    def exact(self) -> tuple[determinants.Points, determinants.Points, int]:
        """Integers of anchors and arms, and the power of two they are over."""
        return self.roots, self.offsets, self.shift


def _facets(
    planar: bool,
    geometry: _Geometry,
    sets: _Sets,
    volumes: Array,
    loads: Array,
    limits: tuple[Array, Array] | None,
    wrenches: Array,
) -> Facets:
    """Leave out what spans no hyperplane, and put the tables together."""
    if not volumes.any():
        raise InputError("cables", "singular at every pose", "attachments and anchors that resist every wrench")
    place = {whole: index for index, whole in enumerate(sets.wholes)}
    whole_of = np.array(
        [[place[tuple(sorted((*s, i)))] for i in rest] for s, rest in zip(sets.subsets, sets.others, strict=True)]
    )
    signs = np.array(
        [[(-1.0) ** sum(j > i for j in s) for i in rest] for s, rest in zip(sets.subsets, sets.others, strict=True)]
    )
    spans = np.any(volumes, axis=(1, 2))[whole_of].any(axis=1)
    force = _power(float(np.abs(limits).max())) if limits is not None else 1.0
    lower, upper = (limit / force for limit in limits) if limits is not None else (np.empty(0), np.empty(0))
    return Facets(
        planar=planar,
        length=geometry.length,
        origin=np.append(geometry.origin, 0.0)[:3],
        anchors=geometry.anchors,
        arms=geometry.arms,
        volumes=volumes,
        loads=np.ascontiguousarray(loads[:, spans]),
        subsets=np.array(sets.subsets)[spans],
        others=np.array(sets.others)[spans],
        volume_of=whole_of[spans],
        signs=signs[spans],
        lower=lower,
        upper=upper,
        wrenches=wrenches,
    )


def _limits(lower: ArrayLike | None, upper: ArrayLike | None, cables: int) -> tuple[Array, Array] | None:
    """Least and greatest tensions, each (m,); None without limits."""
    if lower is None and upper is None:
        return None
    if lower is None or upper is None:
        raise InputError("tension limits", "one of the two", "least and greatest, or neither")
    return open_limits(lower, upper, cables)


def _wrenches(
    wrenches: ArrayLike | None, rows: int, moments: tuple[int, ...], limits: tuple[Array, Array], geometry: _Geometry
) -> tuple[Array, list[list[int]], int]:
    """Wrenches in scaled units, as doubles and as integers, and the shift.

    Integer forces are over ``2^shift``, moments over ``2^(shift + geometry.shift)``.
    """
    loads = np.atleast_2d(finite("wrenches", np.zeros(rows) if wrenches is None else wrenches, rows))
    if loads.ndim != 2 or not len(loads):
        raise InputError("wrenches", f"shape {loads.shape}", f"shape (k, {rows})")
    scaled = loads / _power(float(np.abs(limits).max()))
    scaled[:, moments] /= geometry.length
    (exact,), shift = determinants.integers(determinants.differences(scaled))
    return scaled, [[v << geometry.shift if i in moments else v for i, v in enumerate(load)] for load in exact], shift


def _power(size: float) -> float:
    """The power of two at or below a positive number."""
    return math.ldexp(1.0, math.frexp(size)[1] - 1)
