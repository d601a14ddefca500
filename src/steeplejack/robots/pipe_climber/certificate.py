"""Proof of the number of forward-kinematics solutions: the cubic in exact rationals, its roots in balls (FLINT).

Lengths and dimensions are binary fractions, so the coefficients of the cubic of `forward` are exact rationals. FLINT
factors it and encloses every real root with its multiplicity; whether a root lies in [-1, 1] is decided by precision,
and at the ends by the exact values ``f(1)`` and ``f(-1)``. What comes out is true of the numbers as stored, double
roots included, and every pose has a bound on its error. About a tenth of a millisecond a triple: for single questions
and for tests; `forward` answers millions a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from flint import acb, arb, ctx, fmpq, fmpq_poly

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.layout import Layout
from steeplejack.robots.pipe_climber.modes import Mode
from steeplejack.robots.pipe_climber.singularity import is_degenerate

PRECISION = 200
"""Bits of the balls; doubled where a root lies that close to an end."""


@dataclass(frozen=True)
class CertifiedPose:
    """A pose proved to exist.

    Attributes:
        pose: (x, w, alpha) [m, m, rad], rounded from the enclosure.
        error: Largest distance of any entry from the exact one [m or rad].
        mode: Its assembly mode; "singular" where two modes meet in it.
        multiplicity: 1, or 2 and more where it is a multiple solution.
    """

    pose: tuple[float, float, float]
    error: float
    mode: Mode | Literal["singular", "singular-mirrored"]
    multiplicity: int


@dataclass(frozen=True)
class _Cubic:
    """``f`` and the affine functions it is made of, in exact rationals of c = cos alpha."""

    f: fmpq_poly
    r: fmpq_poly
    x: fmpq_poly
    v: fmpq_poly


def certified_poses(layout: Layout, lengths: Sequence[float]) -> list[CertifiedPose]:
    """Every real pose of three limb lengths, each proved, and proved to be all.

    Args:
        layout: Hinges.
        lengths: q_1 to q_3 [m], taken as the exact binary fractions they are stored as.

    Returns:
        None, or four in the order of `MODES`; fewer where solutions coincide.

    Raises:
        InputError: Lengths that are not three finite numbers above 0, or a mechanism with K = 0.
    """
    if len(lengths) != 3 or not all(0.0 < length < math.inf for length in lengths):
        raise InputError("lengths", f"{[float(length) for length in lengths]} m", "three finite lengths above 0 m")
    if is_degenerate(layout):
        raise InputError("dimensions", f"{list(layout.lengths)} m", "joints in unlike proportions on base and platform")
    cubic = _cubic(layout, [_exact(length) for length in lengths])
    bits = PRECISION
    while (found := _roots(cubic.f, bits)) is None:
        bits *= 2
    with ctx.workprec(bits):
        real = [(pose, multiplicity) for c, multiplicity, end in found if (pose := _pose(cubic, c, end)) is not None]
    names: tuple[Mode, Mode] = ("home", "across")
    upper = [
        _rounded(pose, name if multiplicity == 1 else "singular", multiplicity)
        for (pose, multiplicity), name in zip(real, names, strict=False)
    ]
    return upper + [_mirrored(one) for one in upper if not (one.pose[1] == 0.0 and one.pose[2] in (0.0, math.pi))]


def _exact(value: float) -> fmpq:
    return fmpq(*float(value).as_integer_ratio())


def _cubic(layout: Layout, lengths: list[fmpq]) -> _Cubic:
    """The linear system for (R, v, x) solved, and the cubic it leaves; see `forward`."""
    b2, b3 = (_exact(-place) for place in layout.base[1:])
    l4, l2 = _exact(-layout.platform[0]), _exact(-layout.platform[2])
    k = b2 * (l2 - l4) + b3 * l4
    g1, g2 = lengths[0] ** 2 - l4**2, lengths[1] ** 2 - b2**2
    g3 = fmpq_poly([lengths[2] ** 2 - l2**2 - b3**2, 2 * b3 * l2])
    c = fmpq_poly([0, 1])
    r = (fmpq_poly([l2 * b2 * g1 + b3 * l4 * g2]) - l4 * b2 * g3) / k
    x, v = (g2 - r) / (2 * b2), (r - g1) / (2 * l4)
    return _Cubic(r * (1 - c * c) - x * x - v * v + 2 * x * v * c, r, x, v)


def _roots(f: fmpq_poly, bits: int) -> list[tuple[arb, int, int]] | None:
    """Real roots in [-1, 1], the greatest first, with multiplicity and the end they lie at (0 inside).

    None if more bits are needed.
    """
    inside: list[tuple[arb, int, int]] = []
    with ctx.workprec(bits):
        roots: list[tuple[acb, int]] = f.complex_roots()  # pyright: ignore[reportAssignmentType]
        for complex_root, multiplicity in roots:
            root = complex_root.real
            if not complex_root.imag.is_zero():  # exactly zero for real roots, and never else
                continue
            end = next((end for end in (-1, 1) if root.overlaps(arb(end))), 0)
            if end and f(end) != 0:
                return None
            if end or (root > -1 and root < 1):
                inside.append((root, multiplicity, end))
    return sorted(inside, key=lambda root: float(root[0].mid()), reverse=True)


def _pose(cubic: _Cubic, c: arb, end: int) -> tuple[arb, arb, arb] | None:
    """Enclosure of the pose with w >= 0 of a root; None where w is not real, which only an end allows."""
    if end:
        x, r = cubic.x(end), cubic.r(end)
        square = r - x * x
        if square < 0:
            return None
        return _ball(x), _ball(square).sqrt(), arb(0) if end > 0 else arb.pi()
    x, v = _at(cubic.x, c), _at(cubic.v, c)
    s = (1 - c * c).sqrt()
    w = (x * c - v) / s
    alpha = c.acos()
    return (x, -w, -alpha) if w < 0 else (x, w, alpha)


def _ball(value: fmpq) -> arb:
    return arb(value.p) / arb(value.q)


def _at(poly: fmpq_poly, c: arb) -> arb:
    """An affine polynomial at a ball."""
    return _ball(poly[0]) + _ball(poly[1]) * c


def _rounded(
    pose: tuple[arb, arb, arb], mode: Mode | Literal["singular", "singular-mirrored"], multiplicity: int
) -> CertifiedPose:
    """A pose in doubles with a bound on what rounding and the enclosure add."""
    x, w, alpha = (float(entry.mid()) for entry in pose)
    error = max(float((ball - arb(value)).abs_upper()) for ball, value in zip(pose, (x, w, alpha), strict=True))
    return CertifiedPose((x, w, alpha), error, mode, multiplicity)


def _mirrored(one: CertifiedPose) -> CertifiedPose:
    """The pose on the other side of the base."""
    x, w, alpha = one.pose
    names: dict[str, Mode | Literal["singular-mirrored"]] = {
        "home": "home-mirrored",
        "across": "across-mirrored",
        "singular": "singular-mirrored",
    }
    return CertifiedPose((x, 0.0 - w, 0.0 - alpha), one.error, names[one.mode], one.multiplicity)
