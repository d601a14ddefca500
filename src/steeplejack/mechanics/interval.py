"""Interval arithmetic with outward rounding, compiled: bounds that hold whatever the rounding did.

An interval is two numbers, ``low`` and ``high``, passed and returned as such; kernels call these functions on scalars.
Every operation returns an interval that contains the exact result for every choice of arguments in theirs.

Rounding. IEEE 754 rounds ``+ - * / sqrt`` to the nearest double ``r``, at most half a unit in the last place away.
`down` subtracts ``2^-52 |r| + 2^-1022``, at least one unit, and rounding is monotone, so the exact value is not below
it; `up` is its mirror image. The second term covers results that underflow, also where the processor flushes those to
zero. One operation therefore widens by at most two units, and costs no change of the rounding mode.

Overflow, division by an interval that holds zero, and arguments that are not numbers give bounds at infinity: they
prove nothing, and they are never not-a-number.

The sine and cosine of the C library are taken to be within 4 units in the last place (glibc's are within 1).
"""

from __future__ import annotations

import math

from numba import njit

UNIT = 2.0**-52
"""Relative distance of neighbouring doubles, at most [1]."""

TINY = 2.0**-1022
"""Least normal double."""

LIBRARY = 2.0**-50
"""Relative error that sine and cosine may have [1]."""

FARTHEST = 1e6
"""Angle beyond which sine and cosine are bounded by -1 and 1 only [rad]."""


@njit(cache=True)
def down(value: float) -> float:
    """A lower bound of what was rounded to ``value``."""
    below = value - (abs(value) * UNIT + TINY)
    return below if below == below else -math.inf


@njit(cache=True)
def up(value: float) -> float:
    """An upper bound of what was rounded to ``value``."""
    above = value + (abs(value) * UNIT + TINY)
    return above if above == above else math.inf


@njit(cache=True)
def add(a_low: float, a_high: float, b_low: float, b_high: float) -> tuple[float, float]:
    """Sum of two intervals."""
    return down(a_low + b_low), up(a_high + b_high)


@njit(cache=True)
def sub(a_low: float, a_high: float, b_low: float, b_high: float) -> tuple[float, float]:
    """Difference of two intervals."""
    return down(a_low - b_high), up(a_high - b_low)


@njit(cache=True)
def mul(a_low: float, a_high: float, b_low: float, b_high: float) -> tuple[float, float]:
    """Product of two intervals."""
    p, q, r, s = a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high
    if not math.isfinite(p + q + r + s):
        return -math.inf, math.inf
    return down(min(min(p, q), min(r, s))), up(max(max(p, q), max(r, s)))


@njit(cache=True)
def scale(factor: float, low: float, high: float) -> tuple[float, float]:
    """A number times an interval."""
    p, q = factor * low, factor * high
    if not math.isfinite(p + q):
        return -math.inf, math.inf
    return down(min(p, q)), up(max(p, q))


@njit(cache=True)
def sqr(low: float, high: float) -> tuple[float, float]:
    """Square of an interval; not below zero."""
    p, q = low * low, high * high
    if not math.isfinite(p + q):
        return 0.0, math.inf
    least = 0.0 if low <= 0.0 <= high else max(down(min(p, q)), 0.0)
    return least, up(max(p, q))


@njit(cache=True)
def sqrt(low: float, high: float) -> tuple[float, float]:
    """Square root of the part of an interval that is not below zero; the whole half line where none is."""
    if not high >= 0.0:
        return 0.0, math.inf
    least = max(down(math.sqrt(low)), 0.0) if low > 0.0 else 0.0
    return least, up(math.sqrt(high))


@njit(cache=True)
def div(a_low: float, a_high: float, b_low: float, b_high: float) -> tuple[float, float]:
    """Quotient of two intervals; the whole line where the divisor holds zero."""
    if not (b_low > 0.0 or b_high < 0.0):
        return -math.inf, math.inf
    p, q, r, s = a_low / b_low, a_low / b_high, a_high / b_low, a_high / b_high
    if not math.isfinite(p + q + r + s):
        return -math.inf, math.inf
    return down(min(min(p, q), min(r, s))), up(max(max(p, q), max(r, s)))


@njit(cache=True)
def cos(low: float, high: float) -> tuple[float, float]:
    """Cosine of an interval of angles [rad]."""
    if not (high - low < 2.0 * math.pi and max(abs(low), abs(high)) <= FARTHEST):
        return -1.0, 1.0
    p, q = math.cos(low), math.cos(high)
    least, most = min(p, q), max(p, q)
    # Where a multiple of pi lies within rounding of an end it counts as inside: that can only widen.
    slack = 2.0**-30
    first = math.ceil(low / math.pi - slack)
    last = math.floor(high / math.pi + slack)
    if first <= last:
        even = first % 2.0 == 0.0
        if even or first < last:
            most = 1.0
        if not even or first < last:
            least = -1.0
    return max(least - LIBRARY, -1.0), min(most + LIBRARY, 1.0)


@njit(cache=True)
def sin(low: float, high: float) -> tuple[float, float]:
    """Sine of an interval of angles [rad]."""
    if not (high - low < 2.0 * math.pi and max(abs(low), abs(high)) <= FARTHEST):
        return -1.0, 1.0
    p, q = math.sin(low), math.sin(high)
    least, most = min(p, q), max(p, q)
    slack = 2.0**-30
    first = math.ceil(low / math.pi - 0.5 - slack)
    last = math.floor(high / math.pi - 0.5 + slack)
    if first <= last:
        even = first % 2.0 == 0.0
        if even or first < last:
            most = 1.0
        if not even or first < last:
            least = -1.0
    return max(least - LIBRARY, -1.0), min(most + LIBRARY, 1.0)


@njit(cache=True)
def hull(a_low: float, a_high: float, b_low: float, b_high: float) -> tuple[float, float]:
    """Least interval that holds both."""
    return min(a_low, b_low), max(a_high, b_high)
