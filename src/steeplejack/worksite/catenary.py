"""An elastic catenary through two anchorages, for the tension it is found with.

The stay hangs in the vertical plane through its anchorages, gravity along -z. Per metre of *unstressed* length it
weighs ``w`` [N/m]; its axial stiffness is ``EA`` [N] (``None``: inextensible). ``T`` [N] is the tension where the
tangent is parallel to the chord, so the horizontal force, constant along the stay, is ``H = T cos(theta)`` with
``theta`` the chord's inclination. ``T`` belongs to the final, loaded state: the unstressed length follows from it.

Irvine, *Cable Structures* (1981), section 2.3, gives position against unstressed length. Here it is written in
``u = asinh(V / H)``, with ``V`` the vertical force at a point, ``a = H / w`` and ``e = H / EA``::

    unstressed length   s0 = a (sinh u - sinh u0)
    loaded arc length   s  = a (sinh u - sinh u0 + e ((u - u0) / 2 + (sinh 2u - sinh 2u0) / 4))
    along the heading   x  = a (u - u0 + e (sinh u - sinh u0))
    up                  z  = a (cosh u - cosh u0 + e (sinh^2 u - sinh^2 u0) / 2)

The curve's parameter is ``d = (u - u0) / 2``, 0 at the lower anchorage; with ``m = u0 + d`` every difference becomes a
product, so nothing cancels under a heavy tension or on a steep stay. Valid while the stay carries itself, ``T >= w L``,
and strains less than 5 %.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.worksite.chord import VERTICAL, Array, Chord, Point, heading

WEIGHTLESS = 1e-9  # [1] ratio of weight to tension below which the catenary is its chord
END_STEPS = 40  # fixed-point steps to the ends; each shrinks the error by the strain, at most 5 %
ARC_STEPS = 3  # Newton steps from arc length to d; each squares an error that starts below 1e-2 of the length
FOOT_STEPS = 6  # Newton steps to the foot of a perpendicular


def hang(
    lower: Point, upper: Point, weight: float, tension: float, axial_stiffness: float | None = None
) -> Catenary | Chord:
    """The curve of a stay through two anchorages.

    Args:
        lower: Lower anchorage [m], world frame, z up.
        upper: Upper anchorage [m], world frame.
        weight: Weight per metre of unstressed length [N/m].
        tension: Tension where the tangent is parallel to the chord [N], positive when it pulls.
        axial_stiffness: EA [N]; ``None`` for an inextensible stay.

    Returns:
        Its elastic catenary, or its chord where it is vertical or weighs nothing against its tension.
    """
    chord = Chord(lower, upper)
    span, rise = math.hypot(upper[0] - lower[0], upper[1] - lower[1]), upper[2] - lower[2]
    if span < VERTICAL * chord.length or weight * chord.length < WEIGHTLESS * tension:
        return chord
    horizontal = tension * span / chord.length
    e = horizontal / axial_stiffness if axial_stiffness else 0.0
    mean, half = _ends(span, rise, horizontal / weight, e)
    return Catenary(lower, upper, horizontal / weight, e, mean - half, half)


def _ends(span: float, rise: float, a: float, e: float) -> tuple[float, float]:
    """Mean and half difference of ``u`` between the anchorages, from x = span and z = rise."""
    half = span / (2.0 * a)
    mean = math.asinh(rise / (2.0 * a * math.sinh(half)))
    for _ in range(END_STEPS if e > 0.0 else 0):
        half = span / (2.0 * a * (1.0 + e * math.cosh(mean) * math.sinh(half) / half))
        mean = math.asinh(rise / (2.0 * a * math.sinh(half) * (1.0 + e * math.cosh(mean) * math.cosh(half))))
    return mean, half


@dataclass(frozen=True)
class Catenary:
    """An elastic catenary by loaded arc length from the lower anchorage; built by :func:`hang`.

    Args:
        lower: Lower anchorage [m], world frame, z up.
        upper: Upper anchorage [m], world frame.
        a: Horizontal force over weight per unstressed metre [m].
        e: Horizontal force over axial stiffness [1]; 0 for an inextensible stay.
        u_lower: asinh(V / H) at the lower anchorage [1].
        d_upper: Parameter d at the upper anchorage [1].
    """

    lower: Point
    upper: Point
    a: float
    e: float
    u_lower: float
    d_upper: float

    @cached_property
    def length(self) -> float:
        """Loaded arc length [m]."""
        return float(self._arc(np.asarray(self.d_upper)))

    @cached_property
    def unstressed_length(self) -> float:
        """Length the stay would have without tension [m]."""
        return 2.0 * self.a * math.cosh(self.u_lower + self.d_upper) * math.sinh(self.d_upper)

    @cached_property
    def sag(self) -> float:
        """Largest distance from the chord, at right angles to it [m]: where the tangent is parallel to the chord."""
        across, rise = np.subtract(self.upper, self.lower) @ self.heading, self.upper[2] - self.lower[2]
        x, z = self._plane(np.asarray(0.5 * (math.asinh(rise / across) - self.u_lower)))
        return float(rise * x - across * z) / math.hypot(across, rise)

    @cached_property
    def heading(self) -> Array:
        """Horizontal unit vector (3,) [1] from the lower to the upper anchorage."""
        return heading(self.lower, self.upper)

    def position(self, s: ArrayLike) -> Array:
        """Points of the curve; outside the anchorages it continues.

        Args:
            s: Loaded arc length (...) [m] from the lower anchorage.

        Returns:
            Points (..., 3) [m], world frame.
        """
        x, z = self._plane(self._parameter(np.asarray(s, dtype=float)))
        return self._world(x, z) + self.lower

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangents (..., 3) [1] from lower to upper at loaded arc length ``s`` (...) [m]."""
        u = self.u_lower + 2.0 * self._parameter(np.asarray(s, dtype=float))
        return self._world(1.0 / np.cosh(u), np.tanh(u))

    def nearest(self, p: ArrayLike) -> tuple[Array, Array]:
        """Nearest points between the anchorages, by Newton's method on (curve(d) - p) . tangent(d) = 0.

        Unique for points closer than the radius of curvature, T / (w cos(theta)): kilometres for a stay.

        Args:
            p: Points (..., 3) [m], world frame.

        Returns:
            Loaded arc length (...) [m] and distance (...) [m].
        """
        offset = np.asarray(p, dtype=float) - self.lower
        along, up = offset @ self.heading, offset[..., 2]
        chord = np.subtract(self.upper, self.lower)
        d = self._spread(np.clip(offset @ chord / (chord @ chord), 0.0, 1.0))
        for _ in range(FOOT_STEPS):
            x, z = self._plane(d)
            u = self.u_lower + 2.0 * d
            c, t = np.cosh(u), np.tanh(u)
            slip = (x - along) / c + (z - up) * t
            bend = ((z - up) / c - (x - along) * t) / c
            stretch = self.a * c * (1.0 + self.e * c)
            d = np.clip(d - 0.5 * slip / np.maximum(stretch + bend, 0.1 * stretch), 0.0, self.d_upper)
        return self._arc(d), np.linalg.norm(offset - self._world(*self._plane(d)), axis=-1)

    def _world(self, along: Array, up: Array) -> Array:
        """World vectors (..., 3) from components along the heading and up."""
        vector = np.asarray(along)[..., None] * self.heading
        vector[..., 2] = up
        return vector

    def _plane(self, d: Array) -> tuple[Array, Array]:
        """Distances along the heading and up (...) [m] from the lower anchorage."""
        m = self.u_lower + d
        cosh_m, sinh_d = np.cosh(m), np.sinh(d)
        x = 2.0 * self.a * (d + self.e * cosh_m * sinh_d)
        return x, 2.0 * self.a * np.sinh(m) * sinh_d * (1.0 + self.e * cosh_m * np.cosh(d))

    def _arc(self, d: Array) -> Array:
        """Loaded arc length (...) [m] from the lower anchorage."""
        m = self.u_lower + d
        loaded = d + 0.5 * np.sinh(2.0 * d) * np.cosh(2.0 * m)
        return self.a * (2.0 * np.cosh(m) * np.sinh(d) + self.e * loaded)

    def _spread(self, fraction: Array) -> Array:
        """Parameter ``d`` (...) at a fraction (...) of the unstressed length."""
        low = math.sinh(self.u_lower)
        return 0.5 * (np.arcsinh(low + fraction * (self.unstressed_length / self.a)) - self.u_lower)

    def _parameter(self, s: Array) -> Array:
        """Parameter ``d`` (...) at loaded arc length ``s``; the first guess is exact at both anchorages."""
        d = self._spread(s / self.length)
        for _ in range(ARC_STEPS if self.e > 0.0 else 1):
            c = np.cosh(self.u_lower + 2.0 * d)
            d = d - 0.5 * (self._arc(d) - s) / (self.a * c * (1.0 + self.e * c))
        return d
