"""Linkages by name: the built-in ones and TOML files."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from steeplejack.files import decode_toml, read_source
from steeplejack.mechanics.limb.linkage import Linkage

LINKAGES = ("stewart-gough", "planar-3-rrr", "3-rrs", "bennett", "sarrus")


def load_linkage(linkage: str | Path) -> Linkage:
    """Read a linkage.

    Args:
        linkage: One of `LINKAGES` or the path of a TOML file of the same form.

    Returns:
        The linkage, SI.

    Raises:
        InputError: No such linkage or file, or a field that cannot be used; the message names it.
    """
    if str(linkage) in LINKAGES:
        text = files("steeplejack.mechanics.limb").joinpath("data", f"{linkage}.toml").read_bytes()
    else:
        text = read_source(linkage, f"a TOML linkage file or one of {', '.join(LINKAGES)}")
    return decode_toml(text, Linkage, str(linkage), "see the built-in sarrus.toml for every field")
