"""Stances: where the four bases should stand so that the platform is held well, at a place and along every stay."""

from steeplejack.design.stances.chart import PHASES, shares, stance_chart
from steeplejack.design.stances.ground import Ground, on_bay, straight
from steeplejack.design.stances.rules import ChartRules
from steeplejack.design.stances.stance import BestStance, Objective, Statics, choose_stance

__all__ = [
    "PHASES",
    "BestStance",
    "ChartRules",
    "Ground",
    "Objective",
    "Statics",
    "choose_stance",
    "on_bay",
    "shares",
    "stance_chart",
    "straight",
]
