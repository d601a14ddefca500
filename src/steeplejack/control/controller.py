"""The platform controller: one step from measurement and reference to a command, at a fixed rate.

PD on the pose in the plane of the cables, the planned tensions as gravity feed-forward, the wrench spread over bounded
tensions, each winch commanded by torque; each base under way follows its reference along the stay. Out of the plane
nothing is controlled: there the platform hangs.

The cables are springs between winch and platform. Feeding the platform's own motion back to the winches is stable only
while the gain stays below the cables' stiffness in the plane (Routh: K < k), which a 60 m cable at a flat angle does
not offer. The stretch is therefore compensated from the measured tension slowly: fast motion is judged at the winches,
where force and motion meet and any PD is passive, and what the tensions hold is still seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.control.estimator import estimate, observe
from steeplejack.control.law import law
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.robots.squad.rails import RAIL_STEP, tabulate, winch_exits

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

STATE_SIZE = 54


@dataclass
class Setpoint:
    """What the squad should be doing now."""

    position: Array  # (3,) [m]
    rotation: Array  # (3, 3)
    velocity: Array  # (3,) [m/s]
    acceleration: Array  # (3,) [m/s2]
    tension: Array  # (4,) [N]
    bases: Array  # (5, 4) place [m], rate, acceleration, clock angle [rad] and its rate

    @property
    def s(self) -> Array:
        """Places of the bases (4,) [m]."""
        return self.bases[0]


class State:
    """What the controller remembers: one vector with named parts."""

    def __init__(self, vector: Array) -> None:
        self.vector = vector

    @property
    def position(self) -> Array:
        """Estimated position (3,) [m]."""
        return self.vector[0:3]

    @property
    def rotation(self) -> Array:
        """Estimated orientation (3, 3)."""
        return self.vector[3:12].reshape(3, 3)

    @property
    def velocity(self) -> Array:
        """Estimated velocity (6,) (rotation; translation) [rad/s; m/s]."""
        return self.vector[12:18]

    @property
    def tension(self) -> Array:
        """Measured tensions, filtered (4,) [N]."""
        return self.vector[18:22]

    @property
    def exits(self) -> Array:
        """Winch exits as measured (4, 3) [m]."""
        return self.vector[30:42].reshape(4, 3)

    @property
    def tangents(self) -> Array:
        """Stay tangents there (4, 3)."""
        return self.vector[42:54].reshape(4, 3)


class Output(NamedTuple):
    """What one step asks for, and how it went."""

    command: Array  # (3, 4): winch motor pulls at the cable [N], wheel tractions [N], turning rates of bases [rad/s]
    status: int  # how much of the wrench the bounds let through, see ``control.allocation``
    residual: float  # [m] root mean square of what the cable lengths leave unexplained


@njit(cache=True)
def _step(
    before: Array,
    reading: Array,
    moving: Flags,
    goal: Array,
    goal_rotation: Array,
    goal_velocity: Array,
    goal_acceleration: Array,
    planned: Array,
    goal_bases: Array,
    rails: Array,
    offset: float,
    attachments: Array,
    centre: Array,
    mass: float,
    weight: Array,
    weights: Array,
    observer: Array,
    gains: Array,
    window: Array,
    dt: float,
    after: Array,
    out: Array,
) -> tuple[int, float]:
    """One step in one call, writing state and commands in place: boxing arrays costs more than the arithmetic."""
    tension, momentum, shift, carried, lengths, rates = observe(
        reading[2], reading[1], reading[0], planned, before[22:26], before[26:30], observer, dt
    )
    points, tangents = winch_exits(rails, RAIL_STEP, offset, reading[3], reading[5])
    moved = np.empty((4, 3))
    for i in range(4):
        for k in range(3):
            moved[i, k] = tangents[i, k] * reading[4, i]
    load = weight - mass * goal_acceleration
    rotation = before[3:12].copy().reshape(3, 3)
    position, rotation, velocity, left = estimate(
        before[0:3], rotation, points, moved, attachments, lengths, rates, carried, load, centre, weights
    )
    bases = np.empty((8, 4))
    bases[:5] = goal_bases
    bases[5], bases[6], bases[7] = reading[3], reading[4], reading[5]
    pull, drive, turn, status = law(
        points,
        tangents,
        attachments,
        lengths,
        rates,
        goal,
        goal_rotation,
        goal_velocity,
        goal_acceleration,
        planned,
        bases,
        tension,
        moving,
        mass,
        gains,
        window,
    )
    after[0:3], after[12:18] = position, velocity
    for i in range(3):
        after[3 + 3 * i : 6 + 3 * i] = rotation[i]
    after[18:22], after[22:26], after[26:30] = tension, momentum, shift
    for i in range(4):
        after[30 + 3 * i : 33 + 3 * i] = points[i]
        after[42 + 3 * i : 45 + 3 * i] = tangents[i]
    out[0], out[1], out[2] = pull, drive, turn
    return status, left


class PlatformController:
    """Binds a machine and a bay to the control law.

    Args:
        bay: The stays the bases ride on.
        squad: The machine.
        mass: Platform and payload [kg].
        gravity: Of the worksite (3,) [m/s2].
        tension: Window the commanded tensions stay within [N].
    """

    def __init__(self, bay: Bay, squad: Squad, mass: float, gravity: Array, tension: tuple[float, float]) -> None:
        gains, winch = squad.controller, squad.winch
        reflected = winch.rotor_inertia * (winch.ratio / winch.drum_radius) ** 2
        self._rails = tabulate(bay)
        self._machine = (
            self._rails,
            squad.base.exit_offset,
            np.array(squad.platform.attachments),
            np.array(squad.platform.centre_of_mass),
            mass,
            mass * gravity,
            np.array([gains.length_noise, gains.force_noise, gains.moment_noise]),
            np.array(
                [winch.friction, reflected, gains.tension_filter, gains.stretch_filter, squad.cable.axial_stiffness]
            ),
            np.array(
                [
                    gains.stiffness,
                    gains.damping,
                    gains.yaw_stiffness,
                    gains.yaw_damping,
                    gains.drive_stiffness,
                    gains.drive_damping,
                    squad.base.mass,
                    winch.friction,
                    reflected,
                    squad.base.max_turn_rate,
                ]
            ),
            np.array([*tension, squad.base.hold_force, squad.base.drive_force]),
        )

    def begin(self, setpoint: Setpoint, reading: Array) -> State:
        """The state to start from: the platform rests at the reference, the observer at the planned tensions."""
        points, tangents = winch_exits(self._rails, RAIL_STEP, self._machine[1], reading[3], reading[5])
        still, tension = np.zeros(6), setpoint.tension
        parts = (setpoint.position, setpoint.rotation, still, tension, tension, np.zeros(4), points, tangents)
        return State(np.concatenate([np.ravel(part) for part in parts]))

    def step(self, state: State, setpoint: Setpoint, reading: Array, driven: Flags, dt: float) -> tuple[State, Output]:
        """One control step.

        Args:
            state: From the step before.
            setpoint: Reference now.
            reading: Measurements now (7, 4), rows as in ``runtime.plant.Measurement``.
            driven: Bases whose wheels carry them (4,).
            dt: Control step [s].

        Returns:
            The new state and what to command.
        """
        after, out = np.empty(STATE_SIZE), np.empty((3, 4))
        status, left = _step(
            state.vector,
            reading,
            driven,
            setpoint.position,
            setpoint.rotation,
            setpoint.velocity,
            setpoint.acceleration,
            setpoint.tension,
            setpoint.bases,
            *self._machine,
            dt,
            after,
            out,
        )
        return State(after), Output(out, status, left)
