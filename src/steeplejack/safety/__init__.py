"""Independent checks of every command and measurement against declared limits."""

from steeplejack.safety.monitor import BREACHES, Limits, check

__all__ = ["BREACHES", "Limits", "check"]
