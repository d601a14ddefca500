"""Anchor reconfiguration: where the four bases should stand along their stays, pose by pose and along a path."""

from steeplejack.design.anchors.along import AnchorPath, anchor_path, anchors_along, trade_off
from steeplejack.design.anchors.exact import AnchorOptimum, AnchorStatus, Objective, optimal_anchors, tension_factors
from steeplejack.design.anchors.grid import GridOptimum, algorithm_2
from steeplejack.design.anchors.limits import BindingLimit, binding_limits
from steeplejack.design.anchors.nearest import NearestAnchors, nearest_anchors
from steeplejack.design.anchors.paths import eq28, read_path
from steeplejack.design.anchors.problem import Reconfiguration
from steeplejack.design.anchors.worth import Duty

__all__ = [
    "AnchorOptimum",
    "AnchorPath",
    "AnchorStatus",
    "BindingLimit",
    "Duty",
    "GridOptimum",
    "NearestAnchors",
    "Objective",
    "Reconfiguration",
    "algorithm_2",
    "anchor_path",
    "anchors_along",
    "binding_limits",
    "eq28",
    "nearest_anchors",
    "optimal_anchors",
    "read_path",
    "tension_factors",
    "trade_off",
]
