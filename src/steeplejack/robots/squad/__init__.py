"""CCRobot-S: four movable anchor bases, four driving cables, a flying platform."""

from steeplejack.robots.squad.anchorage import Stance
from steeplejack.robots.squad.bay import Bay, Face
from steeplejack.robots.squad.parameters import BUILT_IN, Squad, load_squad

__all__ = ["BUILT_IN", "Bay", "Face", "Squad", "Stance", "load_squad"]
