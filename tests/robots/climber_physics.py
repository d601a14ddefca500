"""The 3-RPR mechanism as MuJoCo sees it: three limbs and a platform, closed by constraints at P_1 to P_3."""

from __future__ import annotations

import mujoco
import numpy as np
from climber_cases import Array

from steeplejack.robots.pipe_climber import Layout
from steeplejack.robots.pipe_climber.inverse import hinge_angles, limb_lengths

LIMB = """
<body name="cylinder{i}" pos="{b} 0 0">
  <joint name="hinge{i}" type="hinge" axis="0 1 0"/>
  <geom type="sphere" size="0.001" mass="0.1"/>
  <body name="rod{i}">
    <joint name="slide{i}" type="slide" axis="0 0 1"/>
    <geom type="sphere" size="0.001" mass="0.1"/>
    <site name="end{i}"/>
  </body>
</body>"""
MODEL = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <option gravity="0 0 0"/>
  <worldbody>{limbs}
    <body name="platform">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="w" type="slide" axis="0 0 1"/>
      <joint name="alpha" type="hinge" axis="0 1 0"/>
      <geom type="sphere" size="0.001" mass="0.5"/>{pins}
    </body>
  </worldbody>
  <equality>{closures}</equality>
</mujoco>"""


def closed_loops(layout: Layout) -> mujoco.MjModel:
    """The mechanism; qpos is hinge and slide of limbs 1 to 3, then x, w and alpha."""
    limbs = "".join(LIMB.format(i=i, b=b) for i, b in enumerate(layout.base))
    # A body at each P_i, so that the engine has its velocity and acceleration on the platform's side.
    pin = '<body name="pin{i}" pos="{p} 0 0"><geom type="sphere" size="0.001" mass="0.01"/>{site}</body>'
    pins = "".join(pin.format(i=i, p=p, site=f'<site name="hole{i}"/>') for i, p in enumerate(layout.platform))
    closure = '<connect site1="end{i}" site2="hole{i}"/>'
    closures = "".join(closure.format(i=i) for i in range(3))
    return mujoco.MjModel.from_xml_string(MODEL.format(limbs=limbs, pins=pins, closures=closures))


def configuration(layout: Layout, pose: Array) -> Array:
    """The engine's coordinates of a pose, from inverse kinematics."""
    limbs = np.stack((hinge_angles(layout, pose)[:, 0], limb_lengths(layout, pose)), axis=-1)
    return np.concatenate((limbs.ravel(), pose))


def coordinates(joints: Array, platform: Array) -> Array:
    """The engine's velocities or accelerations from those of joints (3 limbs, 3 joints) and pose."""
    return np.concatenate((joints[:, :2].ravel(), platform))
