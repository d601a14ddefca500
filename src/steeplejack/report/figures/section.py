"""The fan in cross-section, looking up the stays: where the face is, and how far off each stay the platform flew."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Circle, Polygon, Wedge
from numpy.typing import NDArray

from steeplejack.report.analysis import Analysis
from steeplejack.report.figures.style import BLUE, CABLES, INK, MUTED, ORANGE, STEEL, Array, canvas, middle_stay, svg
from steeplejack.report.log import Log
from steeplejack.report.notation import between

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NEAR = 1.0  # [m] along the stays from the section, within which poses are drawn in it
ROOM = 0.35  # [m] drawn beyond the camera's range
POSES = 400  # drawn in one section


@dataclass(frozen=True)
class _Plane:
    """A plane at right angles to a stay, seen looking up it: right and up."""

    origin: Array  # (3,) [m]
    axes: Array  # (2, 3)
    face: float  # +1 where the inspected face looks up, -1 where it looks down

    @classmethod
    def at(cls, log: Log, k: int, s: float) -> _Plane:
        stay = log.bay.stays[k]
        tangent, normal = stay.tangent(s), log.bay.normal(float(k), s)
        normal = normal - (normal @ tangent) * tangent
        face = _face(log)
        up = face * normal / np.linalg.norm(normal)
        return cls(stay.position(s), np.stack([np.cross(tangent, up), up]), face)

    def project(self, points: Array) -> Array:
        """Points (..., 3) [m] in the plane (..., 2) [m]."""
        return (points - self.origin) @ self.axes.T


def section_figure(log: Log, analysis: Analysis) -> str:
    """The whole bay halfway through the first stance, and below it the flights along each interior stay close by."""
    interior = log.bay.interior
    with canvas(4.2) as figure:
        whole, close = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 2.3))[:, 0]
        _whole(whole.subplots(), log, analysis)
        row = close.subplots(1, len(interior), squeeze=False, sharex=True, sharey=True)[0]
        order = interior if _runs_right(log) else interior[::-1]
        for axes, k in zip(row, order, strict=True):
            _close(axes, log, analysis, k)
        row[0].set_ylabel("off the stay [m]")
        row[len(row) // 2].set_xlabel("across the stay [m], looking up it")
        return svg(figure, "section")


def _face(log: Log) -> float:
    """One sense for the whole bay, also where its plane is vertical and no face looks up or down."""
    return math.copysign(1.0, log.bay.normal(0.5 * (len(log.bay.stays) - 1), 0.5 * log.bay.reach)[2])


def _runs_right(log: Log) -> bool:
    """Whether the stays of the bay follow each other from left to right when looking up them."""
    middle = len(log.bay.stays) // 2
    s = 0.5 * log.bay.reach
    plane = _Plane.at(log, middle, s)
    return bool(plane.project(log.bay.stays[-1].position(s))[0] > plane.project(log.bay.stays[0].position(s))[0])


def _whole(axes: Axes, log: Log, analysis: Analysis) -> None:
    bay, states = log.bay, log.states
    middle = len(bay.stays) // 2
    along, _distance = middle_stay(log).nearest(states.actual_position)
    sample = _representative(log, analysis, middle)
    plane = _Plane.at(log, middle, float(along[sample]))
    points = np.array([stay.position(stay.nearest(plane.origin)[0]) for stay in bay.stays])
    places = plane.project(points)
    axes.plot(*places.T, color=STEEL, lw=0.7, ls=(0, (4, 3)), zorder=1)
    for k, (stay, place) in enumerate(zip(bay.stays, places, strict=True)):
        inside = k in bay.interior
        axes.add_patch(Circle((place[0], place[1]), bay.radius(k), fc=INK, ec="none", zorder=4))
        label = stay.id if inside else f"{stay.id} (bases)"
        axes.annotate(label, (place[0], place[1]), (0, -9 * plane.face), textcoords="offset points", color=MUTED,
                      ha="center", va="top" if plane.face > 0.0 else "bottom", fontsize=7.5)  # fmt: skip
    platform = plane.project(states.actual_position[sample])
    for i, exit_ in enumerate(plane.project(states.exits_actual[sample])):
        axes.plot([exit_[0], platform[0]], [exit_[1], platform[1]], color=CABLES[i], lw=0.7, zorder=2)
    near = np.flatnonzero((np.abs(along - along[sample]) <= NEAR) & ~states.stopped)
    path = plane.project(states.actual_position[near[:: max(1, len(near) // POSES)]])
    axes.plot(*path.T, ".", color=BLUE, ms=2.0, zorder=3)
    _body(axes, log, plane, sample)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.04, 0.5)
    title = f"bay {along[sample]:.1f} m up {middle_stay(log).id}, {log.mission.request.face} face"
    axes.set_title(
        f"{title}: poses within {NEAR:.0f} m of here, the cables at one of them", weight="normal", color=MUTED
    )
    axes.set_ylabel("[m]")


def _representative(log: Log, analysis: Analysis, k: int) -> int:
    """A sample in the middle of the first flight along stay ``k``, or any where there is none."""
    accuracy = analysis.accuracy
    samples = accuracy.sample[accuracy.stay == k]
    if not len(samples):
        return len(log.states.time) // 2
    first = samples[log.states.leg[samples] == log.states.leg[samples[0]]]
    return int(first[len(first) // 2])


def _close(axes: Axes, log: Log, analysis: Analysis, k: int) -> None:
    stay, radius, (near, far) = log.bay.stays[k], log.bay.radius(k), log.squad.camera.stand_off
    accuracy = analysis.accuracy
    here = accuracy.stay == k
    reach = radius + far + ROOM
    sample = _representative(log, analysis, k)
    plane = _Plane.at(log, k, float(accuracy.s[here][len(accuracy.s[here]) // 2]) if here.any() else 0.5 * stay.length)
    turn = 0.0 if plane.face > 0.0 else 180.0
    axes.add_patch(Wedge((0, 0), radius + far, turn, turn + 180.0, width=far - near, fc=BLUE, alpha=0.09, ec="none"))
    axes.add_patch(Circle((0, 0), radius, fc=INK, ec="none", zorder=4))
    _passes(axes, log, analysis, k, here)
    if here.any():
        local = _Plane.at(log, k, float(stay.nearest(log.states.actual_position[sample])[0]))
        _body(axes, log, local, sample)
    axes.set(aspect="equal", xlim=(-reach, reach))
    low, high = (-reach, 0.4) if plane.face < 0.0 else (-0.4, reach)
    axes.set_ylim(low, high)
    off = accuracy.stand_off[here]
    span = f"{between(float(off.min()), float(off.max()), 2)} m" if len(off) else "not flown"
    axes.set_title(f"{stay.id}: {span}")


def _passes(axes: Axes, log: Log, analysis: Analysis, k: int, here: NDArray[np.bool_]) -> None:
    """Poses along stay ``k``, each seen in the section through itself."""
    accuracy, stay = analysis.accuracy, log.bay.stays[k]
    thinned = np.flatnonzero(here)[:: max(1, int(here.sum()) // POSES)]
    if not len(thinned):
        return
    s, position = accuracy.s[thinned], log.states.actual_position[accuracy.sample[thinned]]
    tangent, normal = stay.tangent(s), log.bay.normal(np.full(len(s), float(k)), s)
    up = _face(log) * (normal - np.sum(normal * tangent, axis=1, keepdims=True) * tangent)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    offset = position - stay.position(s)
    across = np.sum(offset * np.cross(tangent, up), axis=1)
    axes.plot(across, np.sum(offset * up, axis=1), ".", color=BLUE, ms=2.5, zorder=5)


def _body(axes: Axes, log: Log, plane: _Plane, sample: int) -> None:
    """The platform's outline and its camera's cone at one sample."""
    squad, rotation = log.squad, log.states.actual_rotation[sample]
    position = log.states.actual_position[sample]
    x, _y, z = squad.platform.size
    # The body hangs behind the camera: its middle a quarter of its height below, as in the physics.
    corners = np.array([[a * x / 2.0, 0.0, b * z / 2.0 - z / 4.0] for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    axes.add_patch(Polygon(plane.project(position + corners @ rotation.T), fc="none", ec=INK, lw=0.9, zorder=6))
    eye, ahead, aside = plane.project(position), plane.axes @ rotation[:, 2], plane.axes @ rotation[:, 0]
    far, half = squad.camera.stand_off[1], math.tan(0.5 * squad.camera.field_of_view)
    cone = np.stack([eye, eye + far * (ahead + half * aside), eye + far * (ahead - half * aside)])
    axes.add_patch(Polygon(cone, fc=ORANGE, alpha=0.15, ec="none", zorder=3))
