"""Figures of merit of small runs whose errors are known."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray
from small_run import FROM, STAND_OFF, TO, Run, write_run

from steeplejack.planning.mission import Uncovered
from steeplejack.report import Analysis, analyse, read_log
from steeplejack.report.boundary import Driven

Array = NDArray[np.float64]

KEYS = """coverage_fraction clock_coverage not_covered duration_s distance_m stances moves max_tension_n min_slip_margin
min_tension_factor stand_off_m error_along_mm error_across_mm error_stand_off_mm absolute_error_mm faults""".split()


def analysed(path: Path, run: Run | None = None) -> Analysis:
    return analyse(read_log(write_run(path / "run.mcap", run)))


def test_a_perfect_run(tmp_path: Path):
    summary = analysed(tmp_path).summary
    assert summary.coverage_fraction == pytest.approx(1.0)
    assert summary.not_covered == ()
    assert (summary.stances, summary.moves, summary.faults) == (2, 1, ())
    assert summary.duration_s == pytest.approx(479 * 0.05)
    assert (summary.max_tension_n, summary.min_slip_margin, summary.min_tension_factor) == (170.0, 0.4, 0.3)
    assert (summary.stand_off_m.min, summary.stand_off_m.max) == pytest.approx((STAND_OFF, STAND_OFF), abs=1e-6)
    assert summary.absolute_error_mm.max == pytest.approx(0.0, abs=1e-9)
    for spread in (summary.error_along_mm, summary.error_across_mm, summary.error_stand_off_mm):
        assert (spread.mean, spread.std) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_the_keys_are_those_of_the_command_line(tmp_path: Path):
    summary = msgspec.to_builtins(analysed(tmp_path).summary)
    assert list(summary) == KEYS
    assert list(summary["stand_off_m"]) == ["min", "max"]
    assert list(summary["error_across_mm"]) == ["mean", "std"]
    assert list(summary["absolute_error_mm"]) == ["mean", "max"]


def wobble(sample: int, axes: Array) -> Array:
    """Across 3 +- 2 mm, along -4 +- 1 mm, farther off by 5 +- 6 mm; ``axes`` are across, along, towards the stays."""
    sign = 1.0 if sample % 2 else -1.0
    return 1e-3 * ((3.0 + 2.0 * sign) * axes[:, 0] + (-4.0 + sign) * axes[:, 1] - (5.0 + 6.0 * sign) * axes[:, 2])


def test_known_errors_come_back(tmp_path: Path):
    summary = analysed(tmp_path, Run(offset=wobble)).summary
    assert (summary.error_across_mm.mean, summary.error_across_mm.std) == pytest.approx((3.0, 2.0), abs=1e-3)
    assert (summary.error_along_mm.mean, summary.error_along_mm.std) == pytest.approx((-4.0, 1.0), abs=1e-3)
    assert (summary.error_stand_off_mm.mean, summary.error_stand_off_mm.std) == pytest.approx((5.0, 6.0), abs=1e-3)
    sizes = np.linalg.norm([[5.0, -3.0, 11.0], [1.0, -5.0, -1.0]], axis=1)
    assert summary.absolute_error_mm.mean == pytest.approx(sizes.mean(), abs=1e-6)
    assert summary.absolute_error_mm.max == pytest.approx(sizes.max(), abs=1e-6)
    assert summary.stand_off_m.max == pytest.approx(STAND_OFF + 0.011, abs=1e-4)


def test_drift_is_taken_out_of_the_relative_error_and_stays_in_the_absolute_one(tmp_path: Path):
    drift = np.array([0.020, -0.012, 0.009])
    run = Run(offset=lambda i, axes: drift + wobble(i, axes), drift=np.tile(drift, (4, 1)))
    summary = analysed(tmp_path, run).summary
    assert (summary.error_across_mm.mean, summary.error_across_mm.std) == pytest.approx((3.0, 2.0), abs=1e-2)
    assert (summary.error_along_mm.mean, summary.error_along_mm.std) == pytest.approx((-4.0, 1.0), abs=1e-2)
    assert (summary.error_stand_off_mm.mean, summary.error_stand_off_mm.std) == pytest.approx((5.0, 6.0), abs=1e-2)
    still = analysed(tmp_path, Run(offset=lambda i, axes: drift, drift=np.tile(drift, (4, 1)))).summary
    assert still.absolute_error_mm.mean == pytest.approx(1e3 * np.linalg.norm(drift))
    assert abs(still.error_along_mm.mean) < 1e-2


def test_an_ended_run_covers_what_it_flew_and_says_why_not_the_rest(tmp_path: Path):
    """The breach comes halfway along the first stay; what the brakes then hold the camera over does not count."""
    analysis = analysed(tmp_path, Run(until=3.0))
    summary = analysis.summary
    assert summary.faults == ("cable slack (4)",)
    assert (summary.stances, summary.moves) == (1, 0)
    assert 0.2 < summary.coverage_fraction < 0.35
    assert [gap.stay for gap in summary.not_covered] == ["S1", "S2"]
    assert {gap.why for gap in summary.not_covered} == {"the run ended early"}
    assert summary.not_covered[1] == Uncovered("S2", FROM, TO, "the run ended early")
    assert analysis.accuracy.travel[-1] < 3.2
    assert analysis.time_by_activity[5] > 2.5


def test_the_plans_reason_stands_in_the_summary(tmp_path: Path):
    reason = Uncovered("S2", FROM, TO, "pull along the stay of base 2")
    summary = analysed(tmp_path, Run(legs=(0,), uncovered=(reason,))).summary
    assert summary.coverage_fraction == pytest.approx(0.5, abs=0.01)
    assert summary.not_covered == (reason,)


def test_a_run_that_inspected_nothing_has_no_errors_to_report(tmp_path: Path):
    summary = analysed(tmp_path, Run(legs=(1, 2))).summary
    assert np.isnan([summary.error_along_mm.mean, summary.stand_off_m.min, summary.min_tension_factor]).all()
    assert msgspec.json.decode(msgspec.json.encode(summary))["absolute_error_mm"] == {"mean": None, "max": None}


def test_boundary_stays_are_seen_where_a_base_drove(tmp_path: Path):
    """Base 3 drives from 40 to 44 m, beyond the stretch asked for."""
    analysis = analysed(tmp_path)
    driven = [stay for stay in analysis.driven if stay.stretches]
    assert [stay.stretches for stay in driven] == [((40.0, 44.0),)]
    assert driven[0].seen_length == 0.0
    assert driven[0].missed == ((FROM, TO),)


def test_what_a_drive_leaves_unseen():
    stay = Driven("B0", ((10.0, 20.0), (22.0, 30.0)), ((5.0, 12.0), (15.0, 23.0), (29.0, 40.0)))
    assert stay.asked_length == 18.0
    assert stay.seen_length == 2.0 + 5.0 + 1.0 + 1.0
    assert stay.missed == ((12.0, 15.0), (23.0, 29.0))


def test_time_adds_up(tmp_path: Path):
    analysis = analysed(tmp_path)
    assert analysis.time_by_activity.sum() == pytest.approx(analysis.summary.duration_s)
    assert analysis.time_by_activity[0] == pytest.approx(12.0, abs=0.1)
