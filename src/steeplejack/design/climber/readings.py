"""The paper's optimum under every reading of its normalisation, beside the original and the best there is.

Section 5.2 says neither at which scale designs are compared, nor over which region, nor from where joint limits count;
Table II and Eq. 5 disagree on the base; and the index depends on which platform moves, which section 5.1 denies. Each
combination is a `Comparison`; under none of them is the reported 1 : 1 : 0.75 : 0.65 the best, nor better than all of
its neighbours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import cast, get_args

import numpy as np

from steeplejack.design.climber.dimensions import ORIGINAL, PAPER, Ratio, design_plane, performance_chart, rating
from steeplejack.design.climber.ratings import Comparison, Scale, rate
from steeplejack.design.climber.region import Rectangle
from steeplejack.design.climber.transmission import Moving
from steeplejack.errors import InfeasibleError
from steeplejack.robots.pipe_climber.parameters import Convention, Neutral

PRESCRIBED = Rectangle(-0.050, 0.050, 0.130, 0.200)
"""Rectangle like that of Fig. 12 (b), whose sides the paper does not give."""
WITHIN = tuple(math.radians(angle) for angle in (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0))
"""Orientations pooled in the readings that do not stop at parallel platforms."""


@dataclass(frozen=True)
class Reading:
    """What one reading makes of the three designs.

    Attributes:
        comparison: The reading.
        original: GTI of the original dimensions [1]; NaN where they reach nothing.
        paper: GTI of the paper's optimum [1].
        best: GTI of the best of the chart [1].
        ratio: Of the best, ``L_i / L1``.
        share_above_paper: Share of the chart that is better than the paper's optimum [1].
        paper_is_local: Whether none of the eight neighbours of the paper's optimum, 0.01 away, is better.
    """

    comparison: Comparison
    original: float
    paper: float
    best: float
    ratio: Ratio
    share_above_paper: float
    paper_is_local: bool


def readings(step: float = 0.002) -> list[Comparison]:
    """The 64 readings: moving body x orientations x scale x convention x region.

    Regions are the rectangle, and each design's own workspace with each neutral.
    """
    bodies, scales = cast("tuple[Moving, ...]", get_args(Moving)), cast("tuple[Scale, ...]", get_args(Scale))
    conventions, neutrals = cast("tuple[Convention, ...]", get_args(Convention)), get_args(Neutral)
    found: list[Comparison] = []
    for moving, alphas, scale, convention in product(bodies, ((0.0,), WITHIN), scales, conventions):
        plain = Comparison(None, alphas, step, scale, convention, moving)
        found.append(replace(plain, rectangle=PRESCRIBED))
        found += [replace(plain, neutral=neutral) for neutral in neutrals]
    return found


def read(comparison: Comparison, step: float = 0.025) -> Reading:
    """Compare the original, the paper's optimum and the best of a chart under one reading.

    Args:
        comparison: The reading.
        step: Of the chart's ratios [1].

    Returns:
        The three, and how far the paper's is from being an optimum.

    Raises:
        InfeasibleError: No design reaches anything.
    """
    chart = performance_chart(design_plane(step), comparison)
    ratio, best = chart.best()
    paper = rating(PAPER, comparison)
    if math.isnan(paper):
        raise InfeasibleError("the paper's dimensions reach no pose", f"joint limits from {comparison.neutral!r}")
    offsets = np.array([(0.0, 0.0, third, fourth) for third in (-0.01, 0.0, 0.01) for fourth in (-0.01, 0.0, 0.01)])
    around = rate(np.array(PAPER) + offsets, comparison).gti
    local = not bool((around > paper).any())
    return Reading(comparison, rating(ORIGINAL, comparison), paper, best, ratio, chart.share_above(paper), local)
