"""Design: workspace maps of the squad, their figures and their best poses."""

from steeplejack.design.best_pose import BestPose, best_pose
from steeplejack.design.tension_map import Load, MapSummary, summarise, tension_map, write_map

__all__ = ["BestPose", "Load", "MapSummary", "best_pose", "summarise", "tension_map", "write_map"]
