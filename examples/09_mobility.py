"""09 What linkages can do: mobility by three routes, near and far from the reference, and what a redundant hinge is."""

import msgspec

from steeplejack.mechanics.limb import LINKAGES, load_linkage, mobility
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber
from steeplejack.robots.pipe_climber.mechanism import parallel_mechanism, rcm_linkage, whole_robot

robot = load_pipe_climber()
rcm = rcm_linkage(robot.rcm)
climber = [parallel_mechanism(Layout.of(robot), robot.linkage.half_width), rcm, whole_robot(robot)]

print("linkage          screws  closure  d (n - g - 1) + sum f + v       kind")
for linkage in [*climber, *(load_linkage(name) for name in LINKAGES)]:
    found = mobility(linkage)
    k = found.kutzbach
    formula = f"{k.order} ({k.links} - {k.joints} - 1) + {k.freedoms} + {k.redundant} = {k.mobility}"
    print(f"{linkage.name:<16} {found.by_reciprocal_screws:>5} {found.by_closure:>8}   {formula:<31} {found.kind}")

print("\nThe climber's free gripper:", "; ".join(mobility(climber[2]).freedoms))

print("\nThe RCM linkage without one of its hinges:")
for hinge in rcm.joints:
    found = mobility(msgspec.structs.replace(rcm, joints=tuple(joint for joint in rcm.joints if joint is not hinge)))
    verdict = "not needed" if found.mobility == 1 else "needed"
    print(f"  {hinge.name} {verdict}: mobility {found.mobility}, redundant constraints {found.kutzbach.redundant}")

bennett = load_linkage("bennett")
tilted = msgspec.structs.replace(bennett.joints[0], axis=(1e-4, 0.0, 1.0))
missed = mobility(msgspec.structs.replace(bennett, joints=(tilted, *bennett.joints[1:])))
print(f"\nA Bennett linkage with one hinge 0.006 degrees off: mobility {missed.mobility}, {missed.kind}")
