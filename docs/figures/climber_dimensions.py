"""Figures and tables of docs/pipe-climber-dimensions.md: run from the root of the repository, takes three minutes."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from steeplejack.design.charts import save_figure
from steeplejack.design.charts.climber import (
    chart_figure,
    front_figure,
    orientation_figure,
    reach_figure,
    transmission_figure,
)
from steeplejack.design.charts.climber_space import space_figure
from steeplejack.design.climber import (
    PRESCRIBED,
    Comparison,
    design_plane,
    design_space,
    front,
    optimise,
    orientations,
    performance_chart,
    read,
    readings,
    transmission_map,
    workspace_area,
    workspace_volume,
)
from steeplejack.robots.pipe_climber import Layout

DOCS = Path("docs")
TEXT = Layout((0.100, 0.100, 0.075, 0.075))
HOME = replace(TEXT, neutral="home")
NORMAL = replace(TEXT, neutral="normal")


def draw() -> None:
    """The figures."""
    save_figure(reach_figure(HOME, 0.0, orientations(HOME, 0.001)), DOCS / "climber-reach.png")
    sections = {"no joint limits": TEXT, "±30° from home": HOME, "±30° from the normals": NORMAL}
    save_figure(orientation_figure(sections, 0.160), DOCS / "climber-orientation.png")
    angles = (-30, -20, -10, 0, 10, 20, 30)
    maps = {f"α = {angle}°": transmission_map(TEXT, 0.001, math.radians(angle)) for angle in angles}
    save_figure(transmission_figure(maps), DOCS / "climber-transmission.png")
    chart = performance_chart(design_plane(0.01), Comparison(PRESCRIBED))
    save_figure(chart_figure(chart), DOCS / "climber-chart.png")
    space = performance_chart(design_space(0.025), Comparison(PRESCRIBED, step=0.002))
    save_figure(space_figure(space), DOCS / "climber-space.png")
    designs = {"original": TEXT, "reported optimum": Layout((0.100, 0.100, 0.075, 0.065))}
    designs["best of the chart"] = Comparison().layout(chart.best()[0])
    before = {name: transmission_map(layout, 0.001, rectangle=PRESCRIBED) for name, layout in designs.items()}
    save_figure(transmission_figure(before), DOCS / "climber-before-after.png")
    plane = performance_chart(design_plane(0.025), Comparison(step=0.002))
    save_figure(front_figure(front(plane)), DOCS / "climber-front.png")


def areas() -> None:
    """Areas and volumes under every convention and neutral."""
    print("| convention | neutral | alpha = -30 deg | alpha = 0 | alpha = 30 deg | volume [m2 rad] |")
    print("| --- | --- | ---: | ---: | ---: | ---: |")
    for convention in ("text", "equations"):
        for neutral in ("none", "home", "normal"):
            layout = replace(TEXT, convention=convention, neutral=neutral)
            sizes = [f"{workspace_area(layout, math.radians(angle)) * 1e6:,.1f}" for angle in (-30, 0, 30)]
            print(f"| {convention} | {neutral} | {' | '.join(sizes)} | {workspace_volume(layout, 0.001):.5f} |")


def table() -> None:
    """The readings."""
    names = ("moving", "alpha", "scale", "convention", "region", "original", "reported", "best", "best at L3/L1, L4/L1")
    print(f"| {' | '.join(names)} | better than reported |")
    print("| --- | --- | --- | --- | --- | ---: | ---: | ---: | --- | ---: |")
    for one in readings():
        found, asked = read(one), one
        region = "rectangle" if asked.rectangle else f"workspace, {asked.neutral}"
        span = "0" if len(asked.alphas) == 1 else "within 30 deg"
        print(
            f"| {asked.moving} | {span} | {asked.scale} | {asked.convention} | {region} "
            f"| {found.original:.4f} | {found.paper:.4f} | {found.best:.4f} "
            f"| {found.ratio[2]:.3g}, {found.ratio[3]:.3g} | {found.share_above_paper:.0%} |"
        )
        assert not found.paper_is_local


if __name__ == "__main__":
    draw()
    areas()
    table()
    for k in (1.0, None):
        print(k, optimise(Comparison(PRESCRIBED), k))
