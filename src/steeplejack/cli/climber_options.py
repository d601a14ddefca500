"""Options that every command of the pipe climber takes, and the machine they describe."""

from __future__ import annotations

import dataclasses
import math
from typing import Annotated

import typer

from steeplejack.errors import InputError
from steeplejack.robots.pipe_climber.layout import LARGEST, LEAST, Layout
from steeplejack.robots.pipe_climber.parameters import SHIPPED, Convention, Neutral, PipeClimber, load_pipe_climber

Lengths = tuple[float, float, float, float]
Pose = tuple[float, float, float]

ClimberRobot = Annotated[str, typer.Option("--robot", help=f"{', '.join(SHIPPED)} or a TOML robot file.")]
ClimberConvention = Annotated[
    Convention | None,
    typer.Option("--convention", help="Where B2 and B3 sit (Table II or Eq. 5-9); by default as in the robot file."),
]
ClimberDims = Annotated[
    Lengths | None, typer.Option("--dims", help="L1 L2 L3 L4 in metres; by default those of the robot file.")
]
JointNeutral = Annotated[
    Neutral | None,
    typer.Option("--joint-neutral", help="What the hinges' limit counts from; by default as in the robot file."),
]


def climber(
    robot: str, convention: Convention | None = None, dims: Lengths | None = None, neutral: Neutral | None = None
) -> tuple[PipeClimber, Layout]:
    """The machine and its hinges as the options say.

    Raises:
        InputError: No such robot, dimensions no mechanism has, or a neutral "home" that they cannot take.
    """
    machine = load_pipe_climber(robot)
    layout = Layout.of(machine)
    if dims is not None and not all(LEAST <= length <= LARGEST for length in dims):
        valid = f"four finite lengths of {LEAST:g} to {LARGEST:g} m"
        raise InputError("--dims", " ".join(f"{length:g}" for length in dims), valid)
    changes = {"lengths": dims, "convention": convention, "neutral": neutral}
    changed = dataclasses.replace(layout, **{name: one for name, one in changes.items() if one is not None})
    changed.require_home()
    return machine, changed


def pose_of(option: str, pose: Pose) -> Pose:
    """X and W in metres and ALPHA in degrees as (x, w, alpha) [m, m, rad].

    Raises:
        InputError: One of them is not finite, or a place farther than any machine reaches.
    """
    x, w, degrees = pose
    if not (abs(x) <= LARGEST and abs(w) <= LARGEST and abs(degrees) <= LARGEST):
        valid = f"X and W in metres and ALPHA in degrees, all finite and up to {LARGEST:g}"
        raise InputError(option, f"{x:g} {w:g} {degrees:g}", valid)
    return x, w, math.radians(degrees)
