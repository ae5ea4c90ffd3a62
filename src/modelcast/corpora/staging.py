"""A source on its way into a corpus: its trips as read, in a folder that appears whole or not at all.

``samples.arrow``
    A record batch a trip, uncompressed: 64 octets a sample.
``trips.parquet``
    The trips' rows of the catalogue, in the same order.
``done.json``
    The source's state when it was read, and what gave no trip. A source that failed has no trips, and why.

A killed run leaves either the whole folder or none, so what is there counts once.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import fnmatch
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.printable import printable
from modelcast.corpora.catalogue import CATALOGUE, SAMPLED, catalogue_row
from modelcast.corpora.partition_rows import SAMPLES
from modelcast.corpora.sources import Source
from modelcast.io.base import NoUsableRow, OnSkipped
from modelcast.io.failure import failure_reason
from modelcast.io.output import lasting_rename
from modelcast.io.partial import clean_leftovers, partial_folder
from modelcast.io.reading_rate import read_at
from modelcast.io.recordings import Recording
from modelcast.io.skipped import merge_skipped
from modelcast.trips.trajectory import Trajectory

__all__ = [
    "Staged",
    "Staging",
    "samples_under_way",
    "source_folder",
    "stage",
    "staged_already",
    "staged_catalogue",
    "staged_samples",
]

_DONE, _SAMPLES, _TRIPS = "done.json", "samples.arrow", "trips.parquet"
_HELD_TRIPS = 1000
_SAMPLE_BYTES = 8 * len(SAMPLED)


@dataclass(frozen=True, slots=True)
class Staging:
    """A source to be read, and where to.

    Parameters
    ----------
    source
        The recording.
    folder
        The folder of all staged sources.
    thresholds_m
        What the noise of its trips is judged by [m]; None where their quality is not measured.
    """

    source: Source
    folder: Path
    thresholds_m: tuple[float, ...] | None = None

    @property
    def place(self) -> Path:
        """The source's own folder."""
        return source_folder(self.folder, self.source.number)


@dataclass(frozen=True, slots=True)
class Staged:
    """What became of a source.

    Parameters
    ----------
    state
        As `Source.state` when it was read.
    trips, rows, samples
        Numbers of trips, of rows read for them, and of samples.
    skipped
        Vehicles that gave no trip, with the reason, in order of name: that of reading depends on how much
        memory there is.
    skipped_rows
        How many rows those of them had, where that is known.
    failure
        Why it gave nothing; empty where it was read to its end.
    """

    state: list[int]
    trips: int = 0
    rows: int = 0
    samples: int = 0
    skipped: Mapping[str, str] = field(default_factory=dict[str, str])
    skipped_rows: Mapping[str, int] = field(default_factory=dict[str, int])
    failure: str = ""


def samples_under_way(folder: Path) -> int:
    """Return about how many samples of sources that are being read are written.

    Parameters
    ----------
    folder
        The folder of all staged sources.
    """
    found = 0
    for file in folder.glob(f".*/{_SAMPLES}"):
        with suppress(OSError):
            found += file.stat().st_size // _SAMPLE_BYTES
    return found


def source_folder(folder: Path, number: int) -> Path:
    """Return where a source's trips are until they are packed.

    Parameters
    ----------
    folder
        The folder of all staged sources.
    number
        Of the source.
    """
    return folder / f"source-{number:06d}"


def staged_already(work: Staging) -> Staged | None:
    """Return what an earlier run made of a source, None where that is to be done (again).

    A source that failed is read again: there may be more memory, or another library, now.

    Parameters
    ----------
    work
        The source.
    """
    try:
        found = Staged(**json.loads((work.place / _DONE).read_text(encoding="utf-8")))
        changed = found.state != work.source.state
    except (OSError, ValueError, TypeError):
        return None
    return None if changed or found.failure else found


def stage(work: Staging) -> Staged:
    """Read a source into its folder; one that fails leaves the reason there, and no trips.

    Parameters
    ----------
    work
        The source.
    """
    clean_leftovers(work.place)
    with partial_folder(work.place) as folder:
        state = work.source.state
        try:
            staged = _read(work, folder, state)
        except _UnreadableError as error:
            for name in (_SAMPLES, _TRIPS):
                (folder / name).unlink(missing_ok=True)
            staged = Staged(state, failure=str(error))
        (folder / _DONE).write_text(json.dumps(asdict(staged)), encoding="utf-8")
        if work.place.exists():
            _remove(work.place)
        lasting_rename(folder, work.place)
    return staged


def staged_catalogue(work: Staging) -> Any:
    """Return the rows of the catalogue of a source that was read, a `pyarrow.Table`.

    Parameters
    ----------
    work
        The source.
    """
    return pq.read_table(work.place / _TRIPS, schema=CATALOGUE)


def staged_samples(place: Path) -> Callable[[int], Any]:
    """Return a function that gives a trip's samples by its place in the source, as a `pyarrow.RecordBatch`.

    Parameters
    ----------
    place
        A source's own folder.
    """
    batches = pa.ipc.open_file(pa.memory_map(str(place / _SAMPLES)))
    return batches.get_batch


class _UnreadableError(Exception):
    """A source's reader failed; the text is the reason."""


def _trips(source: Source, on_skipped: OnSkipped) -> Iterator[Trajectory]:
    """Yield the trips that are taken.

    Raises
    ------
    _UnreadableError
        Where the reader raises anything.
    """
    try:
        for read in Recording(source.path, source.reader, on_skipped).trips():
            trip = read_at(_named(read, printable(read.trip_id)), source.rate_hz, on_skipped)
            if trip is not None and fnmatch.fnmatch(trip.trip_id, source.pattern):
                yield trip
    except (Exception, SystemExit) as error:
        reason = failure_reason(error, memory_bytes=source.memory_bytes)
        raise _UnreadableError(printable(reason)) from error


def _read(work: Staging, folder: Path, state: list[int]) -> Staged:
    """Write the trips of a source and return their counts."""
    source = work.source
    noted: list[tuple[str, str, int | None]] = []

    def note(what: str, reason: str) -> None:
        lost = reason.rows if isinstance(reason, NoUsableRow) else None
        noted.append((printable(what), printable(reason), lost))

    trips = rows = samples = 0
    held: list[dict[str, Any]] = []
    with (
        pa.OSFile(str(folder / _SAMPLES), "wb") as file,
        pa.ipc.new_file(file, SAMPLES) as batches,
        pq.ParquetWriter(folder / _TRIPS, CATALOGUE, compression="zstd") as catalogue,
    ):
        for trip in _trips(source, note):
            batches.write_batch(_batch(trip))
            held.append(catalogue_row(trip, source=source.label, thresholds_m=work.thresholds_m))
            trips, rows, samples = trips + 1, rows + trip.reading.rows, samples + len(trip)
            if len(held) == _HELD_TRIPS:
                catalogue.write_table(pa.Table.from_pylist(held, schema=CATALOGUE))
                held.clear()
        catalogue.write_table(pa.Table.from_pylist(held, schema=CATALOGUE))
    noted.sort(key=itemgetter(0, 1))
    skipped = merge_skipped({what: why} for what, why, _ in noted)
    each = zip(skipped, noted, strict=True)
    return Staged(state, trips, rows, samples, skipped, {name: lost for name, (*_, lost) in each if lost})


def _batch(trip: Trajectory) -> Any:
    columns = {
        **trip.columns(),
        "east_m": np.ascontiguousarray(trip.position_m[:, 0]),
        "north_m": np.ascontiguousarray(trip.position_m[:, 1]),
    }
    arrays = [
        pa.array(columns[name]) if name in columns else pa.nulls(len(trip), pa.float64())
        for name in SAMPLES.names
    ]
    return pa.record_batch(arrays, schema=SAMPLES)


def _named(trip: Trajectory, name: str) -> Trajectory:
    return trip if trip.trip_id == name else replace(trip, trip_id=name)


def _remove(place: Path) -> None:
    for file in place.iterdir():
        file.unlink()
    place.rmdir()
