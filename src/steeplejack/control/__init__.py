"""Estimators and controllers: from measurement and reference to a command, at a fixed rate."""

from steeplejack.control.controller import Output, PlatformController, Setpoint, State

__all__ = ["Output", "PlatformController", "Setpoint", "State"]
