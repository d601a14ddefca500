"""Steeplejack: robots that climb tall structures with parallel mechanisms.

The names a user writes first, each loaded from its room when it is first used, so that importing the package is quick.
Everything else is imported from its room; see the README for the table of rooms.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from steeplejack.design import tension_map
    from steeplejack.errors import InfeasibleError, InputError, SteeplejackError
    from steeplejack.planning import Mission, Request, Rules, Scene, plan, verdicts
    from steeplejack.report import read_log, write_report
    from steeplejack.robots.squad import Bay, Squad, load_squad
    from steeplejack.robots.squad.planar import PlanarSquad
    from steeplejack.simulation import Session
    from steeplejack.worksite import Bridge, Fan, PlanarSite, Stay, list_worksites, load_worksite

__version__ = version("steeplejack")

__all__ = [
    "Bay",
    "Bridge",
    "Fan",
    "InfeasibleError",
    "InputError",
    "Mission",
    "PlanarSite",
    "PlanarSquad",
    "Request",
    "Rules",
    "Scene",
    "Session",
    "Squad",
    "Stay",
    "SteeplejackError",
    "__version__",
    "list_worksites",
    "load_squad",
    "load_worksite",
    "plan",
    "read_log",
    "tension_map",
    "verdicts",
    "write_report",
]

ROOM_OF = {
    "Bay": "robots.squad",
    "Bridge": "worksite",
    "Fan": "worksite",
    "InfeasibleError": "errors",
    "InputError": "errors",
    "Mission": "planning",
    "PlanarSite": "worksite",
    "PlanarSquad": "robots.squad.planar",
    "Request": "planning",
    "Rules": "planning",
    "Scene": "planning",
    "Session": "simulation",
    "Squad": "robots.squad",
    "Stay": "worksite",
    "SteeplejackError": "errors",
    "list_worksites": "worksite",
    "load_squad": "robots.squad",
    "load_worksite": "worksite",
    "plan": "planning",
    "read_log": "report",
    "tension_map": "design",
    "verdicts": "planning",
    "write_report": "report",
}


def __getattr__(name: str) -> object:
    if name not in ROOM_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{ROOM_OF[name]}"), name)


def __dir__() -> list[str]:
    return __all__
