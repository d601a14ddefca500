"""03 Plan, fly and report: twelve metres of one stay in two cells, with the squad's move between them."""

import tempfile
from pathlib import Path

import numpy as np

from steeplejack.planning import Request, Rules, Scene, plan, verdicts
from steeplejack.report import write_report
from steeplejack.robots.squad import Bay, load_squad
from steeplejack.simulation import Session
from steeplejack.worksite import Bridge, load_worksite

bridge, squad = load_worksite("ecs620-like"), load_squad()
assert isinstance(bridge, Bridge)
bay, rules = Bay.of(bridge.fan("T1L-main"), 5, 7, "under", squad), Rules(tension=(20.0, 250.0), cell_length=6.0)
request = Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 42.0, "under", 0.0, rules.tension)
mission = plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), request, (), lambda done: None)
print(f"{mission.stances} stances, {mission.moves} squad move, {len(mission.legs)} legs")
with tempfile.TemporaryDirectory() as folder:
    log = Path(folder) / "run.mcap"
    result = Session(mission, bridge, bay, squad, verdicts(bridge, squad)).run(log, False, lambda time: None)
    summary = write_report(log, Path(folder) / "report.html")
print(f"covered {100 * summary.coverage_fraction:.1f} %, least slip margin {summary.min_slip_margin:.3f}")
