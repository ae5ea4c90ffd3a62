"""Trips written as tables that the csv and parquet readers read back unchanged.

One row a sample, columns always the same, empty where a trip does not have them: ``trip``, ``t_s``,
``east_m``, ``north_m``, ``up_m``, ``speed_mps``, ``heading_rad``, ``acceleration_mps2``,
``yaw_rate_radps``, and, constant in a trip, ``origin_latitude_deg``, ``origin_longitude_deg``,
``origin_altitude_m``, ``start_unix_s``. Identifiers, samples, origin and start survive; the counts of what
was skipped, the name of the first format and the resampling mark do not. Memory: a row group.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.argument_types import require_type
from modelcast.core.arrays import FloatArray
from modelcast.io.output import atomic_file
from modelcast.trips.trajectory import Trajectory

__all__ = ["GROUP_ROWS", "TRIP_COLUMNS", "write_csv", "write_parquet"]

GROUP_ROWS = 250_000
"""Least rows of a row group but the last: what a file says of its row groups is held until it is complete."""


def write_csv(trips: Trajectory | Iterable[Trajectory], out: str | Path | BinaryIO) -> None:
    """Write trips as comma-separated text, numbers with every digit they need.

    Parameters
    ----------
    trips
        Trips with different identifiers (which may hold no comma or quote), or one.
    out
        The file to write, which appears whole or not at all; or one open for writing bytes.

    Raises
    ------
    TypeError
        Where a trip is none.
    """
    with _opened(out) as file:
        header = True
        for trip in _several(trips):
            if set(trip.trip_id) & set(',"\r\n'):
                raise ValueError(
                    f"trip_id {trip.trip_id!r} holds a comma, a quote or a line end; use Parquet"
                )
            _table(trip).write_csv(file, include_header=header, quote_style="never")
            header = False
        if header:
            file.write((",".join(_SCHEMA) + "\n").encode())


def write_parquet(trips: Trajectory | Iterable[Trajectory], out: str | Path | BinaryIO) -> None:
    """Write trips as Parquet, float64; a row group holds whole trips, at least `GROUP_ROWS` rows of them.

    Parameters
    ----------
    trips
        Trips with different identifiers, or one.
    out
        The file to write, which appears whole or not at all; or one open for writing bytes.

    Raises
    ------
    TypeError
        Where a trip is none.
    """
    schema: Any = pa.schema([(name, pa.string() if name == "trip" else pa.float64()) for name in _SCHEMA])
    with (
        _opened(out) as file,
        pq.ParquetWriter(file, schema, compression="zstd", write_page_checksum=True) as writer,
    ):
        waiting: list[Any] = []
        rows = 0
        for trip in _several(trips):
            waiting.append(_table(trip).to_arrow().cast(schema))
            rows += len(trip)
            if rows >= GROUP_ROWS:
                writer.write_table(pa.concat_tables(waiting))
                waiting, rows = [], 0
        if waiting:
            writer.write_table(pa.concat_tables(waiting))


def _several(trips: Trajectory | Iterable[Trajectory]) -> Iterator[Trajectory]:
    """Yield the trips one at a time."""
    for trip in (trips,) if isinstance(trips, Trajectory) else trips:
        require_type(
            "trips", trip, Trajectory, remedy="modelcast.read_trips(...) gives those of files and frames"
        )
        yield trip


def _opened(out: str | Path | BinaryIO) -> AbstractContextManager[BinaryIO]:
    return atomic_file(out) if isinstance(out, str | Path) else nullcontext(out)


_NUMBERS = (
    "t_s",
    "east_m",
    "north_m",
    "up_m",
    "speed_mps",
    "heading_rad",
    "acceleration_mps2",
    "yaw_rate_radps",
    "origin_latitude_deg",
    "origin_longitude_deg",
    "origin_altitude_m",
    "start_unix_s",
)
_SCHEMA: dict[str, type[pl.DataType]] = {"trip": pl.String, **dict.fromkeys(_NUMBERS, pl.Float64)}

TRIP_COLUMNS = tuple(_SCHEMA)
"""The columns, in order; all but the first are float64."""


def _table(trip: Trajectory) -> pl.DataFrame:
    """Return a trip as a table with all columns."""
    origin = trip.origin
    values: dict[str, FloatArray | float | str | None] = {
        "trip": trip.trip_id,
        "t_s": trip.t_s,
        "east_m": trip.position_m[:, 0],
        "north_m": trip.position_m[:, 1],
        "up_m": trip.up_m,
        "speed_mps": trip.speed_mps,
        "heading_rad": trip.heading_rad,
        "acceleration_mps2": trip.acceleration_mps2,
        "yaw_rate_radps": trip.yaw_rate_radps,
        "origin_latitude_deg": None if origin is None else origin.latitude_deg,
        "origin_longitude_deg": None if origin is None else origin.longitude_deg,
        "origin_altitude_m": None if origin is None else origin.altitude_m,
        "start_unix_s": trip.start_unix_s,
    }
    columns = [
        pl.Series(name, value, dtype=kind)
        if isinstance(value := values[name], np.ndarray)
        else pl.Series(name, [value], dtype=kind).new_from_index(0, len(trip))
        for name, kind in _SCHEMA.items()
    ]
    return pl.DataFrame(columns)
