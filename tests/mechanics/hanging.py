"""Random platforms on locked winches that the equilibrium tests share: any number of cables, some of them slack."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from steeplejack.mechanics.cable import LockedPlatform, spatial_lengths
from steeplejack.spatial import from_vector

GRAVITY = 9.81


class Hanging(NamedTuple):
    """A platform, its mass properties and a pose near which its winches were locked."""

    platform: LockedPlatform
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    position: np.ndarray
    rotation: np.ndarray


def hanging(seed: int) -> Hanging:
    """Three to eight cables, most of them from above, in a turned frame; lengths a few per cent long or short."""
    rng = np.random.default_rng(seed)
    m = int(rng.integers(3, 9))
    angle = np.linspace(0.0, 2.0 * np.pi, m, endpoint=False) + rng.normal(size=m) * 0.3
    radius, height = rng.uniform(2.0, 5.0, m), rng.uniform(2.0, 4.0, m)
    height[3:] *= np.where(rng.random(max(m - 3, 0)) < 0.3, -1.0, 1.0)
    anchors = np.stack((radius * np.cos(angle), radius * np.sin(angle), height), axis=-1)
    attachments = np.stack((0.4 * np.cos(angle), 0.3 * np.sin(angle), rng.uniform(0.0, 0.3, m)), axis=-1)
    attachments += rng.normal(size=(m, 3)) * 0.05
    position, rotation = rng.normal(size=3) * 0.4, from_vector(rng.normal(size=3) * 0.1)
    mass, centre = float(rng.uniform(5.0, 20.0)), rng.normal(size=3) * 0.05
    unstressed = spatial_lengths(anchors, attachments, position, rotation) * rng.uniform(0.97, 1.05, m)
    stiffness = rng.uniform(2e3, 2e4, m)
    platform = LockedPlatform.spatial(
        anchors, attachments, unstressed, [0.0, 0.0, -mass * GRAVITY], axial_stiffness=stiffness, centre=centre
    )
    return Hanging(platform, mass, centre, np.diag(rng.uniform(0.5, 1.0, 3)), position, rotation)
