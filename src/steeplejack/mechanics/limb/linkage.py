"""A linkage as data: links, the joints between them in one closed reference configuration, the fixed link, the output.

The form is a graph, so that single loops, platforms on limbs and linkages with cross-bars are the same kind of file.
Axes and points are in the frame of the fixed link, SI.
"""

from __future__ import annotations

import math
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from steeplejack.errors import InputError
from steeplejack.mechanics.limb.screws import helical, prismatic, revolute

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Kind = Literal["revolute", "prismatic", "helical", "cylindrical", "universal", "spherical", "planar"]

NEEDED: dict[str, tuple[str, ...]] = {
    "revolute": ("axis", "point"),
    "prismatic": ("axis",),
    "helical": ("axis", "point", "pitch"),
    "cylindrical": ("axis", "point"),
    "universal": ("axis", "second_axis", "point"),
    "spherical": ("point",),
    "planar": ("axis",),
}
"""What a joint of each kind has to say."""
LETTERS: dict[str, str] = {kind: kind[0].upper() for kind in NEEDED} | {"planar": "E"}
FREEDOMS = {"revolute": 1, "prismatic": 1, "helical": 1, "cylindrical": 2, "universal": 2, "spherical": 3, "planar": 3}
SHORTEST_AXIS = 1e-9
"""Length of a direction below which it is none, and sine between the axes of a universal joint likewise [1]."""
LARGEST = 1e12
"""Number beyond which a coordinate is a mistake [m]."""
MOST_FREEDOMS = 120
"""Sum over the joints; a linkage of more would take minutes."""


class Joint(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A lower pair between two links.

    Attributes:
        name: Of its own.
        kind: Which pair; ``planar`` slides on a plane and turns about its normal.
        links: The two links; coordinates are of the second relative to the first.
        axis: Direction of the axis, of a universal joint the one fixed in the first link, of a planar one the normal.
        second_axis: Of a universal joint: the axis fixed in the second link.
        point: On the axis, or the centre [m].
        pitch: Of a helical joint: travel a radian [m/rad].
        actuated: Whether a motor holds it.
    """

    name: str
    kind: Kind
    links: tuple[str, str]
    axis: Vector | None = None
    second_axis: Vector | None = None
    point: Vector | None = None
    pitch: float | None = None
    actuated: bool = False

    def __post_init__(self) -> None:
        """Refuse a joint without what its kind needs, with what it has no use for, or with no direction."""
        where = f"joint {self.name!r}"
        if self.kind not in NEEDED:
            raise InputError(where, f"kind {self.kind!r}", f"one of {', '.join(NEEDED)}")
        needed = NEEDED[self.kind]
        for field in ("axis", "second_axis", "point", "pitch"):
            value, optional = getattr(self, field), field == "point" and self.kind in ("prismatic", "planar")
            if value is None and field in needed:
                raise InputError(where, f"a {self.kind} joint without {field}", f"one with {', '.join(needed)}")
            if value is not None and field not in needed and not optional:
                raise InputError(where, f"a {self.kind} joint with {field}", f"one with {', '.join(needed)} only")
            if value is not None:
                _check_field(where, field, value)
        if self.links[0] == self.links[1]:
            raise InputError(where, f"joins {self.links[0]!r} to itself", "two different links")
        if self.kind == "universal" and np.linalg.norm(np.cross(*self._axes())) <= SHORTEST_AXIS:
            raise InputError(where, "axis and second_axis are parallel", "two directions that differ")

    @property
    def freedoms(self) -> int:
        """How many."""
        return FREEDOMS[self.kind]

    def twists(self, origin: Array | None = None) -> Array:
        """Its freedoms one after the other, first link to second, as unit twists (freedoms, 6) [1; m].

        Args:
            origin: Where a planar joint without a point is thought to turn, (3,) [m]; any place will do.
        """
        point = np.zeros(3) if origin is None else origin
        if self.point is not None:
            point = np.array(self.point)
        if self.kind == "spherical":
            return revolute(np.eye(3), point)
        axes = self._axes()
        if self.kind == "universal":
            return revolute(axes, point)
        axis = axes[:1]
        if self.kind == "prismatic":
            return prismatic(axis)
        if self.kind == "cylindrical":
            return np.concatenate((revolute(axis, point), prismatic(axis)))
        if self.kind == "planar":
            return np.concatenate((prismatic(_across(axis[0])), revolute(axis, point)))
        return helical(axis, point, self.pitch or 0.0)

    def _axes(self) -> Array:
        """Unit directions of the axes it has."""
        given = np.array([axis for axis in (self.axis, self.second_axis) if axis is not None])
        given /= np.abs(given).max(axis=1, keepdims=True)
        return given / np.linalg.norm(given, axis=1, keepdims=True)


class Linkage(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Links and joints in a closed reference configuration.

    Attributes:
        name: What to call it.
        description: What it is.
        source: Where its arrangement comes from.
        links: Names of all links, the fixed one included.
        base: The fixed link.
        output: The link whose freedoms are asked for.
        joints: Between them, at least one.
    """

    name: str
    description: str
    source: str
    links: tuple[str, ...]
    base: str
    output: str
    joints: tuple[Joint, ...]

    def __post_init__(self) -> None:
        """Refuse names that do not fit together and links that hang in the air."""
        if not self.joints:
            raise InputError("joints", "none", "at least one")
        if sum(joint.freedoms for joint in self.joints) > MOST_FREEDOMS:
            count = sum(joint.freedoms for joint in self.joints)
            raise InputError("joints", f"{count} freedoms", f"at most {MOST_FREEDOMS} in all")
        _check_unique("links", self.links)
        _check_unique("joints", tuple(joint.name for joint in self.joints))
        for field in ("base", "output"):
            if getattr(self, field) not in self.links:
                raise InputError(field, f"unknown link {getattr(self, field)!r}", f"one of {_listed(self.links)}")
        if self.base == self.output:
            raise InputError("output", f"{self.output!r} is the base as well", "another link")
        for joint in self.joints:
            for link in joint.links:
                if link not in self.links:
                    raise InputError(f"joint {joint.name!r}", f"unknown link {link!r}", f"one of {_listed(self.links)}")
        _check_connected(self)


def _across(axis: Array) -> Array:
    """Two unit directions (2, 3) that span the plane normal to a unit vector (3,)."""
    nearest = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = nearest - axis * (axis @ nearest)
    first /= np.linalg.norm(first)
    return np.stack((first, np.asarray(np.cross(axis, first), dtype=np.float64)))


def _check_field(where: str, field: str, value: float | Vector) -> None:
    """Refuse numbers that are none, and directions without length."""
    count = 1 if field == "pitch" else 3
    try:
        numbers = [float(number) for number in np.atleast_1d(value)]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count:
        raise InputError(where, f"{field} = {value!r}", f"{count} number{'s' if count > 1 else ''}")
    if not all(math.isfinite(number) for number in numbers):
        raise InputError(where, f"{field} has a number that is not finite", "finite numbers")
    if max(map(abs, numbers)) > LARGEST:
        raise InputError(
            where, f"{field} has a number beyond {LARGEST:g}", "metres, and directions of about unit length"
        )
    if "axis" in field and math.hypot(*numbers) <= SHORTEST_AXIS:
        raise InputError(where, f"{field} has no length", "a direction such as [0, 0, 1]")


def _check_unique(field: str, names: tuple[str, ...]) -> None:
    for name in names:
        if not name.strip() or not name.isprintable():
            raise InputError(field, f"the name {name!r}", "names that can be read")
        if names.count(name) > 1:
            raise InputError(field, f"{name!r} twice", "a name once")


def _check_connected(linkage: Linkage) -> None:
    """Refuse links that no chain of joints connects to the base."""
    reached, grown = {linkage.base}, True
    while grown:
        new = {link for joint in linkage.joints if reached & set(joint.links) for link in joint.links} - reached
        reached, grown = reached | new, bool(new)
    loose = [link for link in linkage.links if link not in reached]
    if loose:
        raise InputError("links", f"{_listed(loose)} not connected to {linkage.base!r}", "one connected linkage")


def _listed(names: tuple[str, ...] | list[str]) -> str:
    """Some names, not hundreds."""
    shown = ", ".join(repr(name) for name in names[:8])
    return shown if len(names) <= 8 else f"{shown} and {len(names) - 8} more"
