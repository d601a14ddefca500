"""What is climbed: stay cables in fans on bridges, and the planar example."""

from steeplejack.worksite.bridge import Bridge, Fan, lean, under_normal
from steeplejack.worksite.builtin import BUILT_IN, Listing, list_worksites, load_worksite
from steeplejack.worksite.catenary import Catenary, hang
from steeplejack.worksite.chord import Chord
from steeplejack.worksite.planar import PlanarSite
from steeplejack.worksite.schedule import read_schedule
from steeplejack.worksite.stay import Interval, Stay

__all__ = [
    "BUILT_IN",
    "Bridge",
    "Catenary",
    "Chord",
    "Fan",
    "Interval",
    "Listing",
    "PlanarSite",
    "Stay",
    "hang",
    "lean",
    "list_worksites",
    "load_worksite",
    "read_schedule",
    "under_normal",
]
