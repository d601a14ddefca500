"""The top of a report: how it went in one sentence, and the key figures."""

from __future__ import annotations

from steeplejack.report.analysis import Analysis
from steeplejack.report.html import Markup, element, join
from steeplejack.report.limits import limits
from steeplejack.report.log import BREAKS_OFF, Log
from steeplejack.report.notation import between, number
from steeplejack.robots.squad.comparison import differing

GOAL = 0.95  # [1] share of the length asked for from which an inspection counts as whole


def headline(log: Log, analysis: Analysis) -> Markup:
    """The verdict: what was covered, whether the run came to its end, whether the limits held."""
    summary = analysis.summary
    covered = sum(stay.covered_length for stay in analysis.seen)
    asked = sum(stay.asked_length for stay in analysis.seen)
    share = f"{number(covered)} m of {number(asked)} m asked for ({number(100.0 * summary.coverage_fraction)} %)"
    broken = [limit.name for limit in limits(log, analysis) if not limit.held]
    rest = []
    if summary.faults:
        kind, title = "bad", f"The run ended early: {summary.faults[0]}."
        rest.append(f"Until then {share} were seen on the face looked at.")
        if log.complete and not log.accomplished and log.states.stopped.any():
            rest += [f"How the squad stands: {event.text}." for event in log.events if event.kind == "stop"]
    elif broken:
        kind, title = "bad", "The mission was flown to its end, but not every limit held."
        rest.append(f"{share} were seen on the face looked at. Not held: {'; '.join(broken)}.")
    elif summary.coverage_fraction >= GOAL:
        kind, title = "good", f"Inspected: {share}, and every limit held."
        rest.append(f"Seen all round: {number(100.0 * summary.clock_coverage)} %, about what one face can show.")
    else:
        kind, title = "warn", f"Partly inspected: {share}. Every limit held."
    gaps = len(summary.not_covered)
    rest.append(
        "Nothing that was asked for was left out on this face."
        if not gaps
        else f"{gaps} stretch{'es' if gaps > 1 else ''} not covered, each listed below with its reason."
    )
    if not log.complete and BREAKS_OFF not in title:
        rest.append("The log breaks off: this report covers what was recorded up to there.")
    if names := differing(log.squad, log.actual):
        rest.append(f"Physics ran a machine other than the file: {', '.join(names)}.")
    return element("div", element("strong", title), element("p", join(rest, " ")), cls=f"verdict {kind}")


def tiles(log: Log, analysis: Analysis) -> Markup:
    """The key figures."""
    summary = analysis.summary
    covered = sum(stay.covered_length for stay in analysis.seen)
    near, far = log.squad.camera.stand_off
    cells = (
        (
            "covered, faced sector",
            number(100.0 * summary.coverage_fraction),
            "%",
            f"{number(covered)} m of interior stay",
        ),
        ("seen, all round", number(100.0 * summary.clock_coverage), "%", "one face never sees all round"),
        (
            "duration",
            number(summary.duration_s / 60.0),
            "min",
            f"{number(summary.distance_m, 0)} m flown by the platform",
        ),
        (
            "stances",
            str(summary.stances),
            "",
            f"{summary.moves} squad move{'s' if summary.moves != 1 else ''} finished",
        ),
        (
            "largest cable tension",
            number(summary.max_tension_n, 0),
            "N",
            f"limit {log.mission.request.tension_n[1]:g} N",
        ),
        ("least pull margin", number(summary.min_slip_margin, 3), "", "1 − pull / limit; slips below 0"),
        (
            "stand-off",
            between(summary.stand_off_m.min, summary.stand_off_m.max, 2),
            "m",
            f"camera needs {near:.2f}–{far:.2f} m",
        ),
        (
            "tracking, along and across",
            f"{number(summary.error_along_mm.std)} / {number(summary.error_across_mm.std)}",
            "mm",
            f"1 σ; means {number(summary.error_along_mm.mean)} / {number(summary.error_across_mm.mean)} mm",
        ),
    )
    return element("div", *(_tile(*cell) for cell in cells), cls="tiles")


def _tile(name: str, value: str, unit: str, note: str) -> Markup:
    figure = element("b", value, " ", element("small", unit)) if unit else element("b", value)
    return element("div", element("div", name, cls="name"), figure, element("div", note, cls="note"), cls="tile")
