"""02 Where does the platform hang? One stance on a real-sized bay: tensions and stability against stand-off."""

import numpy as np

from steeplejack.planning import Rules, Scene
from steeplejack.planning.certificate import binding, hold
from steeplejack.robots.squad import Bay, load_squad
from steeplejack.robots.squad.anchorage import facing
from steeplejack.worksite import Bridge, load_worksite

bridge, squad = load_worksite("ecs620-like"), load_squad()
assert isinstance(bridge, Bridge)
bay = Bay.of(bridge.fan("T1L-main"), 5, 9, "under", squad)
scene = Scene.of(bay, squad, Rules(tension=(20.0, 250.0)), np.array(bridge.gravity))

bases = np.array([24.0, 24.0, 71.0, 51.0])  # along their stays [m], cables 1 to 4
anchors, pull = scene.anchors(bases, facing(bay, bases, bay.place(2.0, 25.0, 0.7)))
for stand_off in (0.3, 0.5, 0.7, 0.9):
    place = np.array([2.0, 25.0, bay.radius(2) + stand_off])  # at the middle stay, 25 m up
    held = hold(scene, anchors, pull, place)
    why = "" if held.good[0] else f"  not held: {binding(scene, anchors, pull, place)}"
    print(f"{stand_off:.1f} m off the surface: tensions {np.round(held.tension[0])} N{why}")
