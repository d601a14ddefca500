"""The safety monitor: it knows the machine, the stays and the limits, and nothing of the controller.

Every command, and the readings it answers, are checked before the command leaves. A breach names one cause; the runtime
then stops the squad on its brakes. Nothing is taken over from the controller: tensions are filtered here from motor
currents and winch encoders, winch exits follow from wheel encoders, inclinometers and the geometry of the stays, and
the platform's place is judged by cable lengths and by the balance of forces at the place the mission asks for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.robots.squad.rails import RAIL_STEP, tabulate, winch_exits
from steeplejack.safety.limits import Limits, check

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

FORCE_FILTER = 0.01  # [s] on measured tensions; an overload of 20 % is seen after 2 ms
WHEEL_FILTER = 0.05  # [s] on wheel rates, which encoders give in steps, and on inclinometers
FRICTION_RATE = 0.005  # [m/s] of winch rate over which Coulomb friction changes sign


class Verdict(NamedTuple):
    """What the monitor says of one command."""

    state: Array  # to hand in with the next one
    code: int  # of the first breach, see ``BREACHES``; 0 if all is well
    where: int  # cable or base it concerns, 0 to 3; -1 for neither
    tension: Array  # (4,) [N] as the monitor measures it


class Monitor:
    """Binds the limits of one run to a machine and a bay.

    Args:
        bay: The stays the bases ride on.
        squad: The machine.
        weight: Gravity force on platform and payload (3,) [N].
        tension: Working window of the driving cables [N].
    """

    def __init__(self, bay: Bay, squad: Squad, weight: Array, tension: tuple[float, float]) -> None:
        winch = squad.winch
        reflected = winch.rotor_inertia * (winch.ratio / winch.drum_radius) ** 2
        self._rails = tabulate(bay)
        self._machine = (
            np.array(squad.platform.attachments),
            np.array([squad.base.exit_offset, winch.friction, reflected, squad.cable.axial_stiffness]),
            weight,
            Limits.of(squad, tension, float(np.linalg.norm(weight))).vector,
        )

    def begin(self, tension: Array, clock: Array) -> Array:
        """The state to start from: at rest under planned tensions (4,) [N], gripped at clock angles (4,) [rad]."""
        return np.concatenate([tension, np.zeros(8), clock, clock])

    def step(
        self,
        state: Array,
        reading: Array,
        command: Array,
        grip: Flags,
        moving: Flags,
        goal: Array,
        goal_rotation: Array,
        dt: float,
    ) -> Verdict:
        """Check one command.

        Args:
            state: From the step before (20,).
            reading: Measurements it answers (7, 4), rows as in ``runtime.plant.Measurement``.
            command: Winch pulls [N], wheel tractions [N] and turning rates [rad/s] (3, 4).
            grip: Palms told to be closed (4,).
            moving: Bases under way, from open palms to verified grip (4,).
            goal: Where the mission wants the platform (3,) [m].
            goal_rotation: Its orientation there (3, 3).
            dt: Time since the step before [s].
        """
        after, tension = np.empty(20), np.empty(4)
        code, where = _step(
            state, reading, command, grip, moving, goal, goal_rotation, dt, self._rails, *self._machine, after, tension
        )
        return Verdict(after, code, where, tension)


@njit(cache=True)
def _step(
    before: Array,
    reading: Array,
    command: Array,
    grip: Flags,
    moving: Flags,
    goal: Array,
    goal_rotation: Array,
    dt: float,
    rails: Array,
    attachments: Array,
    machine: Array,
    weight: Array,
    limits: Array,
    after: Array,
    tension: Array,
) -> tuple[int, int]:
    offset, friction, reflected, elasticity = machine
    filter_readings(before, reading, friction, reflected, dt, after, tension)
    lengths, turned = np.empty(4), np.empty(4)
    for i in range(4):
        lengths[i] = reading[0, i] * (1.0 + tension[i] / elasticity)
        after[16 + i] = after[12 + i] if moving[i] else before[16 + i]
        turned[i] = after[12 + i] - after[16 + i]
    exits, tangents = winch_exits(rails, RAIL_STEP, offset, reading[3], reading[5])
    return check(
        command, grip, tension, reading[1], after[8:12], reading[6], turned, moving,
        exits, tangents, attachments, lengths, weight, goal, goal_rotation, limits,
    )  # fmt: skip


@njit(cache=True)
def filter_readings(
    before: Array, reading: Array, friction: float, reflected: float, dt: float, after: Array, tension: Array
) -> None:
    """Tensions from motor pulls and winch rates, in place: ``t = LP(F + friction) + m_r d LP(v)/dt``.

    A rotor of reflected mass m_r [kg] obeys ``m_r dv/dt = t - F - friction`` with v positive paying out. Both sides
    pass one low-pass; its memory gives the derivative, ``(v - LP(v)) / tau``, without differencing encoder steps.

    Args:
        before: Low-passed motor forces [N], winch rates [m/s], wheel rates [m/s] and clock angles [rad] (16+,).
        reading: Measurements (7, 4).
        friction: Of the winch [N].
        reflected: Rotor mass at the cable [kg].
        dt: Time step [s].
        after: The same as ``before`` one step on, written.
        tension: Tensions (4,) [N], written.
    """
    share, slow = dt / (FORCE_FILTER + dt), dt / (WHEEL_FILTER + dt)
    for i in range(4):
        rate = reading[1, i]
        felt = reading[2, i] + friction * np.tanh(rate / FRICTION_RATE)
        after[i] = before[i] + share * (felt - before[i])
        after[4 + i] = before[4 + i] + share * (rate - before[4 + i])
        after[8 + i] = before[8 + i] + slow * (reading[4, i] - before[8 + i])
        after[12 + i] = before[12 + i] + slow * (reading[5, i] - before[12 + i])
        tension[i] = after[i] + reflected * (rate - after[4 + i]) / FORCE_FILTER
