"""Linkages by name: the built-in ones and TOML files."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import msgspec

from steeplejack.errors import InputError
from steeplejack.mechanics.limb.linkage import Linkage

LINKAGES = ("stewart-gough", "planar-3-rrr", "3-rrs", "bennett", "sarrus")
MOST_BYTES = 1 << 20
MOST_QUOTED = 160  # characters of a complaint


def load_linkage(linkage: str | Path) -> Linkage:
    """Read a linkage.

    Args:
        linkage: One of `LINKAGES` or the path of a TOML file of the same form.

    Returns:
        The linkage, SI.

    Raises:
        InputError: No such linkage or file, or a field that cannot be used; the message names it.
    """
    where = _shortened(str(linkage))
    if str(linkage) in LINKAGES:
        text = files("steeplejack.mechanics.limb").joinpath("data", f"{linkage}.toml").read_bytes()
    else:
        text = _read(linkage, where)
    try:
        return msgspec.toml.decode(text, type=Linkage)
    except InputError as error:
        raise InputError(f"{where}, {_shortened(error.where)}", _shortened(error.what), error.valid) from None
    except (msgspec.DecodeError, ValueError, LookupError, RecursionError) as error:
        raise InputError(where, _shortened(str(error)), "see the built-in sarrus.toml for every field") from None


def _read(path: str | Path, where: str) -> bytes:
    """The bytes of a regular file of a sane size, without a byte order mark."""
    valid = f"a TOML linkage file or one of {', '.join(LINKAGES)}"
    try:
        file = Path(path)
        if file.exists() and not file.is_file():
            raise InputError(where, "not a file", valid)
        with file.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise InputError(where, error.strerror or "cannot be read", valid) from None
    except (TypeError, ValueError) as error:  # no path at all, or one with a NUL in it
        raise InputError(where, _shortened(str(error)), valid) from None
    if len(content) > MOST_BYTES:
        raise InputError(where, f"more than {MOST_BYTES} bytes", valid)
    return content.removeprefix(b"\xef\xbb\xbf")


def _shortened(text: str) -> str:
    """Text on one line, its middle left out where it is long."""
    line = " ".join(text.split())
    half = MOST_QUOTED // 2
    return line if len(line) <= MOST_QUOTED else f"{line[:half]} ... {line[-half:]}"
