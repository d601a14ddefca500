"""06 Where to grasp a stay: Algorithm 1, the exact optimum, and what distance from the axis buys (Fig. 14)."""

import math

from steeplejack.design.grasps import GraspQuestion, GraspRegion, best_grasp, grasp_front, grasp_on_grid
from steeplejack.robots.squad import load_squad
from steeplejack.robots.squad.planar import planar_attachments
from steeplejack.worksite import PlanarSite, load_worksite

site = load_worksite("table-iii")
assert isinstance(site, PlanarSite)
slope, intercept = site.stays["3"]
x0 = -0.10
region = GraspRegion.eq19((x0, slope * x0 + intercept), (1.0, slope), delta=0.03, epsilon=0.05)
question = GraspQuestion(site.anchors, planar_attachments(load_squad()), math.radians(50.0), region)

grid = grasp_on_grid(question, step=0.01, kappa=0.01)
print(
    f"Algorithm 1: {grid.tension_factor:.6f} at {grid.position.round(4)} m, {1e3 * grid.distance:.1f} mm off the axis"
)
exact = best_grasp(question)
print(f"exact:       {exact.tension_factor:.6f} at {exact.position.round(4)} m, {1e3 * exact.distance:.1f} mm off it")
print(f"             proved to {exact.gap:.0e} with {exact.evaluations} boxes")

front = grasp_front(question, [0.0, 0.005, 0.010, 0.015, 0.020])
for distance, factor in zip(front.distances, front.tension_factor, strict=True):
    print(f"within {1e3 * distance:4.1f} mm: {factor:.4f}")
