"""Compiled bounds of facets' polynomials over boxes and segments of poses; `certified` and `boundary` are their faces.

A function over the poses ``centre + d`` is held as ``value + slope . d`` and a bound of the rest (a Taylor model of
first order), so its bounds are sharp to second order in the size of the box:

- a determinant is a polynomial: its second derivatives are bounded by what their coefficients allow over the box;
- ``1 / l_i`` has second derivative at most ``2 rho^2 / l^3 + |v''| / l^2`` along a path on which the cable vector moves
  at rate ``rho`` and bends by ``v''``; ``l`` at its least in the box;
- sums and products of such models are models again, and slopes cancel in a sum before its bounds are taken.

Rounding. Every bound gets ``2^-42`` of the sum of the absolute terms of its polynomial over the whole search box, which
exceeds the error of the fewer than 200 operations behind it (each at most ``2^-53`` of that sum; Higham, Accuracy and
Stability of Numerical Algorithms, 2002, section 3.1).

Everything is in scaled units (`facets`). Poses have three coordinates; a fixed one has no width. All compiled code of
regions and rays is in this file because numba's disk cache notices changes in a function's own file only.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

OUTSIDE, INSIDE, UNDECIDED = range(3)
ROUNDING = 2.0**-42
"""Rounding error of a bound over the sum of its absolute terms [1]."""

THIN = 1.0 / 64.0
"""A side shorter than this share of the longest one, both relative to the search box, is not cut [1]."""


@njit(cache=True, error_model="numpy")
def classify(
    planar: bool, anchors: Array, arms: Array, polynomials: Array, slack: Array, wrenches: int,
    others: Integers, volume_of: Integers, signs: Array, lower: Array, upper: Array,
    centres: Array, halves: Array, straight: bool, root: Array, labels: Integers, facets: Integers, cuts: Integers,
) -> None:  # fmt: skip
    """Decide boxes or segments of poses: inside, outside with the facet that proves it, or which side to cut.

    Args:
        planar: Whether the pose is (x, y, phi).
        anchors: (m, 2) or (m, 3).
        arms: (m, 2) in the platform frame or (m, 3) in world axes.
        polynomials: Determinants of n columns, then for every wrench those of the s hyperplanes and the wrench; planar
            (t + k s, 6, 5), or (t + k s, 6, 1) at one angle, or spatial (t + k s, 20, 1).
        slack: Rounding error of each, (t + k s,).
        wrenches: How many wrenches, k; 0 for wrench closure.
        others: (s, r + 1).
        volume_of: (s, r + 1).
        signs: (s, r + 1).
        lower: (m,), or none for wrench closure.
        upper: (m,), or none for wrench closure.
        centres: Middles, (b, 3).
        halves: Half sides of boxes, not negative, or from the middles of segments to their ends, (b, 3).
        straight: Whether they are segments.
        root: Half sides of the search box, (3,).
        labels: Written, (b,).
        facets: Written, (b,): ``2 s`` or ``2 s + 1`` where outside, the hyperplane and its side; else -1.
        cuts: Written, (b,): the side to cut where undecided; else -1.
    """
    models, inverse = np.empty((len(polynomials), 5)), np.empty((len(anchors), 5))
    weights = np.empty(3)
    for b in range(centres.shape[0]):
        labels[b], facets[b] = _judge(
            planar, anchors, arms, polynomials, slack, wrenches, others, volume_of, signs, lower, upper,
            centres[b], halves[b], straight, models, inverse, weights,
        )  # fmt: skip
        cuts[b] = _cut(halves[b], root, weights) if labels[b] == UNDECIDED else -1


@njit(cache=True, error_model="numpy")
def _judge(
    planar: bool, anchors: Array, arms: Array, polynomials: Array, slack: Array, wrenches: int,
    others: Integers, volume_of: Integers, signs: Array, lower: Array, upper: Array,
    centre: Array, half: Array, straight: bool, models: Array, inverse: Array, weights: Array,
) -> tuple[int, int]:  # fmt: skip
    """Label and facet of the poses ``centre + s half``: ``s`` one number in [-1, 1] if straight, else one a coordinate.

    Models are rows of value, three slopes and bound of the rest; ``models`` and ``inverse`` are room for those of the
    polynomials and of ``1 / l_i``. ``weights`` gets how much each coordinate contributes to what stays undecided.
    """
    weights[:] = 0.0
    if planar:
        _quadratics(polynomials, slack, centre, half, models)
    else:
        _cubics(polynomials, slack, centre, half, models)
    if wrenches == 0:
        return _closure(models, others, volume_of, signs, half, straight, weights)
    if not _inverse_lengths(planar, anchors, arms, centre, half, inverse):
        return UNDECIDED, -1
    return _feasibility(models, inverse, wrenches, others, volume_of, signs, lower, upper, half, straight, weights)


@njit(cache=True, error_model="numpy")
def _closure(
    models: Array, others: Integers, volume_of: Integers, signs: Array, half: Array, straight: bool, weights: Array
) -> tuple[int, int]:
    """Both strict signs beside every hyperplane, or one side of one hyperplane empty."""
    label = INSIDE
    for s in range(others.shape[0]):
        positive = negative = False
        not_positive = not_negative = True
        for a in range(others.shape[1]):
            row = models[volume_of[s, a]]
            bound = _spread(row, half, straight) + row[4]
            value = signs[s, a] * row[0]
            positive |= value - bound > 0.0
            negative |= value + bound < 0.0
            not_positive &= value + bound <= 0.0
            not_negative &= value - bound >= 0.0
        if positive and not_negative:
            return OUTSIDE, 2 * s
        if negative and not_positive:
            return OUTSIDE, 2 * s + 1
        if not (positive and negative):
            label = UNDECIDED
            for a in range(others.shape[1]):
                row = models[volume_of[s, a]]
                if abs(row[0]) <= _spread(row, half, straight) + row[4]:
                    _weigh(row, half, weights)
    return label, -1


@njit(cache=True, error_model="numpy")
def _feasibility(
    models: Array, inverse: Array, wrenches: int, others: Integers, volume_of: Integers, signs: Array,
    lower: Array, upper: Array, half: Array, straight: bool, weights: Array,
) -> tuple[int, int]:  # fmt: skip
    """Every facet of the available wrenches on the far side of every wrench, or one that is not."""
    sets, width = others.shape
    first, label = models.shape[0] - wrenches * sets, INSIDE
    pulls, total = np.empty((width, 5)), np.empty(5)
    for s in range(sets):
        for a in range(width):
            _multiply(models[volume_of[s, a]], inverse[others[s, a]], half, straight, pulls[a])
            if signs[s, a] < 0.0:
                for k in range(4):
                    pulls[a, k] = -pulls[a, k]
        for w in range(wrenches):
            for side in range(2):
                sign = 1.0 if side == 0 else -1.0
                row = models[first + w * sets + s]
                for k in range(4):
                    total[k] = sign * row[k]
                total[4] = row[4]
                excess, terms = 0.0, 0.0
                for a in range(width):
                    i = others[s, a]
                    value = sign * pulls[a, 0]
                    tension = upper[i] if value >= 0.0 else lower[i]
                    for k in range(4):
                        total[k] += sign * tension * pulls[a, k]
                    bound = _spread(pulls[a], half, straight) + pulls[a, 4]
                    total[4] += abs(tension) * pulls[a, 4]
                    terms += abs(tension) * (abs(value) + bound)
                    excess += (upper[i] - lower[i]) * max(0.0, bound - abs(value))
                rest = _spread(total, half, straight) + total[4] + ROUNDING * terms
                if total[0] + rest + excess * (1.0 + ROUNDING) < 0.0:
                    return OUTSIDE, 2 * s + side
                if not total[0] - rest >= 0.0:
                    label = UNDECIDED
                    _weigh(total, half, weights)
    return label, -1


@njit(cache=True, error_model="numpy")
def _spread(row: Array, half: Array, straight: bool) -> float:
    """How far the linear part goes from the value at the centre, rounded up."""
    if straight:
        return abs(row[1] * half[0] + row[2] * half[1] + row[3] * half[2]) * (1.0 + ROUNDING)
    return (abs(row[1]) * half[0] + abs(row[2]) * half[1] + abs(row[3]) * half[2]) * (1.0 + ROUNDING)


@njit(cache=True, error_model="numpy")
def _weigh(row: Array, half: Array, weights: Array) -> None:
    """Add each coordinate's share of a bound."""
    whole = abs(row[1]) * half[0] + abs(row[2]) * half[1] + abs(row[3]) * half[2] + row[4]
    if whole > 0.0:
        for k in range(3):
            weights[k] += abs(row[k + 1] * half[k]) / whole


@njit(cache=True, error_model="numpy")
def _cut(half: Array, root: Array, weights: Array) -> int:
    """The side that contributes most to the doubt, or the longest where that one has become thin beside it."""
    longest, best = 0, 0
    for k in range(1, 3):
        if root[k] > 0.0 and (root[longest] == 0.0 or half[k] * root[longest] > half[longest] * root[k]):
            longest = k
        if root[k] > 0.0 and (root[best] == 0.0 or weights[k] > weights[best]):
            best = k
    if weights[best] > 0.0 and half[best] * root[longest] > THIN * half[longest] * root[best]:
        return best
    return longest


@njit(cache=True, error_model="numpy")
def _multiply(row: Array, inverse: Array, half: Array, straight: bool, out: Array) -> None:
    """Product of two models."""
    first, second = _spread(row, half, straight), _spread(inverse, half, straight)
    most, greatest = abs(row[0]) + first + row[4], abs(inverse[0]) + second + inverse[4]
    out[0] = row[0] * inverse[0]
    for k in range(1, 4):
        out[k] = row[k] * inverse[0] + inverse[k] * row[0]
    out[4] = first * second + row[4] * greatest + most * inverse[4] + ROUNDING * most * greatest


@njit(cache=True, error_model="numpy")
def _inverse_lengths(planar: bool, anchors: Array, arms: Array, centre: Array, half: Array, inverse: Array) -> bool:
    """Models of ``1 / l_i``; False where a cable may have no length."""
    hx, hy, hz = abs(half[0]), abs(half[1]), abs(half[2])
    cosine, sine = (math.cos(centre[2]), math.sin(centre[2])) if planar else (1.0, 0.0)
    for i in range(anchors.shape[0]):
        if planar:
            bx = cosine * arms[i, 0] - sine * arms[i, 1]
            by = sine * arms[i, 0] + cosine * arms[i, 1]
            x, y, z = anchors[i, 0] - bx - centre[0], anchors[i, 1] - by - centre[1], 0.0
            arm = math.sqrt(bx * bx + by * by)
            rate, bend = math.sqrt(hx * hx + hy * hy) + arm * hz, arm * hz * hz
            turn = x * by - y * bx
        else:
            x, y = anchors[i, 0] - arms[i, 0] - centre[0], anchors[i, 1] - arms[i, 1] - centre[1]
            z, turn = anchors[i, 2] - arms[i, 2] - centre[2], 0.0
            rate, bend = math.sqrt(hx * hx + hy * hy + hz * hz), 0.0
        length = math.sqrt(x * x + y * y + z * z)
        span = ROUNDING * (1.0 + length + abs(centre[0]) + abs(centre[1]) + abs(centre[2]))
        least = length - (rate + span) * (1.0 + ROUNDING)
        if not least > 0.0:
            return False
        cube = 1.0 / (length * length * length)
        inverse[i, 0] = 1.0 / length
        inverse[i, 1], inverse[i, 2] = x * cube, y * cube
        inverse[i, 3] = -turn * cube if planar else z * cube
        rest = rate * rate / (least * least * least) + 0.5 * bend / (least * least)
        inverse[i, 4] = (rest + 4.0 * span / (least * least) * (1.0 + rate / least)) * (1.0 + ROUNDING)
    return True


@njit(cache=True, error_model="numpy")
def _quadratics(polynomials: Array, slack: Array, centre: Array, half: Array, models: Array) -> None:
    """Quadratics in x and y whose coefficients turn with phi."""
    x, y, phi = centre[0], centre[1], centre[2]
    hx, hy, hz = abs(half[0]), abs(half[1]), abs(half[2])
    harmonics = polynomials.shape[2]
    turns = (1.0, math.cos(phi), math.sin(phi), math.cos(2.0 * phi), math.sin(2.0 * phi))
    rates = (0.0, -turns[2], turns[1], -2.0 * turns[4], 2.0 * turns[3])
    for t in range(polynomials.shape[0]):
        value = along_x = along_y = along_phi = rest = xx = xy = yy = 0.0
        for k in range(harmonics):
            a, b, c = polynomials[t, 0, k], polynomials[t, 1, k], polynomials[t, 2, k]
            d, e, f = polynomials[t, 3, k], polynomials[t, 4, k], polynomials[t, 5, k]
            p, px, py = a + x * (b + x * d + y * e) + y * (c + y * f), b + 2.0 * d * x + e * y, c + e * x + 2.0 * f * y
            turn, rate = turns[k], rates[k]
            value += p * turn
            along_x += px * turn
            along_y += py * turn
            along_phi += p * rate
            xx += d * turn
            xy += e * turn
            yy += f * turn
            if hz > 0.0 and k > 0:
                order = 1.0 if k < 3 else 2.0
                bent = abs(d) * hx * hx + abs(e) * hx * hy + abs(f) * hy * hy
                tilt_x, tilt_y = (
                    abs(px) + 2.0 * abs(d) * hx + abs(e) * hy,
                    abs(py) + abs(e) * hx + 2.0 * abs(f) * hy,
                )
                most = abs(p) + abs(px) * hx + abs(py) * hy + bent
                rest += order * hz * (tilt_x * hx + tilt_y * hy + bent) + 0.5 * order * order * hz * hz * most
        models[t, 0], models[t, 1], models[t, 2], models[t, 3] = value, along_x, along_y, along_phi
        rest += abs(xx) * hx * hx + abs(xy) * hx * hy + abs(yy) * hy * hy
        models[t, 4] = rest * (1.0 + ROUNDING) + slack[t]


@njit(cache=True, error_model="numpy")
def _cubics(polynomials: Array, slack: Array, centre: Array, half: Array, models: Array) -> None:
    """Cubics in x, y and z, in the order of `determinants.CUBIC`."""
    x, y, z = centre[0], centre[1], centre[2]
    a, b, c = abs(half[0]), abs(half[1]), abs(half[2])
    for t in range(polynomials.shape[0]):
        k = polynomials[t, :, 0]
        # Second derivatives are linear: halves of the pure ones, the mixed ones whole.
        xx = k[4] + 3.0 * k[10] * x + k[11] * y + k[12] * z
        yy = k[7] + k[13] * x + 3.0 * k[16] * y + k[17] * z
        zz = k[9] + k[15] * x + k[18] * y + 3.0 * k[19] * z
        xy = k[5] + 2.0 * k[11] * x + 2.0 * k[13] * y + k[14] * z
        xz = k[6] + 2.0 * k[12] * x + k[14] * y + 2.0 * k[15] * z
        yz = k[8] + k[14] * x + 2.0 * k[17] * y + 2.0 * k[18] * z
        models[t, 0] = (
            k[0]
            + x * (k[1] + x * (k[4] + x * k[10] + y * k[11] + z * k[12]) + y * (k[5] + y * k[13] + z * k[14]))
            + y * (k[2] + y * (k[7] + y * k[16] + z * k[17]) + z * (k[8] + z * k[18]))
            + z * (k[3] + z * (k[9] + z * k[19]) + x * (k[6] + z * k[15]))
        )
        models[t, 1] = (
            k[1]
            + x * (2.0 * k[4] + 3.0 * k[10] * x + 2.0 * k[11] * y + 2.0 * k[12] * z)
            + y * (k[5] + k[13] * y + k[14] * z)
            + z * (k[6] + k[15] * z)
        )
        models[t, 2] = (
            k[2]
            + y * (2.0 * k[7] + 3.0 * k[16] * y + 2.0 * k[13] * x + 2.0 * k[17] * z)
            + x * (k[5] + k[11] * x + k[14] * z)
            + z * (k[8] + k[18] * z)
        )
        models[t, 3] = (
            k[3]
            + z * (2.0 * k[9] + 3.0 * k[19] * z + 2.0 * k[15] * x + 2.0 * k[18] * y)
            + x * (k[6] + k[12] * x + k[14] * y)
            + y * (k[8] + k[17] * y)
        )
        rest = (
            abs(xx) * a * a + abs(yy) * b * b + abs(zz) * c * c
            + abs(xy) * a * b + abs(xz) * a * c + abs(yz) * b * c
            + abs(k[10]) * a * a * a + abs(k[16]) * b * b * b + abs(k[19]) * c * c * c
            + (abs(k[11]) * b + abs(k[12]) * c) * a * a + (abs(k[13]) * a + abs(k[17]) * c) * b * b
            + (abs(k[15]) * a + abs(k[18]) * b) * c * c + abs(k[14]) * a * b * c
        )  # fmt: skip
        models[t, 4] = rest * (1.0 + ROUNDING) + slack[t]
