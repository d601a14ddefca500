"""Figures of the design room; importing it loads the plotting library."""

from steeplejack.design.charts.maps import map_figure
from steeplejack.design.charts.style import save_figure

__all__ = ["map_figure", "save_figure"]
