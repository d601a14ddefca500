"""04 A suspended robot in space: CoGiRo's wrench closure, what it holds under gravity, stiffness and vibrations."""

import numpy as np

from steeplejack.mechanics.cable import capacity_margin, distribute, in_wrench_closure, natural_modes
from steeplejack.robots.cable_robot import load_cable_robot

robot, gravity, turn = load_cable_robot("cogiro"), np.array([0.0, 0.0, -9.81]), np.eye(3)
steps = (np.linspace(-6.0, 6.0, 25), np.linspace(-4.5, 4.5, 19), np.linspace(0.5, 3.5, 7))
places = np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 3)

structure, weight = robot.structure(places, turn), robot.weight(gravity, places, turn)
print(f"wrench closure at {in_wrench_closure(structure).sum()} of {len(places)} places: all anchors are above")
margin = capacity_margin(structure, robot.lower, robot.upper, weight)
print(f"100 to 5000 N hold the platform at {(margin >= 0.0).sum()} of them")
best = int(np.argmax(margin))
print(f"most room at {places[best]} m: {margin[best]:.0f} N in any direction, 1 N m counted as 1 N")

for at in (best, int(np.flatnonzero(margin > 0.0)[0])):
    held = distribute(structure[at], weight[at], robot.lower, robot.upper, "max-margin")
    stiffness, mass = robot.stiffness(held.tensions, gravity, places[at], turn), robot.mass_matrix(places[at], turn)
    frequencies = ", ".join(f"{value:.2f}" for value in natural_modes(stiffness, mass).frequencies)
    print(f"at {places[at]} m: {held.tensions.min():.0f} to {held.tensions.max():.0f} N, vibrates at {frequencies} Hz")
