"""Missions: what fits, where to stand, which way to fly, how the squad moves on."""

from steeplejack.planning.certificate import Rules, Scene
from steeplejack.planning.compatibility import Verdict, check
from steeplejack.planning.inspection import plan
from steeplejack.planning.mission import Leg, Mission, Request, Uncovered, Waypoint, decode, encode, write
from steeplejack.planning.request import asked_stretch, choose_bay, choose_stretch, verdicts

__all__ = [
    "Leg",
    "Mission",
    "Request",
    "Rules",
    "Scene",
    "Uncovered",
    "Verdict",
    "Waypoint",
    "asked_stretch",
    "check",
    "choose_bay",
    "choose_stretch",
    "decode",
    "encode",
    "plan",
    "verdicts",
    "write",
]
