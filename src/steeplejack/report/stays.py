"""What a report says stay by stay: does the machine fit, what was seen, what was not and why."""

from __future__ import annotations

import math

import numpy as np

from steeplejack.planning.coverage import Seen
from steeplejack.report.analysis import Analysis
from steeplejack.report.boundary import Driven
from steeplejack.report.html import Markup, badge, bullets, element, folded, join, table
from steeplejack.report.log import Log
from steeplejack.report.notation import between, number
from steeplejack.report.verdict import GOAL
from steeplejack.runtime.recorder import VerdictRecord

WORTH_TELLING = 0.05  # [m] shorter stretches between two drives of a base are within its camera's view


def stays_table(log: Log, analysis: Analysis) -> Markup:
    """A verdict for every stay of the bay, in its order."""
    verdicts = {verdict.stay: verdict for verdict in log.site.verdicts}
    interior = {stay.stay: stay for stay in analysis.seen}
    boundary = {stay.stay: stay for stay in analysis.driven}
    head = ("Stay", "Machine fits", "Verdict", "Covered", "Seen all round", "Stand-off", "Not covered, and why")
    rows = []
    for stay in log.bay.stays:
        fit = _fit(verdicts.get(stay.id))
        if stay.id in interior:
            rows.append((element("b", stay.id, cls="id"), fit, *_interior(log, analysis, interior[stay.id])))
        else:
            rows.append((element("b", stay.id, cls="id"), fit, *_boundary(boundary[stay.id])))
    note = (
        "The outer two stays carry the bases and are out of the platform's reach. The bases' own ring cameras see them "
        "all round where a base drove; they do not count in the share covered."
    )
    return join((table(head, rows, numeric=(3, 4, 5)), element("p", note)))


def _fit(verdict: VerdictRecord | None) -> Markup:
    if verdict is None:
        return badge("not checked", "plain")
    if verdict.fits is None:
        return join((badge("unknown", "warn"), element("p", "assumed: ", ", ".join(verdict.unknown))))
    return badge("fits", "good") if verdict.fits else join((badge("does not", "bad"), bullets(verdict.reasons)))


def _interior(log: Log, analysis: Analysis, stay: Seen) -> tuple[object, ...]:
    share = stay.covered_length / stay.asked_length if stay.asked_length > 0.0 else 0.0
    kind, word = (
        ("good", "covered") if share >= GOAL else ("warn", "partly covered") if share > 0.0 else ("bad", "not covered")
    )
    accuracy = analysis.accuracy
    off = accuracy.stand_off[accuracy.stay == [s.id for s in log.bay.stays].index(stay.stay)]
    span = f"{between(float(off.min()), float(off.max()), 2)} m" if len(off) else "–"
    gaps = [gap for gap in analysis.summary.not_covered if gap.stay == stay.stay]
    return (
        join((badge(word, kind), element("p", f"sector {clock_sector(stay)}", cls="id"))),
        f"{number(stay.covered_length)} of {number(stay.asked_length)} m",
        f"{number(100.0 * float(np.mean(stay.around)))} %",
        span,
        bullets(f"{number(gap.from_m)}–{number(gap.to_m)} m: {gap.why}" for gap in gaps) if gaps else "nothing",
    )


def _boundary(stay: Driven) -> tuple[object, ...]:
    seen, asked = stay.seen_length, stay.asked_length
    word = "seen by the bases" if seen >= GOAL * asked else "partly seen" if seen > 0.0 else "not seen"
    missed = [(low, high) for low, high in stay.missed if high - low >= WORTH_TELLING]
    gaps = [f"{number(low)}–{number(high)} m: no base drove there" for low, high in missed]
    return (
        join((badge(word, "plain"), element("p", "by its bases"))),
        f"{number(seen)} of {number(asked)} m",
        f"{number(100.0 * seen / asked)} %" if asked > 0.0 else "–",
        "–",
        bullets(gaps) if gaps else "nothing",
    )


def clock_sector(stay: Seen) -> str:
    """The sector looked at, in hours and minutes of the clock, halfway along the stretch."""
    facing = float(stay.facing[len(stay.facing) // 2])
    return f"{_clock(facing - stay.half_sector)} to {_clock(facing + stay.half_sector)}"


def _clock(angle: float) -> str:
    whole = round(angle * 360.0 / math.pi) % 720
    return f"{whole // 60 or 12}:{whole % 60:02d}"


def other_stays(log: Log) -> Markup:
    """Whether the machine fits the rest of the worksite's stays."""
    here = {stay.id for stay in log.bay.stays}
    others = [verdict for verdict in log.site.verdicts if verdict.stay not in here]
    if not others:
        return Markup()
    counts = {
        word: sum(v.fits is value for v in others)
        for word, value in (("fit", True), ("do not", False), ("are undecided", None))
    }
    summary = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    rows = [
        (
            v.stay,
            "does not fit" if v.fits is False else "unknown",
            "; ".join((*v.reasons, *(f"{u} unknown" for u in v.unknown))),
        )
        for v in others
        if v.fits is not True
    ]
    parts = [
        element(
            "p",
            f"Of the worksite's other stays {summary}, by the stays' data alone.",
        )
    ]
    if rows:
        parts.append(folded("Stays that do not fit or are undecided", table(("Stay", "", "Why"), rows, cls="dense")))
    return join(parts)
