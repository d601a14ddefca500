"""Winches and the cables on them: rotor, ratio, friction, brake, stored cable, tension-only elastic span.

The free span of unstressed length L and loaded length l carries

    T = max(0, EA (l - L) / L + c (dl/dt - dL/dt)),    c = damping_time EA / L,

and nothing when slack, whatever its rates. The rotor, reflected to the cable, obeys

    m_r d2L/dt2 = T - F - friction,    m_r = rotor_inertia (ratio / drum_radius)^2,

F being the pull that the motor delivers at the cable: what is asked of it, up to its largest torque, and nothing while
the brake is closed, which is where it falls without power. Coulomb friction and brake act implicitly, so a rotor at
rest stays at rest up to their sum.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from steeplejack.robots.squad.parameters import Squad

Array = NDArray[np.float64]


def constants(squad: Squad) -> Array:
    """EA [N], damping time [s], reflected mass [kg], friction [N], brake [N], largest pull [N], stored cable [m]."""
    winch, cable = squad.winch, squad.cable
    gear = winch.ratio / winch.drum_radius
    return np.array(
        [
            cable.axial_stiffness,
            cable.damping_time,
            winch.rotor_inertia * gear**2,
            winch.friction,
            winch.brake_torque * gear,
            winch.max_torque * gear,
            winch.stored_length,
        ]
    )


@njit(cache=True)
def tension(length: float, rate: float, paid: float, pay_rate: float, stiffness: float, damping_time: float) -> float:
    """Tension [N] of a span of loaded length [m] with ``paid`` metres of unstressed cable out."""
    if length <= paid:
        return 0.0
    k = stiffness / paid
    return max(0.0, k * (length - paid) + k * damping_time * (rate - pay_rate))


@njit(cache=True)
def advance(
    lengths: Array,
    rates: Array,
    paid: Array,
    pay_rates: Array,
    pull: Array,
    braked: NDArray[np.bool_],
    constants: Array,
    dt: float,
    delivered: Array,
    tensions: Array,
    least: Array,
    largest_seen: Array,
) -> None:
    """Advance four winches by ``dt`` [s], in place.

    Args:
        lengths: Loaded lengths (4,) [m].
        rates: Their rates (4,) [m/s].
        paid: Unstressed cable out (4,) [m], updated.
        pay_rates: Its rate, positive when paying out (4,) [m/s], updated.
        pull: Motor pull asked for at the cable (4,) [N].
        braked: Closed brakes (4,).
        constants: See :func:`constants`.
        dt: Step [s].
        delivered: Motor pull as delivered (4,) [N], written.
        tensions: Tensions at the start of the step (4,) [N], written.
        least: Least tensions so far (4,) [N], updated.
        largest_seen: Largest tensions so far (4,) [N], updated.
    """
    stiffness, damping_time, mass, friction, brake, largest, stored = constants
    for i in range(4):
        tensions[i] = tension(lengths[i], rates[i], paid[i], pay_rates[i], stiffness, damping_time)
        least[i] = min(least[i], tensions[i])
        largest_seen[i] = max(largest_seen[i], tensions[i])
        delivered[i] = 0.0 if braked[i] else min(max(pull[i], -largest), largest)
        free = pay_rates[i] + dt * (tensions[i] - delivered[i]) / mass
        stop = dt * (friction + (brake if braked[i] else 0.0)) / mass
        pay_rates[i] = np.sign(free) * max(0.0, abs(free) - stop)
        paid[i] += dt * pay_rates[i]
        if paid[i] >= stored:  # the last turns are clamped to the drum
            paid[i], pay_rates[i] = stored, min(0.0, pay_rates[i])
