"""07 Where the bases should stand: the best stance at one place, and a chart along the stays of a bay."""

from steeplejack.design.stances import ChartRules, Statics, choose_stance, on_bay, shares, stance_chart
from steeplejack.robots.squad import Bay, load_squad
from steeplejack.worksite import Bridge, load_worksite

bridge, squad = load_worksite("ecs620-like"), load_squad()
assert isinstance(bridge, Bridge)
bay = Bay.of(bridge.fan("T1L-main"), 5, 9, "under", squad)
place, now = bay.place(2.0, 60.0, 0.7), [55.0, 55.0, 75.0, 75.0]
weight, arms = [0.0, 0.0, -30.0 * 9.81], [[0.0, 0.0, 0.0]] * 4
for slack in (0.0, 0.05):
    best = choose_stance(
        on_bay(bay, squad, (10.0, 400.0)), place, weight, now, 30.0, Statics.SPACE, arms=arms, slack=slack
    )
    print(f"slip margin {best.worth:.3f}, {best.driving:.1f} m of driving, bases at {best.s.round(1)} m")

chart = stance_chart(bridge, squad, ChartRules(spacing=6.0, driving=False), "chords", ["T1L-main"], (5, 9))
held = shares(chart)
free, fixed = float(held.free[0]), float(held.fixed[0])
print(f"30 kg held on {free:.0%} of the bay's stay length; from one stance a cell on {fixed:.0%}")
