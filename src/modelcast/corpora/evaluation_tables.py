"""What an evaluation leaves of one partition: tables of which all partitions together are one data set.

``trips.parquet``, ``rates.parquet``, ``references.parquet``, ``tracking.parquet``
    Rows of single trips (`TRIP_ROWS`, `RATE_ROWS`, `REFERENCES`, `TRACKING`): `modelcast.io.table_files`
    tells from a file what its columns mean.
``events.parquet``, ``samples.parquet``
    As `modelcast.io.record_files` writes them.
``pools.parquet``
    Tracking errors over the partition's trips (`POOLS`): whole numbers, so that sums over partitions are
    exact.
``failures.json``
    Trips that could not be evaluated, with the reason.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import DataFormatError
from modelcast.core.json_text import parse_json
from modelcast.io.arrow import table_writer
from modelcast.io.documents import document_text, plain_value
from modelcast.io.table_files import read_table, write_table
from modelcast.study.gathered import Gathered, Illustration, TripCount
from modelcast.study.histogram import Histogram
from modelcast.study.pooling import TrackingPool
from modelcast.study.rate import RateCount, rate_row
from modelcast.study.result import RATES, REFERENCES, TRACKING, TRIPS, TripRow, trip_values
from modelcast.study.table import Row, TableSchema, count, quantity, text
from modelcast.study.tracking import Contender

__all__ = ["POOLS", "RATE_ROWS", "TRIP_ROWS", "read_tables", "trips_in", "write_tables_of"]

TRIP_ROWS = TableSchema(
    TRIPS.name,
    TRIPS.description,
    (
        *TRIPS.columns,
        quantity(
            "sharpest_mps2",
            "m/s²",
            "Acceleration across the course in the sharpest manoeuvre.",
            missing="no part is long enough",
        ),
        text(
            "details",
            "JSON: reasons of rows skipped and repaired, warnings and what the file was taken for in words, "
            "the smoother's figures.",
        ),
    ),
)
"""Trips: a row a trip."""

RATE_ROWS = TableSchema(
    RATES.name,
    RATES.description,
    (
        *RATES.columns,
        count("moving_messages", "Messages sent while moving."),
        quantity("moving_s", "s", "Time spent moving."),
        count("message_bytes", "Application bytes, messages in their frames.", unit="byte"),
        quantity("airtime_s", "s", "Time on the air, all layers and the security header counted."),
    ),
)
"""Message rates, with the counts that sums over trips are made of: a row a trip, policy and threshold."""

_FIGURES = ("before", "along", "cross", "age", "gaps")
_WHOLE = ("samples", "excluded", "messages", "duration_us", "beyond_us")

POOLS: Any = pa.schema(
    [
        *((name, pa.string()) for name in ("policy", "bank", "rate_basis")),
        *((name, pa.float64()) for name in ("threshold_m", "own_threshold_m", "packet_error_ratio")),
        *((name, pa.int64()) for name in _WHOLE),
        ("figure", pa.string()),
        ("seed", pa.int32()),
        ("first_bin", pa.int32()),
        ("weights", pa.list_(pa.int64())),
        ("weight", pa.int64()),
        ("total", pa.decimal128(38, 0)),
        ("largest", pa.float64()),
    ]
)
"""Columns of ``pools.parquet``: a row a histogram, its pool's own numbers on each (`TrackingPool`).

``figure`` is ``error`` (one for each ``seed``), ``before``, ``along``, ``cross``, ``age`` or ``gaps``;
``weights`` are those of the bins from ``first_bin`` on (`modelcast.study.histogram`), ``total`` is in
millionths.
"""

_BATCH_POOLS = 8
_DAMAGED = "Remove the folder of this part and run again."


def write_tables_of(found: Gathered, sharpest_mps2: Mapping[str, float], folder: Path) -> None:
    """Write the tables of a partition, but for messages and samples.

    Parameters
    ----------
    found
        What was found of its trips.
    sharpest_mps2
        Acceleration of the sharpest manoeuvre, by trip.
    folder
        An existing folder.
    """
    trips = [_trip_row(trip, sharpest_mps2.get(trip.id)) for trip in found.trips]
    rates = [_rate_row(one) for one in found.counts]
    for schema, rows in (
        (TRIP_ROWS, trips),
        (RATE_ROWS, rates),
        (REFERENCES, found.references),
        (TRACKING, found.tracking),
    ):
        write_table(schema.table(rows), folder / f"{schema.name}.parquet")
    pools = list(found.pools.values())
    with table_writer(POOLS, folder / "pools.parquet") as writer:
        for first in range(0, len(pools), _BATCH_POOLS):
            rows = [row for pool in pools[first : first + _BATCH_POOLS] for row in _pool_rows(pool)]
            columns = {name: [row[name] for row in rows] for name in POOLS.names}
            writer.write_table(pa.table(columns, schema=POOLS))


def read_tables(folder: Path, *, each_trip: bool) -> Gathered:
    """Return what `write_tables_of` wrote.

    Parameters
    ----------
    folder
        Of the partition.
    each_trip
        Whether to read the tracking of single trips too, by far the most rows.

    Raises
    ------
    DataFormatError
        Where a table is missing or damaged.
    """
    trips, rates, references = (
        read_table(schema, folder / f"{schema.name}.parquet", remedy=_DAMAGED)
        for schema in (TRIP_ROWS, RATE_ROWS, REFERENCES)
    )
    tracking = read_table(TRACKING, folder / "tracking.parquet", remedy=_DAMAGED) if each_trip else ()
    found = Gathered(
        [_trip_of(row) for row in trips],
        [_count_of(row) for row in rates],
        list(references),
        list(tracking),
    )
    for pool in _pools(folder / "pools.parquet"):
        found.pools[pool.contender, pool.packet_error_ratio] = pool
    sharp = [row for row in trips if row.sharpest_mps2 is not None]
    if sharp:
        sharpest = min(sharp, key=lambda row: (-row.sharpest_mps2, row.id))
        found.illustration = Illustration(sharpest.id, sharpest.sharpest_mps2)
    return found


def trips_in(folder: Path) -> int:
    """Return of how many trips a partition's tables tell; those that failed or were not asked for are none.

    Parameters
    ----------
    folder
        Of the partition.

    Raises
    ------
    DataFormatError
        Where the table is missing or damaged.
    """
    path = folder / f"{TRIP_ROWS.name}.parquet"
    try:
        return pq.read_metadata(path).num_rows
    except (pa.ArrowException, OSError) as error:
        raise DataFormatError(str(path), f"cannot be read: {error}", remedy=_DAMAGED) from error


def _trip_row(trip: TripRow, sharpest_mps2: float | None) -> Row:
    details = {
        name: plain_value(getattr(trip, name))
        for name in ("skipped", "repaired", "conditioning", "warnings", "understood")
    }
    return TRIP_ROWS.row(**trip_values(trip), sharpest_mps2=sharpest_mps2, details=document_text(details))


def _trip_of(row: Row) -> TripRow:
    details = parse_json(row.details)
    own = {
        name: getattr(row, name)
        for name in TRIPS.names
        if name not in {"grid_east_m", "grid_north_m", "skipped", "repaired", "warnings"}
    }
    return TripRow(**own, grid_m=(row.grid_east_m, row.grid_north_m), **details)


def _rate_row(one: TripCount) -> Row:
    raw = {
        name: getattr(one.count, name)
        for name in ("moving_messages", "moving_s", "message_bytes", "airtime_s")
    }
    return RATE_ROWS.row(**dict(rate_row(one.trip, one.count).items()), **raw)


def _count_of(row: Row) -> TripCount:
    count = RateCount(
        row.policy,
        row.bank,
        row.threshold_m,
        row.updates,
        row.identifications,
        row.moving_messages,
        row.duration_s,
        row.moving_s,
        row.message_bytes,
        row.airtime_s,
    )
    return TripCount(row.trip, count)


def _pool_rows(pool: TrackingPool) -> Iterator[dict[str, Any]]:
    contender = pool.contender
    shared = {
        "policy": contender.policy,
        "bank": contender.bank,
        "rate_basis": contender.rate_basis,
        "threshold_m": contender.threshold_m,
        "own_threshold_m": pool.own_threshold_m,
        "packet_error_ratio": pool.packet_error_ratio,
        **{name: getattr(pool, name) for name in _WHOLE},
    }
    each: Iterable[tuple[str, int | None, Histogram]] = [
        *(("error", seed, one) for seed, one in enumerate(pool.by_seed)),
        *((name, None, getattr(pool, name)) for name in _FIGURES),
    ]
    for figure, seed, one in each:
        yield {
            **shared,
            "figure": figure,
            "seed": seed,
            "first_bin": one.first,
            "weights": one.counts,
            "weight": one.weight,
            "total": Decimal(one.total),
            "largest": one.largest,
        }


def _pools(path: Path) -> list[TrackingPool]:
    found: dict[tuple[Contender, float], TrackingPool] = {}
    try:
        with pq.ParquetFile(path) as file:
            for batch in file.iter_batches(batch_size=100, columns=POOLS.names):
                _take(pa.Table.from_batches([batch]), found)
    except (pa.ArrowException, OSError, KeyError, ValueError) as error:
        raise DataFormatError(str(path), f"cannot be read: {error}", remedy=_DAMAGED) from error
    return list(found.values())


def _take(table: Any, found: dict[tuple[Contender, float], TrackingPool]) -> None:
    """Add the histograms of a batch to their pools; those of a pool come one after another."""
    weights = table["weights"].combine_chunks()
    offsets, values = weights.offsets.to_numpy(), weights.values.to_numpy()
    for at, row in enumerate(table.drop_columns(["weights"]).to_pylist()):
        key = (
            Contender(row["policy"], row["bank"], row["rate_basis"], row["threshold_m"]),
            row["packet_error_ratio"],
        )
        if key not in found:
            whole = {name: row[name] for name in _WHOLE}
            found[key] = TrackingPool(*key, own_threshold_m=row["own_threshold_m"], **whole)
        pool = found[key]
        one = Histogram(
            row["first_bin"],
            np.array(values[offsets[at] : offsets[at + 1]], dtype=np.int64),
            row["weight"],
            int(row["total"]),
            row["largest"],
        )
        if row["figure"] == "error":
            pool.by_seed.append(one)
        else:
            setattr(pool, row["figure"], one)
