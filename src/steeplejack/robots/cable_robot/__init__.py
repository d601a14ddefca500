"""Any cable robot with one rigid platform, as data: built-in ones with their sources, TOML files, CASPR models."""

from steeplejack.robots.cable_robot.caspr import load_caspr
from steeplejack.robots.cable_robot.catalogue import BUILT_IN, Listing, list_cable_robots, load_cable_robot
from steeplejack.robots.cable_robot.robot import CableRobot

__all__ = ["BUILT_IN", "CableRobot", "Listing", "list_cable_robots", "load_cable_robot", "load_caspr"]
