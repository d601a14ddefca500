"""Motions of the claw that are known by samples: cubic splines through them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from steeplejack.robots.pipe_climber.motion import Piece
from steeplejack.robots.pipe_climber.poses import Array, Offset

LEAST_SAMPLES = 4
"""Of a cubic spline without conditions at its ends."""


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """A motion of the claw's centre relative to the base through samples, with continuous accelerations.

    The spline asks nothing of the ends (not-a-knot). Between samples h apart of a smooth motion its coordinates are off
    by the order of h^4, speeds h^3, accelerations h^2; noise of the samples comes out of accelerations 1/h^2 times.

    Attributes:
        name: For people.
        times: Of the samples, rising from 0, (n,) with n of at least 4 [s].
        places: x, z of the claw's centre, hz included, alpha, beta, (n, 4) [m, m, rad, rad].
        offset: Whether hz turns with alpha or lies along Z, as Eq. 8 has it.
    """

    name: str
    times: Array
    places: Array
    offset: Offset = "turning"

    @property
    def duration(self) -> float:
        """It runs from t = 0 to this [s]."""
        return float(self.times[-1])

    def coordinates(self, times: Array) -> Array:
        """x, z, alpha and beta with two derivatives at times (...), (..., 4, 3)."""
        return np.stack([self._spline(times, order) for order in range(3)], axis=-1)

    def pieces(self) -> Iterator[Piece]:
        """One from each sample to the next."""
        for begin, end, falling in zip(self.times, self.times[1:], np.moveaxis(self._spline.c, 1, 0), strict=False):
            x, z, alpha, _beta = falling[::-1].T
            yield Piece(float(begin), float(end), (x, z, alpha))

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.times, self.places)
