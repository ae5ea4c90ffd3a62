"""Safety Pilot basic safety messages (``BsmP1``), one-day and two-month releases, 10 Hz.

A trip is one transmitter heard by one receiver in one file of it: (RxDevice, FileId, TxDevice). Its
identifier is ``<stem>/<TxDevice>-<FileId>``, with ``-by<RxDevice>`` where another device received it.

==============================  =====  ===  ==========================================================
Column                          Unit   No.  Use
==============================  =====  ===  ==========================================================
RxDevice, FileId, TxDevice      -      0-2  the trip
GenTime (or Gentime)            µs     3    time; differences only: published sources disagree on
                                            the epoch, so there is no absolute time
TxRandom, MsgCount              -      4-5  not part of a trip; `spmd_losses` tells lost messages from them
DSecond                         -      6    not used
Latitude, Longitude             deg    7-8  position
Elevation                       m      9    height
Speed                           m/s    10   speed
Heading                         deg    11   heading, clockwise from north
Ax                              m/s²   12   acceleration
Ay, Az                          m/s²   13   not used
Yawrate                         deg/s  15   yaw rate, clockwise positive
PathCount to Confidence         -      16   not used
==============================  =====  ===  ==========================================================

With or without a header row, a byte order mark, CRLF; blank cells or the word ``NULL``; E notation.

Skipped and counted: "position unavailable" (blank, out of range, latitude 90.0000001, longitude
180.0000001, or 0, 0), "time missing", "duplicate time" (the first row is kept), "partial last line", "no
first value yet" (rows before an optional column's first value).
Repaired and counted: "out of time order" (sorted); unavailable values, held or left out as `rows` says:
speed 163.82, heading 360, acceleration and yaw rate at the end of their range (20.01, 327.67); "yaw rate
implausible" (over 100 deg/s, seen at launch from rest), treated as unavailable.
Values that a 1 Hz unit repeats for a second are kept as they are.
"""

from typing import ClassVar

import numpy as np

from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.base import Tally
from modelcast.io.bsm_values import available
from modelcast.io.rows import Rows, with_missing
from modelcast.io.spmd import AbstractSpmdReader, Key, SpmdLayout, valid_position

__all__ = ["BSM_LAYOUT", "SpmdBsmReader"]

YAW_RATE_LIMIT_DEGPS = 100.0
"""No car turns faster; 254 and 324 deg/s occur at launch from rest, 327.67 is J2735's unavailable."""


_TIME_UNIT_S = 1e-6


def _trip_name(key: Key) -> str:
    receiver, file_id, sender = key
    return f"{sender}-{file_id}" if sender == receiver else f"{sender}-{file_id}-by{receiver}"


def _usable(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with a time and a position, in SI units."""
    rows = rows.without(np.isnan(rows.columns["GenTime"]), "time missing", tally)
    placed = valid_position(rows.columns["Latitude"], rows.columns["Longitude"])
    rows = rows.without(~placed, "position unavailable", tally)
    raw = rows.columns
    wild = np.abs(raw["Yawrate"]) > YAW_RATE_LIMIT_DEGPS
    tally.repair("yaw rate implausible", int(wild.sum()))
    return Rows(
        rows.line,
        {
            "t_s": raw["GenTime"] * _TIME_UNIT_S,
            "latitude_deg": raw["Latitude"],
            "longitude_deg": raw["Longitude"],
            "altitude_m": raw["Elevation"],
            "speed_mps": available("speed_mps", raw["Speed"]),
            "heading_rad": wrap_angle_rad(np.radians(available("heading_rad", raw["Heading"]))),
            "acceleration_mps2": available("acceleration_mps2", raw["Ax"]),
            "yaw_rate_radps": np.radians(with_missing(raw["Yawrate"], wild)),
        },
    )


BSM_LAYOUT = SpmdLayout(
    source="spmd-bsm",
    header=(
        "RxDevice", "FileId", "TxDevice", "GenTime", "TxRandom", "MsgCount", "DSecond", "Latitude",
        "Longitude", "Elevation", "Speed", "Heading", "Ax", "Ay", "Az", "Yawrate", "PathCount",
        "RadiusOfCurve", "Confidence",
    ),
    counts=frozenset({19}),
    keys=("RxDevice", "FileId", "TxDevice"),
    numbers=("GenTime", "Latitude", "Longitude", "Elevation", "Speed", "Heading", "Ax", "Yawrate"),
    time="GenTime",
    time_unit_s=_TIME_UNIT_S,
    trip_name=_trip_name,
    usable=_usable,
    vehicle=2,
)  # fmt: skip


class SpmdBsmReader(AbstractSpmdReader):
    """Reads BsmP1 files; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = BSM_LAYOUT.source

    @property
    def layout(self) -> SpmdLayout:
        """BsmP1."""
        return BSM_LAYOUT
