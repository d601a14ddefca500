"""The pipe climber on its pipe as a MuJoCo model: masses, sizes and stiffnesses from the robot file.

The tree is lower gripper (free) - cranks G1 and G2 - couplers G3 and G4 - lower platform - three limbs - upper platform
with the upper gripper; what a tree cannot have is closed by equality constraints: couplers G3 and G4 on crank G2,
coupler G4 on the platform, limbs 1 and 2 on the upper platform. Every gripper has two jaws that a gear makes move
alike, every jaw four pads. Pads touch the pipe with Coulomb friction (elliptic cones); nothing else holds the robot.

Frames as in `robots.pipe_climber.grippers`: z along the pipe at a gripper, limbs in the lower platform's plane X-Z.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from steeplejack.robots.pipe_climber import Layout, PipeClimber
from steeplejack.robots.pipe_climber.bars import BAR, POST, ROD, YOKE
from steeplejack.robots.pipe_climber.inertia import BAR_SIDE, GRIPPER, JAW, JAW_OUT, LOAD, PLATE_SIDE, ROD_SIDE
from steeplejack.robots.pipe_climber.pads import pad_row
from steeplejack.robots.pipe_climber.weights import BEHIND, BODY_SHARE, FRAME, linkage_height, linkage_mass
from steeplejack.simulation.climber.solids import Array, Solid
from steeplejack.simulation.engine import mujoco

TIMESTEP = 5e-4  # [s]
# Contacts and loops are as stiff as the solver takes, estimates all. Friction of a soft contact creeps below its limit;
# this stiff, a loaded grip creeps well under 0.1 mm a minute.
# A pad gives a little more slowly than the loops of the frame, or tilting and sliding feed each other at the limit.
STIFF = 'solref="0.002 1" solimp="0.999 0.9999 0.001 0.5 2"'
RUBBER = 'solref="0.004 1.3" solimp="0.995 0.9995 0.001 0.5 2"'
# So do a larger impedance ratio and a solver that goes on to 1e-10; at 1e-6 it leaves a creep of 180 mm a minute.
IMPRATIO = 300.0
# [N/m], [N s/m] and [kg] of a jaw's drive; estimates, as is all damping below.
JAW_STIFFNESS, JAW_DAMPING, JAW_INERTIA = 4.0e4, 150.0, 0.1
SCREW_DAMPING, SERVO_DAMPING = 800.0, 1.5  # [N s/m], [N m s/rad]
PIPE, PADS, LIMBS = 1, 2, 4  # bits of what touches what: pads and limbs touch pipe and obstacles, not one another
PALM, RAIL = 0.003, 0.062  # [m] half of the palm's thickness, half of the length of the rails on it
NO_TOUCH = 'contype="0" conaffinity="0"'
COLOURS = {"pipe": "0.70 0.73 0.76 1", "obstacle": "0.80 0.36 0.10 1", "mark": "0.45 0.49 0.53 1"}


def build(
    robot: PipeClimber,
    layout: Layout,
    solids: Sequence[Solid],
    gravity: Array,
    friction: tuple[float, float],
    payload: float = 0.0,
) -> Any:
    """Compile the scene.

    Args:
        robot: The machine.
        layout: Hinges of its limbs.
        solids: Pipe and obstacles.
        gravity: Of the worksite (3,) [m/s2].
        friction: Of the lower and the upper gripper's pads on the pipe [1].
        payload: At the middle of the upper gripper [kg].

    Returns:
        The compiled model.
    """
    return mujoco.MjModel.from_xml_string(_xml(robot, layout, solids, gravity, friction, payload))


def _numbers(values: Any) -> str:
    return " ".join(f"{float(value):.10g}" for value in np.ravel(values))


def _solid(index: int, solid: Solid) -> str:
    ends = _numbers(np.concatenate([solid.start, solid.end]))
    touch = f'contype="{PIPE}" conaffinity="{PADS + LIMBS}" {RUBBER}'
    return (
        f'<geom name="{solid.kind}{index}" type="{solid.shape}" fromto="{ends}" size="{solid.radius:.10g}" '
        f'rgba="{COLOURS[solid.kind]}" {touch if solid.kind != "mark" else NO_TOUCH}/>'
    )


def _inertial(mass: float, place: Sequence[float], size: Sequence[float]) -> str:
    """Of a box of ``size`` [m] along x, y, z."""
    x, y, z = (side**2 for side in size)
    inertia = mass / 12.0 * np.array([y + z, x + z, x + y])
    return f'<inertial pos="{_numbers(place)}" mass="{mass:.10g}" diaginertia="{_numbers(inertia)}"/>'


def _bar(ends: Sequence[float], radius: float, colour: str) -> str:
    return (
        f'<geom type="capsule" fromto="{_numbers(ends)}" size="{radius:.6g}" rgba="{colour}" mass="0" '
        f'contype="{LIMBS}" conaffinity="{PIPE}"/>'
    )


def _jaws(robot: PipeClimber, end: str, friction: float, palm: float) -> str:
    """Two jaws that slide along X; the coordinate of each is how far its pads stand from the axis."""
    build, out = robot.build, list[str]()
    tall = 0.5 * build.jaw_length
    y, z = 0.5 * build.jaw_width, pad_row(robot)
    for name, side in (("a", 1.0), ("b", -1.0)):
        pads = "".join(
            f'<geom class="pad" name="{end}_{name}{k}" pos="0 {sy * y:.6g} {sz * z:.6g}" '
            f'friction="{friction:.10g} 0 0"/>'
            for k, (sy, sz) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1)))
        )
        out.append(
            f'<body name="{end}_jaw_{name}"><joint name="{end}_{name}" type="slide" axis="{side} 0 0" damping="5" '
            f'armature="{JAW_INERTIA}"/>'
            f"{_inertial(build.jaw_mass, (side * JAW_OUT, 0, 0), JAW)}{pads}"
            f'<geom type="box" class="looks" pos="{side * 0.010} 0 0" size="0.006 {y + 0.006:.4g} {tall:.4g}" '
            f'rgba="0.20 0.22 0.25 1"/>'
            f'<geom type="box" class="looks" pos="{side * 0.013} {-0.5 * palm:.6g} 0" '
            f'size="0.004 {0.5 * palm:.6g} {0.4 * tall:.4g}" rgba="0.20 0.22 0.25 1"/></body>'
        )
    return "".join(out)


def _yoke(robot: PipeClimber, places: Array, colour: str) -> str:
    """A platform, open towards +X: two arms beside the pipe that carry limbs 1 and 2, a bar behind it for limb 3."""
    half, back = robot.linkage.half_width, float(places[2])
    arms = [
        _bar((back, side * half, 0, max(float(place), 0.0), side * half, 0), YOKE, colour)
        for side, place in ((1.0, places[0]), (-1.0, places[1]))
    ]
    return "".join(arms) + _bar((back, -half, 0, back, half, 0), YOKE, colour)


def _limb(robot: PipeClimber, layout: Layout, limb: int, inner: str) -> str:
    """Hinge at B_i, cylinder, rod; the slide's coordinate is q_i. Drawn upright, at q_i = 0."""
    y = (1.0, -1.0, 0.0)[limb] * robot.linkage.half_width
    number, mass, radius = limb + 1, robot.cylinders.mass, robot.build.limb_radius
    body = robot.cylinders.reach[0] - BEHIND
    return f"""
    <body name="cylinder{number}" pos="{_numbers((layout.base[limb], y, 0))}">
      <joint name="base{number}" type="hinge" axis="0 1 0"/>
      {_inertial(BODY_SHARE * mass, (0, 0, 0.5 * body), (2 * radius, 2 * radius, body))}
      {_bar((0, 0, radius, 0, 0, body - radius), radius, "0.93 0.55 0.13 1")}
      <body name="rod{number}">
        <joint name="limb{number}" type="slide" axis="0 0 1" armature="{robot.build.screw_inertia}"/>
        {_inertial((1.0 - BODY_SHARE) * mass, (0, 0, -0.5 * body), (ROD_SIDE, ROD_SIDE, body))}
        {_bar((0, 0, -body, 0, 0, 0), ROD, "0.85 0.87 0.90 1")}
        <site name="rod{number}"/>
        {inner}
      </body>
    </body>"""


def _upper(robot: PipeClimber, layout: Layout, friction: float, payload: float, palm: float) -> str:
    """The upper platform, origin O2, hinged to rod 3 at P_3, with the upper gripper and its payload rigidly on it."""
    build, half, places = robot.build, robot.linkage.half_width, layout.platform
    pins = "".join(f'<site name="pin{i + 1}" pos="{_numbers((places[i], (half, -half)[i], 0))}"/>' for i in (0, 1))
    grip = build.gripper_mass - 2.0 * build.jaw_mass
    offset, back = robot.linkage.claw_offset, float(places[2])
    load = f'<body name="payload">{_inertial(payload, (0, 0, 0), LOAD)}</body>' if payload > 0.0 else ""
    return f"""
    <body name="upper_platform" pos="{_numbers((-back, 0, 0))}">
      <joint name="platform3" type="hinge" axis="0 1 0" pos="{_numbers((back, 0, 0))}"/>
      {_inertial(build.plate_mass, (0.5 * back, 0, 0), (-back, 2 * half, PLATE_SIDE))}
      {_yoke(robot, places, "0.12 0.38 0.62 1")}{pins}
      <body name="upper_gripper" pos="{_numbers((0, 0, offset))}">
        {_inertial(grip, (FRAME[0], 0, FRAME[1]), GRIPPER)}
        {_frame(robot, palm)}
        <site name="upper"/>
        {_jaws(robot, "upper", friction, palm)}{load}
      </body>
    </body>"""


def _frame(robot: PipeClimber, palm: float) -> str:
    """The palm beside the pipe on -Y, which may touch nothing, and behind it the rails that jaws slide on."""
    half, across = 0.5 * robot.build.jaw_length, palm * math.tan(robot.gait.palm)
    colour = 'rgba="0.12 0.38 0.62 1"'
    rails = "".join(
        f'<geom type="box" class="looks" pos="0 {-palm - 3.0 * PALM:.6g} {z:.4g}" size="{RAIL} {PALM} 0.004" {colour}/>'
        for z in (-0.6 * half, 0.6 * half)
    )
    return rails + (
        f'<geom type="box" pos="0 {-palm - PALM:.6g} 0" size="{across:.6g} {PALM} {half:.6g}" mass="0" {colour} '
        f'contype="{LIMBS}" conaffinity="{PIPE}"/>'
    )


def _linkage(robot: PipeClimber, plate: str) -> str:
    """Cranks, couplers and the plate on coupler G3, in a plane below the jaws."""
    rcm, z = robot.rcm, linkage_height(robot)
    mass = 0.25 * linkage_mass(robot)
    crank, half = rcm.crank, 0.5 * rcm.coupler
    colour = "0.30 0.62 0.42 1"

    def coupler(name: str, side: float, inner: str) -> str:
        return f"""<body name="{name}" pos="{_numbers((0, side * crank, 0))}">
          <joint name="{name}" type="hinge" axis="0 0 1"/>
          {_inertial(mass, (half, 0, 0), (2 * half, BAR_SIDE, BAR_SIDE))}
          {_bar((0, 0, 0, 2 * half, 0, 0), BAR, colour)}
          <site name="{name}_end" pos="{_numbers((2 * half, 0, 0))}"/>
          <site name="{name}_middle" pos="{_numbers((half, 0, 0))}"/>
          {inner}</body>"""

    length = (BAR_SIDE, 2 * crank, BAR_SIDE)
    bar = _bar((0, -crank, 0, 0, crank, 0), BAR, colour)
    ends = f'<site name="G2_upper" pos="0 {crank} 0"/><site name="G2_lower" pos="0 {-crank} 0"/>'
    inside = f"""<body name="lower_platform" pos="{_numbers((half, 0, 0))}">
      <joint name="plate" type="hinge" axis="0 0 1"/>{plate}</body>"""
    return f"""
    <body name="G1" pos="{_numbers((-half, 0, z))}"><joint name="G1" type="hinge" axis="0 0 1"/>
      {_inertial(mass, (0, 0, 0), length)}{bar}{coupler("G3", 1.0, inside)}{coupler("G4", -1.0, "")}</body>
    <body name="G2" pos="{_numbers((half, 0, z))}"><joint name="G2" type="hinge" axis="0 0 1"/>
      {_inertial(mass, (0, 0, 0), length)}{bar}{ends}</body>"""


def _lower(robot: PipeClimber, layout: Layout, friction: tuple[float, float], payload: float, palm: float) -> str:
    """The lower gripper and everything on it."""
    build, half, places = robot.build, robot.linkage.half_width, layout.base
    back = float(places.min())
    upper = _upper(robot, layout, friction[1], payload, palm)
    limbs = "".join(_limb(robot, layout, limb, upper if limb == 2 else "") for limb in range(3))
    # The plate's body has its origin at pin E3; what it carries is told from O1.
    crank, z = robot.rcm.crank, linkage_height(robot)
    order = np.array([places[0], places[1], back])
    posts = "".join(_bar((0, s * crank, z, 0, s * half, 0), POST, "0.12 0.38 0.62 1") for s in (1, -1))
    plate = f"""
      {_inertial(build.plate_mass, (0.5 * back, -crank, -z), (-back, 2 * half, PLATE_SIDE))}
      <body name="O1" pos="{_numbers((0, -crank, -z))}">
        {_yoke(robot, order, "0.12 0.38 0.62 1")}{posts}<site name="E4" pos="{_numbers((0, -crank, z))}"/>{limbs}
      </body>"""
    grip = build.gripper_mass - 2.0 * build.jaw_mass
    return f"""
    <body name="lower_gripper"><freejoint name="root"/>
      {_inertial(grip, (FRAME[0], 0, -FRAME[1]), GRIPPER)}
      {_frame(robot, palm)}
      <site name="lower"/>
      {_jaws(robot, "lower", friction[0], palm)}{_linkage(robot, plate)}
    </body>"""


def _actuators(robot: PipeClimber) -> str:
    build, force = robot.build, robot.cylinders.force
    drives = "".join(
        f'<position name="limb{i}" joint="limb{i}" kp="{build.screw_stiffness}" kv="{SCREW_DAMPING}" '
        f'forcerange="{-force} {force}"/>'
        for i in (1, 2, 3)
    )
    torque = build.servo_torque
    drives += (
        f'<position name="servo" joint="G1" kp="{build.servo_stiffness}" kv="{SERVO_DAMPING}" '
        f'forcerange="{-torque} {torque}"/>'
    )
    return drives + "".join(
        f'<position name="{end}_{jaw}" joint="{end}_{jaw}" kp="{JAW_STIFFNESS}" kv="{JAW_DAMPING}" '
        f'forcerange="{-robot.gripper.force} {robot.gripper.force}"/>'
        for end in ("lower", "upper")
        for jaw in "ab"
    )


def _xml(
    robot: PipeClimber,
    layout: Layout,
    solids: Sequence[Solid],
    gravity: Array,
    friction: tuple[float, float],
    payload: float,
) -> str:
    # The palm is set for the thickest pipe of the run.
    palm = robot.gait.clearance + max(solid.radius for solid in solids if solid.kind == "pipe")
    loops = (("G3_end", "G2_upper"), ("G4_end", "G2_lower"), ("G4_middle", "E4"), ("rod1", "pin1"), ("rod2", "pin2"))
    closures = "".join(f'<connect site1="{a}" site2="{b}" {STIFF}/>' for a, b in loops)
    closures += "".join(f'<joint joint1="{e}_a" joint2="{e}_b" {STIFF}/>' for e in ("lower", "upper"))
    return f"""
<mujoco model="{robot.name}">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{TIMESTEP}" gravity="{_numbers(gravity)}" integrator="implicitfast" cone="elliptic"
          impratio="{IMPRATIO}" iterations="30" tolerance="1e-10" jacobian="sparse"/>
  <statistic extent="1"/>
  <visual>
    <global offwidth="1280" offheight="960"/><map znear="0.01" zfar="60"/>
    <headlight ambient="0.45 0.45 0.45" diffuse="0.5 0.5 0.5"/><quality shadowsize="2048"/>
  </visual>
  <default>
    <default class="pad">
      <geom type="sphere" size="{robot.build.pad_radius}" condim="3" priority="1" contype="{PADS}" conaffinity="{PIPE}"
            mass="0" {RUBBER}
            rgba="0.1 0.1 0.1 1"/>
    </default>
    <default class="looks"><geom contype="0" conaffinity="0" mass="0"/></default>
    <site size="0.003" rgba="0 0 0 0"/>
  </default>
  <asset>
    <texture type="skybox" builtin="gradient" rgb1="0.74 0.84 0.93" rgb2="0.95 0.97 0.99" width="256" height="256"/>
  </asset>
  <worldbody>
    <light pos="3 -4 8" dir="-0.3 0.4 -0.8" directional="true" diffuse="0.4 0.4 0.4"/>
    {"".join(_solid(i, solid) for i, solid in enumerate(solids))}
    {_lower(robot, layout, friction, payload, palm)}
  </worldbody>
  <equality>{closures}</equality>
  <actuator>{_actuators(robot)}</actuator>
</mujoco>"""
