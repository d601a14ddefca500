"""The boundary of a workspace along rays: roots, not samples.

Two routes, each for any number of cables:

- `closure_rays`, wrench closure. Along a line of positions every determinant of un-normalised columns is a polynomial
  in the ray's parameter: quadratic in the plane, cubic in space at one orientation. Along a turn of a planar platform
  it is a quartic in the tangent of half the angle. All real roots are isolated between the extrema of the polynomial
  and refined to rounding; the pieces between them, where no determinant changes sign, are judged in the middle.
- `certified_rays`, wrench closure or wrench feasibility with tension limits, planar or spatial, along any segment of
  poses: subdivision with bounds (`enclosure`) until what is undecided is shorter than asked. What it calls inside or
  outside is proved.

Touching without crossing does not end a piece for `closure_rays`, and is a short undecided one for `certified_rays`. A
segment that runs along the boundary, or through singular poses only, stays undecided there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import finite, kind, positive
from steeplejack.mechanics.cable.region import enclosure
from steeplejack.mechanics.cable.region.certified import Label, arguments
from steeplejack.mechanics.cable.region.determinants import CUBIC
from steeplejack.mechanics.cable.region.facets import Facets

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

OUTSIDE, INSIDE, UNDECIDED = enclosure.OUTSIDE, enclosure.INSIDE, enclosure.UNDECIDED

OPEN = 256
"""Most undecided pieces of one certified ray at a time; beyond, it runs along the boundary and is left undecided."""


@dataclass(frozen=True, eq=False)
class Rays:
    """Segments of poses cut into pieces.

    Attributes:
        starts: Where each segment begins, (k, 3) [m, m, rad] or [m, m, m].
        ends: Where it ends, (k, 3).
        places: Ends of the pieces as shares of the segment, ascending from 0 to 1, (k, p + 1) [1]; nan beyond the last.
        labels: `Label` of each piece by number, (k, p); -1 beyond the last.
    """

    starts: Array
    ends: Array
    places: Array
    labels: Integers

    def share(self, label: Label) -> Array:
        """Share of each segment with a label, (k,) [1]."""
        return np.where(self.labels == label, np.diff(self.places, axis=1), 0.0).sum(axis=1)

    def crossings(self, ray: int) -> Array:
        """Poses where a ray crosses the boundary, the middle of an undecided piece between unlike ones, (c, 3)."""
        labels = self.labels[ray][self.labels[ray] >= 0]
        places = self.places[ray]
        where: list[float] = []
        for k in range(1, len(labels)):
            if Label.UNDECIDED not in (labels[k - 1], labels[k]):
                where.append(places[k])
            elif labels[k] == Label.UNDECIDED and k + 1 < len(labels) and labels[k - 1] != labels[k + 1]:
                where.append(0.5 * (places[k] + places[k + 1]))
        start, end = self.starts[ray], self.ends[ray]
        return start + np.array(where).reshape(-1, 1) * (end - start)


@np.errstate(invalid="ignore", over="ignore")
def closure_rays(facets: Facets, starts: ArrayLike, ends: ArrayLike) -> Rays:
    """Cut segments where wrench closure begins and ends, by the roots of the determinants.

    Args:
        facets: Wrench closure of a robot.
        starts: (k, 3) or (3,) [m, m, rad] or [m, m, m].
        ends: (k, 3) or (3,); if planar, each segment moves or turns, not both, and turns by at most pi.

    Returns:
        The pieces, inside or outside; undecided where it takes a determinant that is nothing but rounding all along.

    Raises:
        InputError: A question with tension limits, segments that move and turn at once, or are not finite.
    """
    if kind("facets", facets, Facets).limited:
        raise InputError("facets", "tension limits", "wrench closure; use certified_rays")
    first, last = segments(starts, ends)
    low, high = (first - facets.origin) / facets.units, (last - facets.origin) / facets.units
    turning = facets.planar and bool((low[:, 2] != high[:, 2]).any())
    if turning and ((low[:, :2] != high[:, :2]).any() or (np.abs(high[:, 2] - low[:, 2]) > math.pi).any()):
        raise InputError("rays", "moves and turns at once, or turns by more than pi", "positions, or one turn each")
    degree = 4 if turning else 2 if facets.planar else 3
    shares, span = _nodes(low, high, degree, turning)
    poses = low[:, None] + shares[..., None] * (high - low)[:, None]
    values = _values(facets, poses)
    both = np.concatenate((low, high))
    slack = arguments(facets, both.min(axis=0), both.max(axis=0))[4]
    silent = (np.abs(values) <= slack).all(axis=1) & (values != 0.0).any(axis=1)
    if turning:
        values *= (1.0 + (np.linspace(-1.0, 1.0, degree + 1) * span[:, None])[..., None] ** 2) ** 2
    vandermonde = np.vander(np.linspace(-1.0, 1.0, degree + 1), increasing=True)
    polynomials = np.ascontiguousarray(np.einsum("dn,knt->ktd", np.linalg.inv(vandermonde), values))
    places = np.full((len(first), degree * len(facets.volumes) + 2), np.nan)
    labels = np.full((len(first), places.shape[1] - 1), -1)
    _cut_all(polynomials, silent, span, turning, facets.volume_of, facets.signs, places, labels)
    used = int((labels >= 0).sum(axis=1).max())
    return Rays(first, last, places[:, : used + 1], labels[:, :used])


@np.errstate(invalid="ignore", over="ignore")
def certified_rays(facets: Facets, starts: ArrayLike, ends: ArrayLike, tolerance: float = 1e-12) -> Rays:
    """Cut segments of poses into pieces proved inside, proved outside, and short undecided ones between.

    Args:
        facets: The question, from `planar_facets` or `spatial_facets`.
        starts: (k, 3) or (3,) [m, m, rad] or [m, m, m].
        ends: (k, 3) or (3,).
        tolerance: Length of an undecided piece over that of its segment [1].

    Returns:
        The pieces.

    Raises:
        InputError: Segments that are not finite, or a tolerance that is not positive.
    """
    first, last = segments(starts, ends)
    positive("tolerance", tolerance)
    kind("facets", facets, Facets)
    start, end = (first - facets.origin) / facets.units, (last - facets.origin) / facets.units
    both = np.concatenate((start, end))
    question = arguments(facets, both.min(axis=0), both.max(axis=0))

    def decide(ray: Integers, low: Array, high: Array) -> Integers:
        along = (end - start)[ray]
        centres = start[ray] + (low + 0.5 * (high - low))[:, None] * along
        halves = (0.5 * (1.0 + 2.0**-50) * (high - low))[:, None] * along
        labels, proofs, cuts = (np.empty(len(ray), dtype=np.int64) for _ in range(3))
        enclosure.classify(*question, centres, halves, True, np.ones(3), labels, proofs, cuts)
        return labels

    return subdivide(decide, first, last, tolerance)


def subdivide(
    decide: Callable[[Integers, Array, Array], Integers], starts: Array, ends: Array, tolerance: float
) -> Rays:
    """Decide pieces of segments, halve the undecided ones, level by level, until they are short.

    Args:
        decide: Labels of pieces (p,): number of the segment, and both ends as shares of it.
        starts: (k, 3) [m, m, rad] or [m, m, m].
        ends: (k, 3) [m, m, rad] or [m, m, m].
        tolerance: Longest undecided piece as a share of its segment [1].

    Returns:
        The pieces, neighbours of one label joined.
    """
    ray, low, high = np.arange(len(starts)), np.zeros(len(starts)), np.ones(len(starts))
    done: list[tuple[Integers, Array, Array, Integers]] = []
    while len(ray):
        labels = decide(ray, low, high)
        middle = low + 0.5 * (high - low)
        doubtful = labels == Label.UNDECIDED
        crowded = np.bincount(ray[doubtful], minlength=len(starts)) > OPEN
        cut = doubtful & (high - low > tolerance) & (low < middle) & (middle < high) & ~crowded[ray]
        done.append((ray[~cut], low[~cut], high[~cut], labels[~cut]))
        ray = np.tile(ray[cut], 2)
        low, high = np.concatenate((low[cut], middle[cut])), np.concatenate((middle[cut], high[cut]))
    ray, low, high, labels = (np.concatenate(part) for part in zip(*done, strict=True))
    order = np.lexsort((low, ray))
    ray, high, labels = ray[order], high[order], labels[order]
    last = np.append((ray[1:] != ray[:-1]) | (labels[1:] != labels[:-1]), True)
    ray, high, labels = ray[last], high[last], labels[last]
    count = np.bincount(ray, minlength=len(starts))
    column = np.arange(len(ray)) - (np.cumsum(count) - count)[ray]
    places, kinds = np.full((len(starts), count.max() + 1), np.nan), np.full((len(starts), count.max()), -1)
    places[:, 0] = 0.0
    places[ray, column + 1], kinds[ray, column] = high, labels
    return Rays(starts, ends, places, kinds)


def segments(starts: ArrayLike, ends: ArrayLike) -> tuple[Array, Array]:
    """Both ends of every segment, (k, 3), finite."""
    low, high = (np.atleast_2d(finite("rays", end, 3)) for end in (starts, ends))
    try:
        first, last = np.broadcast_arrays(low, high)
    except ValueError:
        raise InputError("rays", f"ends of shapes {low.shape} and {high.shape}", "as many of each, (k, 3)") from None
    if first.ndim != 2 or not len(first):
        raise InputError("rays", f"ends of shape {first.shape}", "one segment or more between finite poses, (k, 3)")
    return first.copy(), last.copy()


def _nodes(low: Array, high: Array, degree: int, turning: bool) -> tuple[Array, Array]:
    """Shares of each segment that interpolation uses, (k, degree + 1), and the tangent of half of half the turn."""
    nodes = np.linspace(-1.0, 1.0, degree + 1)
    span = np.tan(0.25 * np.abs(high[:, 2] - low[:, 2])) if turning else np.ones(len(low))
    if not turning:
        return np.broadcast_to(0.5 + 0.5 * nodes, (len(low), degree + 1)), span
    still = span == 0.0
    turned = 2.0 * np.arctan(nodes * span[:, None]) / np.where(still, 1.0, np.abs(high[:, 2] - low[:, 2]))[:, None]
    return 0.5 + turned, span


def _values(facets: Facets, poses: Array) -> Array:
    """Determinants at scaled poses, (k, n, t)."""
    x, y, z = np.moveaxis(poses, -1, 0)
    if not facets.planar:
        monomials = np.stack([x**i * y**j * z**k for i, j, k in CUBIC], axis=-1)
        return monomials @ facets.volumes[:, :, 0].T
    monomials = np.stack((np.ones_like(x), x, y, x * x, x * y, y * y), axis=-1)
    harmonics = np.stack((np.ones_like(z), np.cos(z), np.sin(z), np.cos(2.0 * z), np.sin(2.0 * z)), axis=-1)
    products = (monomials[..., :, None] * harmonics[..., None, :]).reshape(*x.shape, 30)
    return products @ facets.volumes.reshape(-1, 30).T


@njit(cache=True, error_model="numpy")
def _cut_all(
    polynomials: Array, silent: NDArray[np.bool_], span: Array, turning: bool,
    volume_of: Integers, signs: Array, places: Array, labels: Integers,
) -> None:  # fmt: skip
    """Pieces of every ray; polynomials (k, t, degree + 1) over [-1, 1], those without a sure sign silent (k, t)."""
    rays, count, size = polynomials.shape
    found, extrema, derived = np.empty(count * (size - 1) + 2), np.empty(size + 1), np.empty((size, size))
    for ray in range(rays):
        total = 1
        found[0] = -1.0
        for t in range(count):
            many = 0 if silent[ray, t] else _roots(polynomials[ray, t], derived, extrema)
            for k in range(many):
                if -1.0 < extrema[k] < 1.0:
                    place = total
                    while found[place - 1] > extrema[k]:
                        found[place] = found[place - 1]
                        place -= 1
                    found[place] = extrema[k]
                    total += 1
        found[total] = 1.0
        pieces = 0
        places[ray, 0] = 0.0
        for k in range(total):
            low, high = found[k], found[k + 1]
            if high <= low:
                continue
            label = _label(polynomials[ray], silent[ray], 0.5 * (low + high), volume_of, signs)
            if pieces == 0 or labels[ray, pieces - 1] != label:
                labels[ray, pieces] = label
                pieces += 1
            places[ray, pieces] = _share(high, span[ray], turning)


@njit(cache=True, error_model="numpy")
def _share(place: float, span: float, turning: bool) -> float:
    """Share of the segment at a place in [-1, 1]; tangents of half the angle where turning."""
    if not turning or span == 0.0:
        return 0.5 + 0.5 * place
    return 0.5 + 0.5 * math.atan(place * span) / math.atan(span)


@njit(cache=True, error_model="numpy")
def _label(polynomials: Array, silent: NDArray[np.bool_], place: float, volume_of: Integers, signs: Array) -> int:
    """Whether all hyperplanes have columns on both sides."""
    label = INSIDE
    for s in range(volume_of.shape[0]):
        positive = negative = doubtful = False
        for a in range(volume_of.shape[1]):
            if silent[volume_of[s, a]]:
                doubtful = True
                continue
            value = signs[s, a] * _horner(polynomials[volume_of[s, a]], polynomials.shape[1] - 1, place)
            positive |= value > 0.0
            negative |= value < 0.0
        if positive and negative:
            continue
        if not doubtful:
            return OUTSIDE
        label = UNDECIDED
    return label


@njit(cache=True, error_model="numpy")
def _horner(polynomial: Array, degree: int, x: float) -> float:
    value = polynomial[degree]
    for k in range(degree - 1, -1, -1):
        value = value * x + polynomial[k]
    return value


@njit(cache=True, error_model="numpy")
def _roots(polynomial: Array, derived: Array, roots: Array) -> int:
    """Real roots in [-1, 1] where the sign changes, ascending, of a polynomial with ascending coefficients.

    The roots of each derivative split the interval into pieces on which the next one up is monotone.
    """
    degree = polynomial.size - 1
    derived[degree, : degree + 1] = polynomial
    for order in range(degree, 1, -1):
        for k in range(order):
            derived[order - 1, k] = (k + 1) * derived[order, k + 1]
    many = 0
    for order in range(1, degree + 1):
        many = _next_roots(derived[order], order, roots, many)
    return many


@njit(cache=True, error_model="numpy")
def _next_roots(polynomial: Array, degree: int, roots: Array, extrema: int) -> int:
    """Replace the roots of the derivative by those of the polynomial itself."""
    low, low_value, many = -1.0, _horner(polynomial, degree, -1.0), 0
    for k in range(extrema + 1):
        high = roots[k] if k < extrema else 1.0
        value = _horner(polynomial, degree, high)
        if low_value * value < 0.0 or (value == 0.0 and low_value != 0.0):
            roots[many] = _between(polynomial, degree, low, high, low_value)
            many += 1
        low, low_value = high, value
    return many


@njit(cache=True, error_model="numpy")
def _between(polynomial: Array, degree: int, low: float, high: float, low_value: float) -> float:
    """The one root between two ends of unlike sign, to rounding: Newton steps, halving where they leave."""
    place = 0.5 * (low + high)
    for step in range(120):
        value, slope = polynomial[degree], 0.0
        for k in range(degree - 1, -1, -1):
            slope = slope * place + value
            value = value * place + polynomial[k]
        if value == 0.0:
            return place
        if (value < 0.0) == (low_value < 0.0):
            low = place
        else:
            high = place
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        guess = place - value / slope if slope != 0.0 else middle
        if step < 20 and low < guess < high and guess != place:
            place = guess
        elif step < 20 and abs(guess - place) <= 2.0**-52 * abs(place):
            return place
        else:
            place = middle
    return place
