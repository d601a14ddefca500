"""Limbs and linkages: screw systems, loop closure, mobility."""

from steeplejack.mechanics.limb.linkage import Joint, Linkage
from steeplejack.mechanics.limb.linkage_file import LINKAGES, load_linkage
from steeplejack.mechanics.limb.mobility import Kutzbach, LimbReport, Mobility, mobility
from steeplejack.mechanics.limb.screws import (
    couple,
    force,
    helical,
    pitch_of_twist,
    prismatic,
    reciprocal_product,
    revolute,
    transform_twists,
    transform_wrenches,
)
from steeplejack.mechanics.limb.systems import Gauge, joined, met, order, reciprocal, same

__all__ = [
    "LINKAGES",
    "Gauge",
    "Joint",
    "Kutzbach",
    "LimbReport",
    "Linkage",
    "Mobility",
    "couple",
    "force",
    "helical",
    "joined",
    "load_linkage",
    "met",
    "mobility",
    "order",
    "pitch_of_twist",
    "prismatic",
    "reciprocal",
    "reciprocal_product",
    "revolute",
    "same",
    "transform_twists",
    "transform_wrenches",
]
