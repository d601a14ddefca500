"""Interval operations contain the exact result, in rational arithmetic, and are not much wider than it."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from steeplejack.mechanics import interval

INFINITE = (-math.inf, math.inf)


def intervals(rng, count):
    """Ends over many magnitudes, about a third of them straddling zero, some a point."""
    ends = rng.normal(size=(count, 2)) * 10.0 ** rng.integers(-12, 13, (count, 2))
    ends[::7, 1] = ends[::7, 0]
    return np.sort(ends, axis=1)


def members(low, high, rng):
    """The ends, the middle and a random member, as fractions."""
    share = Fraction(int(rng.integers(0, 1000)), 1000)
    a, b = Fraction(low), Fraction(high)
    return a, b, (a + b) / 2, a + share * (b - a)


@pytest.mark.parametrize(
    ("name", "exact"),
    [
        ("add", lambda a, b: a + b),
        ("sub", lambda a, b: a - b),
        ("mul", lambda a, b: a * b),
        ("div", lambda a, b: a / b),
    ],
)
def test_binary_operations_contain_the_exact_result(name, exact, rng):
    compiled = getattr(interval, name)
    for a, b in zip(intervals(rng, 400), intervals(rng, 400), strict=True):
        low, high = compiled(*a, *b)
        if name == "div" and b[0] <= 0.0 <= b[1]:
            assert (low, high) == INFINITE
            continue
        values = [exact(x, y) for x in members(*a, rng) for y in members(*b, rng)]
        assert low <= min(values) <= max(values) <= high
        corners = [exact(Fraction(x), Fraction(y)) for x in a for y in b]
        size = max(abs(value) for value in corners)
        assert Fraction(low) >= min(corners) - Fraction(4 * interval.UNIT) * size
        assert Fraction(high) <= max(corners) + Fraction(4 * interval.UNIT) * size


def test_unary_operations_contain_the_exact_result(rng):
    for low, high in intervals(rng, 400):
        values = [x * x for x in members(low, high, rng)]
        least, most = interval.sqr(low, high)
        assert 0.0 <= least <= min(values) <= max(values) <= most
        least, most = interval.sqrt(abs(low), abs(low) + abs(high))
        assert Fraction(least) ** 2 <= Fraction(abs(low))
        assert Fraction(abs(low)) + Fraction(abs(high)) <= Fraction(most) ** 2 * (1 + Fraction(interval.UNIT))
        factor = float(rng.normal())
        least, most = interval.scale(factor, low, high)
        assert all(least <= Fraction(factor) * x <= most for x in members(low, high, rng))


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sine_and_cosine_contain_their_values(name, rng):
    compiled, exact = getattr(interval, name), getattr(np, name)
    for centre in np.concatenate((rng.uniform(-20.0, 20.0, 150), np.arange(-8, 9) * 0.5 * np.pi)):
        for half in (0.0, 1e-9, 0.1, 1.0, 2.5):
            low, high = compiled(centre - half, centre + half)
            values = exact(np.linspace(centre - half, centre + half, 2001))
            assert low <= values.min() and values.max() <= high
            # 2001 samples miss an extremum by half * half / 2000^2 / 2 at most, and rounding by 1e-15.
            slack = 2e-7 * half * half + 2e-15 + (1e-16 if half else 0.0)
            assert low >= values.min() - slack and high <= values.max() + slack
    assert compiled(0.0, 7.0) == (-1.0, 1.0)
    assert compiled(1e7, 1e7) == (-1.0, 1.0)


def test_rounding_is_outward_at_every_magnitude():
    for value in (0.0, 5e-324, 1e-310, 1.0, 1.0 - 2.0**-53, math.pi, 1e300, -1.0, -1e-310, -1e300):
        assert interval.down(value) < value < interval.up(value)
        assert interval.down(value) <= math.nextafter(value, -math.inf)
        assert interval.up(value) >= math.nextafter(value, math.inf)


def test_overflow_and_what_is_not_a_number_prove_nothing():
    assert interval.mul(1e200, 1e200, 1e200, 1e200) == INFINITE
    assert interval.mul(math.nan, 1.0, 1.0, 2.0) == INFINITE
    assert interval.mul(-math.inf, math.inf, 0.0, 0.0) == INFINITE
    assert interval.add(1e308, 1e308, 1e308, 1e308) == INFINITE
    assert interval.add(math.nan, math.nan, 0.0, 1.0) == INFINITE
    assert interval.div(1.0, 2.0, 0.0, 1.0) == INFINITE
    assert interval.div(1.0, 2.0, math.nan, math.nan) == INFINITE
    assert interval.div(1.0, 2.0, 1e-320, 1.0) == INFINITE
    assert interval.sqr(-1e200, 1.0) == (0.0, math.inf)
    assert interval.sqrt(-2.0, -1.0) == interval.sqrt(math.nan, math.nan) == (0.0, math.inf)
    assert interval.sqrt(-2.0, 4.0)[0] == 0.0
    assert interval.cos(math.nan, math.nan) == interval.sin(-math.inf, math.inf) == (-1.0, 1.0)


def test_hull_holds_both():
    assert interval.hull(-1.0, 2.0, 1.0, 3.0) == (-1.0, 3.0)
