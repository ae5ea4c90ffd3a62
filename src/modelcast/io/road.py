"""Road files: where others drove before, as Parquet.

One row a cell of 5 m, in the order in which they were passed:

============================== ======== ================================================================
column                         type     content
============================== ======== ================================================================
latitude_deg, longitude_deg    float64  place on WGS-84 [deg]; or, of trips on a local plane, the next two
east_m, north_m                float64  place on that plane [m]: such a file serves trips on it alone
heading_rad                    float32  clockwise from north, unwrapped along each pass [rad]
pass                           int32    uninterrupted drive that the cell belongs to
trip                           int32    place of its trip among the fingerprints
============================== ======== ================================================================

The metadata hold ``modelcast_road`` ``1`` and ``fingerprints``, those of the trips, blanks between them.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import re
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import DataFormatError
from modelcast.station.context.survey import RoadSurvey
from modelcast.trips.fingerprint import FINGERPRINT

__all__ = ["MOST_CELLS_READ", "read_roads", "write_roads"]

MOST_CELLS_READ = 4_000_000
"""Cells that a file may hold: 20,000 km, 100 MB of memory."""

_KEY, _VERSION, _PRINTS = b"modelcast_road", b"1", b"fingerprints"
_ON_EARTH, _ON_PLANE = ("latitude_deg", "longitude_deg"), ("east_m", "north_m")
_REMEDY = "Build it anew with 'modelcast road build'."


def write_roads(survey: RoadSurvey, file: BinaryIO) -> None:
    """Write a road file; the same survey gives the same content.

    Parameters
    ----------
    survey
        What to write.
    file
        Open for writing bytes.
    """
    x, y = _ON_EARTH if survey.geodetic else _ON_PLANE
    table: Any = pa.table(
        {
            x: pa.array(survey.places[:, 0], pa.float64()),
            y: pa.array(survey.places[:, 1], pa.float64()),
            "heading_rad": pa.array(survey.heading_rad.astype(np.float32), pa.float32()),
            "pass": pa.array(survey.passes, pa.int32()),
            "trip": pa.array(survey.trip, pa.int32()),
        }
    ).replace_schema_metadata({_KEY: _VERSION, _PRINTS: " ".join(survey.fingerprints).encode()})
    pq.write_table(table, file, compression="zstd", write_page_checksum=True)


def read_roads(path: str | Path) -> RoadSurvey:
    """Read a road file; nothing in it is trusted.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is no road file, or breaks a rule of one.
    """
    shown = str(path)
    try:
        file: Any = pq.ParquetFile(str(path), page_checksum_verification=True)
    except (OSError, pa.ArrowException) as error:
        raise DataFormatError(shown, f"is no Parquet file ({error})", remedy=_REMEDY) from error
    with file:
        metadata: Any = file.schema_arrow.metadata or {}
        if metadata.get(_KEY) != _VERSION:
            raise DataFormatError(shown, "is no road file of this version", remedy=_REMEDY)
        if file.metadata.num_rows > MOST_CELLS_READ:
            raise DataFormatError(
                shown, f"holds {file.metadata.num_rows} cells, over {MOST_CELLS_READ}", remedy=_REMEDY
            )
        prints = metadata.get(_PRINTS, b"").decode("ascii", errors="replace").split()
        if not all(re.fullmatch(FINGERPRINT, one) for one in prints):
            raise DataFormatError(shown, "names trips by other than fingerprints", remedy=_REMEDY)
        names = set(file.schema_arrow.names)
        x, y = _ON_EARTH if set(_ON_EARTH) <= names else _ON_PLANE
        wanted = [x, y, "heading_rad", "pass", "trip"]
        missing = [name for name in wanted if name not in names]
        if missing:
            raise DataFormatError(shown, f"lacks {', '.join(missing)}", remedy=_REMEDY)
        try:
            table: Any = file.read(columns=wanted)
        except (OSError, pa.ArrowException) as error:
            raise DataFormatError(shown, f"is damaged ({error})", remedy=_REMEDY) from error
    try:
        return RoadSurvey(
            np.column_stack([_numbers(table, x), _numbers(table, y)]),
            _numbers(table, "heading_rad"),
            _whole(table, "pass"),
            _whole(table, "trip"),
            tuple(prints),
            geodetic=x == _ON_EARTH[0],
        )
    except ValueError as error:
        raise DataFormatError(shown, str(error), remedy=_REMEDY) from error


def _numbers(table: Any, name: str) -> FloatArray:
    """A column of numbers as float64; blanks are refused later, as what is not finite."""
    column = table.column(name)
    if not pa.types.is_floating(column.type):
        raise ValueError(f"column {name!r} holds {column.type}, not numbers")
    return np.array(column.cast(pa.float64()).to_numpy(), dtype=np.float64)


def _whole(table: Any, name: str) -> IntArray:
    """A column of whole numbers."""
    column = table.column(name)
    if column.type != pa.int32() or column.null_count:
        raise ValueError(f"column {name!r} holds {column.type} or blanks, not 32-bit whole numbers")
    return np.array(column.to_numpy(), dtype=np.int64)
