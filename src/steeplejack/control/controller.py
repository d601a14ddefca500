"""The platform controller: one step from measurement and reference to a command, at a fixed rate.

PD on the pose in the plane of the cables, the planned tensions as gravity feed-forward, the wrench spread over bounded
tensions, each winch commanded by torque; each base under way follows its reference along the stay. Out of the plane
nothing is controlled: there the platform hangs.

The cables are springs between winch and platform. Feeding the platform's own motion back to the winches is stable only
while the gain stays below the cables' stiffness in the plane (Routh: K < k), which a 60 m cable at a flat angle does not
offer. The stretch is therefore compensated from the measured tension slowly: fast motion is judged at the winches,
where force and motion meet and any PD is passive, and what the tensions hold is still seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steeplejack.control.estimator import estimate, observe, winch_exits
from steeplejack.control.law import law
from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

RAIL_STEP = 1.0  # [m] between tabulated places on a stay; the arc between them is off its chord by 20 um at R = 6 km


@dataclass
class Setpoint:
    """What the squad should be doing now."""

    position: Array  # (3,) [m]
    rotation: Array  # (3, 3)
    velocity: Array  # (3,) [m/s]
    acceleration: Array  # (3,) [m/s2]
    tension: Array  # (4,) [N]
    s: Array  # (4,) [m] bases
    s_rate: Array  # (4,) [m/s]
    s_acceleration: Array  # (4,) [m/s2]
    clock: Array  # (4,) [rad]
    clock_rate: Array  # (4,) [rad/s]


@dataclass
class State:
    """What the controller remembers."""

    position: Array  # (3,) [m] estimate
    rotation: Array  # (3, 3) estimate
    velocity: Array  # (6,) estimate (rotation; translation)
    tension: Array  # (4,) [N] measured, filtered
    momentum: Array  # (4,) [N] state of the tension observer
    offset: Array  # (4,) [N] slow difference between measured and planned tension
    exits: Array  # (4, 3) [m] winch exits as measured
    tangents: Array  # (4, 3) of the stays there


@dataclass(frozen=True)
class Reading:
    """The measurements the controller uses, see ``runtime.plant.Measurement``."""

    paid: Array
    pay_rate: Array
    pull: Array
    s: Array
    s_rate: Array
    clock: Array


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
        self._rails = _tabulate(bay)
        self._offset = squad.base.exit_offset
        self._attachments = np.array(squad.platform.attachments)
        self._centre = np.array(squad.platform.centre_of_mass)
        self._mass, self._weight = mass, mass * gravity
        self._weights = np.array([gains.length_noise, gains.force_noise, gains.moment_noise])
        reflected = winch.rotor_inertia * (winch.ratio / winch.drum_radius) ** 2
        self._observer = np.array(
            [winch.friction, reflected, gains.tension_filter, gains.stretch_filter, squad.cable.axial_stiffness]
        )
        self._gains = np.array(
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
            ]
        )
        self._window = np.array([*tension, squad.base.hold_force, squad.base.drive_force])

    def begin(self, setpoint: Setpoint, reading: Reading) -> State:
        """The state to start from: the platform rests at the reference."""
        points, tangents = winch_exits(self._rails, RAIL_STEP, self._offset, reading.s, reading.clock)
        return State(
            setpoint.position.copy(),
            setpoint.rotation.copy(),
            np.zeros(6),
            setpoint.tension.copy(),
            setpoint.tension.copy(),
            np.zeros(4),
            points,
            tangents,
        )

    def step(
        self, state: State, setpoint: Setpoint, reading: Reading, moving: Flags, dt: float
    ) -> tuple[State, Array, Array, Array, int, float]:
        """One control step.

        Args:
            state: From the step before.
            setpoint: Reference now.
            reading: Measurements now.
            moving: Bases with open palms (4,).
            dt: Control step [s].

        Returns:
            New state; winch pulls (4,) [N]; wheel tractions (4,) [N]; turning rates (4,) [rad/s]; allocation status;
            root mean square of the lengths' residual [m].
        """
        tension, momentum, offset, carried, lengths, rates = observe(
            reading.pull,
            reading.pay_rate,
            reading.paid,
            setpoint.tension,
            state.momentum,
            state.offset,
            self._observer,
            dt,
        )
        points, tangents = winch_exits(self._rails, RAIL_STEP, self._offset, reading.s, reading.clock)
        position, rotation, velocity, left = estimate(
            state.position,
            state.rotation,
            points,
            tangents * reading.s_rate[:, None],
            self._attachments,
            lengths,
            rates,
            carried,
            self._weight - self._mass * setpoint.acceleration,
            self._centre,
            self._weights,
        )
        bases = np.empty((8, 4))
        bases[0], bases[1], bases[2] = setpoint.s, setpoint.s_rate, setpoint.s_acceleration
        bases[3], bases[4] = setpoint.clock, setpoint.clock_rate
        bases[5], bases[6], bases[7] = reading.s, reading.s_rate, reading.clock
        pull, drive, turn, status = law(
            points,
            tangents,
            self._attachments,
            lengths,
            rates,
            setpoint.position,
            setpoint.rotation,
            setpoint.velocity,
            setpoint.acceleration,
            setpoint.tension,
            bases,
            tension,
            moving,
            self._mass,
            self._gains,
            self._window,
        )
        return (
            State(position, rotation, velocity, tension, momentum, offset, points, tangents),
            pull,
            drive,
            turn,
            status,
            left,
        )


def _tabulate(bay: Bay) -> Array:
    """Every base's stay at steps of RAIL_STEP (4, n, 12): point, tangent, directions of 12 and 3 o'clock."""
    count = max(int(np.ceil(bay.stays[k].length / RAIL_STEP)) for k in bay.carriers) + 1
    out = np.empty((4, count, 12))
    for i, k in enumerate(bay.carriers):
        stay = bay.stays[k]
        s = np.minimum(np.arange(count) * RAIL_STEP, stay.length)
        twelve, three = stay.clock_frame(s)
        out[i] = np.hstack([stay.position(s), stay.tangent(s), twelve, three])
    return out
