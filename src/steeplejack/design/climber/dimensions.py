"""Design space of the 3-RPR mechanism and its performance charts (Ye et al., Robotica 2024, section 5.2, Fig. 13-15).

The parameter-finiteness normalisation divides the four lengths by their sum, ``r_i = L_i / D`` with
``r_4 = 1 - (r_1 + r_2 + r_3)`` (Eq. 32), and keeps ``r_1 >= r_3``, ``r_2 >= r_4``, ``r_1 >= r_2`` (Eq. 33): a bounded
space of three dimensions. With ``L_2 = k L_1`` (Eq. 31) and k fixed two remain, and ratios to L1 name a point in it as
well as the r do: ``L3/L1`` and ``L4/L1``.

Transmission does not depend on scale, but a workspace in millimetres does, so a chart needs a scale too: `Comparison`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.design.climber.ratings import Comparison, Ratings, rate
from steeplejack.errors import InfeasibleError, InputError

Array = NDArray[np.float64]
Index = Literal["gti", "mean", "least"]
Ratio = tuple[float, float, float, float]

LEAST = 0.05
"""Least ratio to L1 that the charts show; joints that coincide need three."""
MOST_DESIGNS = 4_000_000
ORIGINAL: Ratio = (1.0, 1.0, 0.75, 0.75)
"""Dimensions of section 4.3, 100, 100, 75, 75 mm."""
PAPER: Ratio = (1.0, 1.0, 0.75, 0.65)
"""The optimum that section 5.2 reports."""


@dataclass(frozen=True, eq=False)
class Chart:
    """Ratings of the designs of a space.

    Attributes:
        ratios: ``L_i / L1``, (n, 4) [1].
        ratings: Of each.
        comparison: Under which conditions.
    """

    ratios: Array
    ratings: Ratings
    comparison: Comparison

    def values(self, index: Index = "gti") -> Array:
        """One index of each design, (n,) [1]."""
        return {"gti": self.ratings.gti, "mean": self.ratings.mean, "least": self.ratings.least}[index]

    def best(self, index: Index = "gti") -> tuple[Ratio, float]:
        """Design of the greatest value, and the value; of equals the first.

        Raises:
            InfeasibleError: No design has a region to be rated over.
        """
        values = self.values(index)
        if np.isnan(values).all():
            low, high = self.comparison.reach
            raise InfeasibleError(
                "no design of the chart reaches any pose",
                f"limb lengths of {low:g} to {high:g} m and joint limits from {self.comparison.neutral!r}",
            )
        at = int(np.nanargmax(values))
        r1, r2, r3, r4 = self.ratios[at].tolist()
        return (r1, r2, r3, r4), float(values[at])

    def share_above(self, value: float, index: Index = "gti") -> float:
        """Share of the designs that are better than a value [1]."""
        values = self.values(index)
        return float(np.count_nonzero(values > value) / values.size)


def ratio_axis(step: float, least: float = LEAST) -> Array:
    """Ratios from ``least`` to 1, both included, a step apart; where the step does not divide the range, 1 is added.

    Raises:
        InputError: A step that is not between 0.001 and the range.
    """
    if not 0.001 <= step <= 1.0 - least:
        raise InputError("step", f"{step:g}", f"a ratio of 0.001 to {1.0 - least:g}")
    count = math.floor((1.0 - least) / step + 1e-9)
    axis: Array = least + step * np.arange(count + 1, dtype=np.float64)
    if 1.0 - axis[-1] < 1e-9:
        axis[-1] = 1.0  # rounding may put it above, where Eq. 33 rules it out
        return axis
    return np.concatenate((axis, [1.0]))


def design_plane(step: float, k: float = 1.0) -> Array:
    """Designs of a plane of the parameter design space: k fixed, ``L3/L1`` and ``L4/L1`` a step apart (Fig. 14).

    Args:
        step: Of the ratios [1].
        k: ``L2 / L1`` (Eq. 31), in (0, 1].

    Returns:
        ``L_i / L1`` of the designs that hold Eq. 33, (n, 4); L4 varies fastest.

    Raises:
        InputError: A step or k out of range.
    """
    if not LEAST <= k <= 1.0:
        raise InputError("k", f"{k:g}", f"L2 / L1 from {LEAST:g} to 1")
    return design_grid([k], ratio_axis(step), ratio_axis(step))


def design_space(step: float) -> Array:
    """Designs of the whole parameter design space (Fig. 13); those of L2 = L1 are the `design_plane` of that step.

    Args:
        step: Of the three ratios [1].

    Returns:
        ``L_i / L1`` of the designs that hold Eq. 33, (n, 4), with ``n = m^2 (m + 1) / 2`` for m values of a ratio.

    Raises:
        InputError: A step out of range, or one that makes too many designs.
    """
    axis = ratio_axis(step)
    designs = axis.size * axis.size * (axis.size + 1) // 2
    if designs > MOST_DESIGNS:
        raise InputError("step", f"{step:g}, {designs} designs", f"at most {MOST_DESIGNS} designs")
    return design_grid(axis, axis, axis)


def design_grid(k: ArrayLike, third: ArrayLike, fourth: ArrayLike) -> Array:
    """All combinations of ``L2/L1``, ``L3/L1``, ``L4/L1`` that hold Eq. 33, (n, 4)."""
    two, three, four = np.meshgrid(*(np.asarray(axis, dtype=np.float64) for axis in (k, third, fourth)), indexing="ij")
    ratios = np.stack([np.ones_like(two), two, three, four], axis=-1).reshape(-1, 4)
    held = (ratios[:, 1:3] <= 1.0).all(axis=1) & (ratios[:, 3] <= ratios[:, 1])
    return ratios[held]


def normalised(lengths: ArrayLike) -> Array:
    """Parameters ``r_i = L_i / (L1 + L2 + L3 + L4)`` of lengths or ratios, (..., 4) [1] (Eq. 32)."""
    given = np.asarray(lengths, dtype=np.float64)
    return given / given.sum(axis=-1, keepdims=True)


def performance_chart(ratios: Array, comparison: Comparison) -> Chart:
    """Rate the designs of a space.

    Args:
        ratios: From `design_plane` or `design_space`, (n, 4).
        comparison: Region, scale and the rest.

    Returns:
        The chart.
    """
    return Chart(ratios, rate(ratios, comparison), comparison)


def rating(ratio: Ratio, comparison: Comparison) -> float:
    """GTI of one design [1]; NaN where it reaches nothing of the region."""
    return float(rate(np.array([ratio]), comparison).gti[0])
