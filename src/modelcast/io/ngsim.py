"""NGSIM: vehicles on freeways and streets (US-101, I-80, Lankershim, Peachtree) out of video, 10 Hz, in feet.

Three layouts are read, each by the names or the order of its columns, with upper or lower case letters:

- a table with a header and commas, of 18 to 24 columns;
- the joined file of all four places, which has a column ``Location``;
- the original ``trajectories-0750am-0805am.txt``: no header, blanks, 18 columns (freeways) or 24 (streets).

=================  =========  ====  ======================================================================
Column             Unit       No.   Use
=================  =========  ====  ======================================================================
Vehicle_ID         -          0     the trip
Frame_ID           -          1     not used: Global_Time says the same
Total_Frames       -          2     the trip too, because numbers are given anew in every period
Global_Time        Unix ms    3     time, absolute
Local_X, Local_Y   ft         4-5   position of the **front centre**: Local_X to the right of the section's
                                    left edge, Local_Y along it; taken as east and north
Global_X,          ft         6-7   not used: state plane coordinates, of a zone that the file does not name
Global_Y
v_Vel              ft/s       11    speed
v_Acc              ft/s²      12    acceleration
Location           -          -     the trip too
all others         -          -     not used
=================  =========  ====  ======================================================================

A foot is 0.3048 m; a US survey foot would be 2 millionths more. North is the way along the section, so there
is no origin and no heading. A trip is ``<stem>/<Vehicle_ID>-<Total_Frames>``, in the joined file
``<stem>/<Location>-<Vehicle_ID>-<Total_Frames>``. The same three may name vehicles of several periods: where
nothing was seen for over `APART_S`, the rest is another vehicle, with ``-2``, ``-3``, ... behind the name.

Speeds and above all accelerations were differentiated from video with little smoothing: their noise is large,
and is kept. The smoothed versions that others made have the same columns.

Skipped and counted: "time missing", "position missing", "duplicate time" (whole rows occur twice in the
joined file; the first is kept), a cut last line ("partial last line"). Repaired and counted: "out of time
order"; missing speeds and accelerations, held or left out as `rows` says; accelerations that no vehicle has.

References
----------
US Department of Transportation, Next Generation Simulation (NGSIM) Vehicle Trajectories and Supporting Data,
doi:10.21949/1504477 (its table of columns).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

import numpy as np

from modelcast.core.exceptions import DataFormatError
from modelcast.io.base import OnSkipped, Tally, ignore_skipped
from modelcast.io.gathered_trips import TripRows, UsableRows, trips_of
from modelcast.io.gathering import Gathered, gathered
from modelcast.io.holding import AbstractHoldingReader
from modelcast.io.keyed_text import KeyedText, TextKey
from modelcast.io.rows import Rows
from modelcast.io.table_layout import is_number
from modelcast.io.text_head import file_head, first_lines, split_fields
from modelcast.trips.trajectory import Trajectory

__all__ = ["APART_S", "FOOT_M", "NgsimReader"]

FOOT_M = 0.3048
"""Length of a foot."""

APART_S = 60.0
"""A vehicle crosses a section unseen for less than this: after it a number means another one."""

_ORDER: Mapping[str, int] = MappingProxyType(
    {
        "vehicle_id": 0, "frame_id": 1, "total_frames": 2, "global_time": 3, "local_x": 4, "local_y": 5,
        "v_vel": 11, "v_acc": 12,
    }
)  # fmt: skip
_COUNTS = (18, 24)
_NUMBERS = ("global_time", "local_x", "local_y", "v_vel", "v_acc")
_LOCATION = "location"
_YEARS_MS = (1.0e12, 1.3e12)
"""Global_Time of a file without a header: 2001 to 2011; all were recorded in 2005 and 2006."""


@dataclass(frozen=True, slots=True)
class NgsimReader(AbstractHoldingReader):
    """Reads NGSIM trajectories; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = "ngsim"
    streams: ClassVar[bool] = True

    def matches(self, path: Path, head: bytes) -> bool:
        """Return whether the first line is the header, or a row of the original files."""
        del path
        return _layout(first_lines(head)) is not None

    def read(self, path: str, on_skipped: OnSkipped = ignore_skipped) -> Iterator[Trajectory]:
        """Yield a trip per vehicle and period."""
        table = _table(path)
        found = (trip for one in gathered(table, self.held_bytes) for trip in _periods(table, one))
        yield from trips_of(path, self.name, found, _in_si, on_skipped)


@dataclass(frozen=True, slots=True)
class _Layout:
    place: Mapping[str, int]
    fields: int
    separator: str
    header: bool


def _layout(lines: list[str]) -> _Layout | None:
    """Return where the columns are; None where these are not lines of the format."""
    first = next((line for line in lines if line.strip()), "")
    names = [name.lower() for name in split_fields(first)]
    if set(_ORDER) <= set(names):
        place = {name: names.index(name) for name in (*_ORDER, _LOCATION) if name in names}
        return _Layout(place, len(names), ",", header=True)
    cells = split_fields(first, " ")
    if len(cells) in _COUNTS and all(map(is_number, cells)):
        low, high = _YEARS_MS
        if low < float(cells[_ORDER["global_time"]]) < high:
            return _Layout(_ORDER, len(cells), " ", header=False)
    return None


def _table(path: str) -> KeyedText:
    lines = first_lines(file_head(path))
    if not any(line.strip() for line in lines):
        raise DataFormatError(path, "the file is empty", remedy="Check that it is complete.")
    layout = _layout(lines)
    if layout is None:
        raise DataFormatError(
            path, "the first line is neither the header nor a row of NGSIM", row=1,
            remedy=f"ngsim needs the columns {', '.join(_ORDER)}, or, without a header, 18 or 24 numbers.",
        )  # fmt: skip
    keys = (_LOCATION,) if _LOCATION in layout.place else ()
    return KeyedText(
        path, place=layout.place, keys=(*keys, "vehicle_id", "total_frames"), numbers=_NUMBERS,
        counts=(layout.fields,), skip_lines=_header_line(lines) if layout.header else 0,
        separator=layout.separator, name_of="-".join,
    )  # fmt: skip


def _header_line(lines: list[str]) -> int:
    """Return the number of the header's line, from 1."""
    return 1 + next(at for at, line in enumerate(lines) if line.strip())


def _periods(table: KeyedText, found: Gathered[TextKey]) -> Iterator[TripRows]:
    """Yield the rows of one vehicle after another that had the same number; rows without a time go first."""
    name, rows = table.name_of(found.key), found.rows
    t_ms = rows.columns["global_time"]
    known = np.sort(t_ms[np.isfinite(t_ms)])
    starts = known[1:][np.diff(known) > 1000.0 * APART_S]
    which = np.searchsorted(starts, np.where(np.isfinite(t_ms), t_ms, -np.inf), side="right")
    for at in range(starts.size + 1):
        last = found.partial and bool(which[-1] == at)
        yield TripRows(name if at == 0 else f"{name}-{at + 1}", rows.taken(which == at), last)


def _in_si(rows: Rows, tally: Tally) -> UsableRows:
    """Return the rows with a time and a position, in SI units."""
    rows = rows.without(np.isnan(rows.columns["global_time"]), "time missing", tally)
    rows = rows.without(
        np.isnan(rows.columns["local_x"] + rows.columns["local_y"]), "position missing", tally
    )
    raw = rows.columns
    start_ms = float(raw["global_time"].min()) if len(rows) else 0.0
    columns = {
        "t_s": (raw["global_time"] - start_ms) / 1000.0,
        "east_m": raw["local_x"] * FOOT_M,
        "north_m": raw["local_y"] * FOOT_M,
        "speed_mps": raw["v_vel"] * FOOT_M,
        "acceleration_mps2": raw["v_acc"] * FOOT_M,
    }
    return UsableRows(Rows(rows.line, columns), unix_offset_s=start_ms / 1000.0)
