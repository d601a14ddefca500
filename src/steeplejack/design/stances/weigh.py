"""Worth of stances on a ground, as the functions the search takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from steeplejack.design.stances.ground import Ground
from steeplejack.design.stances.held import HELD, SLIPS, helds
from steeplejack.design.stances.search import Indices, Room, Worth
from steeplejack.design.stances.worth import worths

Array = NDArray[np.float64]


def room_about(ground: Ground, centre: Array, within: float) -> Room:
    """Room for bases within so far [m] of places (n, m) [m] along their stays, on their stays."""
    low = np.maximum(centre - within, ground.range[:, 0])
    return Room(
        np.stack([low, np.minimum(centre + within, ground.range[:, 1])], -1),
        ground.barred,
        ground.pairs,
        float(ground.machine[3]),
    )


def known(margins: Array) -> Array:
    """Margins with not a number where no tensions hold the platform."""
    return np.where(margins > -1e3, margins, np.nan)


def by_forces(
    objective: int,
    statics: int,
    ground: Ground,
    room: Room,
    positions: Array,
    arms: Array,
    loads: Array,
    limits: Array,
) -> Worth:
    """Worth at one orientation: see `worths` for the arguments, each row's own but for the loads."""

    def worth(rows: Indices, stances: Array) -> Array:
        return worths(
            objective,
            statics,
            ground.axes,
            ground.tangents,
            ground.step,
            positions[rows],
            arms[rows],
            loads,
            limits[rows],
            ground.machine,
            np.ascontiguousarray(stances),
            room.admits(rows, stances),
        )

    return worth


class Equilibria:
    """Full equilibria of the squad's four bases: worth for the search, and why a stance does not hold.

    Arguments as in `helds`, positions, guesses and limits each row's own.
    """

    def __init__(
        self,
        ground: Ground,
        room: Room,
        positions: Array,
        guesses: Array,
        limits: Array,
        platform: tuple[Array, Array, Array],
        surroundings: tuple[Array, Array, Indices, Array],
    ) -> None:
        """Bind; ``platform`` is attachments, weight, centre of mass, ``surroundings`` stays, radii, own, asked."""
        self._of_rows = positions, guesses, limits
        self._ground, self.room = ground, room
        self._platform, self._surroundings = platform, surroundings

    def on(self, room: Room) -> Equilibria:
        """The same with another room for the bases."""
        return Equilibria(self._ground, room, *self._of_rows, self._platform, self._surroundings)

    def of(self, rows: Indices) -> Equilibria:
        """Some of the rows."""
        room = replace(self.room, windows=self.room.windows[rows])
        positions, guesses, limits = (values[rows] for values in self._of_rows)
        return Equilibria(self._ground, room, positions, guesses, limits, self._platform, self._surroundings)

    def judge(self, rows: Indices, stances: Array) -> tuple[Array, Indices]:
        """Margins and reasons (n, c) of stances (n, c, 4) [m]."""
        positions, guesses, limits = (values[rows] for values in self._of_rows)
        ground = self._ground
        return helds(
            ground.axes,
            ground.tangents,
            ground.step,
            positions,
            guesses,
            *self._platform,
            limits,
            ground.machine,
            *self._surroundings,
            np.ascontiguousarray(stances),
            self.room.admits(rows, stances),
        )

    def margin(self, rows: Indices, stances: Array) -> Array:
        """Slip margin (n, c) where the platform is held, ``-inf`` elsewhere."""
        margins, reasons = self.judge(rows, stances)
        return np.where((reasons == HELD) | (reasons == SLIPS), margins, -np.inf)
