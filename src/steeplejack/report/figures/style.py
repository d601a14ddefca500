"""One look for all figures: few colours that stay apart for colour-blind eyes, thin lines, text as text."""

from __future__ import annotations

import re
from collections.abc import Generator
from contextlib import contextmanager
from io import StringIO
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from steeplejack.report.log import Log
from steeplejack.worksite import Stay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.typing import RcKeyType

Array = NDArray[np.float64]

INK, MUTED, STEEL, GRID, PALE = "#1d2933", "#5f6b76", "#9aa5ae", "#e3e8ec", "#f3f5f7"
BLUE, ORANGE, GREEN, PURPLE, VERMILION = "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00"  # Okabe and Ito
CABLES = (BLUE, ORANGE, GREEN, PURPLE)  # cables and bases 1 to 4
LEGS = {"inspect": BLUE, "fly": MUTED, "brace": PURPLE, "drive": VERMILION}
ACTIVITY = (BLUE, STEEL, PURPLE, VERMILION, ORANGE, INK)  # as in ``analysis.ACTIVITIES``
WIDTH = 9.6  # [inch] of a figure across the page
MOST = 2400  # points kept of one line

STYLE: dict[RcKeyType, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "text.color": INK,
    "text.parse_math": False,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": STEEL,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "xtick.color": STEEL,
    "ytick.color": STEEL,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "lines.linewidth": 1.0,
    "hatch.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "svg.fonttype": "none",
    "svg.hashsalt": "steeplejack",
}


@contextmanager
def canvas(height: float) -> Generator[Figure]:
    """An empty figure across the page, ``height`` [inch] high, in the report's style."""
    with matplotlib.rc_context(STYLE):
        yield Figure(figsize=(WIDTH, height), layout="constrained")


def svg(figure: Figure, name: str) -> str:
    """A figure as one SVG element whose ids are ``name`` and a number, so that several can stand in one page.

    Numbered in the order they appear: the ids matplotlib draws from addresses in memory differ from run to run.
    """
    stream = StringIO()
    nothing = {"Date": None, "Creator": None, "Format": None, "Type": None}
    figure.savefig(stream, format="svg", bbox_inches="tight", pad_inches=0.05, metadata=nothing)
    text = stream.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    numbers = {old: f"{name}-{i}" for i, old in enumerate(dict.fromkeys(re.findall(r'\bid="([^"]+)"', text)))}
    text = re.sub(r'\bid="([^"]+)"', lambda m: f'id="{numbers[m[1]]}"', text)
    text = re.sub(r'href="#([^"]+)"', lambda m: f'href="#{numbers[m[1]]}"', text)
    return re.sub(r"url\(#([^)]+)\)", lambda m: f"url(#{numbers[m[1]]})", text)


def thin(x: Array, y: Array, most: int = MOST) -> tuple[Array, Array]:
    """At most ``most`` points of a long line that keep every extreme: least and largest of each bucket, in order."""
    if len(x) <= most:
        return x, y
    buckets = np.array_split(np.arange(len(x)), most // 2)
    keep = np.unique([bucket[i] for bucket in buckets for i in (np.argmin(y[bucket]), np.argmax(y[bucket]))])
    return x[keep], y[keep]


def spells(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def bare(axes: Axes) -> None:
    """Take ticks, grid and frame off; other axes that share this one's scale keep theirs."""
    axes.grid(False)
    axes.tick_params(bottom=False, labelbottom=False, left=False, labelleft=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def middle_stay(log: Log) -> Stay:
    """The interior stay in the middle of the bay, which places along and across are told from."""
    return log.bay.stays[len(log.bay.stays) // 2]
