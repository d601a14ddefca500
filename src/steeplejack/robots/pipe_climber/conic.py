"""Distance from a point to a hyperbola, a line or a pair of lines, one that cannot miss the nearest point.

In axes that point along the principal directions, with the point as origin, the curve is

    v + h1 d1 + h2 d2 + k1 d1^2 + k2 d2^2 = 0,   k1 k2 <= 0.

The multiplier m of the nearest point d makes ``I + m diag(k1, k2)`` positive semidefinite. Between the two poles the
secular function ``f(m) = v - sum m h^2 (2 + m k) / (4 (1 + m k)^2)`` falls from one sign to the other, so its one root
there is bracketed, however close the curve is to a pair of lines (More, Optim. Methods Softw. 1993).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

NEAR_POLE = 1e-6
"""1 + m k below which the squared distance comes from the dual instead of from a quotient by it [1]."""


@dataclass(frozen=True)
class _Conic:
    """The curve with v > 0: squares of the slopes and the bends, k >= 0 first, and ``v - h^2 / (4 k)`` of the first."""

    value: float
    stiff: tuple[float, float]
    soft: tuple[float, float]
    rest: float

    @property
    def pole(self) -> float:
        """Where the second quotient ends."""
        return -1.0 / self.soft[1] if self.soft[1] < 0.0 else math.inf

    def reduced(self, m: float, power: int) -> float:
        """Value less the first sum, of f (power 2) or of the dual (power 1); no cancellation where m k is large."""
        square, bend = self.stiff
        room = 1.0 + m * bend
        if room > 2.0:
            return self.rest + 0.25 * square / bend / room**power
        return self.value - 0.25 * m * square * (1.0 + room if power == 2 else room) / room**2

    def secular(self, m: float) -> float:
        """f(m); -infinity at the pole and behind it."""
        square, bend = self.soft
        room = 1.0 + m * bend
        if room <= 0.0:
            return -math.inf
        return self.reduced(m, 2) - 0.25 * m * square * (1.0 + room) / room**2


def conic_distance(value: float, slopes: tuple[float, float], bends: tuple[float, float], centre: float) -> float:
    """Least distance from the origin to the curve above.

    Args:
        value: v.
        slopes: h1, h2; not both 0 if both bends are.
        bends: k1, k2, of unlike signs or 0.
        centre: Value of the left side at the curve's centre, known better than ``v - sum h^2 / (4 k)`` where that
            cancels; not asked if a bend is 0.

    Returns:
        The distance, in the unit of d.
    """
    if value == 0.0:
        return 0.0
    conic = _conic(math.copysign(1.0, value), value, slopes, bends, centre)
    m = _multiplier(conic)
    square, bend = conic.soft
    room = 1.0 + m * bend
    if room > NEAR_POLE:
        stiff = conic.stiff[0] / (1.0 + m * conic.stiff[1]) ** 2
        return 0.5 * m * math.sqrt(stiff + square / room**2)
    quotient = square / room if square > 0.0 else 0.0
    return math.sqrt(max(m * (conic.reduced(m, 1) - 0.25 * m * quotient), 0.0))


def _conic(sign: float, value: float, slopes: tuple[float, float], bends: tuple[float, float], centre: float) -> _Conic:
    """The curve with v > 0, and the better known of two forms of its rest."""
    terms = sorted(((sign * k, h * h) for h, k in zip(slopes, bends, strict=True)), reverse=True)
    (k_stiff, stiff), (k_soft, soft) = terms
    value, centre = sign * value, sign * centre
    rest = math.nan
    if k_stiff > 0.0:
        less = 0.25 * stiff / k_stiff
        rest = value - less
        if k_soft < 0.0 and abs(centre) + abs(more := 0.25 * soft / k_soft) < value + less:
            rest = centre + more
    return _Conic(value, (stiff, k_stiff), (soft, k_soft), rest)


def _multiplier(conic: _Conic) -> float:
    """Root of the secular function, from below; the pole where the function has none before it."""
    total = conic.stiff[0] + conic.soft[0]
    if total == 0.0:
        return math.nextafter(conic.pole, 0.0)
    high = 2.0 * conic.value / total  # of a straight line
    while high < conic.pole and conic.secular(high) > 0.0:
        high *= 2.0
    low, high = 0.0, min(high, conic.pole)
    while low < (middle := 0.5 * (low + high)) < high:
        if conic.secular(middle) > 0.0:
            low = middle
        else:
            high = middle
    return low
