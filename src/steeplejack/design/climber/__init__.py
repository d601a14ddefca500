"""Designing the pipe climber: workspaces, transmission over them, and the dimensions that make it best."""

from steeplejack.design.climber.dimensions import (
    ORIGINAL,
    PAPER,
    Chart,
    design_plane,
    design_space,
    normalised,
    performance_chart,
    rating,
    ratio_axis,
)
from steeplejack.design.climber.front import Front, front, least_determinant, non_dominated
from steeplejack.design.climber.optimum import Optimum, optimise
from steeplejack.design.climber.quality import TransmissionMap, transmission_map
from steeplejack.design.climber.ratings import Comparison, Ratings, rate
from steeplejack.design.climber.reach import (
    Places,
    orientations,
    require_poses,
    strips,
    workspace_area,
    workspace_cells,
    workspace_volume,
)
from steeplejack.design.climber.readings import PRESCRIBED, Reading, read, readings
from steeplejack.design.climber.region import Rectangle
from steeplejack.design.climber.study import LostClusterError, Study, claim_study, local_cluster, read_study, run_study
from steeplejack.design.climber.transmission import Moving, local_transmission, output_transmission, transmission_grid

__all__ = [
    "ORIGINAL",
    "PAPER",
    "PRESCRIBED",
    "Chart",
    "Comparison",
    "Front",
    "LostClusterError",
    "Moving",
    "Optimum",
    "Places",
    "Ratings",
    "Reading",
    "Rectangle",
    "Study",
    "TransmissionMap",
    "claim_study",
    "design_plane",
    "design_space",
    "front",
    "local_cluster",
    "local_transmission",
    "non_dominated",
    "normalised",
    "optimise",
    "orientations",
    "output_transmission",
    "performance_chart",
    "rate",
    "rating",
    "ratio_axis",
    "read",
    "read_study",
    "readings",
    "require_poses",
    "run_study",
    "least_determinant",
    "strips",
    "transmission_grid",
    "transmission_map",
    "workspace_area",
    "workspace_cells",
    "workspace_volume",
]
