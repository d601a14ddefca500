"""The report of a climb: one self-contained HTML page."""

from __future__ import annotations

import math
from base64 import b64encode
from pathlib import Path

from steeplejack.report.climb.analysis import ClimbAnalysis, ClimbSummary, Least, summarise
from steeplejack.report.climb.figures import loads_figure, mechanism_figure, progress_figure
from steeplejack.report.climb.log import ClimbLog, read_climb
from steeplejack.report.html import Markup, document, element, figure, folded, section, table, terms
from steeplejack.report.notation import clock, number
from steeplejack.runtime.recorder import Picture

STRIP = (
    ".strip { display: grid; grid-template-columns: repeat(4, 1fr); gap: .6rem; }"
    ".strip figure { margin: 0; } .strip img { display: block; width: 100%; border-radius: 3px; }"
    ".film { margin: 0 0 1rem; } .film img { display: block; border-radius: 3px; }"
)

DOING = {"move": "while it moves the robot", "close": "while the other one closes", "open": "while the other one opens",
         "shift the load": "while the load shifts", "close both": "while both close after a slip"}  # fmt: skip


def write_climb_report(log_path: Path, out_path: Path) -> ClimbSummary:
    """Write the report of a climb.

    Args:
        log_path: The run's MCAP log; one that breaks off is reported up to there.
        out_path: HTML file to write.

    Returns:
        The climb in figures.

    Raises:
        InputError: The log cannot be used; nothing is written.
    """
    log = read_climb(log_path)
    analysis = summarise(log)
    out_path.write_text(climb_page(log, analysis), encoding="utf-8")
    return analysis.summary


def climb_page(log: ClimbLog, analysis: ClimbAnalysis) -> str:
    """The whole page."""
    title = f"Climb of {log.run.name}"
    body = element(
        "body",
        element("h1", title),
        element("p", f"{log.run.description} · {log.robot.name} · run in simulation", cls="kicker"),
        _headline(log),
        _tiles(analysis),
        _asked(log),
        _strip(log),
        _way(log, analysis),
        _limits(log, analysis),
        _grips(log),
        _happened(log),
        _plan(log),
        _sources(log),
    )
    return document(title, body, STRIP)


def _headline(log: ClimbLog) -> Markup:
    """How it went."""
    end = log.end
    if end is None:
        kind, title, rest = "bad", "The log breaks off before the climb's end.", "What follows ends there."
    elif end.completed and not end.slips and not end.collisions:
        kind, title, rest = "good", "Climbed to the goal.", "Nothing slipped and nothing was touched."
    elif end.completed:
        kind, title = "warn", "Climbed to the goal."
        rest = f"Slips: {end.slips}, gripped again {end.regrips} times; touched: {end.collisions}."
    elif end.why:
        kind, title = "bad", f"The climb ended early: {end.why}."
        rest = "The robot hangs with both grippers closed." if end.safe else "The robot was not at rest at the end."
    else:
        kind, title, rest = "warn", "Climbed as far as the plan goes, short of the goal.", log.plan.blocked or ""
    return element("div", element("strong", title), element("p", rest), cls=f"verdict {kind}")


def _tiles(analysis: ClimbAnalysis) -> Markup:
    """The key figures."""
    summary = analysis.summary
    away, turned = analysis.largest_error
    moving, least = analysis.least_moving, analysis.least
    otherwise = "" if least is None or least == moving else f"; {number(least.margin, 2)} {_where(least)}"
    steps = f"in {summary.steps} step{'' if summary.steps == 1 else 's'}"
    way = number(abs(1e3 * summary.distance_m), 0)
    back = summary.distance_m < 0.0 and way != "0"
    bound = f"{number(1e3 * analysis.bound, 2)} mm/s by stroke, speed, grips"
    missed = "no gripper closed" if math.isnan(turned) else f"and {number(math.degrees(turned), 2)}°, at most"
    cells = (
        ("slid back", way, "mm", "nothing climbed") if back else ("climbed", way, "mm", steps),
        ("time", number(summary.duration_s), "s", f"{number(summary.mean_speed_mm_s, 2)} mm/s on average"),
        ("share of the bound", number(_share(analysis), 0), "%", bound),
        ("energy", number(analysis.energy, 1), "J", "put in by cylinders and servo"),
        ("largest force", number(summary.max_actuator_force_n), "N", "of a cylinder"),
        ("least friction left", number(moving.margin if moving else math.nan, 2), "",
         (_where(moving) if moving else "nothing moved") + otherwise),
        ("least transmission", number(summary.min_transmission, 2), "", "local index, along the climb"),
        ("pose error at gripping", number(1e3 * away, 2), "mm", missed),
    )  # fmt: skip
    return element(
        "div",
        *(
            element(
                "div",
                element("span", name, cls="name"),
                element("b", value, element("small", f" {unit}" if unit else "")),
                element("span", note, cls="note"),
                cls="tile",
            )
            for name, value, unit, note in cells
        ),
        cls="tiles",
    )


def _where(least: Least) -> str:
    return f"{DOING.get(least.act, least.act)}, {('lower', 'upper')[least.gripper]} gripper, {clock(least.time)}"


def _share(analysis: ClimbAnalysis) -> float:
    return 0.1 * analysis.summary.mean_speed_mm_s / analysis.bound


def _asked(log: ClimbLog) -> Markup:
    (lower, upper), planned = log.run.friction, log.robot.gripper.friction
    x, y, z = log.run.gravity
    friction = f"{lower:g}" if lower == upper else f"{lower:g} lower gripper, {upper:g} upper gripper"
    friction = friction if lower == upper == planned else f"{friction} in physics, planned for {planned:g}"
    return section(
        "What was asked",
        terms(
            (
                ("Pipe", log.run.name),
                ("Robot", f"{log.robot.name}, {log.robot.body.mass:g} kg"),
                ("Payload", f"{log.run.payload_kg:g} kg on the upper gripper"),
                ("Friction of the pads", friction),
                ("Gravity", f"{x:g}, {y:g}, {z:g} m/s²".replace("-", "−")),
                ("Plan", f"{len(log.plan.phases)} phases, {log.plan.duration_s:.1f} s, {log.plan.reached_m:.3f} m"),
                ("Grippers", f"{log.robot.gripper.jaws} jaws, {log.robot.gripper.force:g} N each"),
                ("Sensors", "without errors" if log.run.seed is None else f"with errors, seed {log.run.seed}"),
            )
        ),
    )


def _strip(log: ClimbLog) -> Markup:
    if not log.pictures and log.film is None:
        return section("Film strip", element("p", "The log holds no pictures."))
    caption = "Rings are painted on the pipe every 100 mm; the camera goes along with the robot."
    film = [_picture(log.film, cls="film")] if log.film is not None else []
    strip = [element("div", *(_picture(picture) for picture in log.pictures), cls="strip")] if log.pictures else []
    return section("Film strip", *film, *strip, element("p", caption))


def _picture(picture: Picture, cls: str = "") -> Markup:
    data, kind = b64encode(picture.data).decode(), "webp" if picture.format == "webp" else "jpeg"
    image = Markup(f'<img alt="The robot on the pipe" src="data:image/{kind};base64,{data}">')
    return element("figure", image, element("figcaption", picture.frame_id), cls=cls)


def _way(log: ClimbLog, analysis: ClimbAnalysis) -> Markup:
    caption = (
        "One cylinder stroke out with the lower gripper holding, one back with the upper one. The bound is that of "
        "full strokes along a straight: a stroke over two strokes' time at full speed and four grip times."
    )
    return section("Way and time", figure(Markup(progress_figure(log, analysis)), "Way along the pipe", caption))


def _limits(log: ClimbLog, analysis: ClimbAnalysis) -> Markup:
    loads = (
        "While both grippers hold, the mechanism is over-determined: cylinders give way to what each grip leaves, and "
        "hand the weight over before one opens. Friction left is 1 less the part of its grip that the wrench on a "
        "gripper's pads takes; a closing jaw that pushes the robot straight takes some for a moment."
    )
    inside = "Commanded and achieved pose are those of the upper gripper in the lower one's frame."
    return section(
        "Loads and limits",
        figure(Markup(loads_figure(log, analysis)), "Forces and friction", loads),
        figure(Markup(mechanism_figure(log, analysis)), "Transmission, speeds and tracking", inside),
    )


def _grips(log: ClimbLog) -> Markup:
    rows = [
        (
            clock(one.time_s),
            one.gripper,
            number(one.force_n),
            number(1e3 * one.error_m, 2),
            number(math.degrees(one.error_rad), 2),
            number(1e3 * one.place_error_m, 2),
        )
        for one in log.grips
    ]
    head = ("time", "gripper", "force [N]", "pose [mm]", "pose [deg]", "place on the pipe [mm]")
    return section(
        "Grips",
        element("p", "Every gripper that closed: its force, and by how much pose and place missed the plan."),
        folded(f"{len(rows)} grips", table(head, rows, numeric=(2, 3, 4, 5), cls="dense")),
    )


def _happened(log: ClimbLog) -> Markup:
    rows = [(clock(one.time_s), one.kind, one.text) for one in log.events if one.kind != "act"]
    if not rows:
        return section("Events", element("p", "Nothing but what was planned."))
    return section("Events", table(("time", "kind", "what"), rows, cls="tight"))


def _plan(log: ClimbLog) -> Markup:
    rows = [
        (
            index + 1,
            one.kind,
            one.hold,
            number(one.duration_s, 2),
            f"{one.s_lower_m:.3f}",
            f"{one.s_upper_m:.3f}",
            one.why,
        )
        for index, one in enumerate(log.plan.phases)
    ]
    head = ("", "phase", "holds", "time [s]", "lower at [m]", "upper at [m]", "why")
    return section("Plan", folded(f"{len(rows)} phases", table(head, rows, numeric=(3, 4, 5), cls="dense")))


def _sources(log: ClimbLog) -> Markup:
    build = log.robot.build
    values = {name: getattr(build, name) for name in build.source}
    rows = [(name, f"{value:g}", build.source[name]) for name, value in values.items()]
    return section(
        "Where it comes from",
        terms((("Pipe", log.run.source), ("Software", f"steeplejack {log.run.version}"))),
        folded("What physics assumes of the robot", table(("value", "SI", "source"), rows, numeric=(1,), cls="dense")),
    )
