"""Data frames of any library as recorded trips, and trips as a frame.

Columns, map and rules are those of Parquet files. What hands its columns over by the Arrow interface
(``__arrow_c_stream__``) or by the older data-frame interchange (``__dataframe__``) is a data frame: Polars,
pandas and pyarrow tables all do. No such library is imported for it.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import polars as pl
import pyarrow as pa
from pyarrow.interchange import from_dataframe

from modelcast.core.exceptions import DataFormatError
from modelcast.io.arrow_trips import PART_ROWS, ArrowTable
from modelcast.io.base import OnSkipped, ignore_skipped
from modelcast.io.table_trips import table_trips
from modelcast.trips.trajectory import Trajectory

__all__ = ["FRAME", "FrameRecording", "frame_html", "frame_recording", "summary_frame"]

FRAME = "frame"
"""Name of a data frame in errors and identifiers, and of its format."""

MOST_FRAME_BYTES = 2**40
"""A frame is in memory already: its trips have no other limit than that."""

_SUMMARY = {
    "trip": pl.String,
    "source": pl.String,
    "duration_s": pl.Float64,
    "samples": pl.Int64,
    "dt_s": pl.Float64,
    "rows": pl.Int64,
    "skipped": pl.Int64,
    "repaired": pl.Int64,
}


@dataclass(frozen=True, slots=True)
class FrameRecording:
    """A data frame that holds trips.

    Parameters
    ----------
    table
        Its columns, a pyarrow table.
    columns
        Column names by meaning; names are detected where it is None.
    on_skipped
        Called with a vehicle that gave no trip, and the reason.
    """

    table: Any
    columns: Mapping[str, str] | None = None
    on_skipped: OnSkipped = ignore_skipped

    def trips(self) -> Iterator[Trajectory]:
        """Yield a trip per vehicle.

        Raises
        ------
        ConfigError, DataFormatError
            As for `modelcast.io.arrow_trips.ArrowTable`.
        """
        table = self.table

        def batches(wanted: Sequence[str], rows: int = PART_ROWS) -> Iterable[Any]:
            return table.select(list(wanted)).to_batches(max_chunksize=rows)

        try:
            found = ArrowTable(FRAME, self.columns, table.schema, table.num_rows, batches)
            yield from table_trips(found, FRAME, self.on_skipped, held_bytes=MOST_FRAME_BYTES)
        except pa.ArrowException as error:
            raise DataFormatError(FRAME, f"cannot be read: {error}") from error


def frame_recording(
    frame: Any, columns: Mapping[str, str] | None = None, on_skipped: OnSkipped = ignore_skipped
) -> FrameRecording:
    """Return a data frame as a recording; what the frame becomes later does not matter to it.

    Parameters
    ----------
    frame
        A Polars or pandas data frame, a pyarrow table, or what hands its columns over as these do.
    columns
        Column names by meaning, for example ``{"t": "time", "east": "x", "north": "y"}``.
    on_skipped
        Called with a vehicle that gave no trip, and the reason.

    Raises
    ------
    DataFormatError
        Where its columns cannot be handed over.

    Examples
    --------
    >>> import polars as pl
    >>> frame = pl.DataFrame({"t_s": [0.0, 0.1, 0.2], "east_m": [0.0, 1.0, 2.0], "north_m": 0.0})
    >>> [trip.trip_id for trip in frame_recording(frame).trips()]
    ['frame/vehicle']
    """
    try:
        if isinstance(frame, pl.DataFrame):
            table: Any = frame.to_arrow(compat_level=pl.CompatLevel.oldest())  # types that Arrow can cast
        else:
            table = pa.table(frame) if hasattr(frame, "__arrow_c_stream__") else from_dataframe(frame)
    except (pa.ArrowException, TypeError, ValueError, RuntimeError, NotImplementedError) as error:
        raise DataFormatError(
            FRAME, f"a {type(frame).__name__} that hands no columns over: {error}",
            remedy="Give each column one type, or write it to Parquet.",
        ) from error  # fmt: skip
    return FrameRecording(table, columns, on_skipped)


def summary_frame(trips: Iterable[Trajectory]) -> pl.DataFrame:
    """Return a row a trip: its name, the format, duration, samples and step, and what became of its rows.

    Parameters
    ----------
    trips
        The trips; none of them is kept.
    """
    rows = [
        (
            trip.trip_id,
            trip.source,
            trip.duration_s,
            len(trip),
            trip.dt_s,
            trip.reading.rows,
            sum(trip.reading.skipped.values()),
            sum(trip.reading.repaired.values()),
        )
        for trip in trips
    ]
    return pl.DataFrame(rows, schema=_SUMMARY, orient="row")


def frame_html(title: str, frame: pl.DataFrame) -> str:
    """Return a data frame below a title, as notebooks show it.

    Parameters
    ----------
    title
        Plain text.
    frame
        The frame; Polars shows its first and last rows.
    """
    shown = frame._repr_html_()  # pyright: ignore[reportPrivateUsage] - the name is that of notebooks
    return f"<p>{escape(title)}</p>{shown}"
