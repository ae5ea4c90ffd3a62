"""Rows of floating-car data from CSV, Parquet and SUMO's XML, each with its number in the file.

=================  =======================  ========================================================
Meaning            Unit                     Names, the first that is there
=================  =======================  ========================================================
time               s                        timestep_time, t_s, time_s, t, time
vehicle            text                     vehicle_id, vehicle, id
east, north        m                        vehicle_x, east_m, east, x; vehicle_y, north_m, north, y
speed              m/s, optional            vehicle_speed, speed_mps, speed
heading            deg clockwise from       vehicle_angle, angle, heading_deg; in rad: heading_rad
                   north, optional
acceleration       m/s², optional           vehicle_acceleration, acceleration_mps2, acceleration
yaw rate           rad/s clockwise, opt.    yaw_rate_radps
length             m, optional              vehicle_length, length_m, length
=================  =======================  ========================================================

The names ``vehicle_...`` and the attributes of XML are SUMO's. CSV has a header row; its fields are parted by
commas or, as SUMO writes them, semicolons; blank optional fields are not known. XML has ``timestep`` elements
with a ``time`` and in them ``vehicle`` elements; other elements (persons) are passed over.
"""

# pyarrow has no type stubs: what comes out of it is unknown to pyright.
# pyright: reportUnknownVariableType=false, reportUnknownArgumentType=false

import csv
from collections.abc import Iterator, Mapping, Sequence
from math import inf, nan, pi
from pathlib import Path
from typing import Any, NamedTuple
from xml.parsers import expat

import pyarrow as pa
import pyarrow.parquet as pq

from modelcast.core.exceptions import DataFormatError
from modelcast.io.rows import LARGEST

__all__ = ["FcdRow", "is_sumo", "read_rows"]

_NAMES: Mapping[str, tuple[str, ...]] = {
    "time": ("timestep_time", "t_s", "time_s", "t", "time"),
    "vehicle": ("vehicle_id", "vehicle", "id"),
    "east": ("vehicle_x", "east_m", "east", "x"),
    "north": ("vehicle_y", "north_m", "north", "y"),
    "speed": ("vehicle_speed", "speed_mps", "speed"),
    "heading_deg": ("vehicle_angle", "angle", "heading_deg"),
    "heading_rad": ("heading_rad",),
    "acceleration": ("vehicle_acceleration", "acceleration_mps2", "acceleration"),
    "yaw_rate": ("yaw_rate_radps",),
    "length": ("vehicle_length", "length_m", "length"),
}
_NEEDED = ("time", "vehicle", "east", "north")
_CHUNK = 2**16
_BATCH = 2**16


class FcdRow(NamedTuple):
    """One vehicle at one time; numbers that are not known are NaN."""

    row: int
    t_s: float
    vehicle: str
    numbers: tuple[float, float, float, float, float, float, float]


def is_sumo(path: str) -> bool:
    """Return whether a file is SUMO's own: XML, or a table with its column names."""
    kind = _kind(path)
    if kind == "xml":
        return True
    names = _parquet_names(path) if kind == "parquet" else _csv_header(path)[0]
    return "timestep_time" in names and "vehicle_x" in names


def read_rows(path: str) -> Iterator[FcdRow]:
    """Yield a file's rows.

    Parameters
    ----------
    path
        The file; its content says which of the three formats it is.

    Raises
    ------
    DataFormatError
        Where a needed column is missing or a value is not a finite number, with file, row and value.
    """
    try:
        kind = _kind(path)
        yield from {"xml": _xml_rows, "parquet": _parquet_rows, "csv": _csv_rows}[kind](path)
    except OSError as error:
        raise DataFormatError(path, f"cannot be read: {error.strerror or error}") from error


def _kind(path: str) -> str:
    try:
        with Path(path).open("rb") as file:
            head = file.read(4096).removeprefix(b"\xef\xbb\xbf")
    except OSError as error:
        raise DataFormatError(path, f"cannot be read: {error.strerror or error}") from error
    if not head.strip():
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    if head.startswith(b"PAR1"):
        return "parquet"
    return "xml" if head.lstrip().startswith(b"<") else "csv"


def _columns(path: str, names: Sequence[str]) -> dict[str, str]:
    """Return which column has which meaning."""
    found: dict[str, str] = {}
    for meaning, known in _NAMES.items():
        name = next((name for name in known if name in names), None)
        if name is not None:
            found[meaning] = name
    missing = [meaning for meaning in _NEEDED if meaning not in found]
    if missing:
        raise DataFormatError(
            path,
            f"no column of {missing[0]} among {', '.join(names)}",
            row=1,
            remedy=f"It may be called {', '.join(_NAMES[missing[0]])}.",
        )
    return found


def _row(path: str, row: int, values: Mapping[str, Any]) -> FcdRow:
    """Return a row of values by meaning."""
    vehicle = values.get("vehicle")
    if vehicle is None or vehicle == "":
        raise DataFormatError(path, "the vehicle is blank", row=row, remedy="Name it.")
    time, east, north = (_number(path, row, name, values.get(name)) for name in ("time", "east", "north"))
    for name, value in (("time", time), ("east", east), ("north", north)):
        if value != value:  # noqa: PLR0124 - NaN
            raise DataFormatError(path, f"{name} is blank", row=row, remedy="Leave the row out.")
    heading = _number(path, row, "heading_deg", values.get("heading_deg")) * pi / 180.0
    if heading != heading:  # noqa: PLR0124 - NaN
        heading = _number(path, row, "heading_rad", values.get("heading_rad"))
    speed, acceleration, yaw_rate, length = (
        _number(path, row, name, values.get(name)) for name in ("speed", "acceleration", "yaw_rate", "length")
    )
    if speed < 0.0 or length < 0.0:
        name, value = ("speed", speed) if speed < 0.0 else ("length", length)
        raise DataFormatError(path, f"{name} is {value}, negative", row=row, remedy="Correct the value.")
    return FcdRow(row, time, str(vehicle), (east, north, speed, heading, acceleration, yaw_rate, length))


def _number(path: str, row: int, name: str, value: Any) -> float:
    """Return a number, NaN where there is none."""
    if value is None or value == "":
        return nan
    try:
        number = inf if isinstance(value, str) and "_" in value else float(value)
    except (TypeError, ValueError, OverflowError):
        number = inf
    if not abs(number) <= LARGEST:
        raise DataFormatError(
            path, f"{name} is {value!r}, not a finite number", row=row, remedy="Correct the value."
        )
    return number


def _csv_header(path: str) -> tuple[list[str], str]:
    """Return the column names and what parts them."""
    with Path(path).open(encoding="utf-8-sig", errors="replace", newline="") as file:
        line = file.readline()
    mark = ";" if line.count(";") > line.count(",") else ","
    return [field.strip(' \t\r\n"') for field in line.split(mark)], mark


def _csv_rows(path: str) -> Iterator[FcdRow]:
    names, mark = _csv_header(path)
    field = {meaning: names.index(name) for meaning, name in _columns(path, names).items()}
    with Path(path).open(encoding="utf-8-sig", errors="replace", newline="") as file:
        reader = csv.reader(file, delimiter=mark)
        try:
            next(reader)
            for cells in reader:
                if not cells:
                    continue
                if len(cells) != len(names):
                    raise DataFormatError(
                        path,
                        f"{len(cells)} fields where the header has {len(names)}",
                        row=reader.line_num,
                        remedy="Check that the line is whole.",
                    )
                values = {meaning: cells[at].strip() for meaning, at in field.items()}
                # SUMO writes a time step without vehicles as a row with a time alone
                if values["vehicle"] or values["east"] or values["north"]:
                    yield _row(path, reader.line_num, values)
        except csv.Error as error:
            raise DataFormatError(path, str(error), row=reader.line_num) from error


def _parquet_names(path: str) -> list[str]:
    try:
        with pq.ParquetFile(path) as file:
            return [str(name) for name in file.schema_arrow.names]
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        raise DataFormatError(
            path, f"is not readable as Parquet: {error}", remedy="Check that it is complete."
        ) from error


def _parquet_rows(path: str) -> Iterator[FcdRow]:
    found = _columns(path, _parquet_names(path))
    number = 0
    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            for batch in file.iter_batches(_BATCH, columns=list(found.values())):
                columns = [batch.column(name).to_pylist() for name in found.values()]
                for cells in zip(*columns, strict=True):
                    number += 1
                    values = dict(zip(found, cells, strict=True))
                    if values["vehicle"] is not None or values["east"] is not None:
                        yield _row(path, number, values)
    except (pa.ArrowException, OSError, ValueError, MemoryError) as error:
        raise DataFormatError(
            path, f"is not readable as Parquet: {error}", remedy="Check that it is complete."
        ) from error


def _xml_rows(path: str) -> Iterator[FcdRow]:
    """Yield the vehicles of SUMO's FCD output; row numbers are lines."""
    parser = expat.ParserCreate()
    found: list[FcdRow] = []
    now: list[str | None] = [None]
    root: list[str] = []

    def started(name: str, attributes: dict[str, str]) -> None:
        if not root:
            root.append(name)
        if name == "timestep":
            now[0] = attributes.get("time")
        elif name == "vehicle":
            values = {
                meaning: next((attributes[known] for known in names if known in attributes), None)
                for meaning, names in _NAMES.items()
            }
            values["time"] = now[0]
            found.append(_row(path, parser.CurrentLineNumber, values))

    parser.StartElementHandler = started
    try:
        with Path(path).open("rb") as file:
            while chunk := file.read(_CHUNK):
                parser.Parse(chunk, False)
                yield from found
                found.clear()
            parser.Parse(b"", True)
    except expat.ExpatError as error:
        yield from found
        raise DataFormatError(
            path,
            f"is not well-formed XML: {expat.ErrorString(error.code)}",
            row=error.lineno,
            remedy="Check that it is complete.",
        ) from error
    if root != ["fcd-export"]:
        raise DataFormatError(
            path, f"the root is {root[0]!r}, not fcd-export", row=1, remedy="Give SUMO's --fcd-output."
        )
