"""Distances of segments against sampling."""

import numpy as np

from steeplejack.mechanics.cable.region import clearance


def test_segment_distance_against_sampling() -> None:
    rng = np.random.default_rng(0)
    t = np.linspace(0, 1, 400)
    for k in range(60):
        a, b, c, d = rng.normal(size=(4, 3))
        if k % 6 == 0:
            d = c + 0.7 * (b - a)  # parallel
        if k % 10 == 0:
            b = a.copy()  # a point
        p, q = a + t[:, None] * (b - a), c + t[:, None] * (d - c)
        sampled = np.linalg.norm(p[:, None] - q[None], axis=2).min()
        exact = clearance.segment_distance(a, b, c, d)
        assert exact <= sampled + 1e-12
        assert sampled - exact < 0.02
