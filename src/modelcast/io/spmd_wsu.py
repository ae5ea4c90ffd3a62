"""Safety Pilot ``DataWsu`` (DAS1): a vehicle's own GPS and CAN, 10 Hz.

A trip is (Device, Trip), ``<stem>/<Device>-<Trip>``.

===========================  =======  ====  ========================================================
Column                       Unit     No.   Use
===========================  =======  ====  ========================================================
Device, Trip                 -        0-1   the trip
Time                         0.01 s   2     not used: it steps on where a fix is repeated
GpsValidWsu                  -        3     rows other than 1 are skipped
GpsTimeWsu                   Unix ms  4     time, absolute
LatitudeWsu, LongitudeWsu    deg      5-6   position
AltitudeWsu                  m        7     height
GpsHeadingWsu                deg      8     heading, clockwise from north
GpsCoastingWsu               -        13    rows other than 0 are skipped: no fix, a dead reckoning
ValidCanWsu                  -        14    values from CAN count as missing where it is not 1
YawRateWsu                   deg/s    15    yaw rate, clockwise positive (CAN)
SpeedWsu                     km/h     16    speed (CAN)
AxWsu                        m/s²     20    acceleration (CAN)
all others                   -              not used
===========================  =======  ====  ========================================================

With or without a header row, a byte order mark, CRLF; blank cells or the word ``NULL``; E notation.

The time is that of the fix: the unit logs a fix twice and then jumps 200 ms, and a repeated position taken
for a new one would be wrong by 0.1 s of travel. The missing epoch is then interpolated with the rest.

Skipped and counted: "no fix", "position coasted", "position unavailable", "no GPS time", "repeated fix",
"partial last line", "no first value yet". Repaired and counted: "out of time order" (sorted); missing
values of optional columns, held or left out as `rows` says. Values held over two rows are kept.
"""

from typing import ClassVar

import numpy as np

from modelcast.core.geodesy import wrap_angle_rad
from modelcast.io.base import Tally
from modelcast.io.rows import Rows, with_missing
from modelcast.io.spmd import AbstractSpmdReader, SpmdLayout, valid_position

__all__ = ["SpmdWsuReader"]

_KMH = 1.0 / 3.6
_TIME_UNIT_S = 1e-3


def _usable(rows: Rows, tally: Tally) -> Rows:
    """Return the rows with a fix of their own, in SI units."""
    rows = rows.without(rows.columns["GpsValidWsu"] != 1.0, "no fix", tally)
    rows = rows.without(rows.columns["GpsCoastingWsu"] != 0.0, "position coasted", tally)
    rows = rows.without(np.isnan(rows.columns["GpsTimeWsu"]), "no GPS time", tally)
    placed = valid_position(rows.columns["LatitudeWsu"], rows.columns["LongitudeWsu"])
    rows = rows.without(~placed, "position unavailable", tally)
    raw = rows.columns
    deaf = raw["ValidCanWsu"] != 1.0
    return Rows(
        rows.line,
        {
            "t_s": raw["GpsTimeWsu"] * _TIME_UNIT_S,
            "latitude_deg": raw["LatitudeWsu"],
            "longitude_deg": raw["LongitudeWsu"],
            "altitude_m": raw["AltitudeWsu"],
            "speed_mps": with_missing(raw["SpeedWsu"] * _KMH, deaf),
            "heading_rad": wrap_angle_rad(np.radians(raw["GpsHeadingWsu"])),
            "acceleration_mps2": with_missing(raw["AxWsu"], deaf),
            "yaw_rate_radps": np.radians(with_missing(raw["YawRateWsu"], deaf)),
        },
    )


_LAYOUT = SpmdLayout(
    source="spmd-wsu",
    header=(
        "Device", "Trip", "Time", "GpsValidWsu", "GpsTimeWsu", "LatitudeWsu", "LongitudeWsu", "AltitudeWsu",
        "GpsHeadingWsu", "GpsSpeedWsu", "HdopWsu", "PdopWsu", "FixQualityWsu", "GpsCoastingWsu",
        "ValidCanWsu", "YawRateWsu", "SpeedWsu", "TurnSngRWsu", "TurnSngLWsu", "BrakeAbsTcsWsu", "AxWsu",
        "PrndlWsu", "VsaActiveWsu", "HeadlampWsu", "WiperWsu", "ThrottleWsu", "SteerWsu",
    ),
    counts=frozenset({27}),
    keys=("Device", "Trip"),
    numbers=(
        "GpsValidWsu", "GpsTimeWsu", "LatitudeWsu", "LongitudeWsu", "AltitudeWsu", "GpsHeadingWsu",
        "GpsCoastingWsu", "ValidCanWsu", "YawRateWsu", "SpeedWsu", "AxWsu",
    ),
    time="GpsTimeWsu",
    time_unit_s=_TIME_UNIT_S,
    trip_name="-".join,
    usable=_usable,
    duplicate="repeated fix",
    start_unix=True,
)  # fmt: skip


class SpmdWsuReader(AbstractSpmdReader):
    """Reads DataWsu files; the module's docstring has the columns and the repairs."""

    name: ClassVar[str] = _LAYOUT.source

    @property
    def layout(self) -> SpmdLayout:
        """DataWsu."""
        return _LAYOUT
