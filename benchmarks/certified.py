"""Certified workspaces and boundaries along rays: what they cost, and the figures of the docs, one thread, one run.

Run ``python benchmarks/certified.py`` for the tables, with ``--json`` for one JSON object, with ``--figures docs`` to
draw the figures of `docs/workspaces.md` too.

- *Regions*: seconds, boxes looked at and gap reached, for wrench closure and for feasibility with tension limits;
  Table III of the CCRobot-S paper (at 50 degrees, and over 44 to 56 degrees), IPAnema 2 and CoGiRo at one orientation.
- *Rays*: microseconds a ray across Table III at 50 degrees, by roots and by certified subdivision, and the area the
  roots integrate to.
- *Orientations*: poses a second of `tension_factor_grid` at one orientation and over a range, which must be the same.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numba
import numpy as np

from steeplejack.mechanics.cable import (
    Label,
    certified_rays,
    certify,
    closure_box,
    closure_rays,
    planar_facets,
    spatial_facets,
    tension_factor_grid,
)

ANCHORS = np.array([[0.0, 0.0], [0.4024, 0.4045], [-0.3522, 0.8966], [-0.6244, 0.6244]])
ATTACHMENTS = np.array([[-0.095, -0.095], [0.095, -0.095], [0.095, 0.095], [-0.095, 0.095]])
PHI = np.deg2rad(50.0)
LOAD = ([0.0, -30.0 * 9.81, 0.0], 10.0, 250.0)

CORNERS = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
IPANEMA_ANCHORS = np.vstack([np.column_stack((CORNERS * [4.0, 3.0], np.full(4, z))) for z in (5.0, 1.0)])
IPANEMA_ATTACHMENTS = np.vstack(
    [np.column_stack((CORNERS * size, np.full(4, z))) for size, z in (([0.65, 0.125], 0.25), ([0.75, 0.1], 0.75))]
)
COGIRO_ANCHORS = np.array(
    [
        [-7.1775, -5.4361, 5.3911], [-7.4594, -5.1504, 5.3999], [-7.3911, 5.1940, 5.3976], [-7.1026, 5.4753, 5.4094],
        [7.2398, 5.3759, 5.4093], [7.5208, 5.0851, 5.4200], [7.4461, -5.2539, 5.3874], [7.1608, -5.5342, 5.3973],
    ]
)  # fmt: skip
COGIRO_ATTACHMENTS = np.array(
    [
        [0.5032, -0.4928, 0.0], [-0.5097, 0.3508, 0.9976], [-0.5032, -0.27, 0.0], [0.4960, 0.3561, 0.9996],
        [-0.5032, 0.4928, 0.0], [0.4998, -0.3404, 0.9991], [0.5021, 0.2750, -0.0007], [-0.5045, -0.3463, 0.9976],
    ]
)  # fmt: skip
COGIRO_LOAD = 91.058 * 9.81 * np.array([0.013, -0.034, 0.0, 0.0, 0.0, -1.0])  # centre of mass at (-0.034, -0.013)


def turned(angle: float) -> np.ndarray:
    """Rotation by one angle about x, then y, then z [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ about_y @ about_x


def questions():
    """Name, question, search box and gap of every row."""
    flat = closure_box(ANCHORS, ATTACHMENTS)
    one, several = np.vstack((flat, [PHI, PHI])), np.vstack((flat, np.deg2rad([44.0, 56.0])))
    closure, held = planar_facets(ANCHORS, ATTACHMENTS), planar_facets(ANCHORS, ATTACHMENTS, *LOAD)
    hall = np.array([[-6.5, 6.5], [-4.5, 4.5], [0.0, 4.0]])
    space = closure_box(IPANEMA_ANCHORS, IPANEMA_ATTACHMENTS)
    ipanema, cogiro = (IPANEMA_ANCHORS, IPANEMA_ATTACHMENTS), (COGIRO_ANCHORS, COGIRO_ATTACHMENTS)
    weight = [0.0, 0.0, 0.0, 0.0, 0.0, -98.1]
    yield "Table III, 50 deg, closure", closure, one, 1e-3
    yield "Table III, 50 deg, 30 kg, 10-250 N", held, one, 1e-3
    yield "Table III, 44-56 deg, closure", closure, several, 0.03
    yield "Table III, 44-56 deg, 30 kg, 10-250 N", held, several, 0.03
    yield "IPAnema 2, tilted, closure", spatial_facets(*ipanema, turned(0.08)), space, 0.03
    yield "IPAnema 2, tilted, 10 kg, 1-200 N", spatial_facets(*ipanema, turned(0.08), weight, 1.0, 200.0), space, 0.1
    yield "CoGiRo, level, 91 kg, 100-5000 N", spatial_facets(*cogiro, turned(0.0), COGIRO_LOAD, 100, 5000), hall, 0.05


def measure_regions() -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for name, facets, box, gap in questions():
        certify(facets, box, gap, 100)
        began = time.perf_counter()
        region = certify(facets, box, gap)
        seconds = time.perf_counter() - began
        rows.append(
            {
                "question": name, "inner": region.inner, "outer": region.outer, "gap": region.gap,
                "reached": region.reached, "evaluations": region.evaluations, "seconds": seconds,
            }
        )  # fmt: skip
    return rows


def scan(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal rays across the anchors' box, at the middles of equal rows."""
    (left, bottom), (right, top) = ANCHORS.min(axis=0), ANCHORS.max(axis=0)
    ys = bottom + (np.arange(count) + 0.5) / count * (top - bottom)
    ends = [np.column_stack((np.full(count, x), ys, np.full(count, PHI))) for x in (left, right)]
    return ends[0], ends[1]


def measure_rays() -> dict[str, float]:
    facets, found = planar_facets(ANCHORS, ATTACHMENTS), {}
    for name, route, count in (("roots", closure_rays, 20_000), ("subdivision", certified_rays, 500)):
        starts, ends = scan(count)
        route(facets, starts[:1], ends[:1])
        began = time.perf_counter()
        rays = route(facets, starts, ends)
        found[f"{name}_us_per_ray"] = (time.perf_counter() - began) / count * 1e6
        box = np.ptp(ANCHORS, axis=0).prod()
        found[f"{name}_area_cm2"] = float(rays.share(Label.INSIDE).mean() * box * 1e4)
    return found


def measure_orientations(side: int = 500, angles: int = 61, rounds: int = 5) -> dict[str, float]:
    (left, bottom), (right, top) = ANCHORS.min(axis=0), ANCHORS.max(axis=0)
    xs, ys = np.linspace(left, right, side), np.linspace(bottom, top, side)
    phis, layers = np.deg2rad(np.linspace(40.0, 60.0, angles)), np.empty((angles, side, side))
    one = many = 0.0
    for _ in range(rounds):
        began = time.perf_counter()
        for _ in range(angles):
            tension_factor_grid(ANCHORS, ATTACHMENTS, PHI, xs, ys, out=layers[0])
        middle = time.perf_counter()
        for phi, layer in zip(phis, layers, strict=True):
            tension_factor_grid(ANCHORS, ATTACHMENTS, phi, xs, ys, out=layer)
        one = max(one, layers.size / (middle - began))
        many = max(many, layers.size / (time.perf_counter() - middle))
    return {"one_orientation_per_second": one, "range_per_second": many}


def draw(folder: Path) -> None:
    """The two figures of the docs."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import PolyCollection

    colours = {Label.INSIDE: "#2f7f5f", Label.OUTSIDE: "#f3f1ec", Label.UNDECIDED: "#d1495b"}
    box = np.vstack((closure_box(ANCHORS, ATTACHMENTS), [PHI, PHI]))
    figure, panels = plt.subplots(1, 2, figsize=(11.0, 5.2), layout="constrained", sharey=True)
    for axes, load, title in zip(panels, ((), LOAD), ("wrench closure", "30 kg within 10-250 N"), strict=True):
        region = certify(planar_facets(ANCHORS, ATTACHMENTS, *load), box, 0.05)
        for label in Label:
            (left, right), (low, high) = 100.0 * np.moveaxis(region.of(label)[:, :2], 0, -1)
            corners = np.stack(
                [np.stack(corner, axis=-1) for corner in ((left, low), (right, low), (right, high), (left, high))],
                axis=1,
            )
            axes.add_collection(
                PolyCollection(corners, facecolor=colours[label], edgecolor="#8a8a8a", linewidth=0.15, label=label.name)
            )
        axes.set_title(f"{title}: {region.inner * 1e4:.0f} to {region.outer * 1e4:.0f} cm²")
        frame(axes)
    panels[0].legend([label.name.lower() for label in Label], loc="lower left", frameon=True)
    panels[0].set_ylabel("y [cm]")
    figure.savefig(folder / "workspace_boxes.png", dpi=110)

    figure, axes = plt.subplots(figsize=(5.8, 5.2), layout="constrained")
    starts, ends = scan(120)
    rays = closure_rays(planar_facets(ANCHORS, ATTACHMENTS), starts, ends)
    for ray in range(len(starts)):
        for piece in np.nonzero(rays.labels[ray] == Label.INSIDE)[0]:
            place = starts[ray] + rays.places[ray, piece : piece + 2, None] * (ends[ray] - starts[ray])
            axes.plot(*100.0 * place[:, :2].T, color=colours[Label.INSIDE], linewidth=0.8)
    crossings = np.concatenate([rays.crossings(ray) for ray in range(len(starts))])
    axes.plot(*100.0 * crossings[:, :2].T, ".", color=colours[Label.UNDECIDED], markersize=3.0)
    axes.set_title("wrench closure along 120 rays, by roots")
    axes.set_ylabel("y [cm]")
    frame(axes)
    figure.savefig(folder / "workspace_rays.png", dpi=110)


def frame(axes) -> None:
    """Anchors, equal scales, label of x."""
    axes.plot(*100.0 * ANCHORS.T, "k^", markersize=6.0)
    axes.set_aspect("equal")
    axes.set_xlim(-78.0, 55.0)
    axes.set_ylim(-15.0, 104.0)
    axes.set_xlabel("x [cm]")


def table(result: dict) -> str:
    lines = [
        "| question | inner | outer | gap | boxes looked at | time |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in result["regions"]:
        gap = f"{100.0 * row['gap']:.3g} %" + ("" if row["reached"] else ", not reached")
        lines.append(
            f"| {row['question']} | {row['inner']:.6g} | {row['outer']:.6g} | {gap} | {row['evaluations']:,} "
            f"| {row['seconds']:.2f} s |"
        )
    rays, rates = result["rays"], result["orientations"]
    lines += ["", "| rays across Table III at 50 deg | us a ray | area [cm2] |", "| --- | ---: | ---: |"]
    for name in ("roots", "subdivision"):
        lines.append(f"| {name} | {rays[f'{name}_us_per_ray']:.1f} | {rays[f'{name}_area_cm2']:.4f} |")
    one, many = (rates[key] / 1e6 for key in ("one_orientation_per_second", "range_per_second"))
    lines += ["", f"Maps: {one:.0f} M poses/s at one orientation, {many:.0f} M poses/s over 61 of them."]
    return "\n".join(lines)


def main() -> None:
    options = argparse.ArgumentParser(description="Certified workspaces and rays: cost and figures.")
    options.add_argument("--json", action="store_true", help="one JSON object instead of the tables")
    options.add_argument("--figures", type=Path, help="folder to draw the figures of the docs into")
    given = options.parse_args()
    numba.set_num_threads(1)
    if given.figures:
        draw(given.figures)
    result = {"regions": measure_regions(), "rays": measure_rays(), "orientations": measure_orientations()}
    print(json.dumps(result) if given.json else table(result))


if __name__ == "__main__":
    main()
