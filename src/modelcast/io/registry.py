"""The trip readers by format name, and how a file's format is found.

Built-in readers are listed here and imported when first needed. Other packages add theirs through the
entry-point group ``modelcast.readers``: each entry point names a format and loads a class derived from
`modelcast.io.base.AbstractTripReader` that takes no arguments.
"""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from modelcast.core.exceptions import DataFormatError
from modelcast.core.open_group import OpenGroup
from modelcast.io.base import AbstractTripReader
from modelcast.io.column_map import example_map
from modelcast.io.other_programs import refuse_other_program
from modelcast.io.packed import member_of, open_octets, recording_name
from modelcast.io.places import readable_kind
from modelcast.io.table_layout import table_layout
from modelcast.io.text_head import first_lines, refuse_utf16, split_fields

__all__ = ["FORMATS", "READERS", "detect_format", "get_reader", "reader_names"]

FORMATS: Mapping[str, str] = MappingProxyType(
    {
        "spmd-bsm": "modelcast.io.spmd_bsm:SpmdBsmReader",
        "spmd-wsu": "modelcast.io.spmd_wsu:SpmdWsuReader",
        "spmd-hv": "modelcast.io.spmd_hv:SpmdHvReader",
        "openacc": "modelcast.io.openacc:OpenAccReader",
        "comma2k19": "modelcast.io.comma2k19:Comma2k19Reader",
        "nyc-cvpd": "modelcast.io.nyc_cvpd:NycCvpdReader",
        "nmea": "modelcast.io.nmea:NmeaReader",
        "smartloc": "modelcast.io.smartloc:SmartLocReader",
        "kitti-poses": "modelcast.io.kitti_poses:KittiPosesReader",
        "kitti-oxts": "modelcast.io.kitti_oxts:KittiOxtsReader",
        "highd": "modelcast.io.highd:HighDReader",
        "ind": "modelcast.io.ind:IndReader",
        "sumo-fcd": "modelcast.io.fcd_trips:FcdReader",
        "gpx": "modelcast.io.gpx:GpxReader",
        "interaction": "modelcast.io.interaction:InteractionReader",
        "ngsim": "modelcast.io.ngsim:NgsimReader",
        "ode-bsm": "modelcast.io.ode_bsm:OdeBsmReader",
        "cv-pilot": "modelcast.io.cv_pilot:CvPilotReader",
        "ros2-mcap": "modelcast.io.ros_mcap:RosMcapReader",
        "ros2-db3": "modelcast.io.ros_db3:RosDb3Reader",
        "pcap": "modelcast.io.pcap_trips:PcapReader",
        "parquet": "modelcast.io.parquet:ParquetReader",
        "csv": "modelcast.io.csv:CsvReader",
    }
)
"""The formats of recordings and the class that reads each; csv is asked last, as the least specific."""

_CORPUS = {"corpus": "modelcast.corpora.reader:CorpusReader"}
"""Trips of all formats in one folder; the layer above this one brings it, and nothing here knows of it."""

READERS = OpenGroup("modelcast.readers", AbstractTripReader, called="format", own={**_CORPUS, **FORMATS})
"""All readers, ours and those of other packages."""

_HEAD_BYTES = 16384


def reader_names() -> tuple[str, ...]:
    """Return the names of all formats that can be read.

    Examples
    --------
    >>> "openacc" in reader_names()
    True
    """
    return READERS.names()


def get_reader(name: str) -> AbstractTripReader:
    """Return the reader of a format.

    Raises
    ------
    ConfigError
        Where no reader of that name is known, or another package's reader is not one.
    """
    return READERS.made(name)


def detect_format(path: str | Path) -> str:
    """Return the name of the format of a file (or of a folder that is one recording).

    Raises
    ------
    DataFormatError
        Where the file does not exist, is a pipe or a device, is empty, or no reader knows it.
    """
    at = Path(path)
    head, named = b"", at
    if member_of(at) is not None or readable_kind(at) == "file":
        with open_octets(path) as file:
            head = file.read(_HEAD_BYTES)
        named = at.with_name(recording_name(at))
        if not head.strip():
            raise DataFormatError(str(path), "the file is empty", remedy="Check that it is complete.")
        refuse_utf16(str(path), head)
    for name in reader_names():
        if get_reader(name).matches(named, head):
            return name
    if not at.is_dir():
        refuse_other_program(str(path), head)
    raise DataFormatError(
        str(path),
        "no reader knows this " + ("folder" if at.is_dir() else "file"),
        remedy=_map_for(head)
        or f"Where it is of a known format, name that by --format: {', '.join(reader_names())}.",
    )


def _map_for(head: bytes) -> str:
    """Return an example of a column map where a file begins like a table, else nothing."""
    lines = first_lines(head)
    layout = table_layout(lines, lambda names: len(names) > 2)
    if layout is None:
        return ""
    names = layout.names
    if len(names) < 3 or not all(name.isprintable() and any(map(str.isalpha, name)) for name in names):
        return ""
    rows = [split_fields(line, layout.separator) for line in lines[layout.lines :]]
    whole = [row for row in rows if len(row) == len(names)]
    cells = {name: [row[at] for row in whole] for at, name in enumerate(names)} if whole else None
    columns = ", ".join(names)
    example = example_map(names, cells=cells)
    return f"As a table of the columns {columns} it takes a column map, for example {example}."
