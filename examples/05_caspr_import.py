"""05 A model from CASPR: write a small one in its format, read it, and ask for its tensions."""

import tempfile
from pathlib import Path

import numpy as np

from steeplejack.mechanics.cable import distribute, tension_factor
from steeplejack.robots.cable_robot import load_caspr

BODIES = """<?xml version="1.0" encoding="utf-8"?>
<bodies_system><links><link_rigid num="1" name="sign board">
  <joint type="PLANAR_XY"/>
  <physical>
    <mass>6.0</mass><com_location>0.0 0.05 0.0</com_location><end_location>0 0 0</end_location>
    <inertia ref="com">
      <Ixx>0</Ixx><Iyy>0</Iyy><Izz>0.25</Izz><Ixy>0</Ixy><Ixz>0</Ixz><Iyz>0</Iyz>
    </inertia>
  </physical>
  <parent><num>0</num><location>0 0 0</location></parent>
</link_rigid></links></bodies_system>
"""
CABLE = """<cable_ideal name="{name}" attachment_reference="joint">
  <properties><force_min>5</force_min><force_max>400</force_max></properties>
  <attachments>
    <attachment><link>0</link><location>{anchor} 0</location></attachment>
    <attachment><link>1</link><location>{end} 0</location></attachment>
  </attachments>
</cable_ideal>
"""
ENDS = {"left foot": ("0 0", "-0.2 -0.1"), "right foot": ("6 0", "0.2 -0.1"),
        "right head": ("6.5 4", "0.2 0.1"), "left head": ("-0.5 4", "-0.2 0.1")}  # fmt: skip

with tempfile.TemporaryDirectory() as folder:
    cables = "".join(CABLE.format(name=name, anchor=anchor, end=end) for name, (anchor, end) in ENDS.items())
    Path(folder, "Board_bodies.xml").write_text(BODIES)
    Path(folder, "Board_cables.xml").write_text(
        f'<cables default_cable_set="facade"><cable_set id="facade">{cables}</cable_set></cables>'
    )
    robot = load_caspr(folder)

pose = np.array([2.6, 2.0, 0.02])
print(f"{robot.name}: {robot.dimension}, {len(robot.anchors)} cables, {robot.mass} kg")
print(f"cable lengths {np.round(robot.lengths(pose), 3)} m, tension factor {tension_factor(robot.structure(pose)):.3f}")
held = distribute(robot.structure(pose), robot.weight([0.0, -9.81], pose), robot.lower, robot.upper)
print(f"tensions {np.round(held.tensions, 1)} N, margin {held.margin:.2f}")
