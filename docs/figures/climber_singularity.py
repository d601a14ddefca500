"""Draws docs/climber-singularity.png: where the pipe climber's mechanism is singular.

python docs/figures/climber_singularity.py
"""

from __future__ import annotations

import math
from pathlib import Path

from steeplejack.design.charts.singularity import singularity_figure
from steeplejack.design.charts.style import save_figure
from steeplejack.robots.pipe_climber import Layout, load_pipe_climber

if __name__ == "__main__":
    figure = singularity_figure(Layout.of(load_pipe_climber()), math.radians(-30.0))
    save_figure(figure, Path(__file__).parents[1] / "climber-singularity.png")
