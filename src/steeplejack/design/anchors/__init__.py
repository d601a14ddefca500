"""Anchor reconfiguration: where the four bases should stand along their stays, pose by pose and along a path."""

from steeplejack.design.anchors.problem import Reconfiguration

__all__ = ["Reconfiguration"]
