"""Grasps to ask for: the reference of Table III, and random robots with random regions."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from steeplejack.design.grasps import GraspQuestion, GraspRegion

GRASP: dict[str, Any] = tomllib.loads((Path(__file__).parents[1] / "reference" / "grasp_table_iii.toml").read_text())
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def track_question(reference: dict[str, Any], widen: float = 1.0) -> GraspQuestion:
    """The published robot and the region of the reference, ``widen`` times as large."""
    given, table = GRASP["region"], reference["table_iii"]
    point = (given["x0"], given["slope"] * given["x0"] + given["intercept"])
    region = GraspRegion.eq19(point, (1.0, given["slope"]), widen * given["delta"], widen * given["epsilon"])
    return GraspQuestion(table["anchors"], table["attachments"], np.deg2rad(given["phi_deg"]), region)


def random_question(rng: np.random.Generator) -> GraspQuestion:
    """A robot that mostly has a workspace, or any four cables, and a region of any size and turn."""
    if rng.uniform() < 0.7:
        anchors = SQUARE + rng.normal(0.0, 0.15, (4, 2))
        attachments = 0.2 * SQUARE + rng.normal(0.0, 0.05, (4, 2))
        phi = rng.normal(0.0, 0.3)
    else:
        anchors, attachments = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-0.3, 0.3, (4, 2))
        phi = rng.uniform(-np.pi, np.pi)
    half_width, half_length = 10.0 ** rng.uniform(-3.0, 0.2, 2)
    region = GraspRegion(rng.uniform(-0.5, 0.5, 2), rng.normal(size=2), half_width, half_length)
    return GraspQuestion(anchors, attachments, phi, region)


def scattered(question: GraspQuestion, count: int, rng: np.random.Generator) -> np.ndarray:
    """Positions all over the region, its border and its corners included, (k, 2) [m]."""
    share = np.concatenate((SQUARE, np.clip(1.2 * rng.uniform(-1.0, 1.0, (count, 2)), -1.0, 1.0)))
    return question.region.placed(share * [question.region.half_length, question.region.half_width])
