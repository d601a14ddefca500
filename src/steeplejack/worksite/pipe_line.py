"""The centre line of a pipe: straights and circular arcs in space, with a frame carried along without twist.

The frame's z axis is the tangent; x is clock 0 and y clock 90 degrees. Over a bend of radius R toward the clock phi,
with ``d = cos(phi) x + sin(phi) y`` at its beginning and theta = s / R,

    p(s) = p0 + R sin(theta) z + R (1 - cos(theta)) d,    F(s) = Rot(z cross d, theta) F0

which is the parallel transport of the frame (Bishop, 1975), so that a clock keeps its meaning along the pipe.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Piece = tuple[float, float, float, float | None]
"""Length, radius (infinite for a straight), clock of the bend's centre, new diameter or None [m, m, rad, m]."""


@dataclass(frozen=True)
class Part:
    """A straight (radius infinite) or a bend of a centre line.

    Attributes:
        start: Where it begins along the pipe [m].
        length: Of its centre line [m].
        radius: Of the bend; infinite for a straight [m].
        toward: Clock of the bend's centre [rad].
        diameter: Of the pipe [m].
        point: Where it begins, (3,) [m].
        frame: Of its beginning, (3, 3).
    """

    start: float
    length: float
    radius: float
    toward: float
    diameter: float
    point: Array
    frame: Array

    @property
    def straight(self) -> bool:
        """Whether it does not bend."""
        return math.isinf(self.radius)

    @property
    def end(self) -> float:
        """Where it ends along the pipe [m]."""
        return self.start + self.length

    def at(self, s: Array) -> tuple[Array, Array]:
        """Points (k, 3) and frames (k, 3, 3) at places (k,) along the pipe [m]."""
        along = s - self.start
        x, y, z = self.frame.T
        if self.straight:
            return self.point + along[:, None] * z, np.broadcast_to(self.frame, (len(s), 3, 3)).copy()
        inward = math.cos(self.toward) * x + math.sin(self.toward) * y
        turn = along / self.radius
        points = self.point + self.radius * (np.sin(turn)[:, None] * z + (1.0 - np.cos(turn))[:, None] * inward)
        still = np.outer(np.cross(z, inward), np.cross(z, inward))
        within, across = np.outer(z, z) + np.outer(inward, inward), np.outer(inward, z) - np.outer(z, inward)
        turns = still + np.cos(turn)[:, None, None] * within + np.sin(turn)[:, None, None] * across
        return points, turns @ self.frame


@dataclass(frozen=True)
class Pipe:
    """One pipe of a run.

    Attributes:
        name: Of the pipe.
        parts: One after the other, from s = 0.
    """

    name: str
    parts: tuple[Part, ...]

    @property
    def length(self) -> float:
        """Of the centre line [m]."""
        return self.parts[-1].end

    def part_at(self, s: ArrayLike) -> NDArray[np.int64]:
        """Index of the part at each place; beyond the ends the first or the last."""
        edges = np.array([part.end for part in self.parts[:-1]])
        return np.searchsorted(edges, np.asarray(s, dtype=np.float64), side="right")

    def centre_line(self, s: ArrayLike) -> tuple[Array, Array]:
        """Points (..., 3) [m] and frames (..., 3, 3) at places (...) along the pipe [m]; z is the tangent."""
        places = np.asarray(s, dtype=np.float64)
        flat, which = places.reshape(-1), self.part_at(places).reshape(-1)
        points, frames = np.empty((flat.size, 3)), np.empty((flat.size, 3, 3))
        for index in np.unique(which):
            mine = which == index
            points[mine], frames[mine] = self.parts[index].at(flat[mine])
        return points.reshape(*places.shape, 3), frames.reshape(*places.shape, 3, 3)

    def chord(self, s: ArrayLike, half: float) -> tuple[Array, Array]:
        """Where something sits that touches the pipe at two places, a distance to either side of its middle.

        Args:
            s: Of its middle along the pipe, (...) [m].
            half: From there to either place along the pipe [m]; 0 for the centre line itself.

        Returns:
            Points (..., 3) halfway between the two points of the centre line [m]; frames (..., 3, 3), those of the
            centre line at s turned by the least angle that brings z into the chord.
        """
        places = np.asarray(s, dtype=np.float64)
        points, frames = self.centre_line(places)
        if half <= 0.0:
            return points, frames
        first, last = self.centre_line(places - half)[0], self.centre_line(places + half)[0]
        along = last - first
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        z = frames[..., 2]
        axis, cosine = np.cross(z, along), (z * along).sum(axis=-1)[..., None, None]
        sideways = np.cross(axis[..., None, :], np.swapaxes(frames, -1, -2))  # of x, y and z as rows
        twice = np.cross(axis[..., None, :], sideways)
        turned = np.swapaxes(frames, -1, -2) + sideways + twice / (1.0 + cosine)
        return 0.5 * (first + last), np.swapaxes(turned, -1, -2)

    def lines(self, s: ArrayLike) -> Array:
        """Unit tangents and curvature vectors of the centre line at places (...) along the pipe, (..., 2, 3) [1, 1/m].

        Args:
            s: Along the pipe [m].
        """
        _points, frames = self.centre_line(s)
        bends = np.array([[math.cos(one.toward), math.sin(one.toward), 0.0] for one in self.parts])
        inward = (bends / np.array([[one.radius] for one in self.parts]))[self.part_at(s)]
        return np.stack((frames[..., 2], (frames @ inward[..., None])[..., 0]), axis=-2)

    def radius(self, s: ArrayLike) -> Array:
        """Of the pipe's outside at places along it (...) [m]."""
        radii = np.array([0.5 * part.diameter for part in self.parts])
        return radii[self.part_at(s)]


def laid(name: str, diameter: float, parts: list[Piece], point: Array, frame: Array) -> Pipe:
    """Lay parts one after the other.

    Args:
        name: Of the pipe.
        diameter: Of its beginning [m].
        parts: Pieces in order.
        point: Where it begins, (3,) [m].
        frame: Of its beginning, (3, 3), z along the pipe.

    Returns:
        The pipe.
    """
    done: list[Part] = []
    start = 0.0
    for length, radius, toward, changed in parts:
        diameter = diameter if changed is None else changed
        part = Part(start, length, radius, toward, diameter, point, frame)
        done.append(part)
        start += length
        points, frames = part.at(np.array([start]))
        point, frame = points[0], frames[0]
    return Pipe(name, tuple(done))
