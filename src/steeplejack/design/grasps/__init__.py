"""Grasps: where along a stay, and how far beside its axis, the platform is held best (Algorithm 1, and exactly)."""

from steeplejack.design.grasps.algorithm_1 import grasp_on_grid
from steeplejack.design.grasps.exact import GraspFront, best_grasp, grasp_front
from steeplejack.design.grasps.question import Grasp, GraspQuestion
from steeplejack.design.grasps.region import GraspRegion

__all__ = ["Grasp", "GraspFront", "GraspQuestion", "GraspRegion", "best_grasp", "grasp_front", "grasp_on_grid"]
