"""A machine as data: a TOML file decoded once into frozen structs, SI, every value with its source.

Each table of the file carries a second table ``source`` with the same keys. A value without a source, an unknown key or
a window upside down is refused with the path of the field.
"""

from __future__ import annotations

import math
from importlib.resources import files
from pathlib import Path
from typing import Annotated, TypeVar, cast

import msgspec

from steeplejack.files import decode_toml, read_source

Machine = TypeVar("Machine", bound=msgspec.Struct)

Vector = tuple[float, float, float]
Window = tuple[float, float]
Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class Sourced(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A table of values, each with its source or the word "estimate"."""

    source: dict[str, str]

    def __post_init__(self) -> None:
        """Refuse a value without a source, a number that is not finite and a window upside down."""
        names = {field for field in self.__struct_fields__ if field != "source"}
        for name in sorted(names ^ set(self.source)):
            raise ValueError(f"`{name}` needs both a value and an entry under `source`")
        for name in sorted(names):
            value = getattr(self, name)
            if not all(math.isfinite(one) for one in _numbers(value)):
                raise ValueError(f"`{name}` = {value} is not finite")
            if isinstance(value, tuple) and len(value) == 2 and not value[0] < value[1]:  # pyright: ignore
                raise ValueError(f"`{name}` = {list(value)} is upside down")  # pyright: ignore[reportUnknownArgumentType]


def _numbers(value: object) -> list[float]:
    """The floating-point numbers of a field."""
    entries = cast("tuple[object, ...]", value) if isinstance(value, tuple) else (value,)
    return [one for one in entries if isinstance(one, float)]


def load_machine(robot: str | Path, shipped: tuple[str, ...], package: str, kind: type[Machine]) -> Machine:
    """Read a machine from a built-in name or a TOML file.

    Args:
        robot: A built-in name or the path of a TOML file of the same form.
        shipped: Those names; files beside the machine's code are called the same, with underscores.
        package: Where that file lies.
        kind: What to decode it as.

    Returns:
        The machine, frozen, SI.

    Raises:
        InputError: No such robot or file, or a field that cannot be used; the message names it.
    """
    file = (str(robot) if str(robot) in shipped else shipped[0]).replace("-", "_") + ".toml"
    if str(robot) in shipped:
        text = files(package).joinpath(file).read_bytes()
    else:
        text = read_source(robot, f"a TOML robot file or {' or '.join(shipped)}")
    return decode_toml(text, kind, str(robot), f"see the built-in {file} for every field")
