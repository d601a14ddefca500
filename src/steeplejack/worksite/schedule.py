"""A stay schedule: one CSV row per stay, read into a bridge; a bad row is named by line and column.

Columns: ``cable_id, tower, plane, side, index``, both anchorages (``x_deck_m`` ... ``z_tower_m``; the deck one is the
lower) and, where known, ``diameter_m, area_m2, force_kN, w_kN_per_m``; an empty cell means unknown. Other columns are
remarks and are not used, except that the texts under ``status`` become the bridge's notes.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

from steeplejack.errors import InputError
from steeplejack.files import read_source
from steeplejack.worksite.bridge import Bridge
from steeplejack.worksite.stay import Stay, with_end_zones
from steeplejack.worksite.validity import first_fault

REQUIRED = ("cable_id", "tower", "plane", "side", "index", *(f"{c}_{e}_m" for e in ("deck", "tower") for c in "xyz"))
OPTIONAL = ("diameter_m", "area_m2", "force_kN", "w_kN_per_m")
COLUMN_OF = {
    "lower": "column z_deck_m",
    "upper": "column z_tower_m",
    "anchorages": "columns x_deck_m to z_tower_m",
    "index": "column index",
    "diameter": "column diameter_m",
    "weight": "column w_kN_per_m",
    "tension": "column force_kN",
    "axial_stiffness": "column area_m2",
}
STEEL_MODULUS = 195e9  # [Pa] estimate: parallel-wire or strand steel
END_ZONE = 2.5  # [m] estimate: anti-vandalism tube below, anchorage and damper above
END_ZONE_NOTE = "estimate: 2.5 m at each anchorage, anti-vandalism tube below, anchorage and damper above"


def read_schedule(schedule: str | Path | bytes, name: str | None = None) -> Bridge:
    """Read a stay schedule.

    Every stay gets a declared end zone of 2.5 m at each anchorage, an estimate.

    Args:
        schedule: Path of a CSV file, or its content.
        name: Name of the bridge, and of the content in messages; by default the file's name.

    Returns:
        The bridge, SI.

    Raises:
        InputError: A file, line or column that cannot be used; the message names it.
    """
    where = (name or "schedule") if isinstance(schedule, bytes) else str(schedule)
    content = schedule if isinstance(schedule, bytes) else read_source(schedule, "a .csv stay schedule")
    rows = read_rows(content, where)
    stays = tuple(with_end_zones(stay, END_ZONE, END_ZONE, END_ZONE_NOTE) for stay in stays_of(rows))
    remarks = dict.fromkeys(row.cells["status"] for row in rows if row.cells.get("status"))
    notes = (*remarks, f"end zones: {END_ZONE_NOTE}")
    return Bridge(name or Path(where).stem, stays, f"stay schedule {where}", notes)


@dataclass(frozen=True)
class Row:
    """One line of a schedule.

    Args:
        where: File and line, for messages.
        cells: Text by column, stripped.
    """

    where: str
    cells: dict[str, str]

    def error(self, column: str, what: str, valid: str) -> InputError:
        """What is wrong in a column of this line."""
        return InputError(f"{self.where}, column {column}", what, valid)

    def text(self, column: str) -> str:
        """A required text."""
        if not self.cells[column]:
            raise self.error(column, "empty", "a value is required here")
        return self.cells[column]

    def choice(self, column: str, choices: tuple[str, ...]) -> str:
        """A required word out of a few."""
        word = self.text(column)
        if word not in choices:
            raise self.error(column, f"{word!r}", f"one of {', '.join(choices)}")
        return word

    def whole(self, column: str) -> int:
        """A required whole number."""
        word = self.text(column)
        if not (word.isascii() and word.isdigit() and len(word) < 10):
            raise self.error(column, f"{word!r}", "a whole number, 0 or more")
        return int(word)

    def number(self, column: str) -> float:
        """A required finite number, in the column's unit."""
        word = self.text(column)
        try:
            value = float(word) if word.isascii() and "_" not in word else math.nan
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(column, f"{word!r}", "a finite number with a decimal point")
        return value

    def known(self, column: str, si: float = 1.0) -> float | None:
        """An optional number above 0 times ``si``; ``None`` where the cell is empty or the column missing."""
        if not self.cells.get(column):
            return None
        value = self.number(column)
        if value <= 0.0:
            raise self.error(column, f"{value:g}", "a number above 0, or empty where unknown")
        return value * si


def read_rows(content: bytes, where: str) -> list[Row]:
    """Lines of a schedule as text cells.

    Args:
        content: A CSV file's bytes.
        where: Its name, for messages.

    Returns:
        At least one row, with every required column.

    Raises:
        InputError: Not text, not a table, a missing column, a ragged line, or no line at all.
    """
    lines = _lines(_text(content, where), where)
    place, header = next(lines)
    _check_header(header, place)
    rows: list[Row] = []
    for place, cells in lines:
        if len(cells) != len(header):
            raise InputError(place, f"{len(cells)} cells", f"{len(header)} as in the header")
        rows.append(Row(place, dict(zip(header, cells, strict=True))))
    if not rows:
        raise InputError(where, "no stays under the header", "one line per stay")
    return rows


def _lines(text: str, where: str) -> Iterator[tuple[str, list[str]]]:
    """Place and stripped cells of every line that is not blank."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield f"{where} line {reader.line_num}", [cell.strip() for cell in cells]
    except csv.Error as error:
        raise InputError(f"{where} line {reader.line_num}", str(error), "comma-separated values") from None


def _text(content: bytes, where: str) -> str:
    if b"\0" in content:
        raise InputError(where, "a binary file", "a stay schedule in UTF-8 text")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(where, f"not text at byte {error.start}", "a stay schedule in UTF-8 text") from None
    if not text.strip(", \t\r\n"):
        raise InputError(where, "an empty file", f"a header line with {', '.join(REQUIRED)}")
    return text


def _check_header(header: list[str], where: str) -> None:
    for column in REQUIRED:
        if column not in header:
            raise InputError(where, f"missing column {column}", f"a header line with {', '.join(REQUIRED)}")
    for column in (*REQUIRED, *OPTIONAL):
        if header.count(column) > 1:
            raise InputError(where, f"column {column} stands twice", "each column once")


def stays_of(rows: list[Row]) -> list[Stay]:
    """Stays of a schedule, each checked, without end zones.

    Raises:
        InputError: A cell that cannot be used, or a repeated id or place in a fan.
    """
    ids: dict[str, Row] = {}
    places: dict[tuple[str, int], Row] = {}
    stays: list[Stay] = []
    for row in rows:
        stay = _stay(row)
        if (first := ids.setdefault(stay.id, row)) is not row:
            raise row.error("cable_id", f"{stay.id!r} stands already at {first.where}", "each id once")
        if (first := places.setdefault((stay.fan, stay.index), row)) is not row:
            what = f"place {stay.index} of fan {stay.fan} is taken at {first.where}"
            raise row.error("index", what, "each place in a fan once")
        stays.append(stay)
    return stays


def _stay(row: Row) -> Stay:
    lower_x, lower_y, lower_z, upper_x, upper_y, upper_z = (row.number(column) for column in REQUIRED[5:])
    area = row.known("area_m2")
    tower = row.text("tower")
    if not tower.isalnum():
        raise row.error("tower", f"{tower!r}", "letters and digits, as in 1 or N2")
    stay = Stay(
        id=row.text("cable_id"),
        tower=tower,
        plane=cast(Literal["L", "R"], row.choice("plane", ("L", "R"))),
        side=cast(Literal["main", "side"], row.choice("side", ("main", "side"))),
        index=row.whole("index"),
        lower=(lower_x, lower_y, lower_z),
        upper=(upper_x, upper_y, upper_z),
        diameter=row.known("diameter_m"),
        weight=row.known("w_kN_per_m", 1e3),
        tension=row.known("force_kN", 1e3),
        axial_stiffness=None if area is None else STEEL_MODULUS * area,
    )
    if fault := first_fault(stay):
        raise InputError(f"{row.where}, {COLUMN_OF[fault.field]}", fault.what, fault.valid)
    return stay
