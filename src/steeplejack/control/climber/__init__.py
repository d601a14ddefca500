"""The pipe climber under control: references followed, grips verified, slips seen."""

from steeplejack.control.climber.controller import ClimberController, State, Status
from steeplejack.control.climber.gait import FIRST, TRANSITIONS, Act, Outcome, closed_in, taken_up
from steeplejack.control.climber.signals import Command, Measurement, Plant, Reference

__all__ = [
    "FIRST",
    "TRANSITIONS",
    "Act",
    "ClimberController",
    "Command",
    "Measurement",
    "Outcome",
    "Plant",
    "Reference",
    "State",
    "Status",
    "closed_in",
    "taken_up",
]
