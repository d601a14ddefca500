"""Pipe climbers and poses the tests share: dimension sets, conventions, seeded poses, the reference values."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.pipe_climber import Layout

Array = NDArray[np.float64]

REFERENCE: dict[str, Any] = tomllib.loads((Path(__file__).parents[1] / "reference" / "pipe_climber.toml").read_text())
ORIGINAL = tuple(REFERENCE["dimensions"]["original"])
CONVENTIONS = ("text", "equations")
# Original, the paper's optimum, asymmetric, L1 = L3 (where the surface at one alpha is two lines), K < 0 in the text.
DIMENSIONS = (ORIGINAL, tuple(REFERENCE["dimensions"]["optimum"]), (0.08, 0.12, 0.05, 0.03), (0.1, 0.1, 0.1, 0.049),
              (0.02, 0.05, 0.12, 0.09))  # fmt: skip
LAYOUTS = [Layout(lengths, convention) for lengths in DIMENSIONS for convention in CONVENTIONS]  # pyright: ignore


def layout(convention: str = "text", **changes: Any) -> Layout:
    """The original dimensions."""
    return Layout(ORIGINAL, convention, **changes)  # pyright: ignore


def radians(pose: list[float]) -> Array:
    """(x, w, alpha) with alpha in degrees, as the reference has it."""
    return np.array([pose[0], pose[1], math.radians(pose[2])])


def poses(rng: np.random.Generator, count: int, turn: float = 0.6) -> Array:
    """Poses about the home pose, away from the singular surface for small turns."""
    low, high = np.array([-0.06, 0.10, -turn]), np.array([0.06, 0.22, turn])
    return rng.uniform(low, high, (count, 3))


def anywhere(rng: np.random.Generator, count: int) -> Array:
    """Poses on both sides of the base and of the singular surface, any alpha."""
    return rng.uniform([-0.15, -0.2, -math.pi], [0.15, 0.25, math.pi], (count, 3))


def named(mechanism: Layout) -> str:
    """Convention and L1..L4 in millimetres."""
    return f"{mechanism.convention}-" + "-".join(f"{1e3 * length:g}" for length in mechanism.lengths)
