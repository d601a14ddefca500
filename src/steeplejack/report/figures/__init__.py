"""The figures of a report, each as one SVG element to stand inside a page."""

from steeplejack.report.figures.accuracy import accuracy_figure, path_figure
from steeplejack.report.figures.coverage import coverage_figure
from steeplejack.report.figures.loads import loads_figure
from steeplejack.report.figures.section import section_figure
from steeplejack.report.figures.side import side_figure

__all__ = [
    "accuracy_figure",
    "coverage_figure",
    "loads_figure",
    "path_figure",
    "section_figure",
    "side_figure",
]
