"""Independent checks of every command and measurement against declared limits."""

from steeplejack.safety.limits import BREACHES, HELD, NOT_A_NUMBER, Limits, check
from steeplejack.safety.monitor import Monitor, Verdict

__all__ = ["BREACHES", "HELD", "NOT_A_NUMBER", "Limits", "Monitor", "Verdict", "check"]
