"""How long one control step takes: estimate, law and safety check, in a run of the simulated squad.

Prints percentiles as a table and as JSON. Bound: the control period of 1 ms.

    python benchmarks/control_step.py
"""

from __future__ import annotations

import json
import time

import numpy as np

from steeplejack.control import PlatformController
from steeplejack.planning import Request, Rules, Scene, plan, verdicts
from steeplejack.robots.squad import Bay, load_squad
from steeplejack.runtime.plant import Command
from steeplejack.runtime.reference import LegReference
from steeplejack.runtime.run import CONTROL_STEP
from steeplejack.safety import Monitor
from steeplejack.simulation import Session
from steeplejack.worksite import Bridge, load_worksite

STEPS = 20_000
PERIOD_US = 1e6 * CONTROL_STEP


def measure() -> np.ndarray:
    """Wall time of every control step [us] over the first 20 s of a mission."""
    bridge, squad = load_worksite("ecs620-like"), load_squad()
    assert isinstance(bridge, Bridge)
    bay, rules = Bay.of(bridge.fan("T1L-main"), 5, 7, "under", squad), Rules(tension=(20.0, 250.0))
    gravity = np.array(bridge.gravity)
    request = Request(bridge.name, squad.name, "T1L-main", (5, 7), 30.0, 38.0, "under", 0.0, rules.tension)
    mission = plan(Scene.of(bay, squad, rules, gravity), request, (), lambda _done: None)
    plant = Session(mission, bridge, bay, squad, verdicts(bridge, squad)).plant()
    controller = PlatformController(bay, squad, squad.platform.mass, gravity, rules.tension)
    monitor = Monitor(bay, squad, squad.platform.mass * gravity, rules.tension)
    reference, none = LegReference.of(mission.legs[0]), np.zeros(4, bool)
    command = Command(np.zeros(4), np.zeros(4), np.zeros(4), np.ones(4, bool), np.zeros(4, bool))
    state = controller.begin(reference.at(0.0), plant.measure().values)
    watch = monitor.begin(reference.at(0.0).tension, plant.measure().clock)
    times = np.empty(STEPS)
    for k in range(STEPS):
        reading = plant.measure()
        setpoint = reference.at(k * CONTROL_STEP)
        began = time.perf_counter()
        state, output = controller.step(state, setpoint, reading.values, none, CONTROL_STEP)
        verdict = monitor.step(
            watch,
            reading.values,
            output.command,
            command.grip,
            none,
            setpoint.position,
            setpoint.rotation,
            CONTROL_STEP,
        )
        watch = verdict.state
        times[k] = 1e6 * (time.perf_counter() - began)
        assert verdict.code == 0
        command.pull = output.command[0]
        plant.apply(command)
        plant.advance(round(CONTROL_STEP / plant.step))
    return times[100:]  # the first steps compile or load the kernels


def main() -> None:
    """Measure and print."""
    times = measure()
    row = {f"p{q}_us": round(float(np.percentile(times, q)), 1) for q in (50, 99, 99.9)}
    row["worst_us"] = round(float(times.max()), 1)
    row["p99_share_of_period"] = round(row["p99_us"] / PERIOD_US, 4)
    for name, value in row.items():
        print(f"{name:<22}{value:>10}")
    print(json.dumps(row))


if __name__ == "__main__":
    main()
