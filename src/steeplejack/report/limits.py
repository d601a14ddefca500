"""Whether every limit held: the worst of the whole run beside each, and when it was."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from steeplejack.planning.certificate import Rules
from steeplejack.report.analysis import Analysis
from steeplejack.report.html import Markup, badge, section, table, text
from steeplejack.report.log import Log
from steeplejack.report.notation import between, minutes, number

Array = NDArray[np.float64]


class Limit(NamedTuple):
    """One limit and how it fared."""

    name: str
    limit: str
    worst: str  # value and time
    held: bool


def limits(log: Log, analysis: Analysis) -> tuple[Limit, ...]:
    """Every limit a report judges, by the log alone."""
    rows: tuple[Callable[[Log, Analysis], Limit], ...] = (_tight, _slack, _pull, _twist, _cables, _body, _stand_off)
    return tuple(row(log, analysis) for row in rows)


def _at(log: Log, sample: int) -> str:
    return f"at {minutes(log.states.time[sample])}"


def _tight(log: Log, _analysis: Analysis) -> Limit:
    largest, high = log.states.max_tension, log.mission.request.tension_n[1]
    top = int(np.argmax(largest))
    worst = f"{number(largest[top])} N {_at(log, top)}"
    return Limit("largest cable tension", f"at most {high:g} N", worst, bool(largest[top] <= high))


def _slack(log: Log, _analysis: Analysis) -> Limit:
    least, low = log.states.min_tension, log.mission.request.tension_n[0]
    bottom = int(np.argmin(least))
    worst = f"{number(least[bottom])} N {_at(log, bottom)}"
    return Limit("no slack cable", f"above 0 N (planned from {low:g} N)", worst, bool(least[bottom] > 0.0))


def _pull(log: Log, _analysis: Analysis) -> Limit:
    margin = log.states.slip_margin
    sample, base = (int(i) for i in np.unravel_index(int(np.argmin(margin)), margin.shape))
    worst = f"{number(margin[sample, base], 3)}, {_base(log, sample, base)}, {_at(log, sample)}"
    return Limit("pull along the stays", "margin above 0", worst, bool(margin[sample, base] > 0.0))


def _twist(log: Log, analysis: Analysis) -> Limit:
    twist, most = analysis.flown.twist, log.squad.base.twist_torque
    sample, base = (int(i) for i in np.unravel_index(int(np.argmax(twist)), twist.shape))
    worst = f"{number(twist[sample, base])} N m, {_base(log, sample, base)}, {_at(log, sample)}"
    return Limit("twist about the stays", f"at most {most:g} N m", worst, bool(twist[sample, base] <= most))


def _base(log: Log, sample: int, base: int) -> str:
    return f"base {base + 1} {'driving' if log.states.base_moving[sample] == base + 1 else 'gripped'}"


def _cables(log: Log, analysis: Analysis) -> Limit:
    return _gap(log, "driving cables clear of the stays", analysis.flown.cable_gap, Rules.cable_clearance)


def _body(log: Log, analysis: Analysis) -> Limit:
    return _gap(log, "platform's centre clear of the stays", analysis.flown.body_gap, log.squad.platform.clearance)


def _gap(log: Log, name: str, gap: Array, least: float) -> Limit:
    closest = int(np.argmin(gap))
    worst = f"{number(gap[closest], 2)} m {_at(log, closest)}"
    return Limit(name, f"at least {least:.2f} m from their surface", worst, bool(gap[closest] >= least))


def _stand_off(log: Log, analysis: Analysis) -> Limit:
    (near, far), accuracy = log.squad.camera.stand_off, analysis.accuracy
    limit = f"{near:.2f}–{far:.2f} m from the surface"
    if not len(accuracy.sample):
        return Limit("stand-off while inspecting", limit, "nothing was inspected", True)
    off = accuracy.stand_off
    room = np.minimum(off - near, far - off)
    worst = int(np.argmin(room))
    span = f"{between(float(off.min()), float(off.max()), 2)} m, nearest a limit"
    words = f"{span} {_at(log, int(accuracy.sample[worst]))}"
    return Limit("stand-off while inspecting", limit, words, bool(room[worst] >= 0.0))


def limits_section(log: Log, analysis: Analysis, drawing: Markup) -> Markup:
    """Whether the limits held, and the loads over time."""
    rows = [
        (row.name, row.limit, row.worst, badge("held", "good") if row.held else badge("not held", "bad"))
        for row in limits(log, analysis)
    ]
    return section("Loads and limits", table(("What", "Limit", "Worst of the whole run", ""), rows), text(drawing))
