"""Draws docs/stance_chart.png: the best and the fixed stance along every interior stay of two fans, in space.

python docs/figures/stance_chart.py [file]
"""

from __future__ import annotations

import sys
from pathlib import Path

from steeplejack.design.charts import save_figure, stance_chart_figure
from steeplejack.design.stances import ChartRules, shares, stance_chart
from steeplejack.robots.squad import load_squad
from steeplejack.worksite import Bridge, load_worksite

SITE, FANS = "ecs620-like", ("T1L-main", "T1L-side")  # the bridge's other fans mirror these
RULES = ChartRules(spacing=8.0)


def main() -> None:
    """Chart, print the shares of the page's table, draw."""
    bridge = load_worksite(SITE)
    assert isinstance(bridge, Bridge)
    chart = stance_chart(bridge, load_squad(), RULES, "space", FANS)
    print(shares(chart))
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "stance_chart.png"
    save_figure(stance_chart_figure(chart), target)


if __name__ == "__main__":
    main()
