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

from steeplejack.design.climber import (
    PRESCRIBED,
    Comparison,
    LostClusterError,
    Study,
    local_cluster,
    rate,
    read_study,
    run_study,
)
from steeplejack.design.climber import study as module
from steeplejack.errors import InputError

pytestmark = pytest.mark.long

# 8 chunks of two tenths of a second and more on one core, so that a kill falls between two of them.
STUDY = Study(Comparison(PRESCRIBED, alphas=tuple(np.linspace(-0.5, 0.5, 60).tolist()), step=0.002), 0.95 / 15)
PROGRAM = """
import sys
from steeplejack.design.climber import PRESCRIBED, Comparison, Study, local_cluster, run_study
import numpy as np
study = Study(Comparison(PRESCRIBED, alphas=tuple(np.linspace(-0.5, 0.5, 60).tolist()), step=0.002), 0.95 / 15)
if sys.argv[2:]:
    with local_cluster(2) as client:
        run_study(study, sys.argv[1], client)
else:
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


def test_workers_that_are_killed_cost_no_finished_chunk(tmp_path: Path) -> None:
    """Both, one after the other: others take their places."""
    pytest.importorskip("distributed")
    kept: dict[str, int] = {}
    with local_cluster(2) as client:
        workers = list(client.run(os.getpid).values())

        def kill(done: int, _of: int) -> None:
            if done in (2, 5):
                os.kill(workers.pop(), signal.SIGKILL)
                kept.update(times(tmp_path))

        chart = run_study(STUDY, tmp_path, client, kill)
    assert not workers
    assert 5 <= len(kept) < STUDY.chunks
    after = times(tmp_path)
    assert {name: after[name] for name in kept} == kept
    assert (chart.ratings.gti == rate(chart.ratios, STUDY.comparison).gti).all()


def test_a_client_that_is_killed_is_taken_over(tmp_path: Path) -> None:
    """Its workers notice and go; another client, with a cluster of its own, does what is missing and no more."""
    pytest.importorskip("distributed")
    folder = tmp_path / "study"
    run = subprocess.Popen([sys.executable, "-c", PROGRAM, str(folder), "cluster"], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 300.0
    while len(times(folder)) < 3:
        assert run.poll() is None and time.monotonic() < deadline
        time.sleep(0.002)
    workers = children(run.pid)
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    kept = times(folder)
    assert 3 <= len(kept) < STUDY.chunks
    while any(alive(worker) for worker in workers):
        assert time.monotonic() < deadline
        time.sleep(0.1)
    kept = times(folder)
    with local_cluster(2) as client:
        chart = run_study(STUDY, folder, client)
    after = times(folder)
    assert len(after) == STUDY.chunks
    assert {name: after[name] for name in kept} == kept
    assert (chart.ratings.gti == rate(chart.ratios, STUDY.comparison).gti).all()


def children(parent: int) -> list[int]:
    """Processes that a process has started."""
    return [int(one) for one in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]


def alive(process: int) -> bool:
    """Whether a process runs; one that has ended and that nobody waits for does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_a_cluster_that_is_lost_is_said_so(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(LostClusterError, match="finished chunks are kept"), local_cluster(1) as client:
        run_study(STUDY, tmp_path, client, lambda done, _of: client.close() if done == 2 else None)
    assert 2 <= len(times(tmp_path)) < STUDY.chunks
    assert len(run_study(STUDY, tmp_path).ratios) == len(module.designs_of(STUDY.ratio_step))


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
