"""Worksites by name: the built-in ones and files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steeplejack.errors import InputError
from steeplejack.files import read_source
from steeplejack.worksite.bridge import Bridge
from steeplejack.worksite.planar import PlanarSite
from steeplejack.worksite.schedule import read_schedule
from steeplejack.worksite.site import read_site
from steeplejack.worksite.site_file import decode_site

BUILT_IN = ("table-iii", "ecs620-like", "russky-like", "sutong-like", "stonecutters-like", "emerson-like")

DATA = Path(__file__).parent / "data"


@dataclass(frozen=True)
class Listing:
    """A built-in worksite in a list.

    Args:
        name: What to call it on the command line.
        description: What it is.
        source: Where its numbers come from.
    """

    name: str
    description: str
    source: str


def list_worksites() -> tuple[Listing, ...]:
    """Every built-in worksite with its source."""
    sites = [decode_site(read_source(_file(name), "a worksite"), name) for name in BUILT_IN]
    return tuple(Listing(site.name, site.description, site.source) for site in sites)


def load_worksite(worksite: str | Path) -> Bridge | PlanarSite:
    """Read a worksite.

    Args:
        worksite: A built-in name, a TOML worksite or a ``.csv`` stay schedule.

    Returns:
        The bridge or planar site, SI.

    Raises:
        InputError: No such worksite, or a file that cannot be used; the message names the place.
    """
    if str(worksite) in BUILT_IN:
        return read_site(_file(str(worksite)), DATA)
    path = Path(worksite)
    if path.suffix.lower() == ".csv":
        return read_schedule(path)
    if path.suffix.lower() == ".toml":
        return read_site(path, path.parent)
    valid = f"a .toml or .csv file, or one of {', '.join(BUILT_IN)}"
    if path.is_file():
        raise InputError(str(worksite), f"a file of unknown kind {path.suffix or '(no suffix)'}", valid)
    raise InputError(f"worksite {worksite}", "a folder" if path.is_dir() else "no such name", valid)


def _file(name: str) -> Path:
    return DATA / f"{name}.toml"
