"""Every distribution against HiGHS and rational arithmetic, pose by pose: the short form of benchmarks/agreement.py."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from published_robots import PLANAR, SPATIAL
from tension_questions import balanced_by, drawn, published
from verdicts import Verdicts, shortcomings, taken

from steeplejack.mechanics.cable import METHODS, distribute

pytestmark = pytest.mark.long

WRONG = ("disagreements", "bad_tensions", "bad_proofs")


@pytest.mark.parametrize("robot", (*PLANAR, *SPATIAL), ids=lambda robot: robot.name)
def test_published_robots_are_judged_as_the_linear_program_does(robot, rng):
    asked = published(robot, rng, 120)
    verdicts = Verdicts.of(*asked)
    assert 0 < np.count_nonzero(verdicts.held) < 120
    assert_all_agree(asked, verdicts)


@pytest.mark.parametrize(("n", "m"), [(3, 4), (3, 6), (6, 8), (6, 10)])
def test_loads_on_the_edge_are_settled_by_rational_arithmetic(n, m, rng):
    """Loads whose margin is 1e-8 one way or the other, where the linear program is not believed."""
    count = 12
    structures, _, lower, upper = drawn(rng, n, m, count)
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    corner = np.sign(np.einsum("ki,kij->kj", rng.normal(size=(count, n)), structures))  # the farthest along a wrench
    inside = np.arange(count) % 2 == 0
    reached = middle + corner * half * np.where(inside, 1.0 - 1e-8, 1.0 + 1e-8)[:, None]
    asked = structures, balanced_by(structures, reached), lower, upper
    verdicts = Verdicts.of(*asked)
    assert verdicts.close.all()
    np.testing.assert_array_equal(verdicts.held, inside)
    assert_all_agree(asked, verdicts, margins=1e-6)


def test_a_wrong_answer_is_noticed(rng):
    asked = published(PLANAR[0], rng, 60)
    verdicts, right = Verdicts.of(*asked), distribute(*asked, "qp")
    for wrong, count in (
        (replace(right, feasible=~right.feasible), "disagreements"),
        (replace(right, tensions=right.tensions + 0.01), "bad_tensions"),
        (replace(right, tensions=right.tensions + 1e3), "bad_tensions"),
        (replace(right, certificate=-right.certificate), "bad_proofs"),
    ):
        assert shortcomings("qp", wrong, asked, verdicts)[count] > 0


def assert_all_agree(asked, verdicts, margins=1e-8):
    for method in METHODS:
        if taken(method, asked[0]):
            found = shortcomings(method, distribute(*asked, method), asked, verdicts)
            assert [found[count] for count in WRONG] == [0, 0, 0], (method, found)
            assert found["margin_apart"] < margins
