"""Cable mechanics: structure, closure, bounded tensions, forward kinematics and maps of cable-driven platforms."""

from steeplejack.mechanics.cable.closure import in_wrench_closure, is_singular, null_vector, tension_factor
from steeplejack.mechanics.cable.distribution import (
    METHODS,
    Method,
    Status,
    TensionDistribution,
    certificate_gap,
    distribute,
)
from steeplejack.mechanics.cable.forward import ForwardKinematics, forward_kinematics, loaded_lengths, pose_rates
from steeplejack.mechanics.cable.grid import best_node, grid_nodes, margin_grid, tension_factor_grid
from steeplejack.mechanics.cable.structure import (
    planar_arms,
    planar_lengths,
    planar_structure_matrix,
    planar_vectors,
    spatial_lengths,
    spatial_structure_matrix,
    spatial_vectors,
)

__all__ = [
    "METHODS",
    "ForwardKinematics",
    "Method",
    "Status",
    "TensionDistribution",
    "best_node",
    "certificate_gap",
    "distribute",
    "forward_kinematics",
    "grid_nodes",
    "in_wrench_closure",
    "is_singular",
    "loaded_lengths",
    "margin_grid",
    "null_vector",
    "planar_arms",
    "planar_lengths",
    "planar_structure_matrix",
    "planar_vectors",
    "pose_rates",
    "spatial_lengths",
    "spatial_structure_matrix",
    "spatial_vectors",
    "tension_factor",
    "tension_factor_grid",
]
