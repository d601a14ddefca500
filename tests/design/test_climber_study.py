"""Studies in chunks: killed in the middle and resumed, on a cluster and without."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from steeplejack.design.climber import PRESCRIBED, Comparison, Study, local_cluster, rate, read_study, run_study
from steeplejack.design.climber import study as module
from steeplejack.errors import InputError

pytestmark = pytest.mark.long

# 16 chunks of at least 0.1 s on one core, so that a kill falls between two of them.
STUDY = Study(Comparison(PRESCRIBED, alphas=tuple(np.linspace(-0.5, 0.5, 60).tolist()), step=0.002), 0.95 / 15)
PROGRAM = """
import sys
from steeplejack.design.climber import PRESCRIBED, Comparison, Study, run_study
import numpy as np
study = Study(Comparison(PRESCRIBED, alphas=tuple(np.linspace(-0.5, 0.5, 60).tolist()), step=0.002), 0.95 / 15)
run_study(study, sys.argv[1])
"""


def times(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("chunk-*.npy")}


def test_killed_and_resumed(tmp_path: Path) -> None:
    assert 5 <= STUDY.chunks <= 20
    folder = tmp_path / "study"
    run = subprocess.Popen([sys.executable, "-c", PROGRAM, str(folder)])
    deadline = time.monotonic() + 300.0
    while len(times(folder)) < 2:
        assert run.poll() is None and time.monotonic() < deadline
        time.sleep(0.002)
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    kept = times(folder)
    assert 2 <= len(kept) < STUDY.chunks
    with pytest.raises(InputError, match="chunks missing"):
        read_study(folder)
    (folder / "chunk-00099.npy.1.part").write_bytes(b"half")  # what a kill in the middle of a write leaves
    steps: list[tuple[int, int]] = []
    chart = run_study(STUDY, folder, progress=lambda done, of: steps.append((done, of)))
    after = times(folder)
    assert {name: after[name] for name in kept} == kept
    assert steps == [(done, STUDY.chunks) for done in range(len(kept), STUDY.chunks + 1)]
    assert not list(folder.glob("*.part"))
    expected = rate(chart.ratios, STUDY.comparison)
    assert (chart.ratings.gti == expected.gti).all()
    assert (chart.ratings.mean == expected.mean).all()


def test_a_damaged_chunk_is_done_again(tmp_path: Path) -> None:
    small = Study(Comparison(PRESCRIBED, step=0.01), 0.95 / 7)
    whole = run_study(small, tmp_path)
    damaged = tmp_path / "chunk-00000.npy"
    good = damaged.read_bytes()
    archive = io.BytesIO()
    np.savez(archive, gti=whole.ratings.gti)
    words, single = io.BytesIO(), io.BytesIO()
    np.save(words, np.full((len(whole.ratios), 4), "x"))
    np.save(single, np.zeros((len(whole.ratios), 4), np.float32))
    for bad in (good[:100], b"", archive.getvalue(), words.getvalue(), single.getvalue(), good + b"0", b"PK" + good):
        damaged.write_bytes(bad)
        with pytest.raises(InputError, match="chunks missing"):
            read_study(tmp_path)
        assert (run_study(small, tmp_path).ratings.gti == whole.ratings.gti).all()
        assert damaged.read_bytes() == good
    run_study(small, tmp_path, progress=lambda done, of: pytest.fail("work") if done < of else None)


def test_another_study_is_not_mixed_in(tmp_path: Path) -> None:
    small = Study(Comparison(PRESCRIBED, step=0.01), 0.95 / 5)
    run_study(small, tmp_path)
    with pytest.raises(InputError, match="another study"):
        run_study(replace(small, ratio_step=0.18), tmp_path)
    with pytest.raises(InputError, match=r"study\.json"):
        read_study(tmp_path / "nothing")


def test_workers_write_the_same(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    few = replace(STUDY, ratio_step=0.95 / 9)
    with local_cluster(2) as client:
        chart = run_study(few, tmp_path / "cluster", client)
    alone = run_study(few, tmp_path / "alone")
    assert (chart.ratings.gti == alone.ratings.gti).all()
    assert (chart.ratings.least == alone.ratings.least).all()


def test_a_cluster_needs_workers_and_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="workers"), local_cluster(0):
        pass
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match="dask is not installed"), local_cluster(1):
        pass


def test_chunks_are_jobs_of_a_tenth_of_a_second() -> None:
    million = Study(Comparison(PRESCRIBED, step=0.002))
    assert len(module.designs_of(million.ratio_step)) > 1_000_000
    assert million.chunk * 1750 >= module.JOB
    assert million.chunks > 50
