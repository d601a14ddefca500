"""Climbing a run of pipes: gait, planner and plan."""

from steeplejack.planning.climb.plan import ClimbPlan, Hold, Phase
from steeplejack.planning.climb.planner import plan_climb
from steeplejack.planning.climb.replay import faults

__all__ = ["ClimbPlan", "Hold", "Phase", "faults", "plan_climb"]
