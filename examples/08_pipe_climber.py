"""08 The pipe climber's kinematics: lengths, every pose, velocities, a singularity-free path, loads, a motion."""

import math

import numpy as np

from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.certificate import certified_poses
from steeplejack.robots.pipe_climber.forward import forward_kinematics
from steeplejack.robots.pipe_climber.grippers import free_gripper, freedoms_of
from steeplejack.robots.pipe_climber.inverse import exceeded, limb_lengths
from steeplejack.robots.pipe_climber.jacobian import jacobian
from steeplejack.robots.pipe_climber.linkage import linkage_angles, linkage_closure
from steeplejack.robots.pipe_climber.motion import eq27, limb_states
from steeplejack.robots.pipe_climber.singular_path import check_waypoints
from steeplejack.robots.pipe_climber.singularity import determinant, singularity_distance
from steeplejack.robots.pipe_climber.statics import friction_needed, largest_load
from steeplejack.robots.pipe_climber.violations import violations

robot = load_pipe_climber()
layout = Layout.of(robot)

pose = (0.020, 0.150, 0.0)
lengths = limb_lengths(layout, pose)
print("lengths        ", (1e3 * lengths).round(6), "mm")
for one in certified_poses(layout, lengths.tolist()):
    x, w, alpha = one.pose
    print(f"  {one.mode:<16} x {1e3 * x:10.4f} mm   w {1e3 * w:10.4f} mm   alpha {math.degrees(alpha):10.4f} deg")
print("out of reach   ", *exceeded(layout, (0.0, 0.119, 0.0)), sep="  ")

beta = math.radians(20.0)
print(f"RCM loops open by {np.abs(linkage_closure(robot.rcm, linkage_angles(robot.rcm, beta))).max():.1e} m at 20 deg")
for fixed in ("lower", "upper"):
    gripper = free_gripper((*pose, beta), robot.linkage.claw_offset, fixed)
    x, w, alpha, turn = freedoms_of(gripper, robot.linkage.claw_offset, fixed)
    print(
        f"{fixed} fixed     other gripper at",
        (1e3 * gripper[:3, 3]).round(3),
        f"mm, turned {math.degrees(turn):.1f} deg",
    )

rng = np.random.default_rng(1)
many = forward_kinematics(layout, rng.uniform(0.12, 0.24, (100_000, 3)))
print("random lengths ", dict(zip(*(part.tolist() for part in np.unique(many.count, return_counts=True)), strict=True)))

speeds = jacobian(layout, pose) @ [0.0, 0.010, 0.0]
print("10 mm/s along Z", (1e3 * speeds).round(4), "mm/s")
print(f"det J           {1e3 * float(determinant(layout, pose)):.3f} mm, ", end="")
print(f"{1e3 * float(singularity_distance(layout, pose)):.1f} mm from the singular surface")
print("path            " + check_waypoints(layout, [(0.0, 0.16, 0.0), (0.02, 0.2, 0.3), (0.0, 0.15, -0.4)]).verdict)

load = largest_load(layout, (0.0, 0.160, 0.0), (0.0, -1.0, 0.0), robot.cylinders.force)
print(f"largest load    {float(load.size):.3f} N, then limb {int(load.limb)} is at its limit")
print(f"friction needed {friction_needed(robot.gripper, robot.body.mass * 9.81):.5f} to hang from one gripper")

lengths, speeds, _ = limb_states(layout, eq27(), 5.0, 0.100)
print("Eq. 27 at 5 s  ", (1e3 * lengths).round(5), "mm", (1e3 * speeds).round(5), "mm/s")
for broken in violations(robot, layout, eq27(), 0.100)[:4]:
    print(f"  limb {broken.limb} {broken.what}: {broken.value:.4f} {broken.unit}, limit {broken.limit:g}")
