"""The stance chart of a bay: what it says of itself, and that its equilibria are those of a mission."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from steeplejack.design.charts import stance_chart_figure
from steeplejack.design.stances import ChartRules, shares, stance_chart
from steeplejack.errors import InputError
from steeplejack.planning import Rules, Scene
from steeplejack.planning.certificate import hold
from steeplejack.robots.squad import Bay, Squad, load_squad
from steeplejack.robots.squad.anchorage import facing
from steeplejack.worksite import Bridge, load_worksite

pytestmark = pytest.mark.long

RULES = ChartRules(spacing=12.0, levels=2, driving=False)


@pytest.fixture(scope="module")
def bridge() -> Bridge:
    bridge = load_worksite("ecs620-like")
    assert isinstance(bridge, Bridge)
    return bridge


@pytest.fixture(scope="module")
def squad() -> Squad:
    return load_squad()


@pytest.fixture(scope="module")
def chords(bridge: Bridge, squad: Squad) -> xr.Dataset:
    done: list[float] = []
    rules = replace(RULES, spacing=4.0, driving=True)
    chart = stance_chart(bridge, squad, rules, fans=["T1L-main"], bay=(5, 9), progress=done.append)
    assert max(done) == 1.0
    return chart


def test_the_free_stance_holds_nearly_all_and_a_fixed_one_a_third_at_most(chords: xr.Dataset) -> None:
    """Point-mass estimate on chords, 30 kg, bay 5:9: 90-97 % of the stay length against at most 36 % (squad.md)."""
    found = shares(chords)
    assert 0.90 < float(found["free"][0]) < 0.97
    assert 0.15 < float(found["fixed"][0]) < 0.36
    assert float(found["every_phase"]) > 0.90
    assert float(found["fixed_every_phase"]) <= float(found["fixed"].min())


def test_a_driving_base_never_helps(chords: xr.Dataset) -> None:
    fixed = chords["fixed_margin"].to_numpy()
    assert np.all((fixed[:, 1:] <= fixed[:, :1] + 1e-9) | np.isnan(fixed[:, 1:]))


def test_a_longer_reach_and_less_payload_never_hold_less(bridge: Bridge, squad: Squad) -> None:
    held = {
        (within, mass): float(
            shares(
                stance_chart(bridge, squad, replace(RULES, within=within, mass=mass), fans=["T1L-main"], bay=(5, 9))
            )["free"][0]
        )
        for within, mass in ((10.0, 30.0), (30.0, 30.0), (30.0, 17.7))
    }
    assert held[10.0, 30.0] < held[30.0, 30.0] <= held[30.0, 17.7]


def test_stances_in_space_are_certified_by_the_planner_too(bridge: Bridge, squad: Squad) -> None:
    """What the chart calls held, `hold` of a mission calls good: same stays, limits less reserve, checks.

    But for places where the platform hangs turned away from the stays: there the tensions that `hold` stays near to
    need not have an equilibrium of their own.
    """
    rules = replace(RULES, mass=squad.platform.mass, tension=(20.0, 250.0), reserve=0.1, spacing=16.0)
    chart = stance_chart(bridge, squad, rules, "space", ["T1L-main"], (5, 9))
    bay = Bay.of(bridge.fan("T1L-main"), 5, 9, "under", squad)
    scene = Scene.of(bay, squad, Rules(tension=(20.0, 250.0)), np.array(bridge.gravity))
    compared = 0
    for row, k in enumerate(bay.interior):
        for j in np.flatnonzero(chart["margin"].to_numpy()[row, 0] >= 0.0):
            one = chart.isel(stay=row, phase=0, s=j)
            off, s = float(one["stand_off"]) + bay.radius(k), float(one["s"])
            stance = one["stance"].to_numpy()
            target = bay.place(float(k), s, off)
            anchors, pull = scene.anchors(stance, facing(bay, stance[None], target)[0])
            held = hold(scene, anchors, pull, np.array([[float(k), s, off]]))
            if np.trace(held.rotation[0] @ bay.frame(float(k), s).T) < 1.0:  # by more than a right angle
                continue
            assert held.quality[0, 0] >= -1e-3  # tabulated stays against the stays themselves [N]
            assert held.good[0] or held.quality[0, 1] <= 0.0 or held.quality[0, 5] < 0.2
            compared += 1
    assert compared > 15
    figure = stance_chart_figure(chart)
    assert len(figure.axes) == 3


def test_bad_charts_are_refused(bridge: Bridge, squad: Squad) -> None:
    with pytest.raises(InputError):
        stance_chart(bridge, squad, RULES, bay=(5, 6))
    with pytest.raises(InputError):
        ChartRules(mass=0.0)
    with pytest.raises(InputError):
        ChartRules(width=2)
