"""Draw the figures of the page on anchors along a path."""

from pathlib import Path

import numpy as np

from steeplejack.design.anchors import Duty, Reconfiguration, eq28, optimal_anchors, trade_off
from steeplejack.design.charts import save_figure
from steeplejack.design.charts.travel import path_figure, trade_off_figure
from steeplejack.robots.squad import load_squad
from steeplejack.robots.squad.planar import planar_attachments, stay_directions
from steeplejack.worksite import PlanarSite, load_worksite

OUT = Path(__file__).parents[1]
PRICES = [0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]

site = load_worksite("table-iii")
assert isinstance(site, PlanarSite)
along = stay_directions(site.anchors, site.stays)
windows = np.tile([-0.05, 0.05], (4, 1))
problem = Reconfiguration(site.anchors, along / along[:, :1], planar_attachments(load_squad()), windows, eq28())
paths = trade_off(problem, Duty(), PRICES)
for path in paths:
    print(f"{path.price:g} per metre: mean {path.mean:.6f}, {path.travel:.4f} m")
save_figure(trade_off_figure(paths, float(np.mean(optimal_anchors(problem).upper))), OUT / "anchors_trade_off.png")
save_figure(path_figure(problem, paths[PRICES.index(0.02)]), OUT / "anchors_path.png")
