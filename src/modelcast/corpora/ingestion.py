"""`ingest`: recordings of any format as one corpus.

Sources are read one by one, each into a folder of its own (`modelcast.corpora.staging`), the partitions are
packed from these (`modelcast.corpora.packing`), and ``corpus.json`` is written last. Both steps can be shared
among processes, and each of their parts appears whole or not at all: a killed run goes on where it stopped,
and what comes out has the same octets whatever the number of processes and of interruptions.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import hashlib
import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from modelcast.core.exceptions import ConfigError
from modelcast.corpora.catalogue import CATALOGUE
from modelcast.corpora.claim import STAGING, claimed, cleared
from modelcast.corpora.executors.base import AbstractCrew, AbstractExecutor, Failed, LostWorkerError
from modelcast.corpora.executors.here import HereExecutor
from modelcast.corpora.finishing import Ingested, Made, failures_of, finish, skipped_of, write_grouped
from modelcast.corpora.layout import (
    FORMAT,
    ROWS_FOLDER,
    VERSION,
    Partition,
    partition_folder,
)
from modelcast.corpora.merging import merged_catalogue
from modelcast.corpora.packing import Packing, pack, packed_already
from modelcast.corpora.sources import FoundSources, Source
from modelcast.corpora.staging import Staged, Staging, samples_under_way, stage, staged_already
from modelcast.io.failure import failure_reason

__all__ = ["Watch", "ingest", "rows_under_way", "watch_nothing"]

_MERGED = "catalogue.parquet"

_SHOWN = 10
_HERE = HereExecutor()

Watch = Callable[[str, int, int, int], None]
"""Called with a stage's name, octets (or samples) done, those to do, and rows done so far."""


def watch_nothing(stage: str, done: int, steps: int, rows: int) -> None:
    """Show nothing: a `Watch`."""
    del stage, done, steps, rows


def ingest(
    found: FoundSources,
    out: str | Path,
    *,
    partitions: int | None = None,
    thresholds_m: Sequence[float] | None = None,
    executor: AbstractExecutor = _HERE,
    watch: Watch = watch_nothing,
) -> Ingested:
    """Make a corpus of recordings, or go on with one whose making was interrupted.

    Parameters
    ----------
    found
        The recordings.
    out
        The corpus' folder: new, empty, or an unfinished corpus of the same sources and settings.
    partitions
        How many; None for as many as give `modelcast.corpora.merging.PARTITION_ROWS` samples each.
    thresholds_m
        What the noise of every trip is judged by, where its quality is to be measured for the catalogue [m];
        None where not.
    executor
        Where the sources are read and the partitions packed.
    watch
        Told of progress.

    Raises
    ------
    ConfigError
        Where the folder is none of these, another ingest is writing into it, a source lies in it or it in
        a source, no source has a usable trip, or a partition could not be written.
    """
    if partitions is not None and partitions < 1:
        raise ConfigError(f"there must be at least 1 partition, got {partitions}")
    folder = Path(out).resolve()
    _require_apart(found.sources, folder, shown=str(out))
    plan = _plan(found, thresholds_m=thresholds_m)
    with claimed(folder, plan, shown=str(out)), executor.start() as crew:
        crew.require_shared([folder, *sorted({one.place.resolve().parent for one in found.sources})])
        staging = folder / STAGING
        judged = None if thresholds_m is None else tuple(thresholds_m)
        works = [Staging(replace(one, path=_absolute(one.path)), staging, judged) for one in found.sources]
        staged, kept = _staged(works, crew, watch)
        read = [work for work in works if not staged[work.source.number].failure]
        catalogue = merged_catalogue(read, partitions=partitions) if read else CATALOGUE.empty_table()
        if not catalogue.num_rows:
            lost = {**failures_of(found, staged), **skipped_of(found, staged)}
            reasons = [f"{name}: {reason}" for name, reason in lost.items()]
            cleared(folder)
            raise ConfigError("; ".join(("no usable trip: no corpus was made", *reasons[:_SHOWN])))
        key = hashlib.sha256(
            json.dumps([plan, [asdict(one) for one in staged.values()], partitions]).encode()
        ).hexdigest()
        packed = _packed(folder, catalogue, key, crew, watch)
        made = Made(folder, found, staged, settings=plan["settings"], catalogue=catalogue, partitions=packed)
        ingested = finish(made, kept=kept)
        cleared(folder)
        return ingested


def rows_under_way(out: str | Path) -> int:
    """Return how many samples of sources that are being read are written; about.

    Parameters
    ----------
    out
        The corpus' folder.
    """
    return samples_under_way(Path(out) / STAGING)


def _plan(found: FoundSources, *, thresholds_m: Sequence[float] | None) -> dict[str, Any]:
    """What an unfinished corpus must be of for an ingest to go on with it."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "settings": {
            **found.settings,
            "inspected_by_m": None if thresholds_m is None else list(thresholds_m),
        },
        "sources": [[one.label, one.reader.name, str(Path(one.path).resolve())] for one in found.sources],
    }


def _absolute(path: str) -> str:
    """Return a path for processes with another working folder; links in it stay."""
    return str(Path(path).absolute())


def _require_apart(sources: Sequence[Source], folder: Path, *, shown: str) -> None:
    for source in sources:
        path = Path(source.path).resolve()
        if path.is_relative_to(folder) or folder.is_relative_to(path):
            raise ConfigError(f"{shown} and its source {source.path} lie in one another: name another folder")


def _staged(works: Sequence[Staging], crew: AbstractCrew, watch: Watch) -> tuple[dict[int, Staged], int]:
    """Return what became of every source by its number, and how many an earlier run had read."""
    staged = {work.source.number: done for work in works if (done := staged_already(work)) is not None}
    kept = len(staged)
    octets = {work.source.number: work.source.state[1] for work in works}
    waiting = [work for work in works if work.source.number not in staged]

    def tell() -> None:
        done = sum(octets[number] for number in staged)
        watch("reading", done, sum(octets.values()), sum(one.rows for one in staged.values()))

    tell()
    for work, answer in crew.as_done(stage, waiting):
        staged[work.source.number] = _lost(work, answer) if isinstance(answer, Failed) else answer
        tell()
    return dict(sorted(staged.items())), kept


def _lost(work: Staging, failed: Failed) -> Staged:
    """Return what becomes of a source that its worker could not hold; anything else ends it all."""
    if not isinstance(failed.error, (LostWorkerError, MemoryError)):
        raise failed.error
    reason = failure_reason(failed.error, memory_bytes=work.source.memory_bytes)
    return Staged(work.source.state, failure=reason)


def _packed(
    folder: Path, catalogue: Any, key: str, crew: AbstractCrew, watch: Watch
) -> tuple[Partition, ...]:
    """Write the merged catalogue and the partitions, and return these by name.

    Raises
    ------
    ConfigError
        Where a partition could not be written; the others are, and are kept for the next run.
    """
    merged = folder / STAGING / _MERGED
    names = list(dict.fromkeys(catalogue["partition"].to_pylist()))
    write_grouped(merged, catalogue)
    works = [Packing(name, folder, folder / STAGING, merged, group, key) for group, name in enumerate(names)]
    packed = {work.name: done for work in works if (done := packed_already(work)) is not None}
    waiting = [work for work in works if work.name not in packed]
    rows, samples = sum(one.rows for one in packed.values()), sum(catalogue["samples"].to_pylist())
    watch("packing", rows, samples, rows)
    lost: dict[str, str] = {}
    for work, done in crew.as_done(pack, waiting):
        if isinstance(done, Failed):
            lost[work.name] = _why_lost(done)
            continue
        packed[work.name] = done
        rows += done.rows
        watch("packing", rows, samples, rows)
    if lost:
        reasons = [f"partition {name}: {reason}" for name, reason in sorted(lost.items())]
        raise ConfigError("; ".join(reasons[:_SHOWN]) + "; what is done is kept")
    for stale in set((folder / ROWS_FOLDER).iterdir()) - {partition_folder(folder, name) for name in names}:
        shutil.rmtree(stale, ignore_errors=True)
    return tuple(packed[name] for name in names)


def _why_lost(failed: Failed) -> str:
    """Why a partition could not be written, and what can be done."""
    if isinstance(failed.error, (LostWorkerError, MemoryError)):
        return f"{failed.reason}: run again with more --memory or fewer --jobs"
    return failed.reason
