"""The fan from the side, in its own plane: stays, stances and where the platform went."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from steeplejack.report.figures.style import (
    BLUE,
    CABLES,
    GRID,
    INK,
    LEGS,
    MUTED,
    PALE,
    STEEL,
    VERMILION,
    Array,
    canvas,
    spells,
    svg,
)
from steeplejack.report.log import Log
from steeplejack.worksite import Stay

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAMES = {"inspect": "inspecting", "fly": "flying between stays", "brace": "shifting load", "drive": "parked"}


def side_figure(log: Log) -> str:
    """All stays of the bay in the plane of the fan, the executed path by kind of leg, base places by stance."""
    plane = _Plane.of(log)
    with canvas(5.6) as figure:
        axes = figure.add_subplot()
        _stays(axes, log, plane, names=True)
        _path(axes, log, plane)
        _bases(axes, log, plane)
        _frame(axes, log, plane)
        inset = axes.inset_axes((0.0, 0.70, 0.24, 0.30))
        _overview(inset, axes, log, plane)
        figure.legend(handles=_legend(log), loc="outside lower center", ncols=4)
        return svg(figure, "side")


@dataclass(frozen=True)
class _Plane:
    """The plane of the bay: level, in the sense in which the stays rise, and up."""

    origin: Array  # (3,) [m] lower anchorage of the boundary stay that starts first
    axes: Array  # (2, 3)

    @classmethod
    def of(cls, log: Log) -> _Plane:
        bay = log.bay
        middle = 0.5 * (len(bay.stays) - 1)
        normal = bay.normal(middle, 0.5 * bay.reach)
        along = bay.axis(middle, bay.reach) - bay.axis(middle, 0.0)
        level = np.cross(normal, [0.0, 0.0, 1.0])
        level *= np.sign(level @ along) / np.linalg.norm(level)
        up = np.cross(normal, level)
        ends = np.array([bay.stays[0].position(0.0), bay.stays[-1].position(0.0)])
        return cls(ends[np.argmin(ends @ level)], np.stack([level, np.sign(up[2]) * up]))

    def project(self, points: Array) -> Array:
        """Points (..., 3) [m] as level and up (..., 2) [m]."""
        return (points - self.origin) @ self.axes.T


def _stays(axes: Axes, log: Log, plane: _Plane, names: bool) -> None:
    request = log.mission.request
    for k, stay in enumerate(log.bay.stays):
        inside = k in log.bay.interior
        axes.plot(*_line(stay, plane, 0.0, stay.length), color=STEEL, lw=1.6 if inside else 2.4, zorder=2)
        if inside and request.from_m < stay.length:
            stretch = _line(stay, plane, request.from_m, min(request.to_m, stay.length))
            axes.plot(*stretch, color=BLUE, alpha=0.18, lw=8.0, solid_capstyle="butt", zorder=1)
        for zone in stay.intervals:
            colour = VERMILION if zone.kind == "obstacle" else INK
            axes.plot(*_line(stay, plane, zone.start, zone.end), color=colour, lw=3.4, solid_capstyle="butt", zorder=3)
        if names:
            _name(axes, log, plane, stay)


def _name(axes: Axes, log: Log, plane: _Plane, stay: Stay) -> None:
    """The stay's id where it enters the drawing from below."""
    low, _high = _reach(log)
    x, y = plane.project(stay.position(max(0.0, low - 3.0)))
    axes.text(x + 1.0, y - 0.5, stay.id, fontsize=8.0, color=MUTED, ha="left", va="center", clip_on=True)


def _reach(log: Log) -> tuple[float, float]:
    """Where along the stays the run took place [m]: bases and requested stretch."""
    request, s = log.mission.request, log.states.actual_s
    return min(request.from_m, float(s.min())), max(request.to_m, float(s.max()))


def _line(stay: Stay, plane: _Plane, low: float, high: float) -> Array:
    return plane.project(stay.position(np.linspace(low, high, 40))).T


def _path(axes: Axes, log: Log, plane: _Plane) -> None:
    states = log.states
    place = plane.project(states.actual_position).T
    for leg in np.unique(states.leg):
        kind = log.mission.legs[leg].kind
        if kind != "drive":
            for first, last in spells(states.leg == leg):
                part = slice(first, last + 1, max(1, (last - first) // 150))
                axes.plot(*place[:, part], color=LEGS[kind], lw=1.5 if kind == "inspect" else 0.9, zorder=5)
    parked = np.array([log.mission.legs[leg].kind == "drive" for leg in states.leg])
    for first, last in spells(parked):
        axes.plot(*place[:, (first + last) // 2], "D", color=VERMILION, ms=3.5, mec="white", mew=0.5, zorder=6)


def _bases(axes: Axes, log: Log, plane: _Plane) -> None:
    """Where the bases stood while each stance inspected, and the four cables halfway through it."""
    states, legs = log.states, log.mission.legs
    inspecting = np.array([legs[leg].kind == "inspect" for leg in states.leg])
    stance = np.array([legs[leg].stance for leg in states.leg])
    for number, value in enumerate(np.unique(stance[inspecting]), start=1):
        samples = np.flatnonzero(inspecting & (stance == value))
        sample = samples[len(samples) // 2]
        platform = plane.project(states.actual_position[sample])
        for i in range(4):
            x, y = plane.project(states.exits_actual[sample, i])
            axes.plot([x, platform[0]], [y, platform[1]], color=CABLES[i], lw=0.6, alpha=0.55, zorder=4)
            axes.plot(x, y, "o", ms=11.0, color=CABLES[i], mec="white", mew=0.8, zorder=7)
            axes.text(x, y, str(number), color="white", fontsize=7.5, weight="bold", ha="center", va="center", zorder=8)


def _frame(axes: Axes, log: Log, plane: _Plane) -> None:
    """Equal scales around the part of the bay the run took place in."""
    low, high = _reach(log)
    corners = np.concatenate(
        [plane.project(stay.position([max(0.0, low - 4.0), min(high, stay.length)])) for stay in log.bay.stays]
    )
    (left, bottom), (right, top) = corners.min(axis=0) - 2.0, corners.max(axis=0) + 2.0
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.set_xlabel("level in the plane of the fan [m], from the first lower anchorage")
    axes.set_ylabel("up the plane of the fan [m]")


def _overview(inset: Axes, axes: Axes, log: Log, plane: _Plane) -> None:
    _stays(inset, log, plane, names=False)
    for line in inset.lines:
        line.set_linewidth(min(1.6, 0.4 * float(line.get_linewidth())))
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    inset.add_patch(Rectangle((left, bottom), right - left, top - bottom, fill=False, ec=VERMILION, lw=0.8, zorder=9))
    inset.set(aspect="equal", facecolor=PALE, xticks=[], yticks=[])
    inset.grid(False)
    inset.margins(0.08)
    inset.text(0.04, 0.93, "whole bay", fontsize=7.5, color=MUTED, va="top", transform=inset.transAxes)
    for spine in inset.spines.values():
        spine.set(visible=True, color=GRID)


def _legend(log: Log) -> list[Line2D | Patch]:
    kinds = {log.mission.legs[leg].kind for leg in np.unique(log.states.leg)}
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=LEGS[kind], lw=1.5, label=f"platform, {name}")
        for kind, name in NAMES.items()
        if kind in kinds and kind != "drive"
    ]
    if "drive" in kinds:
        handles.append(Line2D([], [], color=VERMILION, marker="D", ms=4, lw=0, label="platform parked, a base drives"))
    handles += [
        Line2D([], [], color=CABLES[i], marker="o", ms=7, lw=0.8, label=f"base {i + 1}, number of its stance")
        for i in range(4)
    ]
    handles.append(Patch(color=BLUE, alpha=0.18, label="stretch asked for"))
    zones = {zone.kind for stay in log.bay.stays for zone in stay.intervals}
    if "end zone" in zones:
        handles.append(Line2D([], [], color=INK, lw=3.4, label="end zone"))
    if "obstacle" in zones:
        handles.append(Line2D([], [], color=VERMILION, lw=3.4, label="obstacle"))
    return handles
