"""A call with good arguments for every public function of cable mechanics.

Making them compiles kernels, so whoever asks imports this when it runs and not when tests are collected.
"""

from __future__ import annotations

import numpy as np

from steeplejack.mechanics import cable
from steeplejack.robots.cable_robot import load_cable_robot

PLANAR, SPATIAL = load_cable_robot("planar-4-4"), load_cable_robot("cogiro")
POSE, PLACE, TURN = [5.0, 3.0, 0.02], [1.0, 0.5, 2.0], np.eye(3)
DOWN, FALL = [0.0, -9.81], [0.0, 0.0, -9.81]
BOX = [[-1.0, 1.0], [-1.0, 1.0], [2.0, 2.1]]

STRUCTURE, WEIGHT, LENGTHS = PLANAR.structure(POSE), PLANAR.weight(DOWN, POSE), PLANAR.lengths(POSE)
STRUCTURE_6, WEIGHT_6 = SPATIAL.structure(PLACE, TURN), SPATIAL.weight(FALL, PLACE, TURN)
LENGTHS_6, LOCKED = SPATIAL.lengths(PLACE, TURN), PLANAR.locked(DOWN, POSE)
FLAT = {"anchors": PLANAR.anchors, "attachments": PLANAR.attachments}
SOLID = {"anchors": SPATIAL.anchors, "attachments": SPATIAL.attachments}
AT = {**SOLID, "position": PLACE, "rotation": TURN}
WINDOW, WINDOW_6 = {"lower": 1.0, "upper": 500.0}, {"lower": SPATIAL.lower, "upper": SPATIAL.upper}
WHEELS = {"axes": np.tile([0.0, 0.0, 1.0], (8, 1)), "radii": 0.05}
WHEELS_2 = {"axes": np.tile([0.0, 1.0], (4, 1)), "radii": 0.05}
GRID = {**FLAT, "phi": 0.02, "xs": [4.0, 5.0], "ys": [3.0]}
RAY, RAY_3 = {"starts": [1.0, 1.0, 0.02], "ends": [9.0, 5.0, 0.02]}, {"starts": [0.0, 0.0, 1.0], "ends": PLACE}
SURROUNDINGS = cable.Surroundings.of(**SOLID, rotation=TURN, stays=[[[1.5, -3.0, 3.1], [1.5, 3.0, 3.3]]], radii=0.05)
QUESTION = cable.pose_question(**SOLID, wrenches=WEIGHT_6, **WINDOW_6, centre=SPATIAL.centre_of_mass)
SLOPE, DERIVATIVES = cable.tension_factor_slope(STRUCTURE), cable.planar_structure_derivatives(**FLAT, pose=POSE)
TENSIONS = {"tensions": np.full(4, 9.0), "rates": np.full(4, 1e4)}
TENSIONS_6 = {"tensions": np.full(8, 9.0), "rates": np.full(8, 1e4)}
CENTRE = [0.1, 0.0, 0.0]

CALLS = {
    "available_wrench_set": {"structure": STRUCTURE, **WINDOW, "length": 1.0},
    "best_node": {**FLAT, "phis": [0.0, 0.1], "nodes": 5},
    "box_faces": {"low": [-1.0, -1.0, -1.0], "high": [1.0, 1.0, 1.0]},
    "cable_crossings": {"surroundings": SURROUNDINGS, **RAY_3},
    "cable_rates": {"axial_stiffness": 1e5, "lengths": LENGTHS, "tensions": np.full(4, 9.0)},
    "capacity_margin": {"structure": STRUCTURE, **WINDOW, "task": WEIGHT, "length": 1.0},
    "capacity_margin_slope": {"structure": STRUCTURE, "wrench": WEIGHT, **WINDOW, "length": 1.0},
    "certificate_gap": {"certificate": [1.0, 0.0, 0.0], "structure": STRUCTURE, "wrench": WEIGHT, **WINDOW},
    "certified_rays": {"facets": cable.planar_facets(**FLAT), **RAY, "tolerance": 1e-6},
    "certify": {
        "facets": cable.planar_facets(**FLAT),
        "box": [[4.0, 6.0], [2.0, 4.0], [0.0, 0.1]],
        "gap": 0.3,
        "most": 2000,
    },
    "certify_orientations": {
        "question": QUESTION,
        "box": BOX,
        "turns": [[-0.02, 0.02], [0.0, 0.0], [0.0, 0.0]],
        "gap": 0.3,
        "most": 200,
    },
    "certify_poses": {
        "question": QUESTION,
        "box": [*BOX, [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        "gap": 0.3,
        "most": 200,
    },
    "characteristic_length": {"attachments": PLANAR.attachments},
    "closure_box": FLAT,
    "closure_rays": {"facets": cable.planar_facets(**FLAT), **RAY},
    "condition_number": {"structure": STRUCTURE, "length": 1.0},
    "crossing_planes": {"surroundings": SURROUNDINGS},
    "dexterity": {"structure": STRUCTURE, "length": 1.0},
    "distribute": {
        "structure": STRUCTURE,
        "wrench": WEIGHT,
        **WINDOW,
        "method": "qp",
        "weights": 1.0,
        "reference": 5.0,
    },
    "equilibria": {"platform": LOCKED, "positions": [POSE[:2]], "rotations": [0.02]},
    "every_planar_pose": {"lengths": LENGTHS, **FLAT, "tolerance": 1e-5, "budget": 100},
    "every_spatial_pose": {
        "lengths": LENGTHS_6,
        **AT,
        "half_widths": 0.1,
        "half_angles": 0.1,
        "tolerance": 1e-5,
        "budget": 20,
    },
    "failing_turn": {"turns": [[-0.02, 0.02], [0.0, 0.0], [0.0, 0.0]], "number": 5},
    "forward_kinematics": {"lengths": LENGTHS, **FLAT, "start": POSE, "tolerance": 1e-3, **WHEELS_2},
    "gradient": {"slope": SLOPE, "derivatives": DERIVATIVES, "wrench": np.zeros((3, 3))},
    "gravity_wrench": {"mass": 5.0, "gravity": FALL, "arm": CENTRE},
    "grid_nodes": {"low": 0.0, "high": 1.0, "step": 0.1},
    "in_wrench_closure": {"structure": STRUCTURE},
    "inertial_wrench": {
        "mass": 5.0,
        "inertia": np.eye(3),
        "centre": CENTRE,
        "rotation": TURN,
        "angular_velocity": [0.0, 0.0, 1.0],
        "acceleration": np.ones(6),
    },
    "interference_gaps": {"surroundings": SURROUNDINGS, "positions": PLACE},
    "interference_rays": {"surroundings": SURROUNDINGS, **RAY_3, "clearance": 0.05, "tolerance": 1e-3},
    "interference_region": {"surroundings": SURROUNDINGS, "box": BOX, "clearance": 0.05, "gap": 0.3, "most": 500},
    "is_singular": {"structure": STRUCTURE},
    "loaded_lengths": {"unstretched": LENGTHS, "tensions": np.full(4, 9.0), "axial_stiffness": 1e5},
    "locked_at": {"platform": LOCKED, "position": POSE[:2], "rotation": 0.02, "tensions": 0.0},
    "lost_cable": {"platform": LOCKED, "cable": 1, "position": POSE[:2], "rotation": 0.02, "stride": 0.1},
    "lost_cable_map": {
        "platform": LOCKED,
        "positions": [POSE[:2]],
        "rotations": [0.02],
        "anchors": PLANAR.anchors,
        "tensions": 0.0,
        "cables": [1],
        "corners": PLANAR.attachments,
        "stride": 0.1,
    },
    "margin_grid": {**GRID, "wrench": WEIGHT, **WINDOW, "stays": np.tile([0.0, 1.0], (4, 1)), "pull_limit": 90.0},
    "margin_slope": {"structure": STRUCTURE, "wrench": WEIGHT, **WINDOW},
    "natural_frequencies": {"rest": cable.settle(LOCKED, POSE[:2], 0.02), "mass": PLANAR.mass_matrix(POSE)},
    "natural_modes": {"stiffness": np.diag([1.0, 2.0, 3.0]), "mass": np.eye(3)},
    "normalised_structure": {"structure": STRUCTURE, "length": 1.0},
    "null_space": {"structure": STRUCTURE},
    "null_vector": {"structure": STRUCTURE},
    "planar_arms": {"attachments": PLANAR.attachments, "phi": 0.2},
    "planar_closure_map": {**FLAT, "poses": POSE},
    "planar_facets": {**FLAT, "wrenches": WEIGHT, **WINDOW},
    "planar_feasibility_map": {**FLAT, "poses": POSE, **WINDOW, "task": WEIGHT, "length": 1.0},
    "planar_inertial_wrench": {
        "mass": 5.0,
        "inertia": 0.3,
        "centre": [0.1, 0.0],
        "phi": 0.2,
        "rate": 0.1,
        "acceleration": [1.0, 0.0, 0.0],
    },
    "planar_lengths": {**FLAT, "pose": POSE},
    "planar_mass_matrix": {"mass": 5.0, "inertia": 0.3, "centre": [0.1, 0.0], "phi": 0.2},
    "planar_stiffness": {**FLAT, "pose": POSE, **TENSIONS, "weight": DOWN, "centre": [0.1, 0.0], **WHEELS_2},
    "planar_structure_derivatives": {**FLAT, "pose": POSE, **WHEELS_2},
    "planar_structure_matrix": {**FLAT, "pose": POSE},
    "planar_vectors": {**FLAT, "pose": POSE},
    "planar_weight_derivative": {"weight": DOWN, "centre": [0.1, 0.0], "pose": POSE},
    "platform_overlap": {
        **SOLID,
        "positions": PLACE,
        "rotations": TURN,
        "normals": np.vstack((np.eye(3), -np.eye(3))),
        "offsets": np.full(6, 0.5),
    },
    "pose_question": {**SOLID, "rotation": TURN, "wrenches": WEIGHT_6, **WINDOW_6, "centre": SPATIAL.centre_of_mass},
    "pose_rates": {"structure": STRUCTURE, "length_rates": np.zeros(4)},
    "pulley_runs": {"anchors": SPATIAL.anchors, **WHEELS, "points": SPATIAL.anchors + np.array([1.0, 1.0, -2.0])},
    "rank": {"structure": STRUCTURE},
    "settle": {"platform": LOCKED, "position": POSE[:2], "rotation": 0.02},
    "spatial_closure_map": {**SOLID, "positions": PLACE, "rotations": TURN},
    "spatial_facets": {**SOLID, "rotation": TURN, "wrenches": WEIGHT_6, **WINDOW_6},
    "spatial_feasibility_map": {
        **SOLID,
        "positions": PLACE,
        "rotations": TURN,
        **WINDOW_6,
        "task": WEIGHT_6,
        "length": 1.0,
    },
    "spatial_lengths": AT,
    "spatial_mass_matrix": {"mass": 5.0, "inertia": np.eye(3), "centre": CENTRE, "rotation": TURN},
    "spatial_stiffness": {**AT, **TENSIONS_6, "weight": FALL, "centre": CENTRE, **WHEELS},
    "spatial_structure_derivatives": {**AT, **WHEELS},
    "spatial_structure_matrix": AT,
    "spatial_vectors": AT,
    "spatial_weight_derivative": {"weight": FALL, "centre": CENTRE, "rotation": TURN},
    "tension_factor": {"structure": STRUCTURE_6},
    "tension_factor_grid": {**GRID, "out": np.empty((1, 2))},
    "tension_factor_slope": {"structure": STRUCTURE},
    "tension_polygon": {"structure": STRUCTURE_6, "wrench": WEIGHT_6, **WINDOW_6},
    "track_planar": {"lengths": LENGTHS, **FLAT, "start": POSE, "tolerance": 1e-3, **WHEELS_2},
    "track_spatial": {"lengths": LENGTHS_6, **AT, "tolerance": 1e-3, **WHEELS},
    "wrench_closure": {"structure": STRUCTURE_6},
    "wrench_feasible": {"structure": STRUCTURE, **WINDOW, "task": WEIGHT, "length": 1.0},
}

OTHERS = {
    "LockedPlatform.planar": (
        cable.LockedPlatform.planar,
        {**FLAT, "unstressed": LENGTHS, "weight": DOWN, "axial_stiffness": 1e5, "centre": [0.1, 0.0], "moment": 1.0}
        | {**WHEELS_2, "gyration": 0.5},
    ),
    "LockedPlatform.spatial": (
        cable.LockedPlatform.spatial,
        {**SOLID, "unstressed": LENGTHS_6, "weight": FALL, "centre": CENTRE, "forces": [FALL], "points": [CENTRE]},
    ),
    "Surroundings.of": (
        cable.Surroundings.of,
        {**SOLID, "rotation": TURN, "stays": SURROUNDINGS.stays, "radii": 0.05, "own": -1},
    ),
    "TaskWrenches.point": (cable.TaskWrenches.point, {"wrench": WEIGHT}),
    "TaskWrenches.box": (cable.TaskWrenches.box, {"low": -np.ones(3), "high": np.ones(3)}),
    "TaskWrenches.polytope": (cable.TaskWrenches.polytope, {"vertices": np.eye(3)}),
    "TaskWrenches.shifted": (cable.TaskWrenches.point(WEIGHT).shifted, {"wrench": WEIGHT}),
    "CableRobot.planar.lengths": (PLANAR.lengths, {"pose": POSE}),
    "CableRobot.planar.weight": (PLANAR.weight, {"gravity": DOWN, "pose": POSE}),
    "CableRobot.planar.mass_matrix": (PLANAR.mass_matrix, {"pose": POSE}),
    "CableRobot.planar.locked": (PLANAR.locked, {"gravity": DOWN, "pose": POSE}),
    "CableRobot.structure": (SPATIAL.structure, {"pose": PLACE, "rotation": TURN}),
    "CableRobot.weight": (SPATIAL.weight, {"gravity": FALL, "pose": PLACE, "rotation": TURN}),
    "CableRobot.mass_matrix": (SPATIAL.mass_matrix, {"pose": PLACE, "rotation": TURN}),
    "CableRobot.locked": (SPATIAL.locked, {"gravity": FALL, "pose": PLACE, "rotation": TURN}),
}
