"""Figures of the design room; importing it loads the plotting library."""

from steeplejack.design.charts.anchors import anchors_figure
from steeplejack.design.charts.grasps import grasp_figure
from steeplejack.design.charts.maps import map_figure
from steeplejack.design.charts.stances import stance_chart_figure
from steeplejack.design.charts.style import save_figure

__all__ = ["anchors_figure", "grasp_figure", "map_figure", "save_figure", "stance_chart_figure"]
