"""What a file somebody hands in says: its bytes and its TOML, or one clear line about why not."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import msgspec

from steeplejack.errors import InputError

Kind = TypeVar("Kind")

MOST_BYTES = 1 << 20
"""A robot of a thousand cables takes a tenth of it; parsers take seconds for twenty times as much."""

MOST_QUOTED = 160  # characters of a file that a message repeats


def read_source(path: str | Path, valid: str, most: int = MOST_BYTES) -> bytes:
    """Read a file, without a byte order mark.

    Args:
        path: Of the file.
        valid: What would be valid, for the message.
        most: Bytes it may have.

    Raises:
        InputError: Not a path, no such file, not a regular file, or too large.
    """
    where = shortened(str(path))
    try:
        file = Path(path)
        if file.exists() and not file.is_file():
            raise InputError(where, "a folder" if file.is_dir() else "not a file", valid)
        with file.open("rb") as stream:
            content = stream.read(most + 1)
    except OSError as error:
        raise InputError(where, error.strerror or "cannot be read", valid) from None
    except (TypeError, ValueError) as error:  # no path at all, or one with a NUL in it
        raise InputError(repr(where), shortened(str(error)), valid) from None
    if len(content) > most:
        raise InputError(where, f"more than {most} bytes", valid)
    return content.removeprefix(b"\xef\xbb\xbf")


def decode_toml(content: bytes, kind: type[Kind], where: str, valid: str) -> Kind:
    """Decode TOML, checked field by field.

    Args:
        content: Of the file.
        kind: What it should say.
        where: Its name, for the message.
        valid: What would be valid, for the message.

    Raises:
        InputError: Nothing in it, not TOML, or a field that cannot be used; the message gives its path.
    """
    where = shortened(where)
    if not content.strip():
        raise InputError(where, "an empty file", valid)
    try:
        return msgspec.toml.decode(content, type=kind)
    except InputError as error:
        raise InputError(f"{where}, {shortened(error.where)}", shortened(error.what), error.valid) from None
    except (msgspec.DecodeError, ValueError, LookupError, RecursionError) as error:  # the last three of its parser
        raise InputError(where, shortened(str(error)), valid) from None


def shortened(text: str) -> str:
    """Text on one line, its middle left out where it is long: what a message may repeat of a file."""
    line = " ".join(text.split())
    half = MOST_QUOTED // 2
    return line if len(line) <= MOST_QUOTED else f"{line[:half]} ... {line[-half:]}"
