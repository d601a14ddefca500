"""One-at-a-time sensitivity of the tracking accuracy to the estimates of the robot file: physics, sensors, gains.

Runs one small mission in which all four bases drive (stays 5:7 of the built-in default bay, 38-50 m, three stances)
once as the robot file stands and once per variation, and prints a Markdown table. Noise, bias, drag and drift are only
made worse; of the rest some are varied to one side. The machine is varied; plan, controller and safety go on believing
the file, so a row says what a wrong estimate costs. Only the controller's own gains are varied where they are used.
About fifteen minutes on one core.

    python benchmarks/sensitivity.py
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import msgspec
import numpy as np

from steeplejack.planning import Mission, Request, Rules, Scene, plan
from steeplejack.report import write_report
from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.simulation import Session
from steeplejack.worksite import Bridge, load_worksite

# (name, table, field, factors): each factor in turn, everything else as in the robot file.
VARIATIONS = (
    ("cable stiffness EA", "cable", "axial_stiffness", (0.5, 1.5)),
    ("air density (drag)", "simulation", "drag_density", (3.0,)),
    ("winch friction", "winch", "friction", (0.0, 3.0)),
    ("motor current noise", "winch", "current_noise", (4.0,)),
    ("torque scale error", "winch", "torque_scale_error", (3.0,)),
    ("odometry drift", "base", "odometry_drift", (3.0,)),
    ("cable damping", "cable", "damping_time", (0.3, 3.0)),
    ("rotor inertia", "winch", "rotor_inertia", (2.0,)),
    ("drum radius (reflected mass)", "winch", "drum_radius", (0.8,)),
    ("platform inertia", "platform", "inertia", (2.0,)),
    ("twist torque of the palms", "base", "twist_torque", (0.5,)),
    ("winch encoder counts", "winch", "encoder_counts", (0.1, 0.01)),
    ("wheel encoder grain", "base", "encoder_step", (70.0,)),
    ("inclinometer bias", "base", "clock_bias", (3.0,)),
    ("inclinometer noise", "base", "clock_noise", (4.0,)),
    ("controller stiffness", "controller", "stiffness", (0.5, 2.0)),
    ("controller damping", "controller", "damping", (0.5, 2.0)),
)


def varied(squad: Squad, table: str, field: str, factor: float) -> Squad:
    """The machine with one value or vector multiplied."""
    part = getattr(squad, table)
    value = getattr(part, field)
    value = tuple(factor * each for each in value) if isinstance(value, tuple) else factor * value
    return msgspec.structs.replace(squad, **{table: msgspec.structs.replace(part, **{field: value})})


def run(bridge: Bridge, bay: Bay, mission: Mission, believed: Squad, actual: Squad, folder: Path) -> str:
    """A table row of the errors of one run."""
    log = folder / "run.mcap"
    result = Session(mission, bridge, bay, believed, (), 0, actual).run(log, False, lambda _time: None)
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
    request = Request(bridge.name, squad.name, "T1L-main", (5, 7), 38.0, 50.0, "under", 0.0, rules.tension)
    mission = plan(Scene.of(bay, squad, rules, np.array(bridge.gravity)), request, (), lambda _done: None)
    print("| parameter | along [mm] | across [mm] | stand-off [mm] | absolute mean, max [mm] | slip margin | run |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
    with tempfile.TemporaryDirectory() as folder:
        print(f"| as in the file | {run(bridge, bay, mission, squad, squad, Path(folder))} |", flush=True)
        for name, table, field, factors in VARIATIONS:
            for factor in factors:
                changed = varied(squad, table, field, factor)
                believed = changed if table == "controller" else squad
                row = run(bridge, bay, mission, believed, changed, Path(folder))
                print(f"| {name} x {factor:g} | {row} |", flush=True)


if __name__ == "__main__":
    main()
