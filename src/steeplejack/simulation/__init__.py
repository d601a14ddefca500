"""Physics: the squad in MuJoCo behind the plant protocol, and whole missions run in it."""

from steeplejack.simulation.session import Session

__all__ = ["Session"]
