"""Independent checks of every command and measurement against declared limits."""

from steeplejack.safety.limits import BREACHES, HELD, Limits, check
from steeplejack.safety.monitor import Monitor, Verdict

__all__ = ["BREACHES", "HELD", "Limits", "Monitor", "Verdict", "check"]
