"""One look for every figure of the design room, and how a figure becomes a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

INK, STEEL, ROPE, PAPER = "#22303c", "#8795a1", "#44525e", "white"
STYLE: dict[RcKeyType, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.edgecolor": STEEL,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "svg.hashsalt": "steeplejack",
}


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure; the ending of the name says SVG or PNG. Same figure, same bytes.

    Args:
        figure: What to write.
        path: Ends in ``.svg`` or ``.png``.
    """
    with matplotlib.rc_context(rc=STYLE):
        figure.savefig(path, dpi=200, metadata={"Date": None} if Path(path).suffix == ".svg" else None)
