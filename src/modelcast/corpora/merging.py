"""One catalogue of several staged sources: names made different, vehicles shared out, in order.

A vehicle's partition is that of its name (BLAKE2b, modulo the number of partitions), so it does not depend on
what else the corpus holds. Where two trips share an identifier, the later gets ``#2``, ``#3``, ...; where
that is another's own, the next number.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import hashlib
from collections.abc import Sequence
from typing import Any

import polars as pl
import pyarrow as pa

from modelcast.corpora.catalogue import CATALOGUE
from modelcast.corpora.staging import Staging, staged_catalogue
from modelcast.io.free_names import FreeNames

__all__ = ["BATCH", "PARTITION_ROWS", "STAGED", "merged_catalogue", "partition_of"]

PARTITION_ROWS = 1_000_000
"""Samples of a partition, on average, where the user names no number of partitions."""

STAGED, BATCH = "staged", "batch"
"""Columns of the merged catalogue that the corpus does not keep: where a trip's samples are until then."""

_NAME_DIGITS = 4


def partition_of(vehicle: str, partitions: int) -> str:
    """Return the partition of a vehicle.

    Parameters
    ----------
    vehicle
        Its name.
    partitions
        How many there are.

    Examples
    --------
    >>> partition_of("10107", 1), partition_of("10107", 64) == partition_of("10107", 64)
    ('0000', True)
    """
    digest = hashlib.blake2b(vehicle.encode(), digest_size=8).digest()
    return f"{int.from_bytes(digest) % partitions:0{_NAME_DIGITS}d}"


def merged_catalogue(read: Sequence[Staging], *, partitions: int | None) -> Any:
    """Return the catalogue of sources by partition and trip, with `STAGED` and `BATCH`.

    Parameters
    ----------
    read
        Sources that did not fail, in order.
    partitions
        How many; None for as many as give `PARTITION_ROWS` each.
    """
    tables: list[Any] = []
    for work in read:
        table = staged_catalogue(work)
        number = pa.array([work.source.number] * table.num_rows, pa.int64())
        place = pa.array(range(table.num_rows), pa.int64())
        tables.append(table.append_column(STAGED, number).append_column(BATCH, place))
    table = pa.concat_tables(tables)
    names = pl.DataFrame(pl.from_arrow(table.select(["trip", "vehicle", "samples"])))
    free = FreeNames()
    given = [free.take(name) for name in names["trip"].to_list()]
    names = names.with_columns(pl.Series("trip", given, dtype=pl.String))
    count = partitions or max(1, -(-int(names["samples"].sum()) // PARTITION_ROWS))
    vehicles = names.select(pl.coalesce("vehicle", "trip").alias("vehicle"))["vehicle"]
    partition = {vehicle: partition_of(vehicle, count) for vehicle in vehicles.unique()}
    names = names.with_columns(vehicles.replace_strict(partition, return_dtype=pl.String).alias("partition"))
    for name in ("trip", "partition"):
        at = CATALOGUE.get_field_index(name)
        table = table.set_column(at, CATALOGUE.field(name), names[name].to_arrow().cast(pa.string()))
    order = names.select(pl.arg_sort_by("partition", "trip", maintain_order=True)).to_series()
    return table.take(order.to_arrow())
