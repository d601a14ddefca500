"""The loop: plant protocol, references, gait table, recorder, supervisor."""

from steeplejack.runtime.plant import Command, Measurement, Plant, Truth
from steeplejack.runtime.recorder import Recorder
from steeplejack.runtime.run import Result, Supervisor

__all__ = ["Command", "Measurement", "Plant", "Recorder", "Result", "Supervisor", "Truth"]
