"""Files of other programs that are often taken for tables, told by their first octets."""

import re

from modelcast.core.exceptions import DataFormatError
from modelcast.io.table_layout import is_number, table_layout
from modelcast.io.text_head import first_lines

__all__ = ["refuse_other_program"]

_AS_CSV = "Save the sheet as CSV (UTF-8) there, and name that file."
_AS_GPX = (
    "Save the track as GPX, which has the time of every point: gpsbabel -i {} -f FILE -o gpx -F drive.gpx."
)
_A_ROW = "Write CSV with a row a point: time,lat,lon and, where they are known, speed and heading."
_PAGE = ("is a page of the web", "Get the file that it shows or links to.")
_BEGINNINGS = (
    (
        b"PK\x03\x04",
        "is a workbook (Excel, LibreOffice) or another zip archive, not text",
        _AS_CSV,
    ),
    (b"\xd0\xcf\x11\xe0", "is a workbook of an old Excel, not a table of text", _AS_CSV),
    (b"%PDF", "is a PDF", "Get the table itself, as CSV."),
    (b"{\\rtf", "is formatted text (RTF)", "Save it as plain text in UTF-8."),
    (b"<!doctype html", *_PAGE),
    (b"<html", *_PAGE),
    (b"#ROSBAG", "is a bag of ROS 1", "Make a bag of ROS 2 of it: rosbags-convert --src FILE --dst drive."),
    (b"MATLAB 5.0", "is a file of MATLAB", "Write its table as CSV there: writetable(T, 'drive.csv')."),
    (b"\x89HDF", "is an HDF5 file (or a file of MATLAB 7.3)", "Write its table as CSV, with pandas for one."),
    (b"MDF     ", "is a measurement file (MDF)", "Export its channels: asammdf.MDF(FILE).export('csv')."),
    (b"LOGG", "is a log of a CAN bus (BLF)", "Decode its signals to CSV first."),
    (b"\x93NUMPY", "is an array of NumPy", "Write it as CSV: numpy.savetxt with delimiter=',' and a header."),
    (
        b"ARROW1",
        "is a Feather file",
        "Write it as Parquet: polars.read_ipc(FILE).write_parquet('drive.parquet').",
    ),
)
_ROOTS = (
    (b"<kml", "is KML", _AS_GPX.format("kml")),
    (b"<TrainingCenterDatabase", "is a training (TCX)", _AS_GPX.format("gtrnctr")),
    (b"<html", *_PAGE),
)
"""Documents of XML, by the first element anywhere in the first octets."""
_GEOJSON = re.compile(rb'\s*\{[^{}]*"type"\s*:\s*"(Feature|FeatureCollection|LineString|MultiLineString)"')
_FIT_AT = 8
"""Where files of FIT say what they are."""


def refuse_other_program(path: str, head: bytes) -> None:
    """Refuse a file that no reader knows, by what it is, where that shows.

    Parameters
    ----------
    path
        The file.
    head
        Its first octets.

    Raises
    ------
    DataFormatError
        Where it is a workbook, a PDF, a web page or other octets that are no text, or a table without a line
        that names its columns, or with two columns of one name.
    """
    for beginning, problem, remedy in _BEGINNINGS:
        if head.lstrip()[: len(beginning)].lower() == beginning.lower():
            raise DataFormatError(path, problem, remedy=remedy)
    _refuse_tracks(path, head)
    if b"\0" in head:
        raise DataFormatError(
            path,
            "holds octets that are no text, and no reader knows them",
            remedy="Write it as CSV, or name its format by --format.",
        )
    layout = table_layout(first_lines(head), lambda names: len(names) > 2)
    if layout is None or len(layout.names) < 3 or layout.separator == " ":
        return
    if all(map(is_number, layout.names)):
        raise DataFormatError(
            path, "has numbers where the header row should be", row=layout.lines,
            remedy="Add a first line that names the columns, for example t_s,east_m,north_m.",
        )  # fmt: skip
    twice = next((name for name in layout.names if name and layout.names.count(name) > 1), None)
    if twice is not None:
        raise DataFormatError(
            path, f"column {twice!r} occurs more than once", row=layout.lines,
            remedy="Rename all but the one that is meant.",
        )  # fmt: skip


def _refuse_tracks(path: str, head: bytes) -> None:
    """Refuse tracks in forms that no reader reads."""
    if head[_FIT_AT:].startswith(b".FIT"):
        raise DataFormatError(path, "is an activity (FIT)", remedy=_AS_GPX.format("garmin_fit"))
    if _GEOJSON.match(head):
        raise DataFormatError(path, "is GeoJSON, which has no rule for times", remedy=_A_ROW)
    for root, problem, remedy in _ROOTS:
        if head.lstrip().startswith(b"<") and root in head:
            raise DataFormatError(path, problem, remedy=remedy)
