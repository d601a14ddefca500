"""One-at-a-time sensitivity of the tracking accuracy to the estimated physics parameters.

Runs one small mission with a squad move (stays 5:7 of the built-in default bay, 24-34 m, two stances) once as the robot
file stands and once per variation, and prints a Markdown table. About five minutes on one core.

    python benchmarks/sensitivity.py
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import msgspec
import numpy as np

from steeplejack.planning import Mission, Request, Rules, Scene, plan, verdicts
from steeplejack.report import write_report
from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.simulation import Session
from steeplejack.worksite import Bridge, load_worksite

# (name, table, field, factors): each factor in turn, everything else as in the robot file.
VARIATIONS = (
    ("cable stiffness EA", "cable", "axial_stiffness", (0.5, 1.5)),
    ("air density (drag)", "simulation", "drag_density", (0.0, 3.0)),
    ("winch friction", "winch", "friction", (0.0, 3.0)),
    ("motor current noise", "winch", "current_noise", (0.0, 4.0)),
    ("torque scale error", "winch", "torque_scale_error", (0.0, 3.0)),
    ("odometry drift", "base", "odometry_drift", (0.0, 3.0)),
    ("cable damping", "cable", "damping_time", (0.3, 3.0)),
)


def varied(squad: Squad, table: str, field: str, factor: float) -> Squad:
    """The machine with one value multiplied."""
    part = getattr(squad, table)
    return msgspec.structs.replace(
        squad, **{table: msgspec.structs.replace(part, **{field: factor * getattr(part, field)})}
    )


def run(bridge: Bridge, bay: Bay, mission: Mission, squad: Squad, folder: Path) -> str:
    """A table row of the errors of one run."""
    log = folder / "run.mcap"
    result = Session(mission, bridge, bay, squad, verdicts(bridge, squad)).run(log, False, lambda _time: None)
    summary = write_report(log, folder / "report.html")
    cells = [
        f"{error.mean:+.1f} +- {error.std:.1f}"
        for error in (summary.error_along_mm, summary.error_across_mm, summary.error_stand_off_mm)
    ]
    absolute = summary.absolute_error_mm
    cells += [f"{absolute.mean:.1f}, {absolute.max:.1f}", f"{summary.min_slip_margin:.3f}"]
    return " | ".join([*cells, "complete" if result.completed else "; ".join(result.faults)])


def main() -> None:
    """Run the baseline and every variation."""
    bridge, squad = load_worksite("ecs620-like"), load_squad()
    assert isinstance(bridge, Bridge)
    bay, rules = Bay.of(bridge.fan("T1L-main"), 5, 7, "under", squad), Rules(tension=(20.0, 250.0), cell_length=5.0)
    request = Request(bridge.name, squad.name, "T1L-main", (5, 7), 24.0, 34.0, "under", 0.0, rules.tension)
    # The plan knows the true stiffness of the machine it is made for; it is made once, for the file as it stands.
    mission = plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), request, (), lambda _done: None)
    print("| parameter | along [mm] | across [mm] | stand-off [mm] | absolute mean, max [mm] | slip margin | run |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
    with tempfile.TemporaryDirectory() as folder:
        print(f"| as in the file | {run(bridge, bay, mission, squad, Path(folder))} |", flush=True)
        for name, table, field, factors in VARIATIONS:
            for factor in factors:
                row = run(bridge, bay, mission, varied(squad, table, field, factor), Path(folder))
                print(f"| {name} x {factor:g} | {row} |", flush=True)


if __name__ == "__main__":
    main()
