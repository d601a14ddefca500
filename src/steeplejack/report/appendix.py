"""The back of a report: what happened when, what was assumed, and where the figures come from."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from steeplejack.report.html import Markup, badge, bullets, element, folded, section, table, terms
from steeplejack.report.log import Log
from steeplejack.report.notation import clock
from steeplejack.robots.sourced import Sourced

ESTIMATE = "estimate"


def events_section(log: Log) -> Markup:
    """Breaches, stops and notes; the phases of every leg on request."""
    told = [event for event in log.events if event.kind != "phase"]
    kinds = {"breach": "bad", "stop": "warn"}
    rows = [(clock(event.time_s), badge(event.kind, kinds.get(event.kind, "plain")), event.text) for event in told]
    phases = [(clock(event.time_s), event.text) for event in log.events if event.kind == "phase"]
    return section(
        "Events and faults",
        table(("Time", "", "What"), rows, cls="tight") if rows else element("p", "None."),
        folded(f"Phases of the run: {len(phases)}", table(("Time", "Phase"), phases, cls="dense tight")),
    )


def assumptions_section(log: Log) -> Markup:
    """Data of the bridge that were assumed, and every parameter of the machine that is an estimate."""
    notes = {f"{zone.kind}: {zone.note}" for stay in log.bay.stays for zone in stay.intervals if zone.note}
    bridge = [*log.mission.assumed, *sorted(notes), f"source of the stays: {log.site.source}"]
    rows = list(_estimates(log))
    return section(
        "Assumptions and estimates",
        element("h3", "The bridge"),
        bullets(bridge),
        element("h3", "The machine"),
        element(
            "p",
            f"{len(rows)} parameters of {log.squad.name} have no published value and are estimates. SI units, radians.",
        ),
        table(("Parameter", "Value", "Why this value"), rows, cls="dense"),
    )


def _estimates(log: Log) -> Iterator[tuple[object, str, str]]:
    for part in log.squad.__struct_fields__:
        values = getattr(log.squad, part)
        if not isinstance(values, Sourced):
            continue
        for name, source in values.source.items():
            if source.startswith(ESTIMATE):
                why = source.removeprefix(ESTIMATE).lstrip(": ")
                yield element("code", f"{part}.{name}"), _value(getattr(values, name)), why or "no source found"


def _value(value: object) -> str:
    return msgspec.json.encode(value).decode().strip("[]").replace(",", ", ")


def provenance_section(log: Log) -> Markup:
    """Which mission, which seed, which software, which log."""
    states = log.states
    whole = "complete" if log.complete else "breaks off: the run was killed or the file damaged"
    return section(
        "Provenance",
        terms(
            (
                ("Mission (SHA-256)", element("code", log.mission.sha256)),
                ("Log", element("code", log.path.name)),
                ("Log file", whole),
                ("Recorded", f"{len(states.time)} samples over {states.time[-1]:.1f} s, {len(log.events)} events"),
                ("Software", f"steeplejack {log.seed.version}"),
                ("Seed", log.seed.seed),
                ("Robot", log.squad.name),
                ("Worksite", log.site.name),
            )
        ),
        element("p", "This page was made from the log alone."),
    )
