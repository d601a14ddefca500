"""Estimators and controllers: from measurement and reference to a command, at a fixed rate."""

from steeplejack.control.controller import PlatformController, Reading, Setpoint, State

__all__ = ["PlatformController", "Reading", "Setpoint", "State"]
