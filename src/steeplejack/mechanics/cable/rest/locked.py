"""A platform on cables whose winches are locked: what its equilibria follow from, in one frozen value.

Planar robots live in the plane z = 0 of space with the freedoms (x, y, phi); one set of formulas serves both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.cable.arguments import number, numbers
from steeplejack.mechanics.cable.pose.tracking import PLANAR, SPATIAL
from steeplejack.mechanics.cable.pulleys import in_space, pulley_radii, unit_axes

Array = NDArray[np.float64]

GREATEST = 1e100
"""Of coordinates [m], forces [N] and moments [N m]: squares of larger ones, of which energies are made, overflow. Those
of forces below its inverse vanish."""


@dataclass(frozen=True, eq=False)
class LockedPlatform:
    """Geometry, unstressed lengths, elasticity and loads, all in space; made by `planar` or `spatial`.

    Attributes:
        anchors: (m, 3) [m].
        attachments: In the platform frame from its reference point, (m, 3) [m].
        unstressed: Lengths paid out, arcs on pulleys included, (m,) [m].
        axial_stiffness: ``EA``, infinite for inextensible cables, (m,) [N].
        forces: Constant forces, the weight first, (j, 3) [N].
        points: Where they act in the platform frame, the centre of mass first, (j, 3) [m].
        moment: Constant moment about z; 0 in space, where none has a potential [N m].
        in_plane: Whether only (x, y, phi) move.
        axes: Unit swivel axes of the pulleys, (m, 3).
        radii: Of the pulleys, (m,) [m].
        gyration: Radius that weighs rotation against translation, of the mass where it is known [m].
    """

    anchors: Array
    attachments: Array
    unstressed: Array
    axial_stiffness: Array
    forces: Array
    points: Array
    moment: float
    in_plane: bool
    axes: Array
    radii: Array
    gyration: float

    @classmethod
    def planar(
        cls,
        anchors: ArrayLike,
        attachments: ArrayLike,
        unstressed: ArrayLike,
        weight: ArrayLike,
        *,
        axial_stiffness: ArrayLike = np.inf,
        centre: ArrayLike = (0.0, 0.0),
        moment: float = 0.0,
        radii: ArrayLike | None = None,
        axes: ArrayLike | None = None,
        gyration: float | None = None,
    ) -> LockedPlatform:
        """A platform in the plane.

        Args:
            anchors: (m, 2) [m].
            attachments: (m, 2) [m].
            unstressed: (m,) [m].
            weight: With any other constant force at the centre, (2,) [N].
            axial_stiffness: ``EA``, (m,) or a scalar [N]; inextensible cables by default.
            centre: Where the weight acts, in the platform frame, (2,) [m].
            moment: Constant, counter-clockwise [N m].
            radii: Of pulleys, (m,) or a scalar [m]; straight cables where not given.
            axes: Swivel axes in the plane, see `pulleys`, (m, 2); needed with radii.
            gyration: Radius of gyration about the centre [m]; that of the attachments by default.

        Returns:
            The platform.

        Raises:
            InputError: A shape does not fit or a number is not usable; the message names it.
        """
        return _made(
            2, anchors, attachments, unstressed, axial_stiffness, [weight], [centre], moment, radii, axes, gyration
        )

    @classmethod
    def spatial(
        cls,
        anchors: ArrayLike,
        attachments: ArrayLike,
        unstressed: ArrayLike,
        weight: ArrayLike,
        *,
        axial_stiffness: ArrayLike = np.inf,
        centre: ArrayLike = (0.0, 0.0, 0.0),
        forces: ArrayLike = (),
        points: ArrayLike = (),
        radii: ArrayLike | None = None,
        axes: ArrayLike | None = None,
        gyration: float | None = None,
    ) -> LockedPlatform:
        """A platform in space.

        Args:
            anchors: (m, 3) [m].
            attachments: (m, 3) [m].
            unstressed: (m,) [m].
            weight: (3,) [N].
            axial_stiffness: ``EA``, (m,) or a scalar [N]; inextensible cables by default.
            centre: Where the weight acts, in the platform frame, (3,) [m].
            forces: Further constant forces in world axes, (j, 3) [N]; a moment constant in the world has no potential.
            points: Where they act, in the platform frame, (j, 3) [m].
            radii: Of pulleys, (m,) or a scalar [m]; straight cables where not given.
            axes: Swivel axes, see `pulleys`, (m, 3); needed with radii.
            gyration: Radius of gyration about the centre [m]; that of the attachments by default.

        Returns:
            The platform.

        Raises:
            InputError: A shape does not fit or a number is not usable; the message names it.
        """
        more, where = (_rows(name, value) for name, value in (("forces", forces), ("points", points)))
        if len(more) != len(where):
            raise InputError("points", f"{len(where)} for {len(more)} forces", "one for each force")
        loads, places = [weight, *more], [centre, *where]
        return _made(3, anchors, attachments, unstressed, axial_stiffness, loads, places, 0.0, radii, axes, gyration)

    @property
    def freedoms(self) -> NDArray[np.int64]:
        """Which of (omega; v) move, in the order of a pose, (n,)."""
        return PLANAR if self.in_plane else SPATIAL

    @property
    def load(self) -> float:
        """Sum of the sizes of all forces, the moment over the radius of gyration included [N]."""
        return float(np.linalg.norm(self.forces, axis=1).sum()) + abs(self.moment) / self.gyration


def _made(
    d: int,
    anchors: ArrayLike,
    attachments: ArrayLike,
    unstressed: ArrayLike,
    axial_stiffness: ArrayLike,
    forces: list[ArrayLike],
    points: list[ArrayLike],
    moment: float,
    radii: ArrayLike | None,
    axes: ArrayLike | None,
    gyration: float | None,
) -> LockedPlatform:
    """Check everything once and move it to space."""
    fixed = _points("anchors", anchors, d)
    m = len(fixed)
    local = _points("attachments", attachments, d)
    if len(local) != m or m == 0:
        raise InputError("attachments", f"{len(local)} for {m} anchors", "one for each of at least one anchor")
    lengths = _positive("unstressed", unstressed, m, np.inf)
    elastic = _positive("axial_stiffness", axial_stiffness, m, None)
    loads, places = _points("forces", forces, d), _points("points", points, d)
    wheels = pulley_radii(radii, m)
    if wheels.any() and axes is None:
        raise InputError("axes", "none", f"swivel axes of the pulleys, ({m}, {d})")
    swivels = unit_axes(axes, m)
    if swivels.shape != (m, 3) or not np.isfinite(swivels).all():
        raise InputError("axes", "not usable", f"({m}, {d}) finite and none of length zero")
    if loads.any() and np.abs(loads).max() * GREATEST < 1.0:
        raise InputError("forces", f"{np.abs(loads).max():g} N", f"none, or at least {1.0 / GREATEST:g} N")
    turning = _number("moment", moment, "N m")
    spread = local - places[0]
    radius = (
        float(np.sqrt(np.mean(np.sum(spread * spread, axis=1))))
        if gyration is None
        else _number("gyration", gyration, "m")
    )
    if gyration is not None and not radius > 0.0:
        raise InputError("gyration", f"{radius:g} m", "a finite radius above 0")
    return LockedPlatform(
        fixed, local, lengths, elastic, loads, places, turning, d == 2, swivels, wheels, radius or lengths.max()
    )


def _number(where: str, value: float, unit: str) -> float:
    """One finite number."""
    given = number(where, value)
    if not abs(given) <= GREATEST:
        raise InputError(where, f"{given:g}", f"a finite number of {unit}, at most {GREATEST:g}")
    return given


def _points(where: str, values: ArrayLike | list[ArrayLike], d: int) -> Array:
    """Finite points (k, d) in space (k, 3)."""
    given = numbers(where, cast(ArrayLike, values))
    if given.ndim != 2 or given.shape[1] != d or not np.isfinite(given).all():
        raise InputError(where, f"shape {given.shape}", f"(k, {d}), all finite")
    if np.abs(given).max(initial=0.0) > GREATEST:
        raise InputError(where, f"{np.abs(given).max():g}", f"at most {GREATEST:g}")
    return in_space(given)


def _rows(where: str, values: ArrayLike) -> Array:
    """Points or forces (j, 3), none where there are none."""
    given = numbers(where, values)
    if given.size and (given.ndim not in (1, 2) or given.shape[-1] != 3):
        raise InputError(where, f"shape {given.shape}", "(j, 3)")
    return given.reshape(-1, 3)


def _positive(where: str, values: ArrayLike, count: int, below: float | None) -> Array:
    """Numbers above 0, one for each cable; finite where ``below`` says so."""
    given = numbers(where, values)
    if given.shape not in ((), (count,)):
        raise InputError(where, f"shape {given.shape}", f"one number or {count}")
    if not np.all(given > 0.0) or (below is not None and not np.all(given < below)):
        raise InputError(where, f"{np.ravel(given).tolist()}", "numbers above 0" + (", finite" if below else ""))
    return np.array(np.broadcast_to(given, (count,)))
