"""The squad on its bay as a MuJoCo model: masses, joints and friction from the robot file, rails from the worksite.

A base rides its stay on two slides: along the stay's tangent at a reference place, and across it in the stay's
vertical plane, tied to the first by a quartic that follows the sagging axis. A hinge turns it about the stay. Cable
tensions are computed by the winch model (:mod:`steeplejack.simulation.winch`) and applied through tendon actuators,
so that a slack cable cannot push.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from steeplejack.robots.squad.bay import Bay
from steeplejack.robots.squad.parameters import Squad
from steeplejack.simulation.engine import mujoco

Array = NDArray[np.float64]

TIMESTEP = 5e-4  # [s]
# Friction loss in direct form: reference damping just under the limit of stability 1 / timestep, and the stiffest
# impedance MuJoCo takes. A loaded grip then creeps at about a micrometre a second; the defaults give 6-18 mm/s.
FRICTION_SOLREF = (-1.0, -0.9 / TIMESTEP)
STIFF = "0.9999 0.9999 0.001 0.5 2"
RAIL_DEGREE = 4


@dataclass(frozen=True)
class Rail:
    """A stretch of a stay in the frame of its reference place: x along the tangent, y towards 12 o'clock."""

    origin: Array  # (3,) [m] world
    axes: Array  # (3, 3) columns x, y, z in the world
    reference: float  # [m] arc length of the origin
    bow: Array  # (5,) y as a polynomial of x, lowest degree first
    arc: Array  # (5,) arc length less reference as a polynomial of x
    cast: Array  # (5,) x as a polynomial of arc length less reference

    def x(self, s: float) -> float:
        """Slide coordinate [m] of an arc length [m]."""
        return float(np.polyval(self.cast[::-1], s - self.reference))

    def y(self, x: float) -> float:
        """Place across the tangent [m] of a slide coordinate [m]."""
        return float(np.polyval(self.bow[::-1], x))


def rail(bay: Bay, k: int, low: float, high: float) -> Rail:
    """Fit a rail to the stretch [low, high] of stay ``k`` [m]."""
    stay = bay.stays[k]
    reference = 0.5 * (low + high)
    twelve, _three = stay.clock_frame(reference)
    x = stay.tangent(reference)
    axes = np.column_stack([x, twelve, np.cross(x, twelve)])
    origin = stay.position(reference)
    s = np.linspace(low - 1.0, high + 1.0, 41)
    local = (stay.position(s) - origin) @ axes
    fit = [
        np.asarray(np.polynomial.polynomial.polyfit(a, b, RAIL_DEGREE), float)
        for a, b in ((local[:, 0], local[:, 1]), (local[:, 0], s - reference), (s - reference, local[:, 0]))
    ]
    return Rail(origin, axes, reference, fit[0], fit[1], fit[2])


def build(bay: Bay, squad: Squad, rails: tuple[Rail, ...], mass: float, gravity: Array) -> Any:
    """Compile the scene for a platform of ``mass`` [kg], payload included."""
    return mujoco.MjModel.from_xml_string(_xml(bay, squad, rails, mass, gravity))


def _numbers(values: Array | tuple[float, ...]) -> str:
    return " ".join(f"{v:.10g}" for v in np.ravel(values))


def _quaternion(axes: Array) -> str:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(axes).ravel())
    return _numbers(quaternion)


def _base(squad: Squad, number: int, rail: Rail, radius: float) -> str:
    base = squad.base
    half = np.array([0.5 * base.length, 0.5 * base.exit_offset, 0.12])
    inertia = (
        base.mass
        / 3.0
        * np.array([half[1] ** 2 + half[2] ** 2, half[0] ** 2 + half[2] ** 2, half[0] ** 2 + half[1] ** 2])
    )
    friction = f'solreffriction="{_numbers(FRICTION_SOLREF)}" solimpfriction="{STIFF}"'
    return f"""
    <body name="base{number}" pos="{_numbers(rail.origin)}" quat="{_quaternion(rail.axes)}" gravcomp="1">
      <joint name="along{number}" type="slide" axis="1 0 0" frictionloss="1" {friction}/>
      <joint name="bow{number}" type="slide" axis="0 1 0"/>
      <joint name="turn{number}" type="hinge" axis="1 0 0" frictionloss="1" {friction}/>
      <inertial pos="0 0 0" mass="{base.mass}" diaginertia="{_numbers(inertia)}"/>
      <geom type="box" size="{_numbers(half)}" pos="0 {0.6 * base.exit_offset + radius} 0" rgba="0.93 0.55 0.13 1"/>
      <geom type="box" size="{0.35 * base.length} {radius + 0.03} {radius + 0.03}" rgba="0.25 0.27 0.30 1"/>
      <geom type="cylinder" size="0.05 0.05" pos="0 {base.exit_offset} 0" rgba="0.15 0.15 0.17 1"/>
      <site name="exit{number}" pos="0 {base.exit_offset} 0" size="0.02"/>
    </body>"""


def _stay(bay: Bay, k: int, low: float, high: float) -> str:
    nodes = bay.stays[k].position(np.linspace(low, high, max(2, int((high - low) / 25.0) + 1)))
    colour = "0.80 0.82 0.84 1" if k in bay.interior else "0.62 0.65 0.69 1"
    return "\n".join(
        f'<geom type="capsule" fromto="{_numbers(a)} {_numbers(b)}" size="{bay.radius(k)}" rgba="{colour}"/>'
        for a, b in zip(nodes[:-1], nodes[1:], strict=True)
    )


def _xml(bay: Bay, squad: Squad, rails: tuple[Rail, ...], mass: float, gravity: Array) -> str:
    platform, size = squad.platform, np.array(squad.platform.size)
    # The payload sits at the centre of mass; the box's inertia grows with the mass it carries.
    inertia = np.array(platform.inertia) * mass / platform.mass
    sites = "".join(
        f'<site name="attachment{i + 1}" pos="{_numbers(p)}" size="0.012"/>' for i, p in enumerate(platform.attachments)
    )
    stays = "".join(_stay(bay, k, 0.0, bay.stays[k].length) for k in range(len(bay.stays)))
    bases = "".join(_base(squad, i + 1, rails[i], bay.radius(bay.carriers[i])) for i in range(4))
    tendons = "".join(
        f'<spatial name="cable{i}" width="0.012" rgba="0.95 0.85 0.25 1">'
        f'<site site="exit{i}"/><site site="attachment{i}"/></spatial>'
        for i in range(1, 5)
    )
    ties = "".join(
        f'<joint joint1="bow{i + 1}" joint2="along{i + 1}" polycoef="{_numbers(rails[i].bow)}" '
        f'solref="0.002 1" solimp="{STIFF}"/>'
        for i in range(4)
    )
    motors = "".join(f'<motor name="cable{i}" tendon="cable{i}" gear="-1"/>' for i in range(1, 5))
    motors += "".join(f'<motor name="drive{i}" joint="along{i}"/>' for i in range(1, 5))
    motors += "".join(f'<motor name="turn{i}" joint="turn{i}"/>' for i in range(1, 5))
    return f"""
<mujoco model="{squad.name}">
  <option timestep="{TIMESTEP}" gravity="{_numbers(gravity)}" density="{squad.simulation.drag_density}"
          integrator="Euler" cone="elliptic" iterations="20" tolerance="1e-10">
    <flag contact="disable"/>
  </option>
  <statistic extent="20"/>
  <visual>
    <global offwidth="1280" offheight="720"/><map znear="0.005" zfar="40"/>
    <headlight ambient="0.45 0.45 0.45" diffuse="0.5 0.5 0.5"/><quality shadowsize="0"/>
  </visual>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.74 0.84 0.93" rgb2="0.95 0.97 0.99" width="256" height="256"/>
  </asset>
  <worldbody>
    <light pos="0 0 400" dir="0.3 -0.4 -1" directional="true" diffuse="0.4 0.4 0.4"/>
    {stays}
    {bases}
    <body name="platform">
      <freejoint name="platform"/>
      <inertial pos="{_numbers(platform.centre_of_mass)}" mass="{mass}" diaginertia="{_numbers(inertia)}"/>
      <geom type="box" size="{_numbers(0.5 * size)}" pos="0 0 {-0.25 * size[2]}" rgba="0.12 0.38 0.62 1" mass="0"/>
      <geom type="cylinder" size="0.04 0.03" pos="0 0 {0.28 * size[2]}" rgba="0.1 0.1 0.1 1" mass="0"/>
      {sites}
    </body>
  </worldbody>
  <tendon>{tendons}</tendon>
  <equality>{ties}</equality>
  <actuator>{motors}</actuator>
</mujoco>"""
