"""Cable robots by name: the built-in ones and TOML files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steeplejack.files import decode_toml, read_source
from steeplejack.robots.cable_robot.parameters import Dimension, Parameters
from steeplejack.robots.cable_robot.robot import CableRobot

DATA = Path(__file__).parent / "data"
BUILT_IN = ("ccrobot-s-planar", "planar-4-4", "kntu-planar", "ipanema-2", "cogiro")


@dataclass(frozen=True)
class Listing:
    """A built-in cable robot in a list.

    Attributes:
        name: What to call it.
        description: What it is.
        dimension: ``planar`` or ``spatial``.
        cables: How many.
        source: Where its anchors come from.
    """

    name: str
    description: str
    dimension: Dimension
    cables: int
    source: str


def list_cable_robots() -> tuple[Listing, ...]:
    """Every built-in cable robot with its source."""
    robots = [read_parameters(name) for name in BUILT_IN]
    return tuple(
        Listing(r.name, r.description, r.dimension, len(r.cables.anchors), r.cables.source["anchors"]) for r in robots
    )


def load_cable_robot(robot: str | Path) -> CableRobot:
    """Read a cable robot.

    Args:
        robot: A built-in name (see `list_cable_robots`) or the path of a TOML file of the same form.

    Returns:
        The robot, SI.

    Raises:
        InputError: No such robot or file, or a field that cannot be used; the message names it.
    """
    return CableRobot.of(read_parameters(robot))


def read_parameters(robot: str | Path) -> Parameters:
    """Read a cable robot's values with their sources; arguments and errors as of `load_cable_robot`."""
    if str(robot) in BUILT_IN:
        text = (DATA / f"{robot}.toml").read_bytes()
    else:
        text = read_source(robot, f"a TOML robot file or one of {', '.join(BUILT_IN)}")
    valid = f"fields as in planar-4-4.toml and, in space, cogiro.toml of {DATA}"
    return decode_toml(text, Parameters, str(robot), valid)
