"""The mission report: one self-contained HTML page, made from the log alone."""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path

import numpy as np

from steeplejack.report import figures
from steeplejack.report.analysis import ACTIVITIES, Analysis, Summary, analyse
from steeplejack.report.appendix import assumptions_section, events_section, provenance_section
from steeplejack.report.figures.style import ACTIVITY
from steeplejack.report.html import Markup, document, element, figure, section, terms
from steeplejack.report.limits import limits_section
from steeplejack.report.log import Log, read_log
from steeplejack.report.notation import minutes
from steeplejack.report.stays import other_stays, stays_table
from steeplejack.report.tracking import tracking_section
from steeplejack.report.verdict import headline, tiles
from steeplejack.runtime.recorder import Picture

FORMATS = ("jpeg", "png", "webp")


def write_report(log_path: Path, out_path: Path) -> Summary:
    """Write the report of a run.

    Args:
        log_path: The run's MCAP log; one that breaks off is reported up to there.
        out_path: HTML file to write.

    Returns:
        The run in figures.

    Raises:
        InputError: The log cannot be used; nothing is written.
    """
    log = read_log(log_path)
    analysis = analyse(log)
    out_path.write_text(page(log, analysis), encoding="utf-8")
    return analysis.summary


def page(log: Log, analysis: Analysis) -> str:
    """The whole page."""
    names = [stay.id for stay in log.bay.stays[1:-1]]
    title = f"Inspection of {names[0]} to {names[-1]}" if len(names) > 1 else f"Inspection of {names[0]}"
    request = log.mission.request
    kicker = f"{log.site.name}, fan {request.fan}, {request.face} face · {log.squad.name} · run in simulation"
    body = element(
        "body",
        element("h1", title),
        element("p", kicker, cls="kicker"),
        headline(log, analysis),
        tiles(log, analysis),
        _request(log),
        section("Stay by stay", stays_table(log, analysis), other_stays(log)),
        _coverage(analysis),
        _views(log, analysis),
        limits_section(log, analysis, _loads(log, analysis)),
        _tracking(log, analysis),
        _time(analysis),
        _pictures(log),
        events_section(log),
        assumptions_section(log),
        provenance_section(log),
    )
    return document(f"{title}, {log.site.name}", body)


def _request(log: Log) -> Markup:
    request, camera = log.mission.request, log.squad.camera
    low, high = request.tension_n
    return section(
        "What was asked",
        terms(
            (
                ("Inspect", ", ".join(stay.id for stay in log.bay.stays[1:-1])),
                ("Bases ride on", f"{log.mission.boundary[0]} and {log.mission.boundary[1]}"),
                ("Stretch", f"{request.from_m:.1f}–{request.to_m:.1f} m from the lower anchorages"),
                ("Face of the fan", request.face),
                ("Payload", f"{request.payload_kg:g} kg on the {log.squad.platform.mass:g} kg platform"),
                ("Cable tension", f"{low:g}–{high:g} N"),
                ("Reserve in the plan", f"{100.0 * log.mission.reserve:g} % of every tension, pull and twist limit"),
                (
                    "Faced sector",
                    f"{np.degrees(camera.faced_half_sector):.0f}° either side of the face's normal",
                ),
            )
        ),
    )


def _coverage(analysis: Analysis) -> Markup:
    caption = (
        "What the camera's footprint passed over, from the flown trajectory alone. A place counts as covered where the "
        "whole faced sector was seen. The far side of a stay needs a second flight along the other face."
    )
    drawing = Markup(figures.coverage_figure(analysis))
    return section("Coverage by metre and clock", figure(drawing, "Coverage of each inspected stay", caption))


def _views(log: Log, analysis: Analysis) -> Markup:
    side = (
        "The bay in its own plane. Bases ride on the two outer stays; circles show where they stood while the platform "
        "inspected from stance 1, 2, …, thin lines the driving cables halfway through each stance."
    )
    across = (
        "Looking up the stays. Above, the whole bay at true scale. Below, each inspected stay close by: poses of all "
        "flights along it (dots), the platform's outline and its camera's cone at one of them, and in blue where the "
        "camera is within its range. The figures above each are stand-offs from the stay's surface."
    )
    return section(
        "Where the squad was",
        figure(Markup(figures.side_figure(log)), "Side view of the fan", side),
        figure(Markup(figures.section_figure(log, analysis)), "Section across the fan", across),
    )


def _loads(log: Log, analysis: Analysis) -> Markup:
    caption = (
        "Pull along a stay is what slides a base: the limit is lower while its palms are open and it drives. The "
        "tension factor tells how evenly four cables can be braced against each other in their plane; at 0 they "
        "cannot, and it is the platform's weight that keeps them taut."
    )
    return figure(Markup(figures.loads_figure(log, analysis)), "Tensions, pull margins and tension factor", caption)


def _tracking(log: Log, analysis: Analysis) -> Markup:
    accuracy = analysis.accuracy
    path = figure(
        Markup(figures.path_figure(log)), "Desired and actual trajectory", "In the form of Fig. 18 of the paper."
    )
    if not len(accuracy.sample):
        return section("Accuracy", element("p", "The run ended before anything was inspected."), path)
    caption = (
        "Relative errors over the distance inspected and how they are spread, in the form of Fig. 19 of the paper. "
        "Band and whiskers are one standard deviation about the mean."
    )
    errors = figure(Markup(figures.accuracy_figure(log, accuracy)), "Errors relative to the true anchors", caption)
    return tracking_section(log, accuracy, path, errors)


def _time(analysis: Analysis) -> Markup:
    spent = analysis.time_by_activity
    total = max(float(spent.sum()), 1e-9)
    used = [i for i in range(len(ACTIVITIES)) if spent[i] > 0.0]
    bar = (Markup(f'<i style="flex:{spent[i]:.2f};background:{ACTIVITY[i]}"></i>') for i in used)
    key = (
        element(
            "li",
            Markup(f'<i style="background:{ACTIVITY[i]}"></i>'),
            f"{ACTIVITIES[i]}: {minutes(spent[i])}, {100 * spent[i] / total:.0f} %",
        )
        for i in used
    )
    return section("How the time was spent", element("div", *bar, cls="bar"), element("ul", *key, cls="key"))


def _pictures(log: Log) -> Markup:
    shown = [picture for picture in log.pictures if picture.format in FORMATS]
    if not shown:
        return section("Pictures", element("p", "The log holds no pictures."))
    return section("Pictures", element("div", *(_picture(picture) for picture in shown), cls="pictures"))


def _picture(picture: Picture) -> Markup:
    data = b64encode(picture.data).decode()
    image = Markup(f'<img alt="" src="data:image/{picture.format};base64,{data}">')
    return element("figure", image, element("figcaption", picture.frame_id))
