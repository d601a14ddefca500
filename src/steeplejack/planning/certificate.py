"""Is the platform held at a place, and if not, which limit binds?

A pose is good where an equilibrium exists within the tension, pull and twist limits less their reserve, it is stable,
the cables steer the platform in their plane, and platform and driving cables clear every stay. The fast survey fixes
the platform's orientation to find candidates (attachment radius over cable length changes the cables' directions by
about one per cent); whatever enters a plan is certified with the orientation of its own equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.mechanics.cable.region import clearance
from steeplejack.mechanics.cable.rest import statics
from steeplejack.robots.squad import in_plane, suspension
from steeplejack.robots.squad.anchorage import ALONG, exits, limits
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]

BALANCED = 1e-6
"""Force left over an equilibrium, of the weight, and moment, of the weight at the attachments' radius [1]."""
LEAP = np.deg2rad(15.0)
"""Turn between neighbouring places of a way from which they are two equilibria, not one that moves; estimate [rad]."""


@dataclass(frozen=True)
class Rules:
    """What a plan must respect beyond the machine's own limits; every number an estimate unless the user gives it."""

    tension: tuple[float, float]  # [N] working window
    payload: float = 0.0  # [kg] carried at the platform's centre of mass
    reserve: float = 0.10  # [1] of every tension, pull and twist limit
    cable_clearance: float = 0.02  # [m] between a driving cable and a stay's surface
    dexterity: float = 0.2  # [1] least over largest singular value of the structure matrix in the plane of the cables
    cell_length: float = 12.0  # [m] along the stays, inspected from one stance


@dataclass(frozen=True)
class Scene:
    """A bay, a machine and the rules, with the arrays the kernels take."""

    bay: Bay
    squad: Squad
    rules: Rules
    gravity: tuple[float, float, float]  # [m/s2] of the worksite
    axes: Array  # (stays, nodes, 3) [m] polylines
    radii: Array  # (stays,) [m]

    @classmethod
    def of(cls, bay: Bay, squad: Squad, rules: Rules, gravity: Array) -> Scene:
        """Tabulate the stays' axes over their whole length."""
        return cls(bay, squad, rules, tuple(gravity), np.empty((0, 0, 3)), np.empty(0)).around(0.0, bay.reach)

    def around(self, low: float, high: float) -> Scene:
        """The same scene with the polylines cut to [low, high] and the reach of the cables about it.

        Nodes every 4 m: at the curvature of a 550 m stay sagging 5 m the polyline stays within 0.3 mm of the axis.
        """
        nodes = max(2, int(np.ceil((high - low) / 4.0)) + 1)
        axes = np.stack([stay.position(np.linspace(low, min(high, stay.length), nodes)) for stay in self.bay.stays])
        radii = np.array([self.bay.radius(k) for k in range(len(self.bay.stays))])
        return replace(self, axes=axes, radii=radii)

    @property
    def mass(self) -> float:
        """Platform with payload [kg]."""
        return self.squad.platform.mass + self.rules.payload

    @property
    def weight(self) -> Array:
        """Gravity force on the platform (3,) [N]."""
        return self.mass * np.asarray(self.gravity)

    @property
    def attachments(self) -> Array:
        """Attachments (4, 3) [m], platform frame."""
        return np.array(self.squad.platform.attachments)

    @property
    def centre(self) -> Array:
        """Centre of mass (3,) [m], platform frame."""
        return np.array(self.squad.platform.centre_of_mass)

    @property
    def window(self) -> tuple[Array, Array]:
        """Bounds on the four tensions, reserve taken off both ends (4,) [N]."""
        low, high = self.rules.tension
        return np.full(4, low * (1.0 + self.rules.reserve)), np.full(4, high * (1.0 - self.rules.reserve))

    @property
    def target(self) -> Array:
        """Tensions an equilibrium is kept near to where it can choose (4,) [N]: under the middle of the window."""
        low, high = self.rules.tension
        return np.full(4, low + 0.4 * (high - low))

    @property
    def own(self) -> NDArray[np.int64]:
        """Boundary stay of each base (4,)."""
        return np.array(self.bay.carriers)

    def anchors(self, s: Array, clock: Array, driving: int | None = None) -> tuple[Array, Array]:
        """Winch exits (..., 4, 3) [m] and linear limits (..., 2, 4, 4) of bases at ``s`` and ``clock``."""
        points, tangents, arms = exits(self.bay, self.squad, s, clock)
        return points, limits(self.squad, tangents, arms, self.rules.reserve, driving)


@njit(cache=True)
def survey(
    anchors: Array,
    pull: Array,
    attachments: Array,
    weight: Array,
    rotation: Array,
    points: Array,
    lower: Array,
    upper: Array,
) -> Array:
    """Room [N] of every point under every stance at one fixed orientation (a, n); negative where not held.

    Args:
        anchors: Winch exits (a, 4, 3) [m].
        pull: Linear limits (a, 2, 4, 4).
        attachments: Attachments (4, 3) [m].
        weight: Gravity force (3,) [N].
        rotation: Orientation (3, 3) taken for every point.
        points: Platform positions (n, 3) [m].
        lower: Least tensions (4,) [N].
        upper: Largest tensions (4,) [N].
    """
    out = np.empty((anchors.shape[0], points.shape[0]))
    for a in range(anchors.shape[0]):
        for j in range(points.shape[0]):
            u, _lengths = statics.directions(anchors[a], attachments, points[j], rotation)
            particular, null, independent = suspension.force_family(u, weight)
            if not independent:
                out[a, j] = -np.inf
                continue
            bound, _which = suspension.upper_bounds(u, pull[a], upper)
            low, high, _l, _h = suspension.interval(particular, null, lower, bound)
            out[a, j] = high - low
    return out


@njit(cache=True)
def certify(
    anchors: Array,
    pull: Array,
    attachments: Array,
    weight: Array,
    centre: Array,
    points: Array,
    guess: Array,
    lower: Array,
    upper: Array,
    target: Array,
    cable_stiffness: float,
    axes: Array,
    radii: Array,
    own: NDArray[np.int64],
) -> tuple[Array, Array, Array]:
    """Equilibria at n places, each with its own anchors.

    Args:
        anchors: Winch exits (n, 4, 3) [m].
        pull: Linear limits (n, 2, 4, 4).
        attachments: Attachments (4, 3) [m].
        weight: Gravity force (3,) [N].
        centre: Centre of mass (3,) [m].
        points: Platform positions (n, 3) [m].
        guess: Orientation to start from (3, 3).
        lower: Least tensions (4,) [N].
        upper: Largest tensions (4,) [N].
        target: Tensions to stay near to (n, 4) [N].
        cable_stiffness: EA [N].
        axes: Polylines of the stays (k, m, 3) [m].
        radii: Radii of the stays (k,) [m].
        own: Boundary stay of each base (4,).

    Returns:
        Rotations (n, 3, 3), tensions (n, 4) [N] and quality (n, 6): room [N], -inf where nothing balances, least pivot
        of the Hessian at locked winches (its sign decides), gap of the cables [m], gap of the platform's centre [m],
        longest cable [m], dexterity in the plane of the cables [1].
    """
    n = points.shape[0]
    rotations, tensions, quality = np.empty((n, 3, 3)), np.empty((n, 4)), np.empty((n, 6))
    for j in range(n):
        ends, stiff = np.empty((4, 3)), np.empty(4)
        rotation, t, room = suspension.hang(
            anchors[j], attachments, weight, centre, points[j], guess, lower, pull[j], upper, target[j]
        )
        u, lengths = statics.directions(anchors[j], attachments, points[j], rotation)
        for i in range(4):
            stiff[i] = cable_stiffness / lengths[i]
            ends[i] = points[j] + rotation @ attachments[i]
        hessian = statics.stiffness(attachments, weight, centre, rotation, u, lengths, t, stiff)
        if not _settled(u, t, attachments, weight, centre, rotation):
            room = -np.inf
        quality[j, 0] = room
        quality[j, 1] = statics.least_pivot(hessian)
        quality[j, 2], quality[j, 3] = clearance.cable_gap(anchors[j], ends, axes, radii, own)
        quality[j, 4] = np.max(lengths)
        quality[j, 5] = 0.0
        if room >= 0.0:  # elsewhere nothing is steered, and the eigenvalues cost as much as the rest
            matrix, _scale = in_plane.plane_matrix(u, rotation, attachments)
            quality[j, 5] = in_plane.dexterity(matrix)
        rotations[j], tensions[j] = rotation, t
    return rotations, tensions, quality


@njit(cache=True)
def _settled(u: Array, tension: Array, attachments: Array, weight: Array, centre: Array, rotation: Array) -> bool:
    """Whether forces and moments balance; the search for the orientation may end short of it."""
    force, moment = weight.copy(), np.cross(rotation @ centre, weight)
    for i in range(4):
        force += tension[i] * u[i]
        moment += np.cross(rotation @ attachments[i], tension[i] * u[i])
    size, radius = np.linalg.norm(weight), np.sqrt(np.max(np.sum(attachments**2, axis=1)))
    balanced = np.linalg.norm(force) <= BALANCED * size and np.linalg.norm(moment) <= BALANCED * size * radius
    return bool(balanced)


@dataclass(frozen=True)
class Held:
    """Equilibria at n places and whether each is good."""

    rotation: Array  # (n, 3, 3)
    tension: Array  # (n, 4) [N]
    quality: Array  # (n, 6), see :func:`certify`
    good: NDArray[np.bool_]  # (n,)

    @property
    def steady(self) -> NDArray[np.bool_]:
        """Of places along a way, which are near the orientation of the one before (n,)."""
        trace = np.einsum("nij,nij->n", self.rotation[1:], self.rotation[:-1])
        return np.concatenate(([True], trace >= 1.0 + 2.0 * np.cos(LEAP)))

    @property
    def along(self) -> NDArray[np.bool_]:
        """Of places along a way, which are good and steady (n,)."""
        return self.good & self.steady


def hold(scene: Scene, anchors: Array, pull: Array, places: Array, target: Array | None = None) -> Held:
    """Certify places (n, 3) = (eta, s, d) for winch exits (n, 4, 3) and limits (n, 2, 4, 4), or one of each for all.

    ``target`` are the tensions to stay near to (n, 4) [N]; without it those of the scene.
    """
    places = np.atleast_2d(places)
    n = len(places)
    middle = places[n // 2]
    lower, upper = scene.window
    # Copies, for a kernel is compiled once more for views that are read only.
    rotation, tension, quality = certify(
        np.broadcast_to(anchors, (n, 4, 3)).copy(),
        np.broadcast_to(pull, (n, 2, 4, 4)).copy(),
        scene.attachments,
        scene.weight,
        scene.centre,
        scene.bay.place(places[:, 0], places[:, 1], places[:, 2]),
        scene.bay.frame(float(middle[0]), float(middle[1])),
        lower,
        upper,
        np.broadcast_to(scene.target if target is None else target, (n, 4)).copy(),
        scene.squad.cable.axial_stiffness,
        scene.axes,
        scene.radii,
        scene.own,
    )
    return Held(rotation, tension, quality, meets(scene, quality))


def meets(scene: Scene, quality: Array, hair: float = 0.0) -> NDArray[np.bool_]:
    """Whether each row of :func:`certify`'s quality meets every limit, those of room and lengths but for a ``hair``.

    Args:
        scene: The machine and the rules.
        quality: Of n places (n, 6).
        hair: By which room [N], gaps and cable lengths [m] may miss; stability and dexterity may not.
    """
    good = (quality[:, 0] >= -hair) & (quality[:, 1] > 0.0)
    good &= quality[:, 2] >= scene.rules.cable_clearance - hair
    good &= quality[:, 3] >= scene.squad.platform.clearance - hair
    good &= quality[:, 5] >= scene.rules.dexterity
    return good & (quality[:, 4] <= scene.squad.winch.stored_length + hair)


def slip_margin(scene: Scene, anchors: Array, pull: Array, points: Array, rotation: Array, tension: Array) -> Array:
    """Least over gripped bases of 1 - pull along the stay / what a base holds (n,) [1]; below 0 one slips.

    Args:
        scene: The machine.
        anchors: Winch exits (..., 4, 3) [m].
        pull: Linear limits (..., 2, 4, 4), for the stays' tangents.
        points: Platform positions (n, 3) [m].
        rotation: Its orientations (n, 3, 3).
        tension: Of the cables (n, 4) [N].
    """
    towards = anchors - points[:, None] - np.einsum("nij,aj->nai", rotation, scene.attachments)
    share = np.abs(np.sum(towards * pull[..., ALONG, :, :3], axis=-1)) / np.linalg.norm(towards, axis=-1)
    return 1.0 - np.max(tension * share, axis=-1) / scene.squad.base.hold_force


def binding(scene: Scene, anchors: Array, pull: Array, place: Array) -> str:
    """In words, the limit that rules out a place (3,) for one set of anchors."""
    held = hold(scene, anchors, pull, place)
    if held.good[0]:
        return "none"
    room, least, cables, body, longest, dexterity = held.quality[0]
    if not np.isfinite(room):
        return "the four cables do not balance the weight in space"
    if room < 0.0:
        point = scene.bay.place(place[0], place[1], place[2])
        u, _lengths = statics.directions(anchors, scene.attachments, point, held.rotation[0])
        particular, null, _independent = suspension.force_family(u, scene.weight)
        lower, upper = scene.window
        bound, which = suspension.upper_bounds(u, pull, upper)
        _low, _high, at_low, at_high = suspension.interval(particular, null, lower, bound)
        return " against ".join(sorted(_bound_name(int(k), which) for k in {at_low, at_high}))
    if least <= 0.0:
        return "the equilibrium is unstable"
    if dexterity < scene.rules.dexterity:
        return (
            f"the cables hardly steer the platform in their plane: {dexterity:.2f}, {scene.rules.dexterity:.2f} asked"
        )
    if longest > scene.squad.winch.stored_length:
        return f"a cable would be {longest:.0f} m long, {scene.squad.winch.stored_length:.0f} m are stored"
    if cables < scene.rules.cable_clearance:
        return f"a driving cable passes {cables:.2f} m from a stay, {scene.rules.cable_clearance:.2f} m asked"
    return f"the platform's centre is {body:.2f} m from a stay, {scene.squad.platform.clearance:.2f} m asked"


def _bound_name(bound: int, which: NDArray[np.int64]) -> str:
    if bound < 4:
        return f"least tension of cable {bound + 1}"
    names = {-1: "largest tension of cable", 0: "pull along the stay of base", 1: "twist about the stay of base"}
    return f"{names[int(which[bound - 4])]} {bound - 3}"
