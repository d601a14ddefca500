"""How much friction is left to a gripper in physics: what its pads really bear against what they could.

The wrench of the pipe on a gripper, force and moment as its pads make them, is set against the body of wrenches that
pads give (`robots.pipe_climber.pads`) where they touch the pipe and with what the jaws press with at that moment; what
is left is ``1 - u``. Pads in physics keep within their cones, so that u cannot pass 1: at 1 no more can be borne, and
a load that grows makes the gripper slip or tilt.
"""

from __future__ import annotations

import math

import numpy as np

from steeplejack.control.climber.signals import Array
from steeplejack.robots.pipe_climber.pads import grip_use, pad_wrenches
from steeplejack.simulation.climber.truth import Contacts, Truth

EDGES = 32
"""Of the pyramids about the friction cones. They give up to 1 % more than the cones do at frictions to 0.8, 4 % at 1.5
and a third where pads are about to jam."""


def friction_left(truth: Truth) -> Array:
    """What is left to the lower and the upper gripper.

    Args:
        truth: The robot now.

    Returns:
        (2,), 1 where nothing is asked of a gripper, 0 at the limit, NaN where it does not press [1].
    """
    return np.array([_left(*one) for one in zip(truth.pads, truth.press, truth.wrench, strict=True)])


def _left(pads: Contacts, press: float, wrench: Array) -> float:
    if press <= 0.0:
        return math.nan
    friction = pads.friction / math.cos(math.pi / EDGES)
    body = pad_wrenches(pads.places, pads.normals, pads.jaws, friction, press, EDGES)
    return 1.0 - float(grip_use(body, -wrench))
