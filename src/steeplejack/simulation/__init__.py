"""Physics: the squad in MuJoCo behind the plant protocol, and whole missions run in it."""

from steeplejack.simulation.session import Session
from steeplejack.simulation.warmup import warm

__all__ = ["Session", "warm"]
