"""Rotations and the time scaling of paths."""

from steeplejack.spatial.rotation import from_quaternion, from_vector, nearest_turn, to_quaternion, to_vector
from steeplejack.spatial.timing import Profile, profile

__all__ = ["Profile", "from_quaternion", "from_vector", "nearest_turn", "profile", "to_quaternion", "to_vector"]
