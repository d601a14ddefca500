"""01 The paper's workspace: map the tension factor of Table III at 50 deg and find its best pose (Fig. 8)."""

import math

from steeplejack.design import best_pose, summarise, tension_map
from steeplejack.robots.squad import load_squad
from steeplejack.robots.squad.planar import planar_attachments
from steeplejack.worksite import PlanarSite, load_worksite

site = load_worksite("table-iii")
assert isinstance(site, PlanarSite)
attachments = planar_attachments(load_squad())
summary = summarise(tension_map(site.anchors, attachments, math.radians(50.0), 0.01))
print(f"{summary.inside} of {summary.nodes} nodes inside, mean tension factor {summary.mean_tension_factor:.4f}")
best = best_pose(site.anchors, attachments, math.radians(50.0))
print(f"best {best.tension_factor:.6f} at x = {best.pose[0]:.4f} m, y = {best.pose[1]:.4f} m")
