"""Cable mechanics: structure, closure, bounded tensions, forward kinematics and maps of cable-driven platforms."""

from steeplejack.mechanics.cable.degeneracy import is_singular, rank
from steeplejack.mechanics.cable.measure.derivatives import (
    Gradient,
    StructureDerivatives,
    gradient,
    planar_structure_derivatives,
    planar_weight_derivative,
    spatial_structure_derivatives,
    spatial_weight_derivative,
)
from steeplejack.mechanics.cable.measure.quality import condition_number, dexterity, normalised_structure
from steeplejack.mechanics.cable.measure.slopes import Slope, capacity_margin_slope, margin_slope, tension_factor_slope
from steeplejack.mechanics.cable.pose.every_pose import EveryPose, every_planar_pose, every_spatial_pose
from steeplejack.mechanics.cable.pose.forward import ForwardKinematics, forward_kinematics, loaded_lengths, pose_rates
from steeplejack.mechanics.cable.pose.tracking import (
    PlanarTrack,
    SpatialTrack,
    TrackingStatus,
    track_planar,
    track_spatial,
)
from steeplejack.mechanics.cable.pulleys import pulley_runs
from steeplejack.mechanics.cable.region.boundary import Rays, certified_rays, closure_rays
from steeplejack.mechanics.cable.region.certified import CertifiedRegion, Label, certify, closure_box
from steeplejack.mechanics.cable.region.facets import Facets, planar_facets, spatial_facets
from steeplejack.mechanics.cable.region.grid import best_node, grid_nodes, margin_grid, tension_factor_grid
from steeplejack.mechanics.cable.region.interference import (
    Surroundings,
    box_faces,
    cable_crossings,
    crossing_planes,
    interference_gaps,
    interference_rays,
    interference_region,
    platform_overlap,
)
from steeplejack.mechanics.cable.region.maps import (
    FeasibilityMap,
    planar_closure_map,
    planar_feasibility_map,
    spatial_closure_map,
    spatial_feasibility_map,
)
from steeplejack.mechanics.cable.region.oriented import (
    PoseQuestion,
    certify_orientations,
    certify_poses,
    failing_turn,
    pose_question,
)
from steeplejack.mechanics.cable.rest.equilibrium import Equilibrium, Rest, equilibria, natural_frequencies, settle
from steeplejack.mechanics.cable.rest.locked import LockedPlatform
from steeplejack.mechanics.cable.rest.lost import LostCable, LostCableMap, locked_at, lost_cable, lost_cable_map
from steeplejack.mechanics.cable.rest.modes import Modes, natural_modes, planar_mass_matrix, spatial_mass_matrix
from steeplejack.mechanics.cable.rest.stiffness import cable_rates, planar_stiffness, spatial_stiffness
from steeplejack.mechanics.cable.status import (
    ClosureStatus,
    DistributionStatus,
    FeasibilityStatus,
    RankStatus,
    WrenchSetStatus,
)
from steeplejack.mechanics.cable.structure import (
    planar_arms,
    planar_lengths,
    planar_structure_matrix,
    planar_vectors,
    spatial_lengths,
    spatial_structure_matrix,
    spatial_vectors,
)
from steeplejack.mechanics.cable.tension.distribution import TensionDistribution, certificate_gap, distribute
from steeplejack.mechanics.cable.tension.methods import METHODS, Method, MethodRecord
from steeplejack.mechanics.cable.tension.nullspace import NullSpace, null_space
from steeplejack.mechanics.cable.tension.polygon import TensionPolygon, tension_polygon
from steeplejack.mechanics.cable.wrench.closure import (
    Closure,
    in_wrench_closure,
    null_vector,
    tension_factor,
    wrench_closure,
)
from steeplejack.mechanics.cable.wrench.feasibility import (
    Feasibility,
    capacity_margin,
    characteristic_length,
    wrench_feasible,
)
from steeplejack.mechanics.cable.wrench.load import gravity_wrench, inertial_wrench, planar_inertial_wrench
from steeplejack.mechanics.cable.wrench.task import TaskWrenches
from steeplejack.mechanics.cable.wrench.zonotope import WrenchSet, available_wrench_set

__all__ = [
    "METHODS",
    "CertifiedRegion",
    "Closure",
    "ClosureStatus",
    "DistributionStatus",
    "Equilibrium",
    "EveryPose",
    "Facets",
    "Feasibility",
    "FeasibilityMap",
    "FeasibilityStatus",
    "ForwardKinematics",
    "Gradient",
    "Label",
    "LockedPlatform",
    "LostCable",
    "LostCableMap",
    "Method",
    "MethodRecord",
    "Modes",
    "NullSpace",
    "PlanarTrack",
    "PoseQuestion",
    "RankStatus",
    "Rays",
    "Rest",
    "Slope",
    "SpatialTrack",
    "StructureDerivatives",
    "Surroundings",
    "TaskWrenches",
    "TensionDistribution",
    "TensionPolygon",
    "TrackingStatus",
    "WrenchSet",
    "WrenchSetStatus",
    "available_wrench_set",
    "best_node",
    "box_faces",
    "cable_crossings",
    "cable_rates",
    "capacity_margin",
    "capacity_margin_slope",
    "certificate_gap",
    "certified_rays",
    "certify",
    "certify_orientations",
    "certify_poses",
    "characteristic_length",
    "closure_box",
    "closure_rays",
    "condition_number",
    "crossing_planes",
    "dexterity",
    "distribute",
    "equilibria",
    "every_planar_pose",
    "every_spatial_pose",
    "failing_turn",
    "forward_kinematics",
    "gradient",
    "gravity_wrench",
    "grid_nodes",
    "in_wrench_closure",
    "inertial_wrench",
    "interference_gaps",
    "interference_rays",
    "interference_region",
    "is_singular",
    "loaded_lengths",
    "locked_at",
    "lost_cable",
    "lost_cable_map",
    "margin_grid",
    "margin_slope",
    "natural_frequencies",
    "natural_modes",
    "normalised_structure",
    "null_space",
    "null_vector",
    "planar_arms",
    "planar_closure_map",
    "planar_facets",
    "planar_feasibility_map",
    "planar_inertial_wrench",
    "planar_lengths",
    "planar_mass_matrix",
    "planar_stiffness",
    "planar_structure_derivatives",
    "planar_structure_matrix",
    "planar_vectors",
    "planar_weight_derivative",
    "platform_overlap",
    "pose_question",
    "pose_rates",
    "pulley_runs",
    "rank",
    "settle",
    "spatial_closure_map",
    "spatial_facets",
    "spatial_feasibility_map",
    "spatial_lengths",
    "spatial_mass_matrix",
    "spatial_stiffness",
    "spatial_structure_derivatives",
    "spatial_structure_matrix",
    "spatial_vectors",
    "spatial_weight_derivative",
    "tension_factor",
    "tension_factor_grid",
    "tension_factor_slope",
    "tension_polygon",
    "track_planar",
    "track_spatial",
    "wrench_closure",
    "wrench_feasible",
]
