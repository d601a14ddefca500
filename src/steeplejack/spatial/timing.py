"""Time scaling: from rest to rest along a path within a speed and an acceleration."""

from __future__ import annotations

import math
from typing import NamedTuple


class Profile(NamedTuple):
    """A rest-to-rest motion: raised-cosine ramps of speed about a cruise.

    ``v(t) = v (1 - cos(pi t / T)) / 2`` on the ramps, so the largest acceleration is ``pi v / (2 T)`` and jerk is
    bounded; a ramp covers ``v T / 2``.
    """

    length: float  # [m] or [rad]
    speed: float  # [m/s] reached
    ramp: float  # [s]
    cruise: float  # [s]

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return 2.0 * self.ramp + self.cruise

    def at(self, time: float) -> tuple[float, float, float]:
        """Travel, speed and acceleration at a time; before 0 and after the end, at rest there."""
        if time <= 0.0 or self.length == 0.0:
            return 0.0, 0.0, 0.0
        if time >= self.duration:
            return self.length, 0.0, 0.0
        if time > self.ramp + self.cruise:
            travel, speed, acceleration = self._ramp(self.duration - time)
            return self.length - travel, speed, -acceleration
        if time > self.ramp:
            return 0.5 * self.speed * self.ramp + self.speed * (time - self.ramp), self.speed, 0.0
        return self._ramp(time)

    def _ramp(self, time: float) -> tuple[float, float, float]:
        rate = math.pi / self.ramp
        angle = rate * time
        return (
            0.5 * self.speed * (time - math.sin(angle) / rate),
            0.5 * self.speed * (1.0 - math.cos(angle)),
            0.5 * self.speed * rate * math.sin(angle),
        )


def profile(length: float, speed: float, acceleration: float) -> Profile:
    """The fastest raised-cosine motion over a length [m] within a speed [m/s] and an acceleration [m/s2]."""
    reached = min(speed, math.sqrt(2.0 * acceleration * length / math.pi))
    if reached <= 0.0:
        return Profile(0.0, 0.0, 0.0, 0.0)
    ramp = math.pi * reached / (2.0 * acceleration)
    return Profile(length, reached, ramp, max(0.0, length / reached - ramp))
