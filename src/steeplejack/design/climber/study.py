"""Studies of millions of designs in chunks: on a dask cluster or in this process, and resumable after a kill.

A study is a folder. ``study.json`` says what is asked; every finished chunk is a file ``chunk-00000.npy`` that appears
whole or not at all, because it is written under another name, flushed to the disk and renamed. Whoever computes a chunk
writes it, so a kill of anything at any moment costs the chunks in work and none that is finished. A worker that dies is
replaced and its chunks are given out again; those that it had finished are not computed a second time. On a cluster of
several machines the folder has to be shared between them.
"""

from __future__ import annotations

import io
import os
import signal
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from numpy.typing import NDArray

from steeplejack.design.climber.dimensions import Chart, design_space
from steeplejack.design.climber.ratings import Comparison, Ratings, rate
from steeplejack.errors import InputError, SteeplejackError

if TYPE_CHECKING:
    from distributed import Client, WorkerPlugin

Array = NDArray[np.float64]

JOB = 30_000_000  # poses of a chunk: two tenths of a second and more on one core
QUESTION = "study.json"


class LostClusterError(SteeplejackError):
    """The cluster went away, or a chunk's workers died one after the other; what is finished is kept."""


@dataclass(frozen=True)
class Study:
    """Every design of the parameter design space under one comparison.

    Attributes:
        comparison: Region, scale and the rest.
        ratio_step: Of L2/L1, L3/L1 and L4/L1, from 0.05 to 1 [1]; 0.0076 makes a million designs.
    """

    comparison: Comparison
    ratio_step: float = 0.0076

    @property
    def chunk(self) -> int:
        """Designs a chunk."""
        asked = self.comparison
        if asked.rectangle is not None:
            x, w = asked.rectangle.cells(asked.step)
            poses = x.size * w.size
        else:  # the box around what the limbs can reach: about twice what they do
            poses = round(2.0 * (asked.reach[1] / asked.step) ** 2)
        return max(1, -(-JOB // (poses * len(asked.alphas))))

    @property
    def chunks(self) -> int:
        """Chunks of the study."""
        return -(-len(designs_of(self.ratio_step)) // self.chunk)


@cache
def designs_of(ratio_step: float) -> Array:
    """`design_space`, made once in each process."""
    return design_space(ratio_step)


def run_study(
    study: Study,
    folder: str | Path,
    client: Client | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Chart:
    """Rate every design, or those chunks that a run before has not finished.

    Args:
        study: What is asked.
        folder: Where finished chunks are; made where it does not exist.
        client: Of a dask cluster whose workers see the folder; without one this process does the work on all cores.
        progress: Called with the chunks finished and all of them, at the start and after each.

    Returns:
        The chart of all designs.

    Raises:
        InputError: A folder with another study in it.
        LostClusterError: The cluster is gone; run again, and the study goes on with what is missing.
    """
    place = Path(folder)
    claim_study(study, place)
    missing = [index for index in range(study.chunks) if _finished(study, place, index) is None]
    done = study.chunks - len(missing)
    report = progress or (lambda _done, _all: None)
    report(done, study.chunks)
    for _ in _in_process(study, place, missing) if client is None else _on_cluster(study, place, missing, client):
        done += 1
        report(done, study.chunks)
    return read_study(folder)


def read_study(folder: str | Path) -> Chart:
    """The chart of a finished study.

    Raises:
        InputError: No study there, or one with chunks missing.
    """
    place = Path(folder)
    study = _question(place)
    parts = [_finished(study, place, index) for index in range(study.chunks)]
    whole = [part for part in parts if part is not None]
    if len(whole) < len(parts):
        raise InputError(str(place), f"{len(parts) - len(whole)} of {len(parts)} chunks missing", "a finished study")
    gti, mean, least, area = np.concatenate(whole).T
    return Chart(designs_of(study.ratio_step), Ratings(gti, mean, least, area), study.comparison)


@contextmanager
def local_cluster(workers: int) -> Generator[Client]:
    """A dask cluster of processes on this machine, a thread each.

    Raises:
        InputError: No worker, or dask is not installed.
    """
    if workers < 1:
        raise InputError("workers", f"{workers}", "1 or more")
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise InputError("workers", "dask is not installed", "pip install 'steeplejack[cluster]'") from None
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster,
        Client(cluster, set_as_default=False) as client,  # or xarray would write through it, closed or not
    ):
        client.register_plugin(_deaf_to_interrupts())
        yield client


def _deaf_to_interrupts() -> WorkerPlugin:
    """Lets workers, which a terminal sends Ctrl-C too, leave it to the client to end them."""
    from distributed import WorkerPlugin

    class DeafToInterrupts(WorkerPlugin):
        def setup(self, worker: object) -> None:
            signal.signal(signal.SIGINT, signal.SIG_IGN)

    return DeafToInterrupts()


def compute_chunk(study: Study, folder: str, index: int) -> int:
    """Rate one chunk and write it; returns its number."""
    first = index * study.chunk
    ratings = rate(designs_of(study.ratio_step)[first : first + study.chunk], study.comparison)
    path = _path(Path(folder), index)
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    with part.open("wb") as file:
        columns = np.stack((ratings.gti, ratings.mean, ratings.least, ratings.area), axis=-1)
        np.save(file, np.ascontiguousarray(columns, dtype="<f8"))
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
    return index


def _on_one_core(study: Study, folder: str, index: int) -> int:
    """`compute_chunk` in a worker, of which there is one a core; not again what one that died had finished."""
    import numba

    numba.set_num_threads(1)
    return index if _finished(study, Path(folder), index) is not None else compute_chunk(study, folder, index)


def _in_process(study: Study, place: Path, missing: list[int]) -> Generator[int]:
    for index in missing:
        yield compute_chunk(study, str(place), index)


def _on_cluster(study: Study, place: Path, missing: list[int], client: Client) -> Generator[int]:
    from distributed import CancelledError, KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

    folders = [str(place.resolve())] * len(missing)
    try:
        futures = client.map(_on_one_core, [study] * len(missing), folders, missing, pure=False)
        for future in as_completed(futures, client.loop):
            yield future.result()
    except (CancelledError, CommClosedError, KilledWorker) as error:
        raise LostClusterError(
            f"{place}: the cluster is lost ({type(error).__name__}); finished chunks are kept, run the study again"
        ) from None


def claim_study(study: Study, folder: str | Path) -> None:
    """Write the question of a new study, or see that the folder's is the same; drop what a kill left half written.

    Raises:
        InputError: A folder with another study in it.
    """
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    if (place / QUESTION).exists():
        if _question(place) != study:
            raise InputError(str(place), "another study is in this folder", "an empty folder or the same study")
    else:
        part = place / f"{QUESTION}.{os.getpid()}.part"
        part.write_bytes(msgspec.json.format(msgspec.json.encode(study)))
        part.replace(place / QUESTION)
    for left in place.glob("chunk-*.part"):
        left.unlink(missing_ok=True)


def _question(place: Path) -> Study:
    try:
        return msgspec.json.decode((place / QUESTION).read_bytes(), type=Study)
    except (OSError, msgspec.DecodeError) as error:
        raise InputError(str(place / QUESTION), f"{error}", "a folder with a study in it") from None


def _finished(study: Study, place: Path, index: int) -> Array | None:
    """Ratings of a chunk, or None where it has not been finished, or the file is not one that `compute_chunk` wrote."""
    rows = min(study.chunk, len(designs_of(study.ratio_step)) - index * study.chunk)
    head = _header(rows)
    try:
        written = _path(place, index).read_bytes()
    except OSError:
        return None
    if not written.startswith(head) or len(written) != len(head) + rows * 4 * 8:
        return None
    return np.frombuffer(written, dtype="<f8", offset=len(head)).reshape(rows, 4)


def _header(rows: int) -> bytes:
    """What an ``npy`` file of (rows, 4) little-endian float64 begins with."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (rows, 4)})
    return file.getvalue()


def _path(place: Path, index: int) -> Path:
    return place / f"chunk-{index:05d}.npy"
