"""Singularities of the 3-RPR mechanism: the explicit surface, which kind a singular pose is, and how far away it is.

With ``A = b3 L2 L4``, ``B = b2 b3 L2`` (b2, b3 the distances of B2 and B3 from B1) and ``K = b2 (L2 - L4) + b3 L4``

    q1 q2 q3 det J = -[(x sin a + w cos a) (K w + A sin a) + B sin a (w + L4 sin a)].

That is linear in x, so the singular surface is ``x(w, a)``; at a = 0 it is ``-K w^2``, zero at w = 0 only. The three
forces along the limbs are dependent there, and the platform can move with all actuators locked: the forward
singularity, J_T singular (Ye et al., Robotica 2024, section 4.6, exchanges the names). J_q is the unit matrix, so
there is no other but a limb of no length.

Two geometric cases (Fig. 7): lines of three forces that meet in a point, or are parallel. As the rows (1, p_i, b_i) are
independent (K is not 0), three limbs are parallel only if all lie along X: w = 0 and a = 0 or 180 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.conic import conic_distance
from steeplejack.robots.pipe_climber.inverse import limb_lengths, limb_vectors
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.poses import Array, triples

LINES = 1e-9
"""|A - K L4| in parts of A + |K| L4 up to which the curve at one alpha is the pair of lines it is at 0 [1]."""

PARALLEL = 1e-9
"""Largest sine between limbs that count as parallel [1]."""


LEVEL = 1e-15
"""|sin alpha| up to which the platforms are parallel: that of pi in double precision is 1.2e-16 [1]."""

DEGENERATE = 1e-9
"""|K| in parts of its terms up to which base and platform are similar: singular whenever they are parallel [1]."""


@dataclass(frozen=True)
class SurfaceConstants:
    """What the surface depends on beside the pose.

    Attributes:
        k: ``b2 (L2 - L4) + b3 L4`` [m2].
        a: ``b3 L2 L4`` [m3].
        b: ``b2 b3 L2`` [m3].
        l4: L4 [m].
    """

    k: float
    a: float
    b: float
    l4: float

    @classmethod
    def of(cls, layout: Layout) -> SurfaceConstants:
        """Those of a mechanism."""
        (_, b2, b3), (l4, _, l2) = (-layout.base).tolist(), (-layout.platform).tolist()
        return cls(b2 * (l2 - l4) + b3 * l4, b3 * l2 * l4, b2 * b3 * l2, l4)


@dataclass(frozen=True)
class SingularCase:
    """How the lines of the three forces depend on each other.

    Attributes:
        kind: Three lines through a point, or parallel.
        point: Where they meet, (2,) in X-Z [m]; None if parallel.
        freedom: Unit motion (x, w, alpha) that no actuator resists, (3,), lengths in parts of L1.
    """

    kind: Literal["concurrent", "parallel"]
    point: Array | None
    freedom: Array


def is_degenerate(layout: Layout) -> bool:
    """Whether K = 0: hinges in like proportions on base and platform, and det J = 0 at every pose with alpha = 0."""
    (_, b2, b3), (l4, _, l2) = (-layout.base).tolist(), (-layout.platform).tolist()
    return bool(abs(b2 * (l2 - l4) + b3 * l4) <= DEGENERATE * (b2 * (l2 + l4) + b3 * l4))


def determinant(layout: Layout, poses: ArrayLike) -> Array:
    """``det J`` of the velocity Jacobian, from the formula above.

    Args:
        layout: Hinges.
        poses: (x, w, alpha), (..., 3) [m, m, rad].

    Returns:
        (...) [m]; NaN where a limb has no length.
    """
    given = triples("poses", poses)
    with np.errstate(divide="ignore", invalid="ignore"):
        return surface_value(layout, given) / limb_lengths(layout, given).prod(axis=-1)


def surface_value(layout: Layout, poses: ArrayLike) -> Array:
    """``q1 q2 q3 det J``: a polynomial in x, w, sin alpha and cos alpha, zero on the singular surface, (...) [m4]."""
    given, c = triples("poses", poses), SurfaceConstants.of(layout)
    x, w, alpha = np.moveaxis(given, -1, 0)
    cosine, sine = np.cos(alpha), np.sin(alpha)
    return -((x * sine + w * cosine) * (c.k * w + c.a * sine) + c.b * sine * (w + c.l4 * sine))


def singular_x(layout: Layout, w: ArrayLike, alpha: ArrayLike) -> Array:
    """The singular surface: x at which a pose of given w and alpha is singular.

    Args:
        layout: Hinges.
        w: (...) [m].
        alpha: (...) [rad].

    Returns:
        (...) [m]; NaN where there is none, as for alpha = 0.
    """
    c = SurfaceConstants.of(layout)
    height, turn = np.asarray(w, dtype=np.float64), np.asarray(alpha, dtype=np.float64)
    cosine, sine = np.cos(turn), np.sin(turn)
    arm = c.k * height + c.a * sine
    with np.errstate(divide="ignore", invalid="ignore"):
        x = -height * cosine / sine - c.b * (height + c.l4 * sine) / arm
    return np.where(np.isfinite(x) & (np.abs(sine) > LEVEL), x, np.nan)


def singular_case(layout: Layout, pose: ArrayLike) -> SingularCase:
    """Which of the two geometric cases a singular pose is.

    Args:
        layout: Hinges.
        pose: A pose on the surface, (3,) [m, m, rad].

    Returns:
        The case, where the lines meet, and the motion that is free. Of a pose near the surface, that of the nearest
        rank-2 matrix.
    """
    given = triples("pose", pose)
    vectors = limb_vectors(layout, given)
    lengths = np.hypot(*vectors.T)
    if not (lengths > 0.0).all():
        raise InputError("pose", f"limb {int(np.argmin(lengths)) + 1} has no length", "three limbs with a direction")
    n = vectors / lengths[:, None]
    unit = layout.lengths[0]
    points = np.stack((layout.base, np.zeros(3)), axis=-1)
    moments = (points[:, 1] * n[:, 0] - points[:, 0] * n[:, 1]) / unit  # about Y at O1
    freedom = np.linalg.svd(np.column_stack((n, moments)))[2][-1]
    v_x, v_z, turn = freedom
    x, w = given[:2] / unit
    at_platform = np.array([v_x + w * turn, v_z - x * turn, turn])
    at_platform /= np.linalg.norm(at_platform)
    if abs(turn) <= PARALLEL or np.abs(n[:, 0] * n[0, 1] - n[:, 1] * n[0, 0]).max() <= PARALLEL:
        return SingularCase("parallel", None, at_platform)
    # The lines meet where the free motion has no velocity: v_x + z turn = 0, v_z - x turn = 0.
    return SingularCase("concurrent", unit * np.array([v_z, -v_x]) / turn, at_platform)


def singularity_distance(layout: Layout, poses: ArrayLike) -> Array:
    """How far the platform is from the singular surface when it moves without turning.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].

    Returns:
        Least distance in (x, w) to the surface at the pose's alpha, (...) [m]: at alpha = 0 or 180 degrees |w|, as all
        limbs lie along X at w = 0, or 0 if the mechanism is degenerate.
    """
    given, c = triples("poses", poses), SurfaceConstants.of(layout)
    flat = given.reshape(-1, 3)
    degenerate = is_degenerate(layout)
    return np.array([_distance(c, degenerate, *pose) for pose in flat.tolist()]).reshape(given.shape[:-1])


def singularity_turn(layout: Layout, poses: ArrayLike) -> Array:
    """How far the platform can turn about O2, either way, before it meets the singular surface.

    Args:
        layout: Hinges.
        poses: (..., 3) [m, m, rad].

    Returns:
        Least turn, (...) [rad]; below pi, as det J at alpha + pi has the other sign at alpha = 0.
    """
    given, c = triples("poses", poses), SurfaceConstants.of(layout)
    flat = given.reshape(-1, 3)
    return np.array([_turn(c, *pose) for pose in flat.tolist()]).reshape(given.shape[:-1])


def _distance(c: SurfaceConstants, degenerate: bool, x: float, w: float, alpha: float) -> float:
    """Distance in the plane to the conic det J = 0: ``K cos^2(a/2)`` and ``-K sin^2(a/2)`` are its curvatures."""
    if not (math.isfinite(x) and math.isfinite(w) and math.isfinite(alpha)):
        return math.nan
    cosine, sine = math.cos(alpha), math.sin(alpha)
    if abs(sine) <= LEVEL:
        return 0.0 if degenerate else abs(w)
    normal, arm = x * sine + w * cosine, c.k * w + c.a * sine
    value = normal * arm + c.b * sine * (w + c.l4 * sine)
    by_x, by_w = sine * arm, cosine * arm + c.k * normal + c.b * sine
    along, across = math.cos(0.5 * alpha), math.sin(0.5 * alpha)
    slopes = (across * by_x + along * by_w, along * by_x - across * by_w)
    centre = c.b * sine**2 * (c.l4 - c.a / c.k) if c.k != 0.0 else math.nan
    return conic_distance(value, slopes, (c.k * along**2, -c.k * across**2), centre)


def _turn(c: SurfaceConstants, x: float, w: float, alpha: float) -> float:
    """Least turn to the surface: its roots in ``e^(i alpha)``, a quartic."""
    if not (math.isfinite(x) and math.isfinite(w) and math.isfinite(alpha)):
        return math.nan
    half = 0.5 * (c.a * x + c.b * c.l4)
    second = 0.5 * complex(-half, -0.5 * c.a * w)
    first = 0.5 * complex(c.k * w * w, -(c.k * x + c.b) * w)
    roots = np.roots([second, first, half, first.conjugate(), second.conjugate()])
    angles = np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-6])
    if angles.size == 0:
        return 0.0  # w = 0 and A x + B L4 = 0: singular at every alpha
    return float(np.abs(np.angle(np.exp(1j * (angles - alpha)))).min())
